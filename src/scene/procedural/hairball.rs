//! A ball of hair: thin tubes that circle a sphere and curl as they go. Their boxes overlap everywhere, which no
//! tree can mend; the stress case of the benches.

use super::{
    builder::Builder,
    hash::{between, unit},
};
use crate::scene::{CameraDescription, Falloff, Light, Material, Scene};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Hairs and their segments at detail 1; each segment has `SIDES` sides of two triangles.
const HAIRS: f32 = 2400.0;
const SEGMENTS: f32 = 52.0;
const SIDES: usize = 4;

/// Makes the scene.
pub(super) fn hairball(detail: f32) -> Scene {
    let mut b = Builder::new(detail);
    let colours = [[0.62, 0.30, 0.11], [0.78, 0.50, 0.20], [0.42, 0.14, 0.07], [0.86, 0.70, 0.42]];
    let hair = colours.map(|kd| {
        let ks = Vec3::splat(0.35);
        b.material(Material { name: "hair".into(), kd: kd.into(), ks, ns: 40.0, ..Material::default() })
    });
    let core = Material { name: "core".into(), kd: Vec3::new(0.10, 0.04, 0.03), ..Material::default() };
    let core = b.material(core);

    b.part("core");
    b.paint(core);
    let cells = [b.steps(64.0, 6), b.steps(32.0, 3)];
    b.turned(cells, |v| {
        let (sin, cos) = (0.5 * TAU * v).sin_cos();
        glam::Vec2::new(sin, -cos) * 0.5
    });

    b.part("hair");
    let (hairs, segments) = (b.steps(HAIRS, 1), b.steps(SEGMENTS, 2));
    for i in 0..hairs as u32 {
        b.paint(hair[(unit(i, 0) * hair.len() as f32) as usize]);
        let path: Vec<Vec3> = (0..=segments).map(|k| point_of_hair(i, k as f32 / segments as f32)).collect();
        tube(&mut b, &path, between(0.003, 0.005, i, 1));
    }

    let light = Light::Point {
        position: Vec3::new(-3.5, 4.0, 4.5),
        intensity: Vec3::new(1.25, 1.2, 1.1),
        falloff: Falloff::None,
    };
    let camera = CameraDescription {
        eye: Vec3::new(0.0, 0.35, 3.4),
        at: Vec3::new(0.0, 0.0, 0.0),
        up: Vec3::Y,
        fov_deg: 40.0,
    };
    b.finish("hairball", vec![light], camera, Vec3::splat(0.12), Vec3::new(0.55, 0.66, 0.78))
}

/// Hair `i` at `t` in [0, 1]: from inside the core outwards, around a great circle of its own, in curls.
fn point_of_hair(i: u32, t: f32) -> Vec3 {
    let root = direction(i, 2);
    let axis = root.cross(direction(i, 4)).try_normalize().unwrap_or(Vec3::X);
    let along = Quat::from_axis_angle(axis, t * between(0.6, 2.4, i, 6));
    let out = along * root;
    let reach = between(0.78, 1.0, i, 7);
    let radius = 0.48 + (reach - 0.48) * t.powf(0.6);
    // The curls are wider towards the tip.
    let curl = between(0.015, 0.06, i, 8) * t;
    let (sin, cos) = (TAU * (unit(i, 9) + t * between(2.0, 6.0, i, 10))).sin_cos();
    out * (radius + curl * sin) + axis * (curl * cos)
}

/// A direction for item `index`, uniform over the sphere; takes two numbers, `what` and the one after it.
fn direction(index: u32, what: u32) -> Vec3 {
    let z = between(-1.0, 1.0, index, what);
    let (sin, cos) = (TAU * unit(index, what + 1)).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

/// A tube along `path` that narrows towards its end, and is open at both: its root is inside the core, and its tip is
/// too thin to look into.
fn tube(b: &mut Builder, path: &[Vec3], radius: f32) {
    let last = path.len() - 1;
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let mut side = (path[1] - path[0]).normalize().any_orthonormal_vector();
    for (k, &centre) in path.iter().enumerate() {
        let tangent = (path[(k + 1).min(last)] - path[k.saturating_sub(1)]).normalize();
        // The section keeps its orientation as far as the bend allows: tubes do not twist.
        side = (side - tangent * side.dot(tangent)).normalize();
        let up = tangent.cross(side);
        let r = radius * (1.0 - 0.8 * k as f32 / last as f32);
        for s in 0..SIDES {
            let (sin, cos) = (TAU * s as f32 / SIDES as f32).sin_cos();
            let normal = side * cos + up * sin;
            positions.push(centre + normal * r);
            normals.push(normal);
        }
    }
    for k in 0..last as u32 {
        for s in 0..SIDES as u32 {
            let (low, next) = (k * SIDES as u32, (s + 1) % SIDES as u32);
            let [a, b, c, d] = [low + s, low + next, low + next + SIDES as u32, low + s + SIDES as u32];
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    b.append(&positions, &normals, &triangles);
}
