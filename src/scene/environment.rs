//! What surrounds the scene: seen by rays that hit nothing and, if wanted, a source of light.

use glam::Vec3;

/// What surrounds the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    /// What rays see that hit nothing.
    pub sky: Sky,
    /// Whether surfaces are lit by it, too, with soft shadows; otherwise it is only seen.
    pub light: bool,
}

/// Radiance by direction.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Sky {
    /// [`super::Scene::background`] in every direction.
    #[default]
    Background,
    /// Changes with the height above the horizon, +y being up: linear in the direction's y.
    Gradient {
        /// Straight up.
        zenith: Vec3,
        /// Level.
        horizon: Vec3,
        /// Straight down.
        ground: Vec3,
    },
    /// An image of all directions.
    Map(SkyMap),
}

/// An equirectangular image of all directions, +y being up.
///
/// ```text
///   column 0                   middle                  last
///   row 0        ------------- +y -----------------
///                -z ... -x ... +z ... +x ... -z           (before rotation)
///   last row     ------------- -y -----------------
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMap {
    /// Columns and rows, each >= 1.
    pub size: [u32; 2],
    /// Linear radiance, row by row from the top, finite and >= 0.
    pub pixels: Vec<[f32; 3]>,
    /// Turns the image about +y, radians: what was at +z comes to lie towards +x.
    pub rotation: f32,
    /// Factor of the radiance.
    pub strength: f32,
}
