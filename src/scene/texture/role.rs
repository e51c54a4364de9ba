//! What a picture means: colours, opacities, heights or normals.

use super::mip::{Level, ONE, encode};
use crate::{math::srgb8_to_linear, scene::picture::Picture};

/// What a picture means where it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::scene) enum Role {
    /// sRGB colours; alpha is kept.
    Color,
    /// How much of a surface is there, in all channels: the picture's alpha or, if it has none, its brightness.
    Opacity,
    /// Heights, in the colour channels: brightness.
    Height,
    /// Normals n in the frame of (u, v), as (n + 1) / 2: red along u, green along v, blue out of the surface.
    Normal,
}

impl Role {
    /// The finest level of a texture.
    pub(super) fn convert(self, picture: &Picture) -> Level {
        let convert: &dyn Fn(&[u8; 4]) -> [u16; 4] = match self {
            Role::Color => {
                let linear = srgb8_to_linear().map(encode);
                &move |&[r, g, b, a]| {
                    let [r, g, b] = [r, g, b].map(|c| linear[usize::from(c)]);
                    [r, g, b, share(a)]
                }
            }
            Role::Opacity if picture.has_alpha => &|texel| [share(texel[3]); 4],
            Role::Opacity => &|texel| [brightness(texel); 4],
            Role::Height => &|texel| {
                let height = brightness(texel);
                [height, height, height, ONE as u16]
            },
            Role::Normal => &|&[r, g, b, _]| {
                // 128 is 0, so that a flat map is exactly flat.
                let [x, y, z] = [r, g, b].map(|c| encode(0.5 + (f32::from(c) - 128.0) / 254.0));
                [x, y, z, ONE as u16]
            },
        };
        Level::new(picture.size, picture.texels.iter().map(convert).collect())
    }
}

fn share(value: u8) -> u16 {
    encode(f32::from(value) / 255.0)
}

/// Mean of the three channels, as they are.
fn brightness([r, g, b, _]: &[u8; 4]) -> u16 {
    let sum = u16::from(*r) + u16::from(*g) + u16::from(*b);
    encode(f32::from(sum) / 765.0)
}
