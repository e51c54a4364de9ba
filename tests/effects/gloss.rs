//! Rough mirrors against the reflection integral of GGX, taken over all directions.

use super::{close, floor, glass::reflectance, radiance, scene};
use glam::{DVec3, Vec3};
use irt::scene::{Environment, Material, Sky};
use std::f64::consts::{PI, TAU};

/// Share of the light from `sky` that a surface with normal +y sends to `view`: Cook and Torrance's D G / (4 cos cos) with
/// the GGX distribution and its height-correlated shadowing (B. Walter et al. 2007; E. Heitz 2014), by midpoints.
///
/// `mirror` is the reflectance by the cosine to the micro-normal.
fn integral(view: DVec3, alpha: f64, mirror: impl Fn(f64) -> f64, sky: impl Fn(DVec3) -> f64) -> f64 {
    let a2 = alpha * alpha;
    let lambda = |cosine: f64| {
        let tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
        0.5 * ((1.0 + a2 * tan2).sqrt() - 1.0)
    };
    let (rows, columns) = (400, 800);
    let mut sum = 0.0;
    for row in 0..rows {
        let y = (f64::from(row) + 0.5) / f64::from(rows);
        for column in 0..columns {
            let phi = (f64::from(column) + 0.5) / f64::from(columns) * TAU;
            let radius = (1.0 - y * y).sqrt();
            let light = DVec3::new(radius * phi.cos(), y, radius * phi.sin());
            let micro = (view + light).normalize();
            let half = micro.y;
            let d = a2 / (PI * (half * half * (a2 - 1.0) + 1.0).powi(2));
            let g = 1.0 / (1.0 + lambda(view.y) + lambda(y));
            sum += mirror(view.dot(micro)) * d * g / (4.0 * view.y) * sky(light);
        }
    }
    sum * TAU / f64::from(rows * columns)
}

#[test]
fn a_rough_mirror_blurs_the_sky_as_the_integral_of_ggx_says() {
    for (roughness, degrees, turn) in [
        (0.5f32, 20.0f64, 0.0f64),
        (0.5, 75.0, 0.0),
        (0.5, 75.0, 90.0),
        (0.8, 60.0, 40.0),
        (1.0, 80.0, 200.0),
    ] {
        let ks = Vec3::new(1.0, 0.5, 0.0);
        let material =
            Material { kd: Vec3::ZERO, ks, illum: 3, roughness: Some(roughness), ..Material::default() };
        let mut scene = scene(&floor(), material);
        let sky = Sky::Gradient { zenith: Vec3::splat(3.0), horizon: Vec3::ONE, ground: Vec3::ZERO };
        scene.environment = Environment { sky, light: false };
        scene.settings.samples = 4096;
        let theta = degrees.to_radians();
        let (sin, cos) = turn.to_radians().sin_cos();
        let view = DVec3::new(theta.sin() * cos, theta.cos(), theta.sin() * sin);
        let alpha = f64::from(roughness).powi(2);
        let want = integral(view, alpha, |_| 1.0, |dir| 1.0 + 2.0 * dir.y);
        let got = radiance(&scene, view.as_vec3(), Vec3::ZERO);
        let what = format!("roughness {roughness}, {degrees} degrees, turned by {turn}");
        close(got.x, want, 0.01, &what);
        close(got.y, 0.5 * want, 0.01, &what);
        assert_eq!(got.z, 0.0);
        // Fresnel's reflectance is that of the micro-surface.
        (scene.materials[0].illum, scene.materials[0].ni) = (5, 1.5);
        let fresnel = |cosine: f64| reflectance(cosine.min(1.0).acos(), 1.5);
        let want = integral(view, alpha, fresnel, |dir| 1.0 + 2.0 * dir.y);
        close(radiance(&scene, view.as_vec3(), Vec3::ZERO).x, want, 0.015, &format!("{what}, Fresnel"));
    }
}
