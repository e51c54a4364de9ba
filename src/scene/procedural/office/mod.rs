//! An office for four: the counterpart of the thesis' office.

mod desk;
mod room;
mod shelf;

use super::{
    builder::Builder,
    furniture::{desk_lamp, plant, set, swivel_chair},
};
use crate::scene::{CameraDescription, Falloff, Light, Material, Scene};
use glam::{Affine3A, Vec2, Vec3};

/// Half the extent of the room along x and z.
const HALF: Vec2 = Vec2::new(3.2, 2.6);
/// Height of the ceiling.
const HEIGHT: f32 = 2.8;
/// Middles of the four luminous ceiling panels.
const PANELS: [Vec2; 4] =
    [Vec2::new(-1.5, -1.3), Vec2::new(0.9, -1.3), Vec2::new(-1.5, 1.1), Vec2::new(0.9, 1.1)];
/// Where the desks stand: place, and degrees by which they are turned.
const DESKS: [(f32, f32, f32); 4] =
    [(-1.25, -0.12, 0.0), (0.37, -0.12, 0.0), (-1.25, -0.94, 180.0), (0.37, -0.94, 180.0)];

/// About 37,000 triangles and 8 lights at detail 1.
pub(super) fn office(detail: f32) -> Scene {
    let mut b = Builder::new(detail);
    let paints = Paints::new(&mut b);
    room::shell(&mut b, &paints);
    room::window(&mut b, &paints);
    room::ceiling(&mut b, &paints);
    room::door(&mut b, &paints);
    room::board(&mut b, &paints);
    shelf::shelves(&mut b, &paints);
    let mut bulbs = Vec::new();
    for (i, (x, z, turn)) in DESKS.into_iter().enumerate() {
        b.part("desk");
        let i = i as u32;
        let place = set(x, 0.0, z, turn);
        b.at(place, |b| {
            desk::desk(b, &paints, i);
            let slide = [0.05, -0.12, 0.1, 0.0][i as usize];
            let twist = [160.0, 205.0, 150.0, 190.0][i as usize];
            b.at(set(slide, 0.0, 0.72, twist), |b| {
                swivel_chair(
                    b,
                    if i.is_multiple_of(2) { paints.teal } else { paints.rust },
                    paints.dark,
                    paints.steel,
                );
            });
        });
        if i == 1 || i == 2 {
            let lamp = place * set(-0.62, desk::TOP, -0.1, 70.0);
            b.at(lamp, |b| {
                bulbs.push(lamp.transform_point3(desk_lamp(b, paints.yellow, paints.steel, paints.glow)));
            });
        }
    }
    bulbs.push(floor_lamp(&mut b, &paints));
    b.part("plants");
    b.at(set(-2.65, 0.0, 1.45, 0.0), |b| plant(b, paints.clay, paints.dark, paints.leaf, 48, 1.15, 1));
    b.at(set(2.85, 0.0, -0.9, 0.0), |b| plant(b, paints.white, paints.dark, paints.leaf, 34, 0.95, 5));

    let camera = CameraDescription {
        eye: Vec3::new(2.75, 1.62, 2.3),
        at: Vec3::new(-0.55, 0.92, -0.85),
        up: Vec3::Y,
        fov_deg: 55.0,
    };
    b.finish("office", lights(&bulbs), camera, Vec3::new(0.12, 0.125, 0.14), Vec3::new(0.62, 0.78, 0.95))
}

