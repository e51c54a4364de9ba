//! Bookcases along the far wall.

use super::{HALF, Paints};
use crate::scene::procedural::{builder::Builder, furniture::set, hash};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::PI;

const WIDTH: f32 = 1.1;
const DEPTH: f32 = 0.30;
const LEVELS: u32 = 5;
const LEVEL: f32 = 0.38;
const BOARD: f32 = 0.022;

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Three bookcases, full of books and a few other things.
pub(super) fn shelves(b: &mut Builder, paints: &Paints) {
    for case in 0..3 {
        b.part("bookcase");
        let x = -2.0 + case as f32 * (WIDTH + 0.035);
        b.at(set(x, 0.0, -HALF.y + 0.02, 0.0), |b| {
            carcass(b, paints);
            for level in 0..LEVELS {
                let y = 0.08 + BOARD + level as f32 * LEVEL;
                fill(b, paints, case * LEVELS + level, y);
            }
        });
    }
}

fn carcass(b: &mut Builder, paints: &Paints) {
    let n = b.steps(1.0, 1);
    b.paint(paints.wood);
    let (half, top) = (WIDTH / 2.0, 0.08 + BOARD + LEVELS as f32 * LEVEL);
    for side in [-1.0, 1.0] {
        let x = side * (half - BOARD / 2.0);
        b.block(n, v(x - BOARD / 2.0, -0.01, 0.0), v(x + BOARD / 2.0, top + 0.001, DEPTH));
    }
    for level in 0..=LEVELS {
        let y = 0.08 + level as f32 * LEVEL;
        b.block(n, v(-half + 0.005, y, 0.001), v(half - 0.005, y + BOARD, DEPTH - 0.004));
    }
    b.paint(paints.white);
    b.block(n, v(-half + 0.006, 0.02, 0.002), v(half - 0.006, top - 0.005, 0.012));
}

/// Books side by side from the left; where they end, the last one leans, and an ornament fills the rest.
fn fill(b: &mut Builder, paints: &Paints, shelf: u32, y: f32) {
    let random = |i: u32, k: u32| hash::unit(shelf * 1009 + i * 11 + k, 0);
    let end = WIDTH / 2.0 - 0.04;
    let stop = if shelf % 4 == 1 { end - 0.38 } else { end - 0.09 };
    // Fewer, thicker books where little detail is wanted.
    let scale = b.steps(10.0, 3).min(10) as f32 / 10.0;
    let mut x = -end;
    let mut i = 0;
    while x < stop {
        let thick = ((0.027 + 0.034 * random(i, 0)) / scale).min(end + 0.02 - x);
        let size = v(thick, 0.20 + 0.11 * random(i, 1), 0.15 + 0.06 * random(i, 2));
        let paint = paints.books[(random(i, 3) * 6.0) as usize];
        b.at(set(x, y - 0.001, 0.265 - 0.02 * random(i, 4) - size.z, 0.0), |b| book(b, paints, size, paint));
        x += thick + 0.0015;
        i += 1;
    }
    if x + 0.13 < end {
        let lean = Affine3A::from_rotation_translation(Quat::from_rotation_z(0.22), v(x + 0.055, y, 0.08));
        b.at(lean, |b| book(b, paints, v(0.03, 0.24, 0.17), paints.books[(shelf % 6) as usize]));
    }
    if shelf % 4 == 1 {
        b.at(set(x + 0.24, y - 0.001, 0.17, 0.0), |b| {
            vase(b, if shelf % 8 == 1 { paints.teal } else { paints.clay });
        });
    }
}

/// A book, its spine towards +z: boards, a rounded spine with a label, and the pages between.
fn book(b: &mut Builder, paints: &Paints, size: Vec3, paint: u32) {
    let n = b.steps(1.0, 1);
    b.paint(paint);
    let round = 0.004;
    b.block(n, v(0.0, 0.0, 0.0), size - v(0.0, 0.0, 0.001));
    b.patch([b.steps(2.0, 2), n], true, |u, t| {
        let bulge = round * (1.0 - (2.0 * u - 1.0).powi(2));
        v(size.x * u, size.y * t, size.z + bulge)
    });
    b.paint(paints.books[4]);
    if size.y > 0.24 {
        let label = |t: f32| v(0.2 * size.x, size.y * t, size.z + round);
        b.quad([n, n], label(0.68), v(0.6 * size.x, 0.0, 0.0), v(0.0, 0.04, 0.0));
    }
}

fn vase(b: &mut Builder, paint: u32) {
    b.paint(paint);
    b.turned([b.steps(20.0, 6), b.steps(14.0, 4)], |t| {
        Vec2::new(0.035 + 0.055 * (PI * t.powf(0.8)).sin() - 0.012 * t, 0.24 * t)
    });
}
