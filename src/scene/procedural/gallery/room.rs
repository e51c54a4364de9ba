//! The room of the gallery: floor, walls with a window, ceiling with lamps.

use super::{HALF, HIGH, LAMP_HALF, LAMP_Z, LAMPS, Palette};
use crate::scene::procedural::builder::Builder;
use glam::{Affine3A, Quat, Vec2, Vec3};

pub(super) fn build(b: &mut Builder, m: &Palette) {
    let (wide, deep) = (2.0 * HALF.x, 2.0 * HALF.y);
    let fine = [b.steps(6.0, 1), b.steps(6.0, 1)];
    let corner = Vec3::new(-HALF.x, 0.0, -HALF.y);
    b.part("floor");
    b.paint(m.floor);
    b.tiled(Vec2::new(deep, wide) / 1.6, |b| b.quad(fine, corner, Vec3::Z * deep, Vec3::X * wide));
    b.part("ceiling");
    b.paint(m.white);
    b.quad(fine, corner + Vec3::Y * HIGH, Vec3::X * wide, Vec3::Z * deep);
    b.part("walls");
    b.paint(m.wall);
    b.quad(fine, corner, Vec3::X * wide, Vec3::Y * HIGH);
    b.quad(fine, Vec3::new(HALF.x, 0.0, HALF.y), -Vec3::X * wide, Vec3::Y * HIGH);
    b.quad(fine, Vec3::new(HALF.x, 0.0, -HALF.y), Vec3::Z * deep, Vec3::Y * HIGH);
    window_wall(b, m);
    skirting(b, m);
    lamps(b, m);
}

/// The left wall around a window from floor to door height.
fn window_wall(b: &mut Builder, m: &Palette) {
    let (near, far) = (1.6, -0.9);
    let (low, high) = (0.5, 2.7);
    let lines = |stops: [f32; 4]| move |t: f32| stops[(3.0 * t).round() as usize];
    let (z, y) = (lines([HALF.y, near, far, -HALF.y]), lines([0.0, low, high, HIGH]));
    for (i, j) in [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1), (0, 2), (1, 2), (2, 2)] {
        let at = |k: usize| k as f32 / 3.0;
        let corner = Vec3::new(-HALF.x, y(at(j)), z(at(i)));
        b.quad([1, 1], corner, Vec3::Z * (z(at(i + 1)) - z(at(i))), Vec3::Y * (y(at(j + 1)) - y(at(j))));
    }
    b.part("window");
    b.paint(m.dark);
    let mut bar = |min: Vec3, max: Vec3| b.cuboid(min, max);
    let x = [-HALF.x - 0.09, -HALF.x + 0.05];
    let upright = |z: f32| (Vec3::new(x[0], low, z - 0.03), Vec3::new(x[1], high, z + 0.03));
    for z in [near, near - (near - far) / 3.0, far + (near - far) / 3.0, far] {
        let (min, max) = upright(z);
        bar(min, max);
    }
    for y in [low, high] {
        bar(Vec3::new(x[0], y - 0.03, far), Vec3::new(x[1], y + 0.03, near));
    }
}

fn skirting(b: &mut Builder, m: &Palette) {
    b.part("skirting");
    b.paint(m.white);
    let (x, z, high, thick) = (HALF.x, HALF.y, 0.09, 0.018);
    for side in [-1.0, 1.0] {
        let wall = side * z;
        b.cuboid(
            Vec3::new(-x, 0.0, wall.min(wall - side * thick)),
            Vec3::new(x, high, wall.max(wall - side * thick)),
        );
        let wall = side * x;
        b.cuboid(
            Vec3::new(wall.min(wall - side * thick), 0.0, -z),
            Vec3::new(wall.max(wall - side * thick), high, z),
        );
    }
}

/// Flat lamps on rods. What is seen of them glows; the lights themselves hang just below.
fn lamps(b: &mut Builder, m: &Palette) {
    b.part("lamps");
    for x in LAMPS {
        let half = Vec3::new(LAMP_HALF.x + 0.03, 0.0, LAMP_HALF.y + 0.03);
        let middle = Vec3::new(x, HIGH - 0.3, LAMP_Z);
        b.paint(m.dark);
        b.cuboid(middle - half, middle + half + Vec3::Y * 0.05);
        for side in [-0.5, 0.5] {
            let foot = middle + Vec3::new(side, 0.05, 0.0);
            b.rod([b.steps(8.0, 4), 1], foot, Vec3::new(foot.x, HIGH, foot.z), 0.012);
        }
        b.paint(m.glow);
        let corner = middle - Vec3::new(LAMP_HALF.x, 0.004, LAMP_HALF.y);
        b.quad([1, 1], corner, Vec3::X * 2.0 * LAMP_HALF.x, Vec3::Z * 2.0 * LAMP_HALF.y);
    }
}

/// Places what faces +z in its own frame onto the wall that faces `degrees` about y, at `at`.
pub(super) fn hung(at: Vec3, degrees: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(degrees.to_radians()), at)
}
