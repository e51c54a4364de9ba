//! Pictures on surfaces: what a texture is, and how it is looked up.
//!
//! ```text
//!   file --picture--> 8-bit texels --role--> linear 16-bit texels --mip--> a chain of halves
//!                                                                            |
//!                          colour, opacity, height or normal <--sample-- (u, v), footprint
//! ```
//!
//! How much of the picture a ray sees is told as a width in (u, v), as ray cones give it (Akenine-Möller et al.,
//! "Texture Level of Detail Strategies for Real-Time Ray Tracing", Ray Tracing Gems 2019, section 20.3.4):
//! `cone width / |cos| * sqrt(area in (u, v) / area in space)`.

mod mip;
mod role;
mod sample;
mod store;
#[cfg(test)]
mod tests;

pub(super) use role::Role;
pub(super) use store::Textures;

use super::picture::Picture;
use glam::Vec2;
use mip::{Level, encode};

/// What lies beyond the edges of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The texels at its edge.
    Clamp,
}

/// A picture to be looked up by texture coordinates: linear red, green, blue and opacity.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name for messages, mostly that of its file.
    pub name: String,
    levels: Vec<Level>,
    mapping: Mapping,
    /// Texels per unit of (u, v): the square root of their number in its unit square.
    density: f32,
}

/// How (u, v) of a surface become (u, v) of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mapping {
    /// Factors, finite.
    pub(super) scale: Vec2,
    /// Added afterwards, finite.
    pub(super) offset: Vec2,
    /// What lies outside of the unit square.
    pub(super) wrap: Wrap,
}

impl Mapping {
    /// (u, v) as they are.
    pub(super) const IDENTITY: Mapping = Mapping { scale: Vec2::ONE, offset: Vec2::ZERO, wrap: Wrap::Repeat };
}

impl Texture {
    /// A picture of `size` columns and rows, row by row from the top. Values are kept in [0, 1], to 1 in 32768.
    ///
    /// # Panics
    /// If it has no pixel, or not as many as `size` says.
    pub fn new(name: impl Into<String>, size: [u32; 2], pixels: Vec<[f32; 4]>, wrap: Wrap) -> Texture {
        let texels = pixels.into_iter().map(|pixel| pixel.map(encode)).collect();
        let finest = Level::new(size.map(|side| side as usize), texels);
        Texture::from_finest(name.into(), finest, Mapping { wrap, ..Mapping::IDENTITY })
    }

    /// A texture of a file's picture.
    pub(super) fn of_picture(name: String, picture: &Picture, role: Role, mapping: Mapping) -> Texture {
        Texture::from_finest(name, role.convert(picture), mapping)
    }

    fn from_finest(name: String, finest: Level, mapping: Mapping) -> Texture {
        let density = (finest.texels().len() as f32).sqrt() * mapping.scale.abs().element_product().sqrt();
        Texture { name, levels: mip::chain(finest), mapping, density }
    }

    /// The picture without its smaller versions: lookups then take the full one whatever the footprint.
    pub fn unfiltered(&self) -> Texture {
        let (name, levels) = (self.name.clone(), self.levels[..1].to_vec());
        Texture { name, levels, ..*self }
    }

    /// Columns and rows of the full picture.
    pub fn size(&self) -> [u32; 2] {
        self.levels[0].size().map(|side| side as u32)
    }

    /// Texels along a unit of the surface's (u, v), in the mean of both directions.
    pub fn density(&self) -> f32 {
        self.density
    }

    /// Memory of all its versions in bytes.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(level.texels())).sum()
    }

    /// Smallest and greatest value of the first channel anywhere.
    pub fn range(&self) -> [f32; 2] {
        let mut range = [u16::MAX, 0];
        for texel in self.levels[0].texels() {
            range = [range[0].min(texel[0]), range[1].max(texel[0])];
        }
        range.map(|value| f32::from(value) / mip::ONE)
    }
}
