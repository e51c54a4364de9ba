//! Spheres of mirror and glass against rays on perfect spheres.

use super::{close, radiance, scene_of};
use crate::support::sphere;
use glam::{DVec3, Vec3};
use irt::scene::{Environment, Material, Scene, Sky};

const ZENITH: f64 = 2.0;
const HORIZON: f64 = 1.0;
const GROUND: f64 = 0.2;

/// A fine ball with smooth normals under a sky that changes with height.
fn ball(material: Material) -> Scene {
    let mut mesh = sphere(Vec3::ZERO, 1.0, 160);
    mesh.normals = mesh.positions.iter().map(|p| p.normalize()).collect();
    let mut scene = scene_of(mesh, vec![material]);
    let far = |far: f64| Vec3::splat(far as f32);
    scene.environment = Environment {
        sky: Sky::Gradient { zenith: far(ZENITH), horizon: far(HORIZON), ground: far(GROUND) },
        light: false,
    };
    scene
}

fn sky(dir: DVec3) -> f64 {
    let far = if dir.y >= 0.0 { ZENITH } else { GROUND };
    HORIZON + (far - HORIZON) * dir.y.abs()
}

/// Where a ray from outside meets the unit sphere.
fn meet(org: DVec3, dir: DVec3) -> DVec3 {
    let b = org.dot(dir);
    org + dir * (-b - (b * b - org.length_squared() + 1.0).sqrt())
}

fn mirrored(dir: DVec3, n: DVec3) -> DVec3 {
    dir - 2.0 * dir.dot(n) * n
}

/// Snell's law as vectors; `n` against `dir`.
fn bent(dir: DVec3, n: DVec3, eta: f64) -> DVec3 {
    let cosine = -dir.dot(n);
    eta * dir + (eta * cosine - (1.0 - eta * eta * (1.0 - cosine * cosine)).sqrt()) * n
}

fn aims() -> impl Iterator<Item = (DVec3, DVec3)> {
    let eye = DVec3::new(0.4, 1.3, 4.0);
    [(0.0, 0.0), (0.3, 0.1), (-0.5, 0.2), (0.1, 0.6), (0.0, -0.7), (0.6, -0.5)]
        .into_iter()
        .map(move |(x, y)| (eye, (DVec3::new(x, y, 0.0) - eye).normalize()))
}

#[test]
fn a_mirror_ball_shows_the_sky_where_the_formula_says() {
    let scene = ball(Material { kd: Vec3::ZERO, ks: Vec3::ONE, illum: 3, ..Material::default() });
    for (eye, dir) in aims() {
        let n = meet(eye, dir);
        let got = radiance(&scene, eye.as_vec3(), (eye + dir).as_vec3());
        close(got.x, sky(mirrored(dir, n)), 5.0e-3, &format!("{dir}"));
    }
}

#[test]
fn a_glass_ball_bends_light_as_snell_says() {
    let (ni, r0) = (1.5f64, |cosine: f64, inner: f64| {
        let s = (cosine - 1.5 * inner) / (cosine + 1.5 * inner);
        let p = (inner - 1.5 * cosine) / (inner + 1.5 * cosine);
        0.5 * (s * s + p * p)
    });
    let scene = ball(Material { kd: Vec3::ZERO, d: 0.0, ni: ni as f32, illum: 7, ..Material::default() });
    for (eye, dir) in aims() {
        let n = meet(eye, dir);
        let cosine = -dir.dot(n);
        let inner = (1.0 - (1.0 - cosine * cosine) / (ni * ni)).sqrt();
        let r = r0(cosine, inner);
        let mut want = r * sky(mirrored(dir, n));
        // Inside a sphere all angles are the same at each reflection.
        let (mut at, mut way, mut share) = (n, bent(dir, n, 1.0 / ni), 1.0 - r);
        for _ in 0..12 {
            // Lengths of 1, or errors would grow from reflection to reflection.
            at = (at - 2.0 * at.dot(way) * way).normalize();
            want += share * (1.0 - r) * sky(bent(way, -at, ni));
            share *= r;
            way = mirrored(way, at).normalize();
        }
        let got = radiance(&scene, eye.as_vec3(), (eye + dir).as_vec3());
        close(got.x, want, 1.0e-2, &format!("{dir}"));
    }
}
