//! The TOML vocabulary of a scene file, as it is written there and not yet checked.
//!
//! Every value keeps its place in the file, so that whatever is found wrong with it later can be named by line and
//! column. Keys that are not listed here are errors.

mod map;
mod triple;

pub(super) use map::{Map, Wrap};
pub(super) use triple::Triple;

use serde::Deserialize;
use toml::Spanned;

/// A whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    /// Short name; the file's name if missing.
    pub(super) name: Option<String>,
    /// Image width and height.
    pub(super) size: Option<Spanned<[i64; 2]>>,
    /// Colour of rays that hit nothing; black if missing.
    pub(super) background: Option<Spanned<Triple>>,
    /// Light from everywhere; none if missing.
    pub(super) ambient: Option<Spanned<Triple>>,
    /// The camera; one that frames everything if missing.
    pub(super) camera: Option<Spanned<Camera>>,
    /// At least one.
    pub(super) mesh: Vec<Mesh>,
    /// Changes to materials of the meshes, and new ones.
    #[serde(default)]
    pub(super) material: Vec<Spanned<Material>>,
    /// Lights, in order.
    #[serde(default)]
    pub(super) light: Vec<Spanned<Light>>,
    /// What surrounds the scene; the background alone if missing.
    pub(super) environment: Option<Spanned<Environment>>,
    /// How far light is followed.
    pub(super) settings: Option<Settings>,
}

/// `[camera]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Camera {
    /// Position of the pinhole.
    pub(super) eye: Spanned<[f64; 3]>,
    /// The point in the middle of the image.
    pub(super) at: Spanned<[f64; 3]>,
    /// Up in the image; +y if missing.
    pub(super) up: Option<Spanned<[f64; 3]>>,
    /// Vertical field of view in degrees.
    pub(super) fov: Spanned<f64>,
}

/// `[[mesh]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mesh {
    /// OBJ file, relative to the scene file or to a folder of `IRT_SCENES`.
    pub(super) file: Spanned<String>,
    /// Put before the names of its parts.
    pub(super) name: Option<String>,
    /// Name of the material of all its triangles, instead of the file's.
    pub(super) material: Option<Spanned<String>>,
    /// First: factor, uniform or per axis.
    pub(super) scale: Option<Spanned<Triple>>,
    /// Then: degrees about x, then y, then z.
    pub(super) rotate: Option<Spanned<[f64; 3]>>,
    /// Last: offset.
    pub(super) translate: Option<Spanned<[f64; 3]>>,
    /// First and last number of a sequence of files; `file` has `%d` or the like then.
    pub(super) frames: Option<Spanned<[i64; 2]>>,
    /// Files of the sequence per second.
    pub(super) fps: Option<Spanned<f64>>,
    /// How it is turned and moved after all that, by time.
    #[serde(default)]
    pub(super) key: Vec<Spanned<Key>>,
}

/// `[[mesh.key]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Key {
    /// Seconds.
    pub(super) time: Spanned<f64>,
    /// Degrees about x, then y, then z.
    pub(super) rotate: Option<Spanned<[f64; 3]>>,
    /// After that.
    pub(super) translate: Option<Spanned<[f64; 3]>>,
}

/// `[[material]]`: what is given replaces the value of the meshes' material of that name.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Material {
    pub(super) name: Spanned<String>,
    pub(super) ka: Option<Spanned<Triple>>,
    pub(super) kd: Option<Spanned<Triple>>,
    pub(super) ks: Option<Spanned<Triple>>,
    pub(super) ke: Option<Spanned<Triple>>,
    pub(super) ns: Option<Spanned<f64>>,
    pub(super) ni: Option<Spanned<f64>>,
    pub(super) d: Option<Spanned<f64>>,
    pub(super) illum: Option<Spanned<i64>>,
    pub(super) tf: Option<Spanned<Triple>>,
    /// Per unit of the scene.
    pub(super) absorption: Option<Spanned<Triple>>,
    /// 0 is a perfect mirror.
    pub(super) roughness: Option<Spanned<f64>>,
    pub(super) map_kd: Option<Map>,
    pub(super) map_d: Option<Map>,
    pub(super) map_ke: Option<Map>,
    pub(super) map_bump: Option<Map>,
    pub(super) norm: Option<Map>,
}

/// `[[light]]`: which keys are needed, and which make no sense, depends on the kind.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Light {
    pub(super) kind: LightKind,
    /// Linear colour; white if missing.
    pub(super) color: Option<Spanned<Triple>>,
    /// Strength, 1 if missing. The light sends `color` times this.
    pub(super) intensity: Option<Spanned<f64>>,
    pub(super) position: Option<Spanned<[f64; 3]>>,
    /// Where the light travels to; any length but zero.
    pub(super) direction: Option<Spanned<[f64; 3]>>,
    pub(super) falloff: Option<Spanned<Falloff>>,
    /// Half angle of the cone of full strength, degrees.
    pub(super) inner: Option<Spanned<f64>>,
    /// Half angle of the whole cone, degrees.
    pub(super) outer: Option<Spanned<f64>>,
    pub(super) corner: Option<Spanned<[f64; 3]>>,
    pub(super) edge_u: Option<Spanned<[f64; 3]>>,
    pub(super) edge_v: Option<Spanned<[f64; 3]>>,
    pub(super) two_sided: Option<Spanned<bool>>,
    pub(super) radius: Option<Spanned<f64>>,
}

/// `[environment]`: a picture, a gradient, or nothing but whether the background lights.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Environment {
    /// Picture file, as a mesh is found.
    pub(super) map: Option<Spanned<String>>,
    /// Degrees about +y.
    pub(super) rotation: Option<Spanned<f64>>,
    /// Factor of the picture.
    pub(super) strength: Option<Spanned<f64>>,
    pub(super) zenith: Option<Spanned<Triple>>,
    pub(super) horizon: Option<Spanned<Triple>>,
    pub(super) ground: Option<Spanned<Triple>>,
    /// Lights surfaces; true if missing.
    pub(super) light: Option<bool>,
}

/// `[settings]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    pub(super) samples: Option<Spanned<i64>>,
    pub(super) adaptive: Option<Spanned<f64>>,
    pub(super) light_samples: Option<Spanned<i64>>,
    pub(super) bounces: Option<Spanned<i64>>,
    pub(super) max_depth: Option<Spanned<i64>>,
    pub(super) cutoff: Option<Spanned<f64>>,
    pub(super) emitters: Option<bool>,
    pub(super) smooth_terminator: Option<bool>,
    pub(super) ambient_occlusion: Option<AmbientOcclusion>,
    pub(super) depth_of_field: Option<DepthOfField>,
    /// Names of effects to leave out.
    #[serde(default)]
    pub(super) without: Vec<Spanned<String>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AmbientOcclusion {
    pub(super) radius: Spanned<f64>,
    pub(super) samples: Option<Spanned<i64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DepthOfField {
    pub(super) aperture: Spanned<f64>,
    pub(super) focus: Spanned<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LightKind {
    Point,
    Directional,
    Spot,
    Rectangle,
    Sphere,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Falloff {
    None,
    InverseSquare,
}
