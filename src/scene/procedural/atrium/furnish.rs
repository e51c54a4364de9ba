//! Cloth, plants and lights of the atrium.

use super::{
    super::{
        architecture::{facing, moved},
        builder::Builder,
        garden,
    },
    COURT, EAVES, GALLERY, GROUND_COLUMN, Palette, Side, THICK, WALK,
};
use crate::scene::{Falloff, Light};
use glam::Vec3;

/// Banners over the balustrades of the long sides, curtains in the arches of the gallery.
pub(super) fn cloth(b: &mut Builder, m: &Palette, side: Side) {
    for i in 0..side.bays {
        let seed = (side.quarters * 8) as u32 + i as u32;
        let colours = m.cloths[(i / 2 + side.quarters as usize) % m.cloths.len()];
        if side.is_long() && i % 2 == 1 {
            b.at(moved(side.bay(i), GALLERY + 0.95, 0.53), |b| garden::banner(b, 1.15, 2.6, colours, seed));
        }
        if i % 2 == 0 {
            b.paint(colours[0]);
            for (quarters, x) in [(0, -1.24), (2, 1.24)] {
                b.at(moved(side.bay(i) + x, GALLERY + 2.7, -0.05) * facing(quarters, Vec3::ZERO), |b| {
                    garden::curtain(b, 0.85, 2.65, seed * 2 + quarters as u32);
                });
            }
        }
    }
}

/// Orange trees along the court, agaves at its columns.
pub(super) fn plants(b: &mut Builder, m: &Palette) {
    let trees = [(-3.0, 2.9), (3.0, 2.9), (6.6, 2.9), (-1.5, -2.9), (4.5, -2.9)];
    for (seed, (x, z)) in trees.into_iter().enumerate() {
        b.at(moved(x, 0.0, z), |b| {
            garden::pot(b, m.terracotta, m.earth);
            garden::orange_tree(b, m.wood, m.greens, m.orange, seed as u32);
        });
    }
    let agaves = [(-5.6, 3.1), (0.0, 3.4), (-4.6, -3.2), (1.5, -3.4), (7.6, 1.5), (7.6, -1.5)];
    for (seed, (x, z)) in agaves.into_iter().enumerate() {
        b.at(moved(x, 0.0, z), |b| {
            garden::pot(b, m.terracotta, m.earth);
            b.at(moved(0.0, 0.52, 0.0), |b| garden::agave(b, m.agave, seed as u32));
        });
    }
}

/// The sun, the light of the sky from two sides, and lanterns in the walks.
pub(super) fn lights(b: &mut Builder, m: &Palette) -> Vec<Light> {
    let far = |position: Vec3, intensity: [f32; 3]| Light::Point {
        position,
        intensity: intensity.into(),
        falloff: Falloff::None,
    };
    let mut lights = vec![
        far(Vec3::new(-25.0, 52.0, -24.0), [1.32, 1.10, 0.78]),
        far(Vec3::new(14.0, 50.0, 10.0), [0.10, 0.14, 0.21]),
        far(Vec3::new(-6.0, 14.0, 0.5), [0.09, 0.12, 0.17]),
    ];
    let beside = COURT.y + 0.5 * (WALK + 0.5 * THICK);
    let end = COURT.x + 0.5 * (WALK + 0.5 * THICK);
    for (x, floor, z) in [
        (4.5, 0.0, -beside),
        (-1.5, 0.0, beside),
        (end, 0.0, 0.0),
        (end, GALLERY, 0.0),
        (1.5, GALLERY, -beside),
    ] {
        let ceiling = if floor == 0.0 { GROUND_COLUMN.height + 1.48 } else { EAVES - 0.02 };
        b.at(moved(x, ceiling, z), |b| garden::lantern(b, ceiling - floor - 2.9, m.iron, m.glow));
        lights.push(Light::Point {
            position: Vec3::new(x, floor + 2.6, z),
            intensity: Vec3::new(3.4, 2.0, 0.9),
            falloff: Falloff::InverseSquare,
        });
    }
    lights
}
