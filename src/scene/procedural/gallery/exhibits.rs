//! What the gallery shows.

use super::{HALF, Palette, room::hung};
use crate::scene::procedural::{
    builder::Builder,
    furniture::{plate, set},
    hash::unit,
};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

pub(super) fn build(b: &mut Builder, m: &Palette) {
    pictures(b, m);
    let top = 0.98;
    for (name, x, z) in
        [("stone", -2.55, -1.7), ("glass", -0.75, -1.35), ("chrome", 0.95, -1.55), ("vase", 2.5, -1.15)]
    {
        b.part(name);
        b.at(set(x, 0.0, z, 0.0), |b| {
            plinth(b, m, top);
            b.at(set(0.0, top, 0.0, 0.0), |b| exhibit(b, m, name));
        });
    }
    b.part("bench");
    b.at(set(1.75, 0.0, 0.75, -14.0), |b| bench(b, m));
    b.part("plants");
    b.at(set(-4.0, 0.0, -2.85, 0.0), |b| plant(b, m, 1.15, 1));
    b.at(set(4.02, 0.0, -2.9, 120.0), |b| plant(b, m, 0.95, 2));
}

/// What stands on a plinth, on y = 0. Nothing touches: rays in glass need to know what they are in.
fn exhibit(b: &mut Builder, m: &Palette, name: &str) {
    let gap = 0.0005;
    let around = b.steps(64.0, 8);
    match name {
        "stone" => {
            b.paint(m.stone);
            b.tiled(Vec2::new(3.0, 1.5), |b| b.ball(around, Vec3::Y * (0.27 + gap), Vec3::splat(0.27)));
        }
        "glass" => {
            b.paint(m.glass);
            b.ball(around, Vec3::Y * (0.29 + gap), Vec3::splat(0.29));
        }
        "chrome" => {
            b.paint(m.chrome);
            let cells = [around, b.steps(48.0, 6)];
            b.turned(cells, |v| {
                // A drop: a ball drawn out to a tip.
                let angle = PI * v;
                let reach =
                    if v > 0.0 && v < 1.0 { angle.sin() * (0.5 * angle).cos().powf(0.8) } else { 0.0 };
                Vec2::new(0.33 * reach, gap + 0.34 * (1.0 - angle.cos()))
            });
        }
        _ => {
            b.paint(m.bottle);
            b.turned([around, b.steps(56.0, 12)], |v| vase(v) + Vec2::Y * gap);
        }
    }
}

/// A vase of thick glass, once around its section: from the middle of the foot up the outside, over the lip and down the
/// inside to the middle of the bottom.
fn vase(v: f32) -> Vec2 {
    const SECTION: [[f32; 2]; 17] = [
        [0.0, 0.0],
        [0.07, 0.0],
        [0.115, 0.012],
        [0.135, 0.07],
        [0.165, 0.20],
        [0.175, 0.32],
        [0.14, 0.43],
        [0.10, 0.50],
        [0.105, 0.56],
        [0.150, 0.615],
        [0.143, 0.622],
        [0.092, 0.565],
        [0.086, 0.50],
        [0.125, 0.42],
        [0.157, 0.31],
        [0.11, 0.075],
        [0.0, 0.05],
    ];
    let at = v * (SECTION.len() - 1) as f32;
    let i = (at as usize).min(SECTION.len() - 2);
    let t = at - i as f32;
    // Beyond the axis, the section goes on as its mirror image.
    let point = |k: isize| {
        let last = SECTION.len() as isize - 1;
        let [r, y] = SECTION[if k < 0 { -k } else { last - (k - last).abs() } as usize];
        if (0..=last).contains(&k) { Vec2::new(r, y) } else { Vec2::new(-r, y) }
    };
    let [p, q, r, s] = [-1, 0, 1, 2].map(|k| point(i as isize + k));
    // Catmull and Rom's spline.
    let curve =
        q + 0.5 * t * ((r - p) + t * ((2.0 * p - 5.0 * q + 4.0 * r - s) + t * (3.0 * (q - r) + s - p)));
    if v > 0.0 && v < 1.0 { Vec2::new(curve.x.max(0.0), curve.y) } else { Vec2::new(0.0, curve.y) }
}

fn plinth(b: &mut Builder, m: &Palette, top: f32) {
    b.paint(m.white);
    b.cuboid(Vec3::new(-0.23, 0.0, -0.23), Vec3::new(0.23, top - 0.03, 0.23));
    b.at(set(0.0, top - 0.015, 0.0, 0.0), |b| plate(b, Vec3::new(0.25, 0.015, 0.25), 0.02, 0.006, |p| p));
}

