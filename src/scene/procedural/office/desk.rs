//! A desk and what lies on it. The user sits at +z.

use super::{Paints, room::upright};
use crate::scene::procedural::{
    builder::Builder,
    furniture::{plate, set},
    hash,
};
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::PI;

/// Height of a desk's top.
pub(super) const TOP: f32 = 0.74;

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Desk number `i` with its computer and clutter.
pub(super) fn desk(b: &mut Builder, paints: &Paints, i: u32) {
    b.paint(paints.wood);
    plate_at(b, v(0.0, TOP - 0.014, 0.0), v(0.795, 0.014, 0.395), 0.03, 0.010);
    b.paint(paints.steel);
    let n = b.steps(2.0, 1);
    for side in [-1.0, 1.0] {
        let x = side * 0.74;
        b.block(n, v(x - 0.02, 0.03, 0.29), v(x + 0.02, TOP - 0.02, 0.33));
        b.block(n, v(x - 0.02, 0.03, -0.33), v(x + 0.02, TOP - 0.02, -0.29));
        b.block(n, v(x - 0.025, -0.004, -0.37), v(x + 0.025, 0.04, 0.37));
    }
    upright(b, paints.white, v(0.0, 0.50, -0.31), v(0.70, 0.18, 0.008));
    pedestal(b, paints);
    b.at(set(0.05, TOP, -0.17, 6.0 - 4.0 * i as f32), |b| monitor(b, paints, i));
    b.at(set(-0.02, TOP, 0.17, 3.0 - 2.0 * i as f32), |b| keyboard(b, paints));
    clutter(b, paints, i);
}

fn plate_at(b: &mut Builder, at: Vec3, half: Vec3, corner: f32, edge: f32) {
    b.at(Affine3A::from_translation(at), |b| plate(b, half, corner, edge, |p| p));
}

/// Three drawers on castors under the right side.
fn pedestal(b: &mut Builder, paints: &Paints) {
    b.at(set(0.48, 0.0, 0.0, 0.0), |b| {
        b.paint(paints.white);
        b.block(b.steps(2.0, 1), v(-0.2, 0.05, -0.26), v(0.2, 0.6, 0.26));
        for drawer in 0..3 {
            let y = 0.145 + 0.178 * drawer as f32;
            upright(b, paints.white, v(0.0, y, 0.265), v(0.195, 0.083, 0.012));
            b.paint(paints.steel);
            let handle = [b.steps(6.0, 3), b.steps(8.0, 3)];
            b.tube(
                handle,
                Vec3::Y,
                |_| 0.005,
                |t| v(-0.06 + 0.12 * t, y + 0.04, 0.272 + 0.024 * (PI * t).sin().max(0.0).sqrt()),
            );
        }
        b.paint(paints.dark);
        for (x, z) in [(-0.16, -0.21), (0.16, -0.21), (-0.16, 0.21), (0.16, 0.21)] {
            b.ball(b.steps(8.0, 4), v(x, 0.027, z), Vec3::splat(0.029));
        }
    });
}

/// A flat screen on a foot, with a few windows open.
fn monitor(b: &mut Builder, paints: &Paints, i: u32) {
    b.paint(paints.dark);
    plate_at(b, v(0.0, 0.006, -0.02), v(0.12, 0.007, 0.09), 0.04, 0.005);
    b.tube(
        [b.steps(8.0, 4), b.steps(4.0, 2)],
        Vec3::X,
        |_| 0.018,
        |t| v(0.0, 0.005 + 0.28 * t, -0.045 - 0.01 * t),
    );
    upright(b, paints.dark, v(0.0, 0.34, -0.02), v(0.30, 0.185, 0.016));
    b.paint(paints.screen);
    let n = [b.steps(2.0, 1); 2];
    b.quad(n, v(-0.286, 0.172, -0.002), v(0.572, 0.0, 0.0), v(0.0, 0.336, 0.0));
    let mut mark = |paint: u32, depth: f32, x: f32, y: f32, w: f32, h: f32| {
        b.paint(paint);
        b.quad([b.steps(1.0, 1); 2], v(x, y, depth), v(w, 0.0, 0.0), v(0.0, h, 0.0));
    };
    let shift = 0.03 * (i % 3) as f32;
    mark(paints.window, -0.0005, -0.25 + shift, 0.20, 0.30, 0.27);
    mark(paints.window, -0.0005, 0.10 + shift, 0.25, 0.13, 0.17);
    for line in 0..9 {
        let length = 0.06 + 0.18 * hash::unit(i * 31 + line, 0);
        let indent = 0.02 * (hash::unit(i * 57 + line, 0) * 3.0).floor();
        mark(paints.text, 0.001, -0.235 + shift + indent, 0.44 - 0.026 * line as f32, length, 0.011);
    }
    for bar in 0..5 {
        mark(
            paints.text,
            0.001,
            0.11 + shift + 0.022 * bar as f32,
            0.262,
            0.014,
            0.03 + 0.11 * hash::unit(i * 91 + bar, 0),
        );
    }
}

