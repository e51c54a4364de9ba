//! What is rendered: triangles and how they move, materials, lights and a camera, all in world space and fully validated.
//!
//! Readers and generators produce a [`Scene`]; everything downstream only borrows it. A scene holds one flat
//! triangle list, because that is what a tree is built over; [`Part`]s remember which range came from which mesh.

mod area;
mod check;
mod description;
mod effect;
mod environment;
mod framing;
mod inspect;
mod library;
mod light;
mod load;
mod material;
mod mesh;
mod motion;
mod obj;
mod picture;
pub mod procedural;
mod settings;
mod tally;
mod text;
mod texture;

pub use effect::{Effect, EffectSet};
pub use environment::{Environment, Sky, SkyMap};
pub use inspect::{CameraReport, LightReport, MotionReport, SceneReport, Share, TextureReport, TrackReport};
pub use library::{Described, Library, MeshPlace, SCENES_VARIABLE};
pub use light::{AreaLight, Falloff, Light};
pub use load::{described, load};
pub use material::{Bump, BumpKind, Material};
pub use mesh::{Part, TriangleMesh};
pub use motion::{DEFAULT_RATE, Key, Motion, Shape, Track};
pub use settings::{AmbientOcclusion, DepthOfField, RenderSettings};
pub use text::numbered;
pub use texture::{Texture, Wrap};

use glam::Vec3;

/// A pinhole camera as a scene file describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraDescription {
    /// Position of the pinhole.
    pub eye: Vec3,
    /// The point in the middle of the image.
    pub at: Vec3,
    /// A vector that points up in the image; need not be normalised nor orthogonal to the viewing direction.
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub fov_deg: f32,
}

/// Image size of a scene that asks for no other.
pub const DEFAULT_SIZE: [u32; 2] = [1024, 1024];
/// Most pixels of an image: 3 GiB of film.
pub const MAX_PIXELS: u64 = 1 << 28;
/// Most pixels along a side of an image.
pub const MAX_SIDE: u32 = 1 << 16;

/// No coordinate of a scene is greater than this: squares of distances then stay finite in f32.
pub const MAX_COORDINATE: f32 = 1.0e18;

/// Everything one image is a function of, except sampling.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Short name, as a user would type it.
    pub name: String,
    /// All triangles, in world space.
    pub mesh: TriangleMesh,
    /// Materials, indexed by [`TriangleMesh::materials`]; never empty when there are triangles.
    pub materials: Vec<Material>,
    /// Images, indexed by the maps of [`Material`].
    pub textures: Vec<Texture>,
    /// Lights without extent, in the order in which their contributions are added.
    pub lights: Vec<Light>,
    /// Lights with an extent, whose contributions follow.
    pub area_lights: Vec<AreaLight>,
    /// What surrounds the scene.
    pub environment: Environment,
    /// How far light is followed.
    pub settings: RenderSettings,
    /// The camera.
    pub camera: CameraDescription,
    /// Light that reaches every surface from everywhere (multiplies `Ka` or, where that is zero, `Kd`).
    pub ambient: Vec3,
    /// Linear colour of rays that hit nothing.
    pub background: Vec3,
    /// How the triangles move; `mesh` is what they are at the time of the last [`Scene::pose`], at first 0.
    pub motion: Option<Motion>,
    /// Image size in pixels, width then height, unless the user asks for another.
    pub size: [u32; 2],
    /// What was repaired, dropped or ignored while loading, counted; each a sentence for the user.
    pub warnings: Vec<String>,
}

impl Default for Scene {
    /// Nothing, seen from (0, 0, 5).
    fn default() -> Scene {
        Scene {
            name: String::new(),
            mesh: TriangleMesh::default(),
            materials: vec![Material::default()],
            textures: Vec::new(),
            lights: Vec::new(),
            area_lights: Vec::new(),
            environment: Environment::default(),
            settings: RenderSettings::default(),
            camera: CameraDescription { eye: 5.0 * Vec3::Z, at: Vec3::ZERO, up: Vec3::Y, fov_deg: 40.0 },
            ambient: Vec3::ZERO,
            background: Vec3::ZERO,
            motion: None,
            size: DEFAULT_SIZE,
            warnings: Vec::new(),
        }
    }
}
