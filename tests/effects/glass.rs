//! Fresnel's reflectance, total reflection and Beer's law against their formulas.

use super::{close, cuboid, floor, radiance, scene};
use glam::Vec3;
use irt::scene::{Environment, Light, Material, Scene, Sky};

fn glass(ni: f32, absorption: Vec3) -> Material {
    Material { kd: Vec3::ZERO, d: 0.0, ni, illum: 7, absorption, ..Material::default() }
}

/// Radiance `up` from all directions above the horizon and `down` from all below.
fn halves(scene: &mut Scene, up: f32, down: f32) {
    // The horizon is in between: rays of the tests are steep, and the sky is linear in y.
    let far = |far: f32| Vec3::splat(far);
    scene.environment = Environment {
        sky: Sky::Gradient { zenith: far(up), horizon: far(0.0), ground: far(down) },
        light: false,
    };
}

/// Reflectance by the amplitudes of both polarisations as functions of the angles alone (Fresnel's sine and tangent laws).
pub(super) fn reflectance(theta: f64, ni: f64) -> f64 {
    if theta == 0.0 {
        return ((ni - 1.0) / (ni + 1.0)).powi(2);
    }
    let sine = theta.sin() / ni;
    if sine >= 1.0 {
        return 1.0;
    }
    let inner = sine.asin();
    let s = (theta - inner).sin() / (theta + inner).sin();
    let p = (theta - inner).tan() / (theta + inner).tan();
    0.5 * (s * s + p * p)
}

#[test]
fn a_surface_reflects_what_fresnel_says() {
    for ni in [1.1f32, 1.5, 2.4] {
        for degrees in [0.0f64, 20.0, 45.0, 60.0, 75.0, 85.0] {
            let theta = degrees.to_radians();
            let mut from_above = scene(&floor(), glass(ni, Vec3::ZERO));
            halves(&mut from_above, 1.0, 0.0);
            let eye = Vec3::new(theta.sin() as f32, theta.cos() as f32, 0.0);
            // The mirrored ray sees a sky of cos theta.
            let got = radiance(&from_above, eye, Vec3::ZERO).x;
            let want = reflectance(theta, f64::from(ni)) * theta.cos();
            close(got, want, 2.0e-3, &format!("index {ni}, {degrees} degrees"));
            // From inside the glass, below the floor: the other side of the same surface.
            let mut from_below = scene(&floor(), glass(ni, Vec3::ZERO));
            halves(&mut from_below, 0.0, 1.0);
            let got = radiance(&from_below, -eye, Vec3::ZERO).x;
            let want = reflectance(theta, 1.0 / f64::from(ni)) * theta.cos();
            close(got, want, 2.0e-3, &format!("index {ni}, {degrees} degrees from inside"));
        }
    }
}

#[test]
fn an_opaque_mirror_of_illum_five_has_fresnel_times_ks() {
    let ks = Vec3::new(1.0, 0.5, 0.25);
    let material = Material { kd: Vec3::ZERO, ks, ni: 1.5, illum: 5, ..Material::default() };
    let mut scene = scene(&floor(), material);
    halves(&mut scene, 1.0, 0.0);
    let theta = 70f64.to_radians();
    let got = radiance(&scene, Vec3::new(theta.sin() as f32, theta.cos() as f32, 0.0), Vec3::ZERO);
    let want = reflectance(theta, 1.5) * theta.cos();
    for k in 0..3 {
        close(got[k], f64::from(ks[k]) * want, 2.0e-3, "illum 5");
    }
}

#[test]
fn a_slab_weakens_light_by_beers_law() {
    let absorption = Vec3::new(0.3, 1.0, 0.0);
    for (ni, thickness) in [(1.0f32, 0.5f32), (1.0, 2.0), (1.5, 0.5), (1.5, 2.0)] {
        let slab = cuboid(Vec3::new(-50.0, -thickness, -50.0), Vec3::new(50.0, 0.0, 50.0));
        let mut scene = scene(&slab, glass(ni, absorption));
        halves(&mut scene, 0.0, 1.0);
        for degrees in [0.0f64, 40.0] {
            let theta = degrees.to_radians();
            let eye = Vec3::new(theta.sin() as f32, theta.cos() as f32, 0.0) * 3.0;
            let got = radiance(&scene, eye, Vec3::ZERO);
            let inner = (theta.sin() / f64::from(ni)).asin();
            let r = reflectance(theta, f64::from(ni));
            for k in 0..3 {
                // Light goes straight through, or is reflected inside twice, four times, ...
                let once = (-f64::from(absorption[k]) * f64::from(thickness) / inner.cos()).exp();
                let want = theta.cos() * (1.0 - r).powi(2) * once / (1.0 - (r * once).powi(2));
                close(got[k], want, 2.0e-3, &format!("index {ni}, thickness {thickness}, {degrees} degrees"));
            }
        }
    }
}

#[test]
fn glass_that_is_tinted_and_only_partly_clear_takes_its_share() {
    let material =
        Material { d: 0.25, ni: 1.0, illum: 6, tf: Vec3::new(1.0, 0.5, 0.0), ..glass(1.0, Vec3::ZERO) };
    let mut scene = scene(&floor(), material);
    halves(&mut scene, 0.0, 1.0);
    let got = radiance(&scene, 2.0 * Vec3::Y, Vec3::ZERO);
    for k in 0..3 {
        close(got[k], [0.75, 0.375, 0.0][k], 1.0e-5, "tint");
    }
    // What is not clear reflects diffusely.
    scene.materials[0].kd = Vec3::splat(0.8);
    scene.environment.sky = Sky::Background;
    scene.lights.push(Light::Directional { direction: -Vec3::Y, intensity: Vec3::ONE });
    close(radiance(&scene, 2.0 * Vec3::Y, Vec3::ZERO).x, 0.25 * 0.8, 1.0e-5, "kd");
}

#[test]
fn without_fresnel_light_is_mirrored_inside_only_beyond_the_critical_angle() {
    // The critical angle of 1.5 is 41.8 degrees.
    for (degrees, total) in [(41.0f64, false), (43.0, true), (70.0, true)] {
        let mut scene = scene(&floor(), Material { illum: 9, ..glass(1.5, Vec3::ZERO) });
        halves(&mut scene, 0.0, 1.0);
        let theta = degrees.to_radians();
        let eye = -Vec3::new(theta.sin() as f32, theta.cos() as f32, 0.0);
        let got = radiance(&scene, eye, Vec3::ZERO).x;
        close(got, if total { theta.cos() } else { 0.0 }, 1.0e-4, &format!("{degrees} degrees"));
    }
}
