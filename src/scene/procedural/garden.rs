//! What makes a court pleasant: a fountain, plants in pots, cloth that hangs, lanterns.

use super::{
    architecture::{Arch, spline},
    builder::Builder,
    hash::{between, unit},
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A body of revolution whose outline is a smooth curve through `points` (radius, height), bottom to top.
pub(super) fn vessel(b: &mut Builder, around: f32, up: f32, points: &[Vec2]) {
    let cells = [b.steps(around, 4), b.steps(up, 2)];
    b.turned(cells, |v| spline(points, v));
}

/// A fountain on the origin: a round basin, a stem and a bowl, with water in both.
pub(super) fn fountain(b: &mut Builder, stone: u32, water: u32, spray: u32) {
    let p = Vec2::new;
    b.paint(stone);
    let step = [p(2.1, -0.05), p(2.1, 0.14), p(2.04, 0.16), p(1.5, 0.16)];
    b.lathe(&step, b.steps(32.0, 6));
    let wall = [p(1.62, 0.15), p(1.55, 0.24), p(1.6, 0.5), p(1.74, 0.62), p(1.76, 0.7), p(1.68, 0.73)];
    vessel(b, 32.0, 10.0, &wall);
    vessel(b, 32.0, 6.0, &[p(1.68, 0.73), p(1.54, 0.72), p(1.48, 0.62), p(1.46, 0.4)]);
    let stem = [p(0.42, 0.4), p(0.36, 0.66), p(0.2, 0.8), p(0.26, 1.0), p(0.14, 1.2), p(0.17, 1.42)];
    vessel(b, 18.0, 10.0, &stem);
    let bowl = [p(0.14, 1.4), p(0.4, 1.46), p(0.7, 1.6), p(0.86, 1.76), p(0.84, 1.8), p(0.74, 1.74)];
    vessel(b, 28.0, 10.0, &bowl);
    vessel(
        b,
        12.0,
        10.0,
        &[p(0.1, 1.68), p(0.08, 1.9), p(0.15, 2.05), p(0.1, 2.2), p(0.03, 2.28), p(0.0, 2.38)],
    );
    b.paint(water);
    pool(b, 1.5, 0.56, 26.0);
    pool(b, 0.8, 1.73, 40.0);
    b.paint(spray);
    for jet in 0..8 {
        let turn = Affine3A::from_rotation_y(TAU * jet as f32 / 8.0);
        b.at(turn, |b| water_jet(b, Vec2::new(0.8, 1.8), Vec2::new(1.22, 0.55)));
    }
}

/// A round sheet of water with rings of small waves.
fn pool(b: &mut Builder, radius: f32, height: f32, waves: f32) {
    let cells = [b.steps(28.0, 6), b.steps(9.0, 2)];
    b.patch(cells, true, |u, v| {
        let r = radius * (1.0 - v);
        let (sin, cos) = (-u * TAU).sin_cos();
        Vec3::new(r * cos, height + 0.006 * (waves * r).sin() * (1.0 - v), r * sin)
    });
}

/// A thin arc of falling water in the xy plane.
fn water_jet(b: &mut Builder, from: Vec2, to: Vec2) {
    let cells = [b.steps(4.0, 3), b.steps(5.0, 3)];
    b.patch(cells, true, |u, v| {
        let x = from.x + (to.x - from.x) * v;
        let y = from.y + (to.y - from.y) * v * v;
        let out = Vec2::new((from.y - to.y) * 2.0 * v, to.x - from.x).normalize();
        let (sin, cos) = (u * TAU).sin_cos();
        let r = 0.012 + 0.014 * v;
        Vec3::new(x + out.x * r * cos, y + out.y * r * cos, r * sin)
    });
}

/// A terracotta pot on the origin, 0.6 high, filled with earth.
pub(super) fn pot(b: &mut Builder, clay: u32, earth: u32) {
    let p = Vec2::new;
    b.paint(clay);
    let outside = [p(0.22, -0.01), p(0.25, 0.06), p(0.3, 0.25), p(0.33, 0.46), p(0.38, 0.5), p(0.39, 0.58)];
    vessel(b, 14.0, 5.0, &outside);
    vessel(b, 14.0, 3.0, &[p(0.39, 0.58), p(0.36, 0.62), p(0.33, 0.6), p(0.32, 0.5)]);
    b.paint(earth);
    let around = b.steps(14.0, 5);
    b.lathe(&[p(0.34, 0.53), p(0.0, 0.56)], around);
}

/// An agave: a rosette of thick pointed leaves that bend down, 0.8 high.
pub(super) fn agave(b: &mut Builder, greens: [u32; 2], seed: u32) {
    const LEAVES: u32 = 18;
    let cells = [b.steps(2.0, 1), b.steps(4.0, 2)];
    for i in 0..LEAVES {
        let key = seed * LEAVES + i;
        let age = i as f32 / LEAVES as f32;
        let long = between(0.75, 0.95, key, 21);
        // Young leaves stand up, old ones lie down.
        let (rise, bend) = (1.45 - 1.0 * age, between(0.3, 0.9, key, 22) * (0.4 + age));
        b.paint(greens[(i % 2) as usize]);
        b.at(Affine3A::from_rotation_y(i as f32 * 2.4 + unit(key, 23)), |b| {
            b.patch(cells, true, |u, v| {
                let angle = rise - bend * v;
                let side = 2.0 * u - 1.0;
                let half = 0.075 * (1.0 - v).powf(0.6) * (1.0 + 1.2 * v);
                let (sin, cos) = angle.sin_cos();
                let out = 0.04 + long * v * (0.5 * cos + 0.5 * rise.cos());
                let up = long * v * (0.5 * sin + 0.5 * rise.sin());
                // Hollow like a gutter.
                Vec3::new(half * side, up + 0.05 * side * side, out)
            });
        });
    }
}

/// An orange tree clipped to a ball, standing in its pot on the origin.
pub(super) fn orange_tree(b: &mut Builder, bark: u32, greens: [u32; 2], fruit: u32, seed: u32) {
    let (centre, radius) = (Vec3::new(0.0, 1.75, 0.0), 0.55);
    b.paint(bark);
    vessel(b, 7.0, 4.0, &[Vec2::new(0.05, 0.5), Vec2::new(0.035, 0.9), Vec2::new(0.04, 1.5)]);
    b.paint(greens[0]);
    b.at(Affine3A::from_translation(centre), |b| {
        let cells = [b.steps(12.0, 5), b.steps(7.0, 3)];
        b.turned(cells, |v| Vec2::new((PI * v).sin(), -(PI * v).cos()) * (0.82 * radius));
    });
    let leaves = b.steps(200.0, 24).min(200);
    for i in 0..leaves as u32 {
        let key = seed * 1024 + i;
        b.paint(greens[usize::from(unit(key, 31) < 0.6)]);
        b.at(on_ball(centre, radius, key, i as f32 / leaves as f32), leaf);
    }
    b.paint(fruit);
    for i in 0..8 {
        let place = on_ball(centre, radius, seed * 1024 + 512 + i, (i as f32 + 0.5) / 8.0);
        b.at(place, |b| {
            let cells = [b.steps(5.0, 3), b.steps(3.0, 2)];
            b.turned(cells, |v| Vec2::new((PI * v).sin(), -(PI * v).cos()) * 0.045);
        });
    }
}

/// A place near a ball's surface with z pointing out and a little astray; `rank` in [0, 1] runs from top to bottom.
fn on_ball(centre: Vec3, radius: f32, key: u32, rank: f32) -> Affine3A {
    let y = 1.0 - 2.0 * rank;
    let (sin, cos) = (key as f32 * 2.399_963).sin_cos();
    let r = (1.0 - y * y).max(0.0).sqrt();
    let out = Vec3::new(r * cos, y, r * sin);
    let astray = Vec3::new(unit(key, 33) - 0.5, unit(key, 34) - 0.3, unit(key, 35) - 0.5);
    let turn = Quat::from_rotation_arc(Vec3::Z, (out + 1.1 * astray).normalize());
    let place = centre + out * radius * between(0.86, 1.03, key, 36);
    Affine3A::from_rotation_translation(turn * Quat::from_rotation_z(TAU * unit(key, 37)), place)
}

/// A leaf at the origin that looks towards +z, folded a little along its middle.
fn leaf(b: &mut Builder) {
    let cells = [b.steps(1.0, 1), b.steps(2.0, 2)];
    b.patch(cells, true, |u, v| {
        let side = 2.0 * u - 1.0;
        let half = 0.05 * (PI * (0.08 + 0.92 * v)).sin();
        Vec3::new(half * side, 0.17 * (v - 0.5), 0.018 * side * side - 0.05 * (v - 0.5) * (v - 0.5))
    });
}

/// A banner that hangs down from the origin, in front of z = 0: a field, a border and two tails.
pub(super) fn banner(b: &mut Builder, width: f32, length: f32, [field, border]: [u32; 2], seed: u32) {
    let (across, down) = (b.steps(10.0, 5), b.steps(12.0, 6));
    let edge = (across / 10).max(1);
    let phase = TAU * unit(seed, 41);
    let paint = |i: usize, j: usize| {
        let stripe = i < edge || i >= across - edge || j < 2 * edge || (j > 3 * edge && j <= 4 * edge);
        if stripe { border } else { field }
    };
    b.mosaic([across, down], true, paint, |u, v| {
        // v runs upwards, so that the front looks towards +z.
        let fall = 1.0 - v;
        let tail = 1.0 - 0.13 * (1.0 - (2.0 * u - 1.0).abs());
        let wave = (5.0 * u + 2.0 * fall + phase).sin() + 0.5 * (11.0 * u - 3.0 * fall).sin();
        Vec3::new((u - 0.5) * width, -length * tail * fall, 0.09 + 0.035 * wave * (0.25 + fall))
    });
}

/// A curtain that hangs from the origin and is drawn to one side by a tie: half an opening of the width `width`.
pub(super) fn curtain(b: &mut Builder, width: f32, length: f32, seed: u32) {
    let cells = [b.steps(18.0, 8), b.steps(6.0, 3)];
    let phase = TAU * unit(seed, 43);
    b.patch(cells, true, |u, v| {
        let fall = 1.0 - v;
        // Narrowest at the tie, two thirds down.
        let drawn = 1.0 - 0.62 * (-(fall - 0.62) * (fall - 0.62) * 9.0).exp();
        let fold = (TAU * 3.0 * u + phase).sin() * (0.045 + 0.03 * fall);
        Vec3::new(width * drawn * u, -length * fall, fold + 0.03 * (3.0 * fall + phase).sin())
    });
}

/// A lantern below the origin on a rod of the length `drop`: a glowing globe under a hood. Its light belongs just
/// below it.
pub(super) fn lantern(b: &mut Builder, drop: f32, metal: u32, glow: u32) {
    let p = Vec2::new;
    b.paint(metal);
    b.at(Affine3A::from_translation(Vec3::new(0.0, -drop, 0.0)), |b| {
        let around = b.steps(4.0, 3);
        b.lathe(&[p(0.012, 0.1), p(0.012, drop)], around);
        vessel(b, 10.0, 4.0, &[p(0.17, 0.02), p(0.16, 0.05), p(0.06, 0.1), p(0.02, 0.16)]);
        b.paint(glow);
        let cells = [b.steps(10.0, 4), b.steps(5.0, 2)];
        b.turned(cells, |v| {
            let (sin, cos) = (PI * v).sin_cos();
            p(0.11 * sin, -0.06 - 0.13 * cos)
        });
    });
}

/// A door below an arch, on a wall towards +z: leaves of wood in a frame of stone. `height` is that of the springing.
pub(super) fn door(b: &mut Builder, arch: Arch, height: f32, wood: u32, stone: u32) {
    b.paint(wood);
    let along = b.steps(5.0, 2);
    for right in [false, true] {
        b.patch([along, 1], false, |u, v| {
            let top = arch.arc(right, u, 0.0);
            Vec3::new(top.x, (height + top.y) * v, 0.03)
        });
        // Two panels in each leaf.
        let x = if right { 0.08 } else { 0.1 - arch.half };
        for [low, high] in [[0.2, 0.42], [0.48, 0.94]] {
            let size = Vec3::new(arch.half - 0.18, height * (high - low), 0.06);
            let corner = Vec3::new(x, height * low, 0.0);
            b.cuboid(corner, corner + size);
        }
    }
    b.paint(stone);
    let p = Vec2::new;
    let frame = [p(0.0, 0.0), p(0.0, 0.1), p(0.08, 0.14), p(0.16, 0.14), p(0.18, 0.0)];
    b.at(Affine3A::from_translation(Vec3::Y * height), |b| super::architecture::archivolt(b, arch, &frame));
    for side in [-1.0, 1.0] {
        let (near, far) = (side * arch.half, side * (arch.half + 0.18));
        b.cuboid(Vec3::new(near.min(far), -0.02, -0.02), Vec3::new(near.max(far), height, 0.14));
    }
}
