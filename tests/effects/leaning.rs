//! Shading normals that lean away from their triangles, where formulas for one normal do not tell which of both counts.

use super::{close, floor, matt, radiance, scene};
use glam::{DVec3, Vec3};
use irt::scene::{AreaLight, Environment, Falloff, Light, Material, Scene, Sky};
use std::f64::consts::TAU;

/// A unit vector that leans from +y to +x.
fn leaning(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, cos, 0.0)
}

/// A floor whose normals lean to +x.
fn slanted(degrees: f64, material: Material) -> Scene {
    let mut scene = scene(&floor(), material);
    scene.mesh.normals = vec![leaning(degrees).as_vec3(); scene.mesh.positions.len()];
    scene
}

/// What the middle of the floor sends to a viewer who is so many degrees from +y to +x.
fn seen(scene: &Scene, degrees: f64) -> Vec3 {
    radiance(scene, 3.0 * leaning(degrees).as_vec3(), Vec3::ZERO)
}

/// Radiance that is proportional to the height above the horizon and to the depth below it.
fn linear_sky(zenith: f32, ground: f32) -> Environment {
    let [zenith, ground] = [zenith, ground].map(Vec3::splat);
    Environment { sky: Sky::Gradient { zenith, horizon: Vec3::ZERO, ground }, light: false }
}

#[test]
fn what_the_shading_normal_looks_away_from_makes_no_highlight() {
    let mut scene = slanted(60.0, Material { ks: Vec3::ONE, ns: 1.0, ..matt(0.0) });
    // 105 degrees from the normal, but above the floor; the middle between it and the viewer is near the normal.
    for (degrees, lit) in [(-45.0, false), (0.0, true)] {
        let (direction, intensity) = (-leaning(degrees).as_vec3(), Vec3::ONE);
        let position = -5.0 * direction;
        let lights = [
            Light::Directional { direction, intensity },
            Light::Point { position, intensity, falloff: Falloff::None },
        ];
        let sphere = AreaLight::Sphere { center: position, radius: 0.1, radiance: Vec3::splat(1000.0) };
        for light in lights {
            (scene.lights, scene.area_lights) = (vec![light], vec![]);
            assert_eq!(seen(&scene, 80.0).x > 0.1, lit, "{light:?}");
            assert!(lit || seen(&scene, 80.0) == Vec3::ZERO, "{light:?}");
        }
        (scene.lights, scene.area_lights) = (vec![], vec![sphere]);
        assert_eq!(seen(&scene, 80.0).x > 0.1, lit, "{sphere:?}");
        assert!(lit || seen(&scene, 80.0) == Vec3::ZERO, "{sphere:?}");
    }
}

#[test]
fn light_from_below_the_triangle_does_not_count() {
    let mut scene = slanted(60.0, matt(0.5));
    for (degrees, cosine) in [(100.0, 0.0), (80.0, 20.0f64.to_radians().cos())] {
        let (direction, intensity) = (-leaning(degrees).as_vec3(), Vec3::ONE);
        let position = -5.0 * direction;
        let lights = [
            Light::Directional { direction, intensity },
            Light::Point { position, intensity, falloff: Falloff::None },
        ];
        for light in lights {
            (scene.lights, scene.area_lights) = (vec![light], vec![]);
            close(seen(&scene, 20.0).x, 0.5 * cosine, 1.0e-4, &format!("{light:?}"));
        }
        let sphere = AreaLight::Sphere { center: position, radius: 0.01, radiance: Vec3::splat(250_000.0) };
        (scene.lights, scene.area_lights) = (vec![], vec![sphere]);
        close(seen(&scene, 20.0).x, 0.5 * cosine, 5.0e-3, &format!("{sphere:?}"));
    }
}

#[test]
fn light_of_the_sky_comes_from_around_the_shading_normal() {
    for degrees in [30.0, 60.0] {
        let mut scene = slanted(degrees, matt(0.5));
        scene.environment = Environment { light: true, ..linear_sky(2.0, 5.0) };
        scene.settings.light_samples = 1024;
        // The integral of radiance and cosine over the directions above both horizons, by midpoints.
        let (n, rows, columns) = (leaning(degrees), 400, 800);
        let mut sum = 0.0;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let y = (f64::from(row) + 0.5) / f64::from(rows);
            let (sin, cos) = ((f64::from(column) + 0.5) / f64::from(columns) * TAU).sin_cos();
            let radius = (1.0 - y * y).sqrt();
            sum += 2.0 * y * n.dot(DVec3::new(radius * cos, y, radius * sin)).max(0.0);
        }
        let want = 0.5 * sum * 2.0 / f64::from(rows * columns);
        close(seen(&scene, 20.0).x, want, 0.01, &format!("{degrees} degrees"));
    }
}

#[test]
fn images_in_slanted_mirrors_stay_above_them() {
    let mut scene = slanted(40.0, Material { ks: Vec3::ONE, illum: 3, ..matt(0.0) });
    scene.environment = linear_sky(1.0, 0.0);
    // About the shading normal as long as that leads up.
    for (degrees, mirrored) in [(10.0, 70.0), (20.0, 60.0), (0.0, 80.0)] {
        close(seen(&scene, degrees).x, leaning(mirrored).y, 1.0e-4, &format!("{degrees} degrees"));
    }
    // 120 and 160 degrees would lead down: about the floor's own normal.
    for degrees in [-40.0, -80.0] {
        close(seen(&scene, degrees).x, leaning(-degrees).y, 1.0e-4, &format!("{degrees} degrees"));
    }
}

#[test]
fn slanted_glass_bends_light_about_the_shading_normal() {
    let lean = 25.0;
    let mut scene = slanted(lean, Material { d: 0.0, ni: 1.5, illum: 6, ..matt(0.0) });
    scene.environment = linear_sky(0.0, 1.0);
    for degrees in [-20.0f64, 10.0, 60.0] {
        // All in one plane: angles add up.
        let inner = ((degrees - lean).to_radians().sin() / 1.5).asin().to_degrees();
        close(seen(&scene, degrees).x, leaning(lean + inner).y, 1.0e-4, &format!("{degrees} degrees"));
    }
}
