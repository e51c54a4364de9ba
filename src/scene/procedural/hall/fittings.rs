//! What stands and hangs in the hall: lamps, curtains, the panel's table, the lectern, plants.

use super::{FRONT, HALF_WIDTH, HEIGHT, Paints, STAGE};
use crate::scene::procedural::{
    builder::Builder,
    furniture::{plant, plate, set, stacking_chair, turned_leg},
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Velvet curtains on both sides of the stage.
pub(super) fn curtains(b: &mut Builder, paints: &Paints) {
    b.part("curtains");
    b.paint(paints.velvet);
    let cells = [b.steps(110.0, 66), b.steps(24.0, 3)];
    for side in [-1.0, 1.0] {
        b.patch(cells, true, |u, t| {
            // Folds are shallow at the rail and deep at the hem.
            let fold = (0.05 + 0.09 * (1.0 - t)) * (u * 11.0 * TAU + 0.8 * (5.0 * u).sin()).sin();
            let x = side * (6.0 + HALF_WIDTH) / 2.0 + (u - 0.5) * (HALF_WIDTH - 5.75);
            v(x, 0.03 + (HEIGHT - 0.55) * t, FRONT + 2.4 + fold)
        });
    }
    b.paint(paints.brass);
    let rail = [b.steps(10.0, 4), b.steps(2.0, 1)];
    for side in [-1.0, 1.0] {
        let y = HEIGHT - 0.5;
        b.rod(rail, v(side * 5.6, y, FRONT + 2.4), v(side * (HALF_WIDTH + 0.02), y, FRONT + 2.4), 0.04);
    }
}

/// The table on the stage: turned legs, chairs, microphones, glasses, name plates.
pub(super) fn panel_table(b: &mut Builder, paints: &Paints) {
    b.part("panel table");
    b.at(set(-1.4, STAGE[1], -8.5, 0.0), |b| {
        b.paint(paints.walnut);
        b.at(Affine3A::from_translation(v(0.0, 0.735, 0.0)), |b| {
            plate(b, v(2.5, 0.025, 0.42), 0.08, 0.02, |p| p);
        });
        b.block(b.steps(3.0, 1), v(-2.36, 0.60, 0.27), v(2.36, 0.715, 0.30));
        for x in [-2.3, -0.77, 0.77, 2.3] {
            for z in [-0.28, 0.28] {
                b.at(set(x, -0.002, z, 0.0), |b| turned_leg(b, 0.72, 0.045));
            }
        }
        for i in 0..5 {
            let x = (i as f32 - 2.0) * 0.96;
            b.at(set(x, 0.0, -0.62, 4.0 * (i as f32 - 2.0)), |b| {
                stacking_chair(b, paints.walnut, paints.accent, paints.steel);
            });
            b.at(set(x, 0.76, 0.0, 0.0), |b| place_setting(b, paints, i));
        }
    });
    for (x, seed) in [(-5.9, 3), (6.05, 8)] {
        b.at(set(x, STAGE[1], -9.9, 0.0), |b| {
            plant(b, paints.brass, paints.walnut, paints.leaf, 46, 1.25, seed);
        });
    }
}

fn place_setting(b: &mut Builder, paints: &Paints, i: u32) {
    let around = b.steps(14.0, 5);
    b.paint(paints.steel);
    b.at(set(0.16, 0.0, 0.05, 0.0), |b| {
        b.turned([around, b.steps(4.0, 2)], |t| {
            Vec2::new(0.055 * (1.0 - t * t).max(0.0).sqrt(), -0.002 + 0.025 * t)
        });
        let bow = |t: f32| v(-0.02, 0.01 + 0.30 * t, -0.16 * t * t);
        b.tube([b.steps(8.0, 3), b.steps(10.0, 3)], Vec3::X, |_| 0.006, bow);
        b.ball(around, bow(1.0), v(0.018, 0.026, 0.022));
    });
    b.paint(paints.glass);
    let z = 0.1 - 0.03 * (i % 2) as f32;
    b.at(set(-0.2, 0.0, z, 0.0), |b| {
        let profile =
            [(0.0, 0.0015), (0.028, 0.0015), (0.034, 0.11), (0.031, 0.11), (0.027, 0.012), (0.0, 0.011)];
        b.lathe(&profile.map(|(r, y)| Vec2::new(r, y)), around);
    });
    b.paint(paints.plaster);
    // A folded name plate, seen from the hall.
    b.at(set(0.0, 0.002, 0.28, 0.0), |b| {
        let n = [b.steps(2.0, 1); 2];
        b.quad(n, v(-0.13, 0.0, 0.04), v(0.26, 0.0, 0.0), v(0.0, 0.09, -0.04));
        b.quad(n, v(0.13, 0.0, -0.04), v(-0.26, 0.0, 0.0), v(0.0, 0.09, 0.04));
    });
}

/// The speaker's desk.
pub(super) fn lectern(b: &mut Builder, paints: &Paints) {
    b.part("lectern");
    b.at(set(3.2, STAGE[1], -7.9, 14.0), |b| {
        b.paint(paints.walnut);
        plate_at(b, v(0.0, 0.03, 0.0), v(0.36, 0.034, 0.28), |p| p);
        b.paint(paints.oak);
        // The body swells outwards at the top.
        plate_at(b, v(0.0, 0.55, 0.02), v(0.24, 0.5, 0.16), |p| {
            let flare = 1.0 + 0.25 * (p.y + 0.5).max(0.0).powi(2);
            v(p.x * flare, p.y, p.z * flare)
        });
        b.paint(paints.walnut);
        plate_at(b, v(0.0, 1.09, -0.02), v(0.36, 0.022, 0.26), |p| v(p.x, p.y + 0.28 * p.z, p.z));
        b.paint(paints.brass);
        let upright =
            Affine3A::from_rotation_translation(Quat::from_rotation_x(PI / 2.0), v(0.0, 0.72, 0.186));
        b.at(upright, |b| {
            b.turned([b.steps(28.0, 8), b.steps(4.0, 2)], |t| {
                Vec2::new(0.11 * (1.0 - t), 0.012 + 0.012 * (1.0 - (1.0 - t).powi(4)))
            });
        });
        b.paint(paints.steel);
        for side in [-1.0, 1.0] {
            let bow = |t: f32| v(side * (0.16 - 0.08 * t), 1.08 + 0.34 * t, 0.14 - 0.2 * t * t);
            b.tube([b.steps(8.0, 3), b.steps(12.0, 3)], Vec3::X, |_| 0.007, bow);
            b.ball(b.steps(12.0, 5), bow(1.0), v(0.02, 0.028, 0.026));
        }
    });
}

fn plate_at(b: &mut Builder, at: Vec3, half: Vec3, bend: impl Fn(Vec3) -> Vec3) {
    b.at(Affine3A::from_translation(at), |b| plate(b, half, 0.05, 0.02, bend));
}

/// Four pendants over the audience and bars of spot lamps over the stage.
pub(super) fn lamps(b: &mut Builder, paints: &Paints) {
    b.part("lamps");
    for (x, z) in [(-4.0, -2.0), (4.0, -2.0), (-4.0, 5.0), (4.0, 5.0)] {
        b.at(set(x, 3.5, z, 0.0), |b| pendant(b, paints));
    }
    b.paint(paints.steel);
    let bar = [b.steps(10.0, 4), b.steps(4.0, 1)];
    b.rod(bar, v(-6.0, 4.62, -5.9), v(6.0, 4.62, -5.9), 0.03);
    for i in 0..8 {
        let x = (i as f32 - 3.5) * 1.45;
        b.paint(paints.steel);
        let aim = Quat::from_rotation_x(0.75) * Quat::from_rotation_z(0.2 * (i as f32 - 3.5) / 3.5);
        b.at(Affine3A::from_rotation_translation(aim, v(x, 4.42, -5.9)), |b| {
            let profile = [(0.11, -0.16), (0.09, 0.02), (0.05, 0.12), (0.02, 0.16), (0.0, 0.165)];
            b.lathe(&profile.map(|(r, y)| Vec2::new(r, y)), b.steps(18.0, 6));
            b.paint(paints.glow);
            b.turned([b.steps(18.0, 6), b.steps(3.0, 2)], |t| {
                Vec2::new(0.104 * t, -0.14 - 0.03 * (1.0 - t * t))
            });
        });
    }
}

/// A drum of three glowing rings with brass rims, hung from a rod; its light shines from just below.
fn pendant(b: &mut Builder, paints: &Paints) {
    b.paint(paints.brass);
    b.rod([b.steps(8.0, 3), 1], v(0.0, 0.18, 0.0), v(0.0, HEIGHT - 3.4, 0.0), 0.015);
    for (i, radius) in [0.62, 0.44, 0.26].into_iter().enumerate() {
        let y = 0.03 + 0.1 * i as f32;
        b.paint(paints.glow);
        ring(b, y, radius, [0.028, 0.045]);
        b.paint(paints.brass);
        ring(b, y + 0.045, radius, [0.036, 0.008]);
        for spoke in 0..3 {
            let (sin, cos) = ((spoke as f32 / 3.0 + 0.1 * i as f32) * TAU).sin_cos();
            let arm = [b.steps(6.0, 3), b.steps(2.0, 1)];
            b.rod(arm, v(0.0, y + 0.16, 0.0), v(radius * cos, y + 0.04, radius * sin), 0.007);
        }
    }
}

/// A torus about the y axis with an elliptic section.
fn ring(b: &mut Builder, y: f32, radius: f32, section: [f32; 2]) {
    b.turned([b.steps(48.0, 10), b.steps(10.0, 4)], |t| {
        let (sin, cos) = (t * TAU).sin_cos();
        Vec2::new(radius + section[0] * cos, y + section[1] * sin)
    });
}