/// Materials of the office.
struct Paints {
    wall: u32,
    floor: u32,
    white: u32,
    tile: u32,
    wood: u32,
    dark: u32,
    steel: u32,
    teal: u32,
    rust: u32,
    yellow: u32,
    clay: u32,
    leaf: u32,
    glow: u32,
    screen: u32,
    window: u32,
    text: u32,
    books: [u32; 6],
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
            wall: add("wall", [0.70, 0.68, 0.61], 0.0, 1.0, DARK),
            floor: add("floor", [0.47, 0.31, 0.18], 0.06, 20.0, DARK),
            white: add("white", [0.78, 0.77, 0.74], 0.15, 40.0, DARK),
            tile: add("ceiling tile", [0.74, 0.74, 0.72], 0.0, 1.0, DARK),
            wood: add("birch", [0.66, 0.49, 0.31], 0.15, 35.0, DARK),
            dark: add("dark plastic", [0.06, 0.062, 0.068], 0.25, 35.0, DARK),
            steel: add("steel", [0.34, 0.35, 0.37], 0.6, 60.0, DARK),
            teal: add("teal fabric", [0.06, 0.27, 0.30], 0.03, 8.0, DARK),
            rust: add("rust fabric", [0.50, 0.17, 0.07], 0.03, 8.0, DARK),
            yellow: add("yellow enamel", [0.72, 0.47, 0.06], 0.4, 60.0, DARK),
            clay: add("clay", [0.55, 0.25, 0.14], 0.05, 12.0, DARK),
            leaf: add("leaf", [0.10, 0.30, 0.09], 0.15, 25.0, DARK),
            glow: add("glow", [0.60, 0.60, 0.60], 0.0, 1.0, [0.85, 0.83, 0.78]),
            screen: add("screen", [0.03, 0.03, 0.035], 0.3, 60.0, [0.03, 0.07, 0.13]),
            window: add("window on a screen", [0.05, 0.05, 0.05], 0.0, 1.0, [0.42, 0.47, 0.52]),
            text: add("text on a screen", [0.05, 0.05, 0.05], 0.0, 1.0, [0.08, 0.20, 0.34]),
            books: [
                add("book red", [0.50, 0.09, 0.07], 0.1, 20.0, DARK),
                add("book blue", [0.08, 0.17, 0.40], 0.1, 20.0, DARK),
                add("book green", [0.11, 0.30, 0.16], 0.1, 20.0, DARK),
                add("book ochre", [0.60, 0.40, 0.10], 0.1, 20.0, DARK),
                add("book cream", [0.70, 0.64, 0.50], 0.1, 20.0, DARK),
                add("book black", [0.07, 0.07, 0.09], 0.2, 30.0, DARK),
            ],
        }
    }
}

/// A floor lamp in the corner by the window; returns where its bulb shines from, beside the pole.
fn floor_lamp(b: &mut Builder, paints: &Paints) -> Vec3 {
    b.part("floor lamp");
    let place = Vec3::new(-2.75, 0.0, -1.55);
    let around = b.steps(28.0, 8);
    b.at(Affine3A::from_translation(place), |b| {
        b.paint(paints.dark);
        let foot = [(0.16, -0.001), (0.16, 0.02), (0.03, 0.035), (0.012, 0.05)];
        b.lathe(&foot.map(|(r, y)| Vec2::new(r, y)), around);
        b.rod([b.steps(8.0, 3), b.steps(4.0, 1)], Vec3::Y * 0.03, Vec3::Y * 1.62, 0.013);
        b.paint(paints.white);
        b.turned([around, b.steps(6.0, 2)], |v| Vec2::new(0.23 - 0.09 * v.powf(0.8), 1.38 + 0.3 * v));
        b.paint(paints.glow);
        b.ball(b.steps(14.0, 5), Vec3::Y * 1.56, Vec3::splat(0.045));
    });
    place + Vec3::new(0.06, 1.49, 0.05)
}

/// The sun outside the window, four ceiling panels, three lamps.
fn lights(bulbs: &[Vec3]) -> Vec<Light> {
    let point = |position: Vec3, intensity: [f32; 3]| Light::Point {
        position,
        intensity: intensity.into(),
        falloff: Falloff::InverseSquare,
    };
    let mut lights = vec![Light::Point {
        position: Vec3::new(-13.0, 6.1, 4.4),
        intensity: Vec3::new(2.0, 1.62, 1.12),
        falloff: Falloff::None,
    }];
    lights.extend(PANELS.map(|p| point(Vec3::new(p.x, HEIGHT - 0.4, p.y), [0.66, 0.72, 0.80])));
    lights.extend(bulbs.iter().map(|&bulb| point(bulb, [0.34, 0.22, 0.10])));
    lights
}
