//! How much light is to be followed: what belongs to a scene beside its geometry and light.

use super::EffectSet;

/// How far light is followed, and by how many samples. All of it changes the image; none of it is a matter of speed alone.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Camera rays per pixel, >= 1. One goes through the centre of the pixel; more are stratified over its area, and their
    /// mean is taken.
    pub samples: u32,
    /// Only pixels whose centre differs from one of their corners or of their eight neighbours by more than this get three
    /// eighths of the samples, at least four, and all if those scatter by six times as much; the others get one, through
    /// the centre. What is compared are square roots of colours within 0 to 1, about what an eye sees, by their greatest
    /// channel; > 0. Chapter 3.7 of the thesis.
    pub adaptive: Option<f32>,
    /// Shadow rays per camera ray to each [`super::AreaLight`], to all emitting triangles together, and to a sky that lights;
    /// >= 1. Stratified.
    pub light_samples: u32,
    /// Diffuse reflections that indirect light is followed over; 0 leaves it out.
    pub bounces: u32,
    /// Ambient light is what gets past nearby surfaces, instead of reaching every corner.
    pub ambient_occlusion: Option<AmbientOcclusion>,
    /// A lens in place of the pinhole.
    pub depth_of_field: Option<DepthOfField>,
    /// Reflections and refractions in a row after which rays end, so that two mirrors do not last for ever.
    pub max_depth: u32,
    /// Rays end whose contribution to the colour of their pixel is below this in every channel; 0 follows all of them.
    pub cutoff: f32,
    /// Triangles whose material emits (`ke`) light the others, with soft shadows. Otherwise they only glow.
    pub emitters: bool,
    /// Shadow rays of meshes with smooth normals start on the curved surface that the normals stand for, and light that is
    /// above it counts, so that the edges of triangles do not show where light grazes (J. Hanika, "Hacking the Shadow
    /// Terminator", 2021).
    pub smooth_terminator: bool,
    /// Effects that are left out although the scene calls for them.
    pub without: EffectSet,
}

/// Ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// Surfaces farther than this do not count; > 0, may be infinite.
    pub radius: f32,
    /// Rays per surface, >= 1.
    pub samples: u32,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthOfField {
    /// Radius of the lens, > 0.
    pub aperture: f32,
    /// Distance of the plane that is in focus from the eye along the viewing direction, > 0.
    pub focus: f32,
}

impl RenderSettings {
    /// What an image of eight bits cannot show: half of a step of 1/256.
    pub const CUTOFF: f32 = 1.0 / 512.0;
}

impl Default for RenderSettings {
    fn default() -> RenderSettings {
        RenderSettings {
            samples: 1,
            adaptive: None,
            light_samples: 16,
            bounces: 0,
            ambient_occlusion: None,
            depth_of_field: None,
            max_depth: 8,
            cutoff: RenderSettings::CUTOFF,
            emitters: false,
            smooth_terminator: false,
            without: EffectSet::EMPTY,
        }
    }
}
