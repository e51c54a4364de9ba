//! Gothic elements: clustered piers, ribbed vaults, windows with tracery.

use super::super::{
    architecture::{Arch, arched_wall, archivolt, bar, facing, groin_vault, moved},
    builder::Builder,
    hash::unit,
};
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// A pier on the origin: a core with eight shafts, each with base and capital, under one abacus.
pub(super) fn clustered_pier(b: &mut Builder, height: f32, core: f32, stone: u32, shaft: u32) {
    b.paint(stone);
    let around = b.steps(12.0, 6);
    let p = Vec2::new;
    let foot = core + 0.24;
    b.lathe(&[p(foot, -0.02), p(foot, 0.25), p(foot - 0.06, 0.33), p(foot - 0.2, 0.34)], around);
    b.lathe(&[p(core, 0.3), p(core, height - 0.2)], around);
    let head = core + 0.36;
    b.lathe(
        &[p(core + 0.16, height - 0.24), p(head, height - 0.14), p(head, height), p(0.0, height)],
        around,
    );
    for k in 0..8 {
        let turn = Affine3A::from_rotation_y((k as f32 + 0.5) * FRAC_PI_4);
        b.at(turn * moved(core, 0.3, 0.0), |b| colonnette(b, height - 0.5, 0.11, [stone, shaft]));
    }
}

/// A slender shaft of `height` on the origin with a moulded base and a capital.
pub(super) fn colonnette(b: &mut Builder, height: f32, r: f32, [stone, shaft]: [u32; 2]) {
    let around = b.steps(6.0, 4);
    let curve = b.steps(2.0, 1);
    b.paint(stone);
    b.turned([around, curve], |v| Vec2::new(r * (1.05 + 0.5 * (PI * v).sin()), 0.16 * v));
    b.turned([around, curve], |v| Vec2::new(r * (1.0 + 0.65 * v * v), height - 0.34 * (1.0 - v)));
    b.paint(shaft);
    let up = b.steps(1.0, 1);
    b.turned([around, up], |v| Vec2::new(r, 0.15 + (height - 0.48) * v));
}

/// A vault with ribs along its groins, springing at height 0; see [`groin_vault`] for `arch`.
pub(super) fn ribbed_vault(b: &mut Builder, arch: Arch, half: Vec2, [web, rib]: [u32; 2], radius: f32) {
    b.paint(web);
    groin_vault(b, arch, half.x, half.y);
    b.paint(rib);
    let cells = [b.steps(5.0, 3), b.steps(7.0, 2)];
    for (x, z) in [(half.x, half.y), (-half.x, half.y), (half.x, -half.y), (-half.x, -half.y)] {
        let side = Vec3::new(z, 0.0, -x).normalize();
        bar(b, cells, radius, side, |v| {
            let s = (v * FRAC_PI_2).sin();
            Vec3::new(x * s, arch.height(s) - 0.3 * radius, z * s)
        });
    }
    boss(b, arch.rise(), 2.4 * radius);
}

/// A knob where ribs meet.
fn boss(b: &mut Builder, height: f32, radius: f32) {
    let cells = [b.steps(8.0, 4), b.steps(4.0, 2)];
    b.turned(cells, |v| {
        let (sin, cos) = (PI * v).sin_cos();
        Vec2::new(radius * sin, height - 0.5 * radius - 0.6 * radius * cos)
    });
}

/// A rib across a vault from wall to wall, in the plane x = 0.
pub(super) fn transverse_rib(b: &mut Builder, arch: Arch, half: f32, radius: f32) {
    let cells = [b.steps(6.0, 3), b.steps(8.0, 2)];
    for z in [-half, half] {
        bar(b, cells, radius, Vec3::X * z.signum(), |v| {
            let s = (v * FRAC_PI_2).sin();
            Vec3::new(0.0, arch.height(s), z * s)
        });
    }
}

/// The opening of a window: a pointed arch on upright jambs.
#[derive(Clone, Copy)]
pub(super) struct Window {
    /// The arch.
    pub arch: Arch,
    /// Height of the sill.
    pub sill: f32,
    /// Height at which the arch springs.
    pub springing: f32,
}

/// One bay of a wall with a window: from 0 up to `top`, `2 * bay` wide and `thick` deep about z = 0.
pub(super) fn windowed_wall(b: &mut Builder, window: Window, bay: f32, top: f32, thick: f32) {
    let Window { arch, sill, springing } = window;
    let (half, z) = (arch.half, 0.5 * thick);
    let cells = [b.steps(2.0, 1), b.steps(2.0, 1)];
    for quarters in [0, 2] {
        b.at(facing(quarters, Vec3::ZERO), |b| {
            b.quad(cells, Vec3::new(-bay, 0.0, z), Vec3::X * 2.0 * bay, Vec3::Y * sill);
            for x in [-bay, half] {
                let (du, dv) = (Vec3::X * (bay - half), Vec3::Y * (springing - sill));
                b.quad(cells, Vec3::new(x, sill, z), du, dv);
            }
        });
    }
    let (up, deep) = (Vec3::Y * (springing - sill), Vec3::Z * thick);
    b.quad([1, 1], Vec3::new(-half, sill, -z), up, deep);
    b.quad([1, 1], Vec3::new(half, sill, -z), deep, up);
    b.quad([1, 1], Vec3::new(-half, sill, -z), deep, Vec3::X * 2.0 * half);
    b.at(moved(0.0, springing, 0.0), |b| arched_wall(b, arch, bay, top - springing, thick));
}