/// Five rows of keys, and a mouse beside them.
fn keyboard(b: &mut Builder, paints: &Paints) {
    b.paint(paints.dark);
    plate_at(b, v(0.0, 0.008, 0.0), v(0.225, 0.009, 0.07), 0.012, 0.006);
    b.paint(paints.white);
    // Fewer, wider keys where little detail is wanted.
    let keys = b.steps(14.0, 3).min(14);
    let wide = 0.424 / keys as f32;
    for row in 0..5 {
        let z = -0.0625 + 0.0255 * row as f32;
        let mut key = 0;
        while key < keys {
            // The space bar.
            let span = if row == 4 && key == keys / 4 { (keys / 2).max(1) } else { 1 };
            let x = -0.212 + wide * key as f32;
            keycap(b, v(x, 0.0165, z), Vec2::new(wide * span as f32 - 0.003, 0.0215));
            key += span;
        }
    }
    b.paint(paints.dark);
    b.ball(b.steps(14.0, 6), v(0.31, 0.006, 0.01), v(0.031, 0.026, 0.052));
}

/// The five visible faces of a key.
fn keycap(b: &mut Builder, corner: Vec3, size: Vec2) {
    let n = [b.steps(1.0, 1); 2];
    let height = 0.008;
    let taper = 0.0025;
    let low = |x: f32, z: f32| corner + v(x * size.x, 0.0, z * size.y);
    let high = |x: f32, z: f32| {
        corner + v(taper + x * (size.x - 2.0 * taper), height, taper + z * (size.y - 2.0 * taper))
    };
    b.patch(n, false, |u, t| high(u, 1.0 - t));
    // Sides counter-clockwise as seen from above.
    let round = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0), (0.0, 1.0)];
    for side in round.windows(2) {
        let [from, to] = [side[0], side[1]].map(|(x, z)| Vec2::new(x, z));
        b.patch(n, false, |u, t| {
            let p = from.lerp(to, u);
            low(p.x, p.y).lerp(high(p.x, p.y), t)
        });
    }
}

/// A mug, papers, a book or two.
fn clutter(b: &mut Builder, paints: &Paints, i: u32) {
    let around = b.steps(20.0, 6);
    b.at(set(-0.42, TOP, 0.12 - 0.05 * i as f32, 30.0 + 50.0 * i as f32), |b| {
        b.paint([paints.rust, paints.white, paints.teal, paints.yellow][i as usize % 4]);
        let profile = [
            (0.0, 0.0015),
            (0.036, 0.0015),
            (0.041, 0.01),
            (0.041, 0.095),
            (0.037, 0.095),
            (0.036, 0.012),
            (0.0, 0.011),
        ];
        b.lathe(&profile.map(|(r, y)| Vec2::new(r, y)), around);
        b.tube(
            [b.steps(7.0, 3), b.steps(10.0, 4)],
            Vec3::Z,
            |_| 0.006,
            |t| {
                let (sin, cos) = ((t - 0.5) * PI).sin_cos();
                v(0.038 + 0.03 * cos, 0.05 + 0.03 * sin, 0.0)
            },
        );
    });
    b.paint(paints.white);
    for sheet in 0..4 {
        let turn = 12.0 * (hash::unit(i * 17 + sheet, 0) - 0.5) + 20.0;
        b.at(set(0.52, TOP + 0.0015 + 0.0025 * sheet as f32, 0.18, turn), |b| {
            b.block(b.steps(1.0, 1), v(-0.105, 0.0, -0.148), v(0.105, 0.0015, 0.148));
        });
    }
    for k in 0..3 {
        let y = TOP + 0.001 + 0.032 * k as f32;
        b.paint(paints.books[((i * 5 + k * 7) % 6) as usize]);
        b.at(set(0.58, y, -0.18, 40.0 * (hash::unit(i * 23 + k, 0) - 0.5)), |b| {
            b.block(b.steps(1.0, 1), v(-0.09, 0.0, -0.12), v(0.09, 0.03, 0.12));
        });
    }
}
