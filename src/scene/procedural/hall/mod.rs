//! A conference hall: rows of chairs in arcs before a stage; the counterpart of the thesis' conference room.

mod fittings;
mod room;

use super::{
    builder::Builder,
    furniture::{set, stacking_chair},
    hash,
};
use crate::scene::{CameraDescription, Falloff, Light, Material, Scene};
use glam::Vec3;

/// Half the width of the hall, along x.
const HALF_WIDTH: f32 = 9.0;
/// Wall behind the stage.
const FRONT: f32 = -11.0;
/// Wall behind the audience.
const REAR: f32 = 11.0;
/// Height of the ceiling.
const HEIGHT: f32 = 5.4;
/// Front edge and height of the stage.
const STAGE: [f32; 2] = [-7.0, 0.5];

/// About 331,000 triangles and 6 lights at detail 1.
pub(super) fn hall(detail: f32) -> Scene {
    let mut b = Builder::new(detail);
    let paints = Paints::new(&mut b);
    room::shell(&mut b, &paints);
    room::walls(&mut b, &paints);
    room::ceiling(&mut b, &paints);
    room::stage(&mut b, &paints);
    fittings::curtains(&mut b, &paints);
    fittings::panel_table(&mut b, &paints);
    fittings::lectern(&mut b, &paints);
    fittings::lamps(&mut b, &paints);
    audience(&mut b, &paints, detail);
    let camera = CameraDescription {
        eye: Vec3::new(7.6, 3.0, 9.6),
        at: Vec3::new(-1.1, 1.25, -3.0),
        up: Vec3::Y,
        fov_deg: 46.0,
    };
    b.finish("hall", lights(), camera, Vec3::new(0.115, 0.11, 0.12), Vec3::new(0.02, 0.02, 0.03))
}

/// Materials of the hall.
struct Paints {
    carpet: u32,
    runner: u32,
    plaster: u32,
    oak: u32,
    walnut: u32,
    cushion: u32,
    accent: u32,
    steel: u32,
    brass: u32,
    velvet: u32,
    screen: u32,
    picture: u32,
    glow: u32,
    glass: u32,
    leaf: u32,
}

impl Paints {
    fn new(b: &mut Builder) -> Paints {
        let mut add = |name: &str, kd: [f32; 3], ks: f32, ns: f32, ke: [f32; 3]| {
            b.material(Material {
                name: name.into(),
                kd: kd.into(),
                ks: Vec3::splat(ks),
                ke: ke.into(),
                ns,
                ..Material::default()
            })
        };
        const DARK: [f32; 3] = [0.0; 3];
        Paints {
            carpet: add("carpet", [0.16, 0.19, 0.24], 0.0, 1.0, DARK),
            runner: add("runner", [0.42, 0.13, 0.10], 0.0, 1.0, DARK),
            plaster: add("plaster", [0.72, 0.69, 0.63], 0.0, 1.0, DARK),
            oak: add("oak", [0.62, 0.42, 0.23], 0.12, 30.0, DARK),
            walnut: add("walnut", [0.27, 0.15, 0.085], 0.25, 50.0, DARK),
            cushion: add("cushion", [0.10, 0.24, 0.34], 0.03, 8.0, DARK),
            accent: add("accent", [0.55, 0.19, 0.11], 0.03, 8.0, DARK),
            steel: add("steel", [0.30, 0.31, 0.33], 0.6, 60.0, DARK),
            brass: add("brass", [0.50, 0.35, 0.14], 0.55, 45.0, DARK),
            velvet: add("velvet", [0.36, 0.06, 0.07], 0.05, 6.0, DARK),
            screen: add("screen", [0.30, 0.30, 0.30], 0.0, 1.0, [0.34, 0.40, 0.46]),
            picture: add("picture", [0.10, 0.20, 0.30], 0.0, 1.0, [0.04, 0.12, 0.22]),
            glow: add("glow", [0.60, 0.56, 0.50], 0.0, 1.0, [0.75, 0.66, 0.50]),
            glass: add("glass", [0.35, 0.45, 0.46], 0.7, 120.0, DARK),
            leaf: add("leaf", [0.10, 0.27, 0.09], 0.12, 25.0, DARK),
        }
    }
}

/// Rows in arcs about a point on the stage, an aisle down the middle. A chair cannot be made of less than 224
/// triangles: where detail is low, few come to sit down.
fn audience(b: &mut Builder, paints: &Paints, detail: f32) {
    const ROWS: u32 = 13;
    const CENTRE: f32 = -15.0;
    b.part("audience");
    let stride = ((0.4 / detail) as u32).clamp(1, 8);
    let mut places = 0..;
    for row in 0..ROWS {
        let radius = 10.7 + 1.0 * row as f32;
        for side in [-1.0, 1.0] {
            for seat in 0..10 {
                // Chairs keep their spacing along the arc; the aisle is as wide in every row.
                let angle = (0.95 + 0.64 * seat as f32 + 0.3) / radius;
                let (x, z) = (side * radius * angle.sin(), CENTRE + radius * angle.cos());
                if x.abs() > HALF_WIDTH - 0.9 || places.next().is_some_and(|place| place % stride != 0) {
                    continue;
                }
                let fabric = if (row + seat) % 7 == 3 { paints.accent } else { paints.cushion };
                let jitter = 5.0 * (hash::unit(row * 64 + seat * 2 + (side > 0.0) as u32, 0) - 0.5);
                let turn = 180.0 + (side * angle).to_degrees() + jitter;
                b.at(set(x, 0.0, z, turn), |b| stacking_chair(b, paints.oak, fabric, paints.steel));
            }
        }
    }
}

fn lights() -> Vec<Light> {
    let point = |position: [f32; 3], intensity: [f32; 3]| Light::Point {
        position: position.into(),
        intensity: intensity.into(),
        falloff: Falloff::InverseSquare,
    };
    const WARM: [f32; 3] = [9.5, 7.8, 5.4];
    vec![
        point([-4.0, 3.42, -2.0], WARM),
        point([4.0, 3.42, -2.0], WARM),
        point([-4.0, 3.42, 5.0], WARM),
        point([4.0, 3.42, 5.0], WARM),
        point([-3.0, 4.5, -5.4], [5.0, 6.4, 8.6]),
        point([5.0, 4.5, -5.4], [5.0, 6.4, 8.6]),
    ]
}
