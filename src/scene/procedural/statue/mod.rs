//! A rabbit on a plinth: one closed, smooth mesh, the counterpart of the Stanford bunny.

mod field;
mod rabbit;
mod surface;

use super::builder::Builder;
use crate::scene::{CameraDescription, Falloff, Light, Material, Scene};
use field::Field;
use glam::{Affine3A, Vec2, Vec3};
use surface::{Grid, Surface, polygonise, split};

/// Side of a grid cell at detail 1: makes about 66 thousand triangles.
const CELL: f32 = 0.0171;
/// Above this detail a coarser rabbit is split instead of a finer grid searched.
const GRID_DETAIL: f32 = 1.5;
/// Below this detail the grid would lose the ears.
const LEAST_DETAIL: f32 = 0.45;
/// Height of the plinth's top.
const TOP: f32 = 0.62;

/// About 72,000 triangles and 3 lights at detail 1.
pub(super) fn statue(detail: f32) -> Scene {
    let mut b = Builder::new(detail);
    let porcelain = b.material(glossy("porcelain", [0.74, 0.66, 0.55], 0.32, 70.0));
    let glass = b.material(glossy("glass", [0.02, 0.015, 0.015], 0.9, 180.0));
    let slate = b.material(glossy("slate", [0.09, 0.12, 0.13], 0.22, 40.0));
    let brass = b.material(glossy("brass", [0.52, 0.35, 0.12], 0.6, 50.0));
    let backdrop = b.material(glossy("backdrop", [0.17, 0.27, 0.33], 0.0, 1.0));

    b.part("rabbit");
    b.paint(porcelain);
    b.at(Affine3A::from_translation(Vec3::Y * (TOP - 0.004)), |b| {
        let (field, surface) = skin(detail);
        let normals: Vec<Vec3> = surface.positions.iter().map(|&p| field.normal(p)).collect();
        b.append(&surface.positions, &normals, &surface.triangles);
        b.part("eyes");
        b.paint(glass);
        for (centre, radius) in rabbit::eyes() {
            b.ball(b.steps(24.0, 8), centre, Vec3::splat(radius));
        }
    });
    plinth(&mut b, slate, brass);
    b.part("backdrop");
    b.paint(backdrop);
    b.patch([b.steps(6.0, 2), b.steps(28.0, 10)], true, studio);

    let camera = CameraDescription {
        eye: Vec3::new(1.6, 1.45, 2.35),
        at: Vec3::new(0.0, 1.08, -0.02),
        up: Vec3::Y,
        fov_deg: 28.0,
    };
    let background = Vec3::new(0.05, 0.07, 0.09);
    b.finish("statue", lights(), camera, Vec3::new(0.10, 0.12, 0.15), background)
}

/// The rabbit's field and its mesh.
fn skin(detail: f32) -> (Field, Surface) {
    let field = rabbit::rabbit();
    let detail = detail.max(LEAST_DETAIL);
    let pieces = (detail / GRID_DETAIL).ceil().max(1.0);
    let [min, max] = rabbit::BOUNDS;
    let coarse = polygonise(&field, &Grid::new(min, max, CELL * pieces / detail));
    let fine = split(&field, &coarse, pieces as u32);
    (field, fine)
}

fn glossy(name: &str, kd: [f32; 3], ks: f32, ns: f32) -> Material {
    Material { name: name.into(), kd: kd.into(), ks: Vec3::splat(ks), ns, ..Material::default() }
}

/// A turned plinth with a brass ring.
fn plinth(b: &mut Builder, stone: u32, ring: u32) {
    b.part("plinth");
    let around = b.steps(72.0, 12);
    b.paint(stone);
    let profile = [
        (0.72, -0.002),
        (0.72, 0.07),
        (0.70, 0.09),
        (0.66, 0.10),
        (0.62, 0.14),
        (0.60, 0.18),
        (0.60, 0.44),
        (0.62, 0.49),
        (0.67, 0.53),
        (0.69, 0.55),
        (0.69, 0.60),
        (0.67, TOP),
        (0.0, TOP),
    ];
    b.lathe(&profile.map(|(r, y)| Vec2::new(r, y)), around);
    b.paint(ring);
    b.turned([around, b.steps(8.0, 3)], |v| {
        let (sin, cos) = ((v - 0.5) * std::f32::consts::PI).sin_cos();
        Vec2::new(0.598 + 0.018 * cos, 0.31 + 0.025 * sin)
    });
}

/// Floor and wall in one sweep, without a corner.
fn studio(u: f32, v: f32) -> Vec3 {
    const BEND: f32 = 1.6;
    let x = 12.0 - 24.0 * u;
    let arc = BEND * std::f32::consts::FRAC_PI_2;
    let along = v * (9.0 + arc + 5.0);
    let (y, z) = if along < 9.0 {
        (0.0, 5.0 - along)
    } else if along < 9.0 + arc {
        let (sin, cos) = ((along - 9.0) / BEND).sin_cos();
        (BEND * (1.0 - cos), -4.0 - BEND * sin)
    } else {
        (BEND + along - 9.0 - arc, -4.0 - BEND)
    };
    Vec3::new(-x, y, z)
}

fn lights() -> Vec<Light> {
    let point = |position: [f32; 3], intensity: [f32; 3]| Light::Point {
        position: position.into(),
        intensity: intensity.into(),
        falloff: Falloff::InverseSquare,
    };
    vec![
        point([3.0, 3.6, 2.4], [19.0, 16.0, 12.0]),
        point([-3.4, 2.0, 2.6], [2.4, 3.4, 5.0]),
        point([-2.2, 3.0, -1.5], [4.0, 4.8, 6.0]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural::hash;
    use std::collections::HashMap;

    #[test]
    fn the_rabbit_is_closed() {
        for detail in [0.1, 0.5, 0.6, 0.7, 1.0, 1.3, 1.6, 2.0, 3.2] {
            let (_, surface) = skin(detail);
            let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
            for &[a, b, c] in &surface.triangles {
                for edge in [[a, b], [b, c], [c, a]] {
                    *edges.entry(edge).or_default() += 1;
                }
            }
            // Each edge once in each direction: closed, two triangles an edge, consistently turned.
            let odd = edges.iter().filter(|&(&[a, b], &n)| n != 1 || edges.get(&[b, a]) != Some(&1)).count();
            assert_eq!(odd, 0, "detail {detail}");
            // One piece without a handle: vertices - edges + triangles = 2.
            let euler =
                surface.positions.len() as i64 - edges.len() as i64 / 2 + surface.triangles.len() as i64;
            assert_eq!(euler, 2, "detail {detail}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_field() {
        let field = rabbit::rabbit();
        for i in 0..500u32 {
            let random = |k: u32| hash::unit(i * 3 + k, 0) - 0.5;
            let p = field.project(Vec3::new(0.6 * random(0), 0.5 + 0.9 * random(1), random(2)));
            let gradient = field.sample(p).gradient;
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let difference = field.sample(p + axis * 1e-3).value - field.sample(p - axis * 1e-3).value;
                assert!((difference / 2e-3 - gradient.dot(axis)).abs() < 0.05, "at {p}");
            }
        }
    }
}
