//! The shell of the hall: floor, panelled walls, doors, ceiling, stage.

use super::{FRONT, HALF_WIDTH, HEIGHT, Paints, REAR, STAGE};
use crate::scene::procedural::{
    builder::Builder,
    furniture::{plate, set},
};
use glam::{Affine3A, Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Floor, ceiling and the four walls, facing inwards, and the runner in the aisle.
pub(super) fn shell(b: &mut Builder, paints: &Paints) {
    b.part("shell");
    let (w, depth) = (2.0 * HALF_WIDTH, REAR - FRONT);
    let n = [b.steps(10.0, 1), b.steps(10.0, 1)];
    b.paint(paints.carpet);
    b.quad(n, v(-HALF_WIDTH, 0.0, REAR), v(w, 0.0, 0.0), v(0.0, 0.0, -depth));
    b.paint(paints.plaster);
    b.quad(n, v(-HALF_WIDTH, HEIGHT, FRONT), v(w, 0.0, 0.0), v(0.0, 0.0, depth));
    b.quad(n, v(-HALF_WIDTH, 0.0, FRONT), v(w, 0.0, 0.0), v(0.0, HEIGHT, 0.0));
    b.quad(n, v(HALF_WIDTH, 0.0, REAR), v(-w, 0.0, 0.0), v(0.0, HEIGHT, 0.0));
    b.quad(n, v(-HALF_WIDTH, 0.0, REAR), v(0.0, 0.0, -depth), v(0.0, HEIGHT, 0.0));
    b.quad(n, v(HALF_WIDTH, 0.0, FRONT), v(0.0, 0.0, depth), v(0.0, HEIGHT, 0.0));
    b.paint(paints.runner);
    b.block(b.steps(6.0, 1), v(-0.75, -0.01, STAGE[0] + 0.9), v(0.75, 0.012, REAR - 0.4));
}

/// Wooden panels along the side walls with brass fillets between, and doors.
pub(super) fn walls(b: &mut Builder, paints: &Paints) {
    b.part("walls");
    const BAYS: u32 = 12;
    let bay = (REAR - FRONT - 0.6) / BAYS as f32;
    for side in [-1.0, 1.0] {
        // In the frame of the wall: x along it, y up, z into the hall.
        let wall = set(side * HALF_WIDTH, 0.0, (REAR + FRONT) / 2.0, -90.0 * side);
        b.at(wall, |b| {
            for i in 0..BAYS {
                let x = (i as f32 - (BAYS as f32 - 1.0) / 2.0) * bay;
                let is_door = if side < 0.0 { i == 2 } else { i == BAYS - 3 };
                if is_door {
                    door(b, paints, x);
                } else {
                    panel(b, paints.walnut, v(x, 0.66, 0.03), v(bay / 2.0 - 0.06, 0.56, 0.035));
                    panel(b, paints.oak, v(x, 2.0, 0.03), v(bay / 2.0 - 0.06, 0.72, 0.035));
                }
                panel(b, paints.oak, v(x, 3.55, 0.03), v(bay / 2.0 - 0.06, 0.74, 0.035));
                b.paint(paints.brass);
                b.block(
                    b.steps(2.0, 1),
                    v(x + bay / 2.0 - 0.015, 0.0, -0.01),
                    v(x + bay / 2.0 + 0.015, 4.4, 0.05),
                );
            }
            b.paint(paints.walnut);
            let half = (REAR - FRONT) / 2.0;
            b.block(b.steps(4.0, 1), v(-half, -0.01, -0.02), v(half, 0.085, 0.03));
            b.block(b.steps(4.0, 1), v(-half, 4.38, -0.02), v(half, 4.5, 0.12));
        });
    }
    b.at(set(0.0, 0.0, REAR, 180.0), |b| {
        for i in 0..9 {
            let x = (i as f32 - 4.0) * 1.95;
            if i == 2 || i == 6 {
                door(b, paints, x);
            } else {
                panel(b, paints.walnut, v(x, 1.3, 0.03), v(0.9, 1.2, 0.035));
            }
            panel(b, paints.oak, v(x, 3.55, 0.03), v(0.9, 0.74, 0.035));
        }
    });
}

/// A soft-edged panel that stands upright, `half` its size in the frame of the wall.
fn panel(b: &mut Builder, paint: u32, centre: Vec3, half: Vec3) {
    b.paint(paint);
    let upright = Affine3A::from_rotation_translation(Quat::from_rotation_x(FRAC_PI_2), centre);
    b.at(upright, |b| plate(b, v(half.x, half.z, half.y), 0.03, 0.02, |p| p));
}

/// A double door with frame and handles, 2.5 m high, its middle at `x` along the wall.
fn door(b: &mut Builder, paints: &Paints, x: f32) {
    let n = b.steps(2.0, 1);
    b.paint(paints.walnut);
    b.block(n, v(x - 0.88, -0.01, -0.02), v(x - 0.78, 2.62, 0.13));
    b.block(n, v(x + 0.78, -0.01, -0.02), v(x + 0.88, 2.62, 0.13));
    b.block(n, v(x - 0.90, 2.52, -0.02), v(x + 0.90, 2.64, 0.14));
    for side in [-1.0, 1.0] {
        let leaf = x + side * 0.385;
        panel(b, paints.oak, v(leaf, 1.26, 0.02), v(0.38, 1.255, 0.03));
        panel(b, paints.walnut, v(leaf, 1.85, 0.045), v(0.26, 0.5, 0.02));
        panel(b, paints.walnut, v(leaf, 0.65, 0.045), v(0.26, 0.45, 0.02));
        b.paint(paints.brass);
        let (x, tube) = (x + side * 0.06, [b.steps(8.0, 5), b.steps(14.0, 8)]);
        b.tube(
            tube,
            Vec3::X,
            |_| 0.012,
            |t| v(x, 1.0 + 0.4 * t, 0.03 + 0.075 * (PI * t).sin().max(0.0).sqrt()),
        );
    }
}

/// Arched wooden baffles under the ceiling.
pub(super) fn ceiling(b: &mut Builder, paints: &Paints) {
    b.part("ceiling");
    b.paint(paints.oak);
    const BAFFLES: u32 = 24;
    let cells = [b.steps(40.0, 4), b.steps(1.0, 1)];
    for i in 0..BAFFLES {
        let z = FRONT + 4.2 + (REAR - FRONT - 5.0) * i as f32 / (BAFFLES - 1) as f32;
        let wave = 0.12 * (i as f32 * 0.55).sin();
        let width = 2.0 * HALF_WIDTH - 0.3;
        let x = move |u: f32| (u - 0.5) * width;
        let low = move |u: f32| HEIGHT - 0.62 + (0.34 + wave) * (PI * u).sin();
        let thick = 0.035;
        b.patch(cells, false, |u, t| v(x(u), low(u) + (HEIGHT + 0.02 - low(u)) * t, z + thick));
        b.patch(cells, false, |u, t| {
            v(x(1.0 - u), low(1.0 - u) + (HEIGHT + 0.02 - low(1.0 - u)) * t, z - thick)
        });
        b.patch(cells, false, |u, t| v(x(u), low(u), z - thick + 2.0 * thick * t));
        for side in [0.0, 1.0] {
            let out = if side > 0.0 { -1.0 } else { 1.0 };
            let height = HEIGHT + 0.02 - low(side);
            b.quad(
                [1, 1],
                v(x(side), low(side), z - out * thick),
                v(0.0, 0.0, 2.0 * out * thick),
                v(0.0, height, 0.0),
            );
        }
    }
}

/// The platform with its steps, slats on the wall behind it, and the screen.
pub(super) fn stage(b: &mut Builder, paints: &Paints) {
    b.part("stage");
    let [edge, height] = STAGE;
    b.paint(paints.oak);
    b.block(b.steps(8.0, 1), v(-6.8, -0.01, FRONT - 0.02), v(6.8, height, edge));
    b.paint(paints.walnut);
    b.block(b.steps(4.0, 1), v(-6.83, height - 0.05, edge - 0.06), v(6.83, height + 0.012, edge + 0.03));
    for (i, x) in [-5.6, 5.6].into_iter().flat_map(|x| [(0, x), (1, x)]) {
        let (top, reach) = (height * (2 - i) as f32 / 3.0, 0.34 * (i + 1) as f32);
        b.block(b.steps(3.0, 1), v(x - 0.7, -0.01, edge - 0.02), v(x + 0.7, top, edge + reach));
    }
    for i in 0..68 {
        let x = (i as f32 - 33.5) * 0.2;
        b.paint(if i % 2 == 0 { paints.walnut } else { paints.oak });
        let depth = 0.07 + 0.05 * ((i * i) as f32 * 0.7).sin();
        b.block(b.steps(2.0, 1), v(x - 0.07, height - 0.02, FRONT - 0.02), v(x + 0.07, 4.7, FRONT + depth));
    }
    screen(b, paints);
}

fn screen(b: &mut Builder, paints: &Paints) {
    let z = FRONT + 0.24;
    panel(b, paints.steel, v(-1.2, 2.75, z), v(2.56, 1.46, 0.05));
    b.paint(paints.screen);
    b.quad([b.steps(8.0, 1); 2], v(-3.7, 1.36, z + 0.056), v(5.0, 0.0, 0.0), v(0.0, 2.8, 0.0));
    // A slide: a headline and a rising bar chart.
    b.paint(paints.picture);
    let mut mark = |x: f32, y: f32, w: f32, h: f32| {
        b.quad([b.steps(1.0, 1); 2], v(-3.7 + x, 1.36 + y, z + 0.062), v(w, 0.0, 0.0), v(0.0, h, 0.0));
    };
    mark(0.4, 2.3, 2.9, 0.2);
    mark(0.4, 2.05, 1.9, 0.08);
    for i in 0..7 {
        let x = i as f32;
        mark(0.5 + 0.58 * x, 0.35, 0.36, 0.2 + 0.18 * x + 0.12 * (x * 2.1).sin());
    }
}
