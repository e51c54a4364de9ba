//! A camera and lights for geometry that brings none.
//!
//! The camera looks down at the middle of everything from the front right (a three-quarter view) with +y up, from so
//! far that the sphere around the bounding box fits the smaller side of a square image. A white point light of full
//! strength stands above and left of it, a second one of half strength to the right, both without falloff.

use super::{CameraDescription, Falloff, Light};
use crate::math::Aabb;
use glam::{DVec3, Vec3};

/// Vertical field of view, degrees.
const FOV: f64 = 40.0;

/// A camera that sees all of a box that is not empty.
pub(super) fn camera(bounds: &Aabb) -> CameraDescription {
    let (center, radius) = sphere(bounds);
    let distance = 1.05 * radius / (0.5 * FOV.to_radians()).sin();
    let eye = center + distance * DVec3::new(0.6, 0.45, 1.0).normalize();
    CameraDescription { eye: eye.as_vec3(), at: center.as_vec3(), up: Vec3::Y, fov_deg: FOV as f32 }
}

/// Two lights on the camera's side of a box that is not empty.
pub(super) fn lights(bounds: &Aabb) -> Vec<Light> {
    let (center, radius) = sphere(bounds);
    let light = |direction: [f64; 3], intensity: f32| Light::Point {
        position: (center + 4.0 * radius * DVec3::from_array(direction).normalize()).as_vec3(),
        intensity: Vec3::splat(intensity),
        falloff: Falloff::None,
    };
    vec![light([-0.6, 1.0, 0.8], 1.0), light([1.0, 0.3, 0.5], 0.5)]
}

/// Sphere around a box, never so small that points beside it round to its centre, or that the square of its radius
/// vanishes in f32.
fn sphere(bounds: &Aabb) -> (DVec3, f64) {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let center = 0.5 * (min + max);
    let least = 1.0e-5 * center.abs().max_element();
    (center, (0.5 * (max - min).length()).max(least).max(1.0e-15))
}
