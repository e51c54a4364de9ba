//! Light sources, without extent and with.

use glam::Vec3;

/// How the light of a positional source weakens with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Falloff {
    /// Not at all: `intensity` arrives everywhere (the classic of Whitted-style renderers, and of the thesis).
    #[default]
    None,
    /// As 1 / distance^2, so that `intensity` is in radiance x area.
    InverseSquare,
}

/// A light source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines from a point in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Linear colour times strength.
        intensity: Vec3,
        /// How it weakens with distance.
        falloff: Falloff,
    },
    /// Shines from infinitely far away.
    Directional {
        /// Where the light travels to; unit length.
        direction: Vec3,
        /// Linear colour times strength.
        intensity: Vec3,
    },
    /// A point light restricted to a cone with a soft rim.
    Spot {
        /// Where it is.
        position: Vec3,
        /// Axis of the cone; unit length.
        direction: Vec3,
        /// Linear colour times strength on the axis.
        intensity: Vec3,
        /// How it weakens with distance.
        falloff: Falloff,
        /// Full strength within this angle from the axis, radians.
        inner: f32,
        /// No light beyond this angle from the axis, radians, in (inner, pi/2].
        outer: f32,
    },
}

/// A light source with an extent: it casts soft shadows.
///
/// It is a source only. No ray meets it, so it is not seen, nor mirrored, nor does it cast a shadow; a source that can be
/// seen is a mesh whose material emits (see [`super::RenderSettings::emitters`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaLight {
    /// Shines from one side of a parallelogram.
    Rectangle {
        /// One of its corners.
        corner: Vec3,
        /// From the corner along one edge; neither zero nor parallel to the other.
        edge_u: Vec3,
        /// From the corner along the other edge. The light shines to the side that `edge_u` x `edge_v` points to.
        edge_v: Vec3,
        /// Radiance that leaves each of its points in each direction.
        radiance: Vec3,
        /// Shines from both sides.
        two_sided: bool,
    },
    /// Shines from the outside of a sphere.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Its radius, > 0.
        radius: f32,
        /// Radiance that leaves each of its points in each direction.
        radiance: Vec3,
    },
}
