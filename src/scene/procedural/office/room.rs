//! The shell of the office: walls, window with blinds, ceiling, door, whiteboard.

use super::{HALF, HEIGHT, PANELS, Paints};
use crate::scene::procedural::{
    builder::Builder,
    furniture::{plate, set},
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// The opening of the window in the wall at -x: z from, z to, y from, y to.
const OPENING: [f32; 4] = [-1.3, 1.1, 0.95, 2.4];

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Floor boards, walls with the opening of the window, skirting.
pub(super) fn shell(b: &mut Builder, paints: &Paints) {
    b.part("shell");
    let n = [b.steps(6.0, 1), b.steps(6.0, 1)];
    b.paint(paints.wall);
    b.quad(n, v(-HALF.x, 0.0, -HALF.y), v(2.0 * HALF.x, 0.0, 0.0), v(0.0, HEIGHT, 0.0));
    b.quad(n, v(HALF.x, 0.0, HALF.y), v(-2.0 * HALF.x, 0.0, 0.0), v(0.0, HEIGHT, 0.0));
    b.quad(n, v(HALF.x, 0.0, -HALF.y), v(0.0, 0.0, 2.0 * HALF.y), v(0.0, HEIGHT, 0.0));
    // Around the opening; blocks, because the reveal shows.
    let [z0, z1, y0, y1] = OPENING;
    let mut wall = |y: [f32; 2], z: [f32; 2]| {
        b.block(b.steps(2.0, 1), v(-HALF.x - 0.22, y[0], z[0]), v(-HALF.x, y[1], z[1]));
    };
    wall([-0.1, HEIGHT + 0.1], [-HALF.y - 0.1, z0]);
    wall([-0.1, HEIGHT + 0.1], [z1, HALF.y + 0.1]);
    wall([-0.1, y0], [z0, z1]);
    wall([y1, HEIGHT + 0.1], [z0, z1]);
    b.paint(paints.dark);
    b.quad(n, v(-HALF.x, -0.01, HALF.y), v(2.0 * HALF.x, 0.0, 0.0), v(0.0, 0.0, -2.0 * HALF.y));
    b.paint(paints.floor);
    let (count, width) = (26, 2.0 * HALF.y / 26.0);
    for i in 0..count {
        let z = -HALF.y + i as f32 * width;
        b.quad(
            [b.steps(6.0, 1), b.steps(1.0, 1)],
            v(-HALF.x, 0.0, z + width - 0.003),
            v(2.0 * HALF.x, 0.0, 0.0),
            v(0.0, 0.0, 0.006 - width),
        );
    }
    b.paint(paints.white);
    let n = b.steps(2.0, 1);
    b.block(n, v(-HALF.x - 0.02, -0.02, -HALF.y - 0.02), v(1.55, 0.08, -HALF.y + 0.015));
    b.block(n, v(-HALF.x - 0.02, -0.02, -HALF.y + 0.02), v(-HALF.x + 0.015, 0.081, HALF.y + 0.02));
    b.block(n, v(HALF.x - 0.015, -0.02, -HALF.y - 0.02), v(HALF.x + 0.02, 0.082, HALF.y + 0.02));
}

/// Frame, sill and blinds.
pub(super) fn window(b: &mut Builder, paints: &Paints) {
    b.part("window");
    let [z0, z1, y0, y1] = OPENING;
    let n = b.steps(2.0, 1);
    b.paint(paints.white);
    let x = -HALF.x - 0.14;
    for z in [z0 - 0.01, (z0 + z1) / 2.0 - 0.03, z1 - 0.05] {
        b.block(n, v(x, y0 - 0.01, z), v(x + 0.06, y1 + 0.01, z + 0.06));
    }
    for y in [y0 - 0.01, y1 - 0.05] {
        b.block(n, v(x + 0.004, y, z0 - 0.02), v(x + 0.056, y + 0.06, z1 + 0.02));
    }
    let sill = Affine3A::from_translation(v(-HALF.x - 0.02, y0 + 0.005, (z0 + z1) / 2.0));
    b.at(sill, |b| plate(b, v(0.13, 0.018, (z1 - z0) / 2.0 + 0.06), 0.02, 0.012, |p| p));
    b.block(n, v(-HALF.x + 0.005, y1 - 0.02, z0 - 0.05), v(-HALF.x + 0.075, y1 + 0.05, z1 + 0.05));
    blinds(b, paints);
}

/// Curved slats, half open, the lowest ones pulled up a little.
fn blinds(b: &mut Builder, paints: &Paints) {
    b.part("blinds");
    b.paint(paints.white);
    let [z0, z1, y0, y1] = OPENING;
    let (middle, half) = ((z0 + z1) / 2.0, (z1 - z0) / 2.0 + 0.03);
    let cells = [b.steps(5.0, 1), b.steps(3.0, 1)];
    const SLATS: u32 = 27;
    let pitch = (y1 - y0 - 0.30) / SLATS as f32;
    for i in 0..SLATS {
        let y = y1 - 0.05 - pitch * i as f32;
        b.patch(cells, true, |u, t| {
            let across = t - 0.5;
            let arch = 0.012 * (1.0 - 4.0 * across * across);
            // Tilted down towards the room, so that the sun comes through in stripes.
            v(-HALF.x + 0.04 + 0.046 * across, y + arch - 0.022 * across, middle + half * (2.0 * u - 1.0))
        });
    }
    let bottom = y1 - 0.05 - pitch * SLATS as f32;
    b.block(
        b.steps(2.0, 1),
        v(-HALF.x + 0.018, bottom - 0.012, middle - half),
        v(-HALF.x + 0.062, bottom + 0.012, middle + half),
    );
    let cord = [b.steps(4.0, 3), 1];
    for z in [middle - 0.7 * half, middle, middle + 0.7 * half] {
        b.rod(cord, v(-HALF.x + 0.068, bottom, z), v(-HALF.x + 0.068, y1, z), 0.002);
    }
}

/// Tiles with dark joints, four of them luminous.
pub(super) fn ceiling(b: &mut Builder, paints: &Paints) {
    b.part("ceiling");
    b.paint(paints.dark);
    let n = [b.steps(4.0, 1); 2];
    b.quad(n, v(-HALF.x, HEIGHT, -HALF.y), v(2.0 * HALF.x, 0.0, 0.0), v(0.0, 0.0, 2.0 * HALF.y));
    let (nx, nz) = (11, 9);
    let size = Vec2::new(2.0 * HALF.x / nx as f32, 2.0 * HALF.y / nz as f32);
    for j in 0..nz {
        for i in 0..nx {
            let low = -HALF + size * Vec2::new(i as f32, j as f32) + 0.006;
            let high = low + size - 0.012;
            let lit = PANELS.iter().any(|p| p.cmpgt(low).all() && p.cmplt(high).all());
            b.paint(if lit { paints.glow } else { paints.tile });
            let y = if lit { HEIGHT - 0.012 } else { HEIGHT - 0.02 };
            b.block(b.steps(1.0, 1), v(low.x, y, low.y), v(high.x, HEIGHT + 0.05, high.y));
        }
    }
}

/// Door in the far wall, with frame, panels and handle.
pub(super) fn door(b: &mut Builder, paints: &Paints) {
    b.part("door");
    let n = b.steps(2.0, 1);
    b.at(set(2.2, 0.0, -HALF.y, 0.0), |b| {
        b.paint(paints.white);
        b.block(n, v(-0.56, -0.01, -0.02), v(-0.47, 2.16, 0.05));
        b.block(n, v(0.47, -0.01, -0.02), v(0.56, 2.16, 0.05));
        b.block(n, v(-0.57, 2.08, -0.02), v(0.57, 2.17, 0.055));
        upright(b, paints.wood, v(0.0, 1.045, 0.008), v(0.472, 1.04, 0.022));
        for (y, half) in [(1.5, 0.42), (0.55, 0.38)] {
            upright(b, paints.wood, v(0.0, y, 0.028), v(0.33, half, 0.016));
        }
        b.paint(paints.steel);
        let rod = [b.steps(10.0, 4), b.steps(2.0, 1)];
        b.rod(rod, v(-0.40, 1.03, 0.02), v(-0.40, 1.03, 0.08), 0.011);
        b.rod(rod, v(-0.41, 1.03, 0.075), v(-0.28, 1.03, 0.075), 0.010);
    });
}

/// A whiteboard with a tray and pens, on the wall opposite the window.
pub(super) fn board(b: &mut Builder, paints: &Paints) {
    b.part("whiteboard");
    b.at(set(HALF.x, 0.0, 0.5, -90.0), |b| {
        upright(b, paints.steel, v(0.0, 1.55, 0.01), v(0.92, 0.57, 0.016));
        upright(b, paints.white, v(0.0, 1.55, 0.016), v(0.89, 0.54, 0.016));
        b.paint(paints.steel);
        b.block(b.steps(2.0, 1), v(-0.4, 0.955, 0.0), v(0.4, 0.97, 0.09));
        for (i, paint) in [paints.books[0], paints.books[1], paints.books[2]].into_iter().enumerate() {
            b.paint(paint);
            let x = -0.2 + 0.17 * i as f32;
            b.rod([b.steps(8.0, 3), 1], v(x, 0.979, 0.06), v(x + 0.12, 0.979, 0.05), 0.008);
        }
    });
}

/// A soft-edged plate that stands upright, `half` its size.
pub(super) fn upright(b: &mut Builder, paint: u32, centre: Vec3, half: Vec3) {
    b.paint(paint);
    let turn = Affine3A::from_rotation_translation(Quat::from_rotation_x(FRAC_PI_2), centre);
    b.at(turn, |b| plate(b, v(half.x, half.z, half.y), 0.02, half.z * 0.6, |p| p));
}
