//! Furniture that several scenes share. Everything stands on y = 0 and faces +z.

use super::{
    builder::Builder,
    hash,
    shapes::{Slab, SlabCells},
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Moves to (x, y, z) and turns about the y axis, degrees counter-clockwise as seen from above.
pub(super) fn set(x: f32, y: f32, z: f32, degrees: f32) -> Affine3A {
    let turn = Quat::from_rotation_y(degrees.to_radians());
    Affine3A::from_rotation_translation(turn, Vec3::new(x, y, z))
}

/// A plate with soft edges, `half` of its size each way, centred on the placement.
pub(super) fn plate(b: &mut Builder, half: Vec3, corner: f32, edge: f32, bend: impl Fn(Vec3) -> Vec3) {
    let slab = Slab { half: Vec2::new(half.x, half.z), thickness: 2.0 * half.y, corner, edge };
    let cells = SlabCells {
        corner: b.steps(2.0, 1),
        side: b.steps(1.0, 1),
        edge: b.steps(1.0, 1),
        face: b.steps(1.0, 1),
    };
    b.slab(slab, cells, bend);
}

/// A stacking chair with a bent plywood back, on four splayed steel legs. Seat at 0.45 m.
pub(super) fn stacking_chair(b: &mut Builder, wood: u32, cushion: u32, steel: u32) {
    b.paint(cushion);
    let cells = SlabCells {
        corner: b.steps(3.0, 1),
        side: b.steps(2.0, 1),
        edge: b.steps(1.0, 1),
        face: b.steps(2.0, 1),
    };
    let seat = Slab { half: Vec2::new(0.22, 0.21), thickness: 0.05, corner: 0.07, edge: 0.022 };
    b.slab(seat, cells, |p| {
        // A hollow to sit in, a front edge that falls away.
        let hollow = 0.02 * ((p.x / 0.22).powi(2) - 1.0);
        let fall = -0.12 * (p.z - 0.08).max(0.0);
        p + Vec3::Y * (0.46 + hollow + fall)
    });
    b.paint(wood);
    let back = Slab { half: Vec2::new(0.215, 0.15), thickness: 0.018, corner: 0.06, edge: 0.008 };
    b.slab(back, cells, |p| {
        // The plate stands up: its z runs down the back; wrapped about the sitter, leaning backwards.
        let wrap = 0.07 * (p.x / 0.215).powi(2);
        Vec3::new(p.x, 0.72 - p.z, p.y - 0.245 + 0.18 * p.z + wrap)
    });
    b.paint(steel);
    let tube = [b.steps(6.0, 3), b.steps(8.0, 3)];
    for side in [-1.0, 1.0] {
        // Back leg and post in one bow.
        b.tube(
            tube,
            Vec3::X,
            |_| 0.012,
            |t| Vec3::new(side * (0.23 - 0.05 * t), 0.80 * t, -0.30 + 0.379 * t - 0.301 * t * t),
        );
        // Front leg, bent under the seat towards the back: a cubic Bezier curve.
        let bend = [(0.225, 0.0, 0.24), (0.20, 0.50, 0.17), (0.195, 0.41, 0.10), (0.195, 0.41, -0.19)]
            .map(|(x, y, z)| Vec3::new(side * x, y, z));
        b.tube(
            tube,
            Vec3::X,
            |_| 0.012,
            |t| {
                let s = 1.0 - t;
                bend[0] * (s * s * s)
                    + bend[1] * (3.0 * s * s * t)
                    + bend[2] * (3.0 * s * t * t)
                    + bend[3] * (t * t * t)
            },
        );
        for z in [0.24, -0.30] {
            b.ball(
                b.steps(6.0, 3),
                Vec3::new(side * if z > 0.0 { 0.225 } else { 0.23 }, 0.012, z),
                Vec3::splat(0.018),
            );
        }
    }
}

/// A turned wooden leg of the given height: a foot, a swelling, rings.
pub(super) fn turned_leg(b: &mut Builder, height: f32, radius: f32) {
    let cells = [b.steps(14.0, 5), b.steps(26.0, 6)];
    b.turned(cells, |v| {
        let swell = 0.75 + 0.35 * (PI * v).sin().powi(2) - 0.2 * (3.0 * PI * v).sin().powi(4);
        let foot = if v < 0.1 { 0.25 * (v / 0.1 * PI).sin() } else { 0.0 };
        Vec2::new(radius * (swell + foot), height * v)
    });
}

/// A pot plant: a turned pot and `leaves` arching blades; `seed` makes each plant its own.
pub(super) fn plant(b: &mut Builder, pot: u32, soil: u32, leaf: u32, leaves: u32, size: f32, seed: u32) {
    let around = b.steps(20.0, 6);
    b.paint(pot);
    let profile =
        [(0.0, 0.001), (0.13, 0.001), (0.17, 0.26), (0.19, 0.27), (0.19, 0.31), (0.172, 0.31), (0.165, 0.27)];
    b.lathe(&profile.map(|(r, y)| Vec2::new(r, y) * size), around);
    b.paint(soil);
    b.turned([around, b.steps(2.0, 1)], |v| Vec2::new(0.167 * (1.0 - v), 0.275 + 0.015 * v) * size);
    b.paint(leaf);
    let cells = [b.steps(2.0, 2), b.steps(6.0, 3)];
    for i in 0..leaves {
        let random = |k: u32| hash::unit(seed * 9973 + i * 7 + k, 0);
        let around = TAU * (i as f32 * 0.382 + 0.08 * random(0));
        let (reach, rise) = (size * (0.25 + 0.4 * random(1)), size * (0.55 + 0.6 * random(2)));
        let width = size * (0.045 + 0.03 * random(3));
        let (sin, cos) = around.sin_cos();
        let (out, across) = (Vec3::new(cos, 0.0, sin), Vec3::new(-sin, 0.0, cos));
        let root = Vec3::Y * (0.28 * size) + out * (0.05 * size * random(4));
        // Rises, arches over, and droops; a fold along the middle.
        b.patch(cells, true, |u, v| {
            let blade = width * (PI * (0.06 + 0.92 * v)).sin().max(0.0).powf(0.7);
            let side = 2.0 * u - 1.0;
            let spine = root + out * (reach * v * v) + Vec3::Y * (rise * (v - 0.45 * v * v * v));
            spine + across * (side * blade) + Vec3::Y * (0.35 * blade * side.abs())
        });
    }
}

/// An office chair on a five-armed base with castors. Seat at 0.48 m.
pub(super) fn swivel_chair(b: &mut Builder, fabric: u32, frame: u32, metal: u32) {
    let cells = SlabCells {
        corner: b.steps(3.0, 1),
        side: b.steps(3.0, 1),
        edge: b.steps(2.0, 1),
        face: b.steps(3.0, 1),
    };
    b.paint(fabric);
    let seat = Slab { half: Vec2::new(0.25, 0.24), thickness: 0.085, corner: 0.10, edge: 0.038 };
    b.slab(seat, cells, |p| {
        let hollow = 0.025 * ((p.x / 0.25).powi(2) - 1.0);
        let fall = -0.9 * (p.z - 0.1).max(0.0).powi(2);
        p + Vec3::Y * (0.475 + hollow + fall)
    });
    let back = Slab { half: Vec2::new(0.23, 0.30), thickness: 0.06, corner: 0.11, edge: 0.027 };
    b.slab(back, cells, |p| {
        let wrap = 0.06 * (p.x / 0.23).powi(2);
        // Support for the small of the back.
        let lumbar = 0.03 * (-((p.z - 0.13) / 0.12).powi(2)).exp();
        Vec3::new(p.x, 0.86 - p.z, p.y - 0.27 + 0.16 * p.z + wrap + lumbar)
    });
    b.paint(frame);
    let tube = [b.steps(7.0, 5), b.steps(9.0, 5)];
    b.tube(tube, Vec3::X, |_| 0.022, |t| Vec3::new(0.0, 0.40 + 0.42 * t * t, -0.06 - 0.36 * t + 0.1 * t * t));
    for side in [-1.0, 1.0] {
        // The arm rest's bracket: out from under the seat and up.
        b.tube(
            tube,
            Vec3::Z,
            |_| 0.014,
            |t| {
                let (sin, cos) = (t * PI / 2.0).sin_cos();
                Vec3::new(side * (0.17 + 0.14 * sin), 0.43 + 0.24 * (1.0 - cos), -0.02)
            },
        );
        let pad = Affine3A::from_translation(Vec3::new(side * 0.31, 0.675, 0.0));
        b.at(pad, |b| plate(b, Vec3::new(0.04, 0.016, 0.13), 0.035, 0.012, |p| p));
    }
    b.paint(metal);
    b.rod([b.steps(12.0, 4), 1], Vec3::Y * 0.09, Vec3::Y * 0.45, 0.027);
    for arm in 0..5 {
        let (sin, cos) = (TAU * (arm as f32 / 5.0 + 0.05)).sin_cos();
        let out = |reach: f32, y: f32| Vec3::new(reach * cos, y, reach * sin);
        b.tube(
            [tube[0], b.steps(4.0, 2)],
            Vec3::Y,
            |t| 0.026 - 0.010 * t,
            |t| out(0.31 * t, 0.13 - 0.05 * t * t),
        );
        b.paint(frame);
        b.ball(b.steps(8.0, 4), out(0.305, 0.032), Vec3::splat(0.034));
        b.paint(metal);
    }
}

/// A desk lamp: a weighted foot, two arms, a bell. Returns where a bulb shines from, in the frame of the lamp.
pub(super) fn desk_lamp(b: &mut Builder, enamel: u32, metal: u32, glow: u32) -> Vec3 {
    let around = b.steps(20.0, 6);
    let [elbow, tip] = [Vec3::new(0.0, 0.30, -0.12), Vec3::new(0.0, 0.46, 0.14)];
    b.paint(enamel);
    let foot = [(0.09, -0.001), (0.09, 0.015), (0.075, 0.025), (0.02, 0.032), (0.0, 0.033)];
    b.lathe(&foot.map(|(r, y)| Vec2::new(r, y)), around);
    b.paint(metal);
    let arm = [b.steps(8.0, 3), b.steps(2.0, 1)];
    b.rod(arm, Vec3::new(0.0, 0.02, 0.0), elbow, 0.008);
    b.rod(arm, elbow, tip, 0.007);
    b.ball(b.steps(10.0, 4), elbow, Vec3::splat(0.017));
    b.paint(enamel);
    let head = Affine3A::from_rotation_translation(Quat::from_rotation_x(-0.35), tip);
    let mut bulb = Vec3::ZERO;
    b.at(head, |b| {
        let bell = |v: f32| Vec2::new(0.02 + 0.075 * (1.0 - v).powf(0.7), -0.09 + 0.13 * v);
        b.turned([around, b.steps(8.0, 3)], bell);
        b.turned([around, 1], |v| Vec2::new(0.02 * (1.0 - v), 0.04 + 0.004 * v));
        b.paint(glow);
        b.ball(b.steps(10.0, 4), Vec3::new(0.0, -0.03, 0.0), Vec3::splat(0.03));
        bulb = head.transform_point3(Vec3::new(0.0, -0.085, 0.0));
    });
    bulb
}
