//! What stands in a church: pews, an altar, candles, chandeliers.

use super::super::{
    architecture::{bar, moved},
    builder::Builder,
    garden::vessel,
};
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// A pew from z = 0 to `length`, looking towards +x, with carved ends.
pub(super) fn pew(b: &mut Builder, length: f32) {
    b.cuboid(Vec3::new(-0.2, 0.4, 0.02), Vec3::new(0.22, 0.45, length - 0.02));
    b.cuboid(Vec3::new(-0.26, 0.2, 0.02), Vec3::new(-0.21, 0.95, length - 0.02));
    b.cuboid(Vec3::new(-0.3, 0.93, 0.02), Vec3::new(-0.18, 0.98, length - 0.02));
    for z in [-0.03, length - 0.03] {
        b.at(moved(-0.04, 0.0, z), pew_end);
    }
}

/// A board 0.06 thick towards +z, its top swung up to a knob at the back.
fn pew_end(b: &mut Builder) {
    let (along, up) = (b.steps(6.0, 3), b.steps(1.0, 1));
    let top = |u: f32| 0.62 + 0.45 * (0.5 + 0.5 * (PI * u).cos()).powi(2);
    let at = |u: f32, v: f32, z: f32| Vec3::new(0.56 * u - 0.28, -0.02 + (top(u) + 0.02) * v, z);
    b.patch([along, up], false, |u, v| at(u, v, 0.06));
    b.patch([along, up], false, |u, v| at(1.0 - u, v, 0.0));
    b.patch([along, 1], true, |u, v| at(u, 1.0, 0.06 - 0.06 * v));
    b.quad([1, 1], at(0.0, 0.0, 0.0), Vec3::Z * 0.06, at(0.0, 1.0, 0.0) - at(0.0, 0.0, 0.0));
    b.quad([1, 1], at(1.0, 0.0, 0.06), Vec3::NEG_Z * 0.06, at(1.0, 1.0, 0.0) - at(1.0, 0.0, 0.0));
    b.at(moved(-0.25, 1.1, 0.03), |b| {
        let cells = [b.steps(6.0, 4), b.steps(4.0, 2)];
        b.turned(cells, |v| Vec2::new(0.055 * (PI * v).sin(), -0.06 * (PI * v).cos()));
    });
}

/// A candle of `height` on the origin with its flame.
pub(super) fn candle(b: &mut Builder, height: f32, radius: f32, wax: u32, flame: u32) {
    let around = b.steps(7.0, 4);
    b.paint(wax);
    b.lathe(&[Vec2::new(radius, 0.0), Vec2::new(radius, height), Vec2::new(0.0, height)], around);
    b.paint(flame);
    let cells = [around, b.steps(4.0, 2)];
    b.turned(cells, |v| {
        let bulge = (PI * v.powf(0.7)).sin().max(0.0);
        Vec2::new(0.7 * radius * bulge, height + 0.01 + 5.0 * radius * v)
    });
}

/// The candlestick of an altar, with its candle.
pub(super) fn candlestick(b: &mut Builder, gold: u32, wax: u32, flame: u32) {
    let p = Vec2::new;
    b.paint(gold);
    let outline = [
        p(0.12, -0.01),
        p(0.1, 0.04),
        p(0.03, 0.1),
        p(0.05, 0.2),
        p(0.025, 0.3),
        p(0.03, 0.45),
        p(0.09, 0.5),
        p(0.09, 0.52),
    ];
    vessel(b, 10.0, 12.0, &outline);
    b.at(moved(0.0, 0.5, 0.0), |b| candle(b, 0.4, 0.035, wax, flame));
}

/// A ring of candles that hangs from the origin by three chains of the length `drop`.
pub(super) fn chandelier(b: &mut Builder, drop: f32, [iron, wax, flame]: [u32; 3]) {
    const RADIUS: f32 = 0.95;
    b.at(moved(0.0, -drop, 0.0), |b| {
        b.paint(iron);
        let cells = [b.steps(6.0, 3), b.steps(28.0, 8)];
        bar(b, cells, 0.045, Vec3::Y, |v| {
            let (sin, cos) = (TAU * v).sin_cos();
            Vec3::new(RADIUS * cos, 0.0, RADIUS * sin)
        });
        let cells = [b.steps(4.0, 3), b.steps(1.0, 1)];
        for k in 0..3 {
            b.at(Affine3A::from_rotation_y(TAU * k as f32 / 3.0), |b| {
                bar(b, cells, 0.014, Vec3::Z, |v| Vec3::new(RADIUS * (1.0 - v), 1.6 * v, 0.0));
            });
        }
        bar(b, cells, 0.014, Vec3::Z, |v| Vec3::new(0.0, 1.58 + (drop - 1.58) * v, 0.0));
        for k in 0..10 {
            b.at(Affine3A::from_rotation_y(TAU * k as f32 / 10.0) * moved(RADIUS, 0.0, 0.0), |b| {
                b.paint(iron);
                vessel(b, 7.0, 3.0, &[Vec2::new(0.02, 0.03), Vec2::new(0.06, 0.07), Vec2::new(0.07, 0.1)]);
                candle(b, 0.3, 0.028, wax, flame);
            });
        }
    });
}

/// A table on the origin, 3 wide along z, with a cloth whose hem falls in folds. The front is towards -x.
pub(super) fn altar(b: &mut Builder, stone: u32, cloth: u32, hem: u32) {
    b.paint(stone);
    b.cuboid(Vec3::new(-0.5, -0.02, -1.4), Vec3::new(0.5, 1.0, 1.4));
    b.cuboid(Vec3::new(-0.6, 0.98, -1.55), Vec3::new(0.6, 1.1, 1.55));
    b.paint(cloth);
    let fine = b.steps(40.0, 12);
    let down = b.steps(5.0, 2);
    b.mosaic(
        [fine, down],
        true,
        |_, j| if j == 0 { hem } else { cloth },
        |u, v| {
            let fold = 0.025 * (TAU * 9.0 * u).sin() * (1.0 - v);
            Vec3::new(-0.63 - 0.03 * (1.0 - v) + fold, 0.45 + 0.66 * v, 1.5 * (2.0 * u - 1.0))
        },
    );
    b.paint(cloth);
    b.quad([1, 1], Vec3::new(-0.63, 1.11, -1.5), Vec3::Z * 3.0, Vec3::X * 1.2);
}

/// A cross on the origin, facing -x.
pub(super) fn cross(b: &mut Builder, gold: u32) {
    b.paint(gold);
    vessel(b, 12.0, 5.0, &[Vec2::new(0.16, -0.01), Vec2::new(0.13, 0.06), Vec2::new(0.03, 0.14)]);
    let cells = [b.steps(8.0, 4), b.steps(2.0, 1)];
    bar(b, cells, 0.035, Vec3::X, |v| Vec3::new(0.0, 0.1 + 1.1 * v, 0.0));
    bar(b, cells, 0.035, Vec3::X, |v| Vec3::new(0.0, 0.85, 0.7 * (v - 0.5)));
    b.at(moved(0.0, 0.85, 0.0) * Affine3A::from_rotation_x(FRAC_PI_2), |b| {
        let cells = [b.steps(8.0, 4), b.steps(20.0, 8)];
        bar(b, cells, 0.02, Vec3::X, |v| {
            let (sin, cos) = (TAU * v).sin_cos();
            Vec3::new(0.0, 0.2 * cos, 0.2 * sin)
        });
    });
}
