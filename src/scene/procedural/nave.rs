//! To come.

use super::builder::Builder;
use crate::scene::{CameraDescription, Scene};
use glam::Vec3;

/// Makes the scene.
pub(super) fn nave(detail: f32) -> Scene {
    let camera = CameraDescription { eye: Vec3::ZERO, at: Vec3::X, up: Vec3::Y, fov_deg: 60.0 };
    Builder::new(detail).finish("nave", Vec::new(), camera, Vec3::ZERO, Vec3::ZERO)
}
