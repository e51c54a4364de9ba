//! The TOML vocabulary of a scene file, as it is written there and not yet checked.
//!
//! Every value keeps its place in the file, so that whatever is found wrong with it later can be named by line and
//! column. Keys that are not listed here are errors.

use serde::{Deserialize, Deserializer, de};
use std::fmt;
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
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LightKind {
    Point,
    Directional,
    Spot,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Falloff {
    None,
    InverseSquare,
}

/// Three numbers, or one that stands for three equal ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triple(pub(super) [f64; 3]);

impl<'de> Deserialize<'de> for Triple {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Triple, D::Error> {
        deserializer.deserialize_any(TripleVisitor)
    }
}

struct TripleVisitor;

impl<'de> de::Visitor<'de> for TripleVisitor {
    type Value = Triple;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or an array of three numbers")
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Triple, E> {
        Ok(Triple([value; 3]))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Triple, E> {
        Ok(Triple([value as f64; 3]))
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<Triple, A::Error> {
        let mut values = [0.0; 3];
        for (index, value) in values.iter_mut().enumerate() {
            *value = seq.next_element()?.ok_or_else(|| de::Error::invalid_length(index, &self))?;
        }
        match seq.next_element::<f64>()? {
            None => Ok(Triple(values)),
            Some(_) => Err(de::Error::invalid_length(4, &self)),
        }
    }
}