fn bench(b: &mut Builder, m: &Palette) {
    b.paint(m.oak);
    for z in [-0.17, 0.0, 0.17] {
        b.at(set(0.0, 0.43, z, 0.0), |b| plate(b, Vec3::new(0.85, 0.025, 0.075), 0.02, 0.01, |p| p));
    }
    b.paint(m.dark);
    for x in [-0.62, 0.62] {
        b.cuboid(Vec3::new(x - 0.02, 0.38, -0.22), Vec3::new(x + 0.02, 0.404, 0.22));
        for z in [-0.2, 0.2] {
            b.cuboid(Vec3::new(x - 0.02, 0.0, z - 0.02), Vec3::new(x + 0.02, 0.38, z + 0.02));
        }
    }
}

fn pictures(b: &mut Builder, m: &Palette) {
    let [dusk, bars, julia, rings] = m.pictures;
    let back = |x: f32| hung(Vec3::new(x, 1.72, -HALF.y), 0.0);
    let right = |z: f32| hung(Vec3::new(HALF.x, 1.62, z), -90.0);
    b.part("pictures");
    for (place, material, half) in [
        (back(-3.05), m.panes, Vec2::splat(0.5)),
        (back(-1.55), rings, Vec2::splat(0.52)),
        (back(0.15), dusk, Vec2::new(0.72, 0.54)),
        (back(1.75), bars, Vec2::splat(0.5)),
        (back(3.1), julia, Vec2::splat(0.5)),
    ] {
        b.at(place, |b| framed(b, m.dark, material, half));
    }
    b.part("mirror");
    b.at(right(-0.9), |b| framed(b, m.oak, m.mirror, Vec2::new(0.75, 1.0)));
}

/// A picture of twice `half` in a frame, facing +z.
fn framed(b: &mut Builder, frame: u32, material: u32, half: Vec2) {
    b.paint(material);
    let (wide, deep) = (0.045, 0.035);
    let corner = Vec3::new(-half.x, -half.y, 0.5 * deep);
    b.tiled(Vec2::ONE, |b| b.quad([1, 1], corner, Vec3::X * 2.0 * half.x, Vec3::Y * 2.0 * half.y));
    b.paint(frame);
    let outer = half + wide;
    for side in [-1.0, 1.0] {
        let (a, z) = (side * half.y, side * outer.y);
        b.cuboid(Vec3::new(-outer.x, a.min(z), 0.0), Vec3::new(outer.x, a.max(z), deep));
        let (a, z) = (side * half.x, side * outer.x);
        b.cuboid(Vec3::new(a.min(z), -half.y, 0.0), Vec3::new(a.max(z), half.y, deep));
    }
}

/// A Swiss cheese plant: flat leaves, cut out of pictures, on bent stems.
fn plant(b: &mut Builder, m: &Palette, size: f32, seed: u32) {
    let around = b.steps(24.0, 6);
    b.paint(m.pot);
    let profile =
        [(0.0, 0.001), (0.14, 0.001), (0.19, 0.30), (0.205, 0.31), (0.205, 0.35), (0.185, 0.35), (0.18, 0.3)];
    b.lathe(&profile.map(|(r, y)| Vec2::new(r, y) * size), around);
    b.paint(m.soil);
    b.turned([around, b.steps(2.0, 1)], |v| Vec2::new(0.181 * (1.0 - v), 0.31 + 0.015 * v) * size);
    for i in 0..11 {
        let random = |k: u32| unit(seed * 977 + i * 11 + k, 5);
        let turn = TAU * (i as f32 * 0.382 + 0.1 * random(0));
        let (reach, rise) = (size * (0.14 + 0.3 * random(1)), size * (0.75 + 0.75 * random(2)));
        let (out, across) = (Vec3::new(turn.cos(), 0.0, turn.sin()), Vec3::new(-turn.sin(), 0.0, turn.cos()));
        let stem = move |t: f32| out * (reach * t * t) + Vec3::Y * (size * 0.3 + (rise - size * 0.3) * t);
        b.paint(m.stem);
        let cells = [b.steps(6.0, 3), b.steps(6.0, 3)];
        b.patch(cells, true, |u, v| {
            let (sin, cos) = (-u * TAU).sin_cos();
            stem(v) + (out * cos + across * sin) * (0.006 * size)
        });
        b.paint(m.leaf);
        let length = size * (0.30 + 0.16 * random(3));
        let droop = 0.5 + 0.9 * random(4);
        let cells = [b.steps(4.0, 2), b.steps(6.0, 3)];
        b.tiled(Vec2::ONE, |b| {
            b.patch(cells, true, |u, v| {
                let side = 2.0 * u - 1.0;
                let bend = Vec3::Y * (0.35 - droop * v) * v;
                let fold = Vec3::Y * (0.10 * side * side);
                stem(1.0) + (out * v + bend + fold + across * (0.45 * side)) * length
            });
        });
    }
}