/// Bars of stone in the opening of `window`: two lights under a circle with four foils.
pub(super) fn tracery(b: &mut Builder, window: Window) {
    let Window { arch, sill, springing } = window;
    let h = arch.half;
    let (thin, thick) = (0.045 * h.max(0.8), 0.07 * h.max(0.8));
    let cells = [b.steps(4.0, 3), b.steps(5.0, 2)];
    let upright = [cells[0], b.steps(1.0, 1)];
    for x in [-h, 0.0, h] {
        bar(b, upright, thick, Vec3::Z, |v| Vec3::new(x, sill + (springing - sill) * v, 0.0));
    }
    bar(b, upright, thick, Vec3::Z, |v| Vec3::new(h * (2.0 * v - 1.0), sill, 0.0));
    let light = Arch { half: 0.5 * h, point: arch.point };
    for right in [false, true] {
        bar(b, cells, thick, Vec3::Z, |v| arch.arc(right, v, 0.0).extend(0.0) + Vec3::Y * springing);
        for x in [-0.5 * h, 0.5 * h] {
            let foot = Vec3::new(x, springing, 0.0);
            bar(b, cells, thin, Vec3::Z, |v| light.arc(right, v, 0.0).extend(0.0) + foot);
        }
    }
    let (centre, ring) = (Vec3::new(0.0, springing + 0.98 * h, 0.0), 0.36 * h);
    let circle = |r: f32, v: f32| Vec3::new(r * (TAU * v).cos(), r * (TAU * v).sin(), 0.0);
    bar(b, [cells[0], 2 * cells[1]], thin, Vec3::Z, |v| centre + circle(ring, v));
    // Coarse circles are empty.
    for k in 0..4 * b.steps(1.0, 0).min(1) {
        let (sin, cos) = ((k as f32 + 0.5) * FRAC_PI_2).sin_cos();
        let place = centre + 0.5 * ring * Vec3::new(cos, sin, 0.0);
        bar(b, cells, 0.6 * thin, Vec3::Z, |v| place + circle(0.42 * ring, v));
    }
}

/// Leaded panes that fill `window` in the plane z = 0, each one of `glass`, by chance of its place.
pub(super) fn stained_glass(b: &mut Builder, window: Window, glass: &[u32], seed: u32) {
    /// Panes across the window, up to the springing, and along either arc, however fine the mesh.
    const PANES: [usize; 3] = [8, 9, 5];
    let Window { arch, sill, springing } = window;
    let (across, up, arc) = (b.steps(4.0, 2), b.steps(9.0, 3), b.steps(5.0, 2));
    let pane = |i: usize, j: usize| {
        let chance = unit((i + 64 * j) as u32, 61 + seed);
        glass[(chance * glass.len() as f32) as usize]
    };
    // Alike on both sides of the middle, as windows are.
    let below = |i: usize, j: usize| {
        let i = i * PANES[0] / (2 * across);
        pane(i.min(PANES[0] - 1 - i), j * PANES[1] / up)
    };
    b.mosaic([2 * across, up], false, below, |u, v| {
        Vec3::new(arch.half * (2.0 * u - 1.0), sill + (springing - sill) * v, 0.0)
    });
    for right in [false, true] {
        let above = |i: usize, j: usize| {
            let i = if right { arc - 1 - i } else { i };
            pane(i * PANES[2] / arc, PANES[1] + j * PANES[0] / (2 * across))
        };
        b.mosaic([arc, across], false, above, |u, v| {
            let top = arch.arc(right, u, 0.0);
            Vec3::new(top.x, springing + top.y * v, 0.0)
        });
    }
}

/// The deep mouldings of an arcade arch, on both sides of a wall `thick` deep.
pub(super) fn arcade_mouldings(b: &mut Builder, arch: Arch, thick: f32) {
    let z = 0.5 * thick;
    let p = |out: f32, depth: f32| Vec2::new(out, z + depth);
    let rolls: Vec<Vec2> = (0..=3)
        .map(|k| {
            let (sin, cos) = (PI * k as f32 / 3.0).sin_cos();
            p(0.12 - 0.07 * cos, 0.03 + 0.09 * sin)
        })
        .collect();
    let mut profile = vec![p(0.0, -0.02), p(0.0, 0.03)];
    profile.extend(rolls);
    profile.extend([p(0.24, 0.03), p(0.26, 0.11), p(0.34, 0.11), p(0.38, -0.02)]);
    for quarters in [0, 2] {
        b.at(facing(quarters, Vec3::ZERO), |b| archivolt(b, arch, &profile));
    }
}
