//! Lookups: linear between the four nearest texels, and between the two versions that fit a footprint best.
//!
//! They use `+`, `*`, rounding and conversions alone, so that every machine gives the same bits.

use super::{
    Texture, Wrap,
    mip::{Level, ONE},
};
use crate::math::log2;
use glam::{Vec2, Vec4};

impl Texture {
    /// The mean around `uv` over about a square with sides of `footprint`, in units of the surface's (u, v). (0, 0) is
    /// the lower left corner of the picture. Values are in [0, 1]. Coordinates that are not finite count as 0, and a
    /// footprint that is not greater than 0 asks for the full picture.
    pub fn sample(&self, uv: Vec2, footprint: f32) -> [f32; 4] {
        let uv = self.mapped(uv);
        let level = self.level(footprint);
        let (whole, share) = (level as usize, level - level.floor());
        let fine = self.bilinear(&self.levels[whole], uv);
        let value = match self.levels.get(whole + 1) {
            Some(next) if share > 0.0 => mix(fine, self.bilinear(next, uv), share),
            _ => fine,
        };
        (value * (1.0 / ONE)).to_array()
    }

    /// The version for a footprint: 0 is the full picture, and each whole number half of the one before.
    pub fn level(&self, footprint: f32) -> f32 {
        let texels = footprint * self.density;
        // Written so that NaN gives the full picture.
        if texels > 1.0 {
            // More texels than any picture has do not matter.
            log2(texels.min(1.0e6)).clamp(0.0, (self.levels.len() - 1) as f32)
        } else {
            0.0
        }
    }

    /// (u, v) of the picture, in the unit square.
    fn mapped(&self, uv: Vec2) -> Vec2 {
        let uv = uv * self.mapping.scale + self.mapping.offset;
        let inside = match self.mapping.wrap {
            Wrap::Repeat => uv - uv.floor(),
            Wrap::Clamp => uv.clamp(Vec2::ZERO, Vec2::ONE),
        };
        if inside.is_finite() { inside } else { Vec2::ZERO }
    }

    /// The mean of the four nearest texels, weighted by nearness.
    fn bilinear(&self, level: &Level, uv: Vec2) -> Vec4 {
        let [width, height] = level.size();
        // Rows run down, v runs up.
        let (x0, x1, right) = self.neighbours(uv.x, width);
        let (y0, y1, down) = self.neighbours(1.0 - uv.y, height);
        let texel = |x: usize, y: usize| Vec4::from_array(level.texels()[y * width + x].map(f32::from));
        let upper = mix(texel(x0, y0), texel(x1, y0), right);
        let lower = mix(texel(x0, y1), texel(x1, y1), right);
        mix(upper, lower, down)
    }

    /// The two texels of a row of `side` whose centres are on either side of `at`, which is in [0, 1], and how far it
    /// is from the first to the second.
    fn neighbours(&self, at: f32, side: usize) -> (usize, usize, f32) {
        let at = at * side as f32 - 0.5;
        let first = at.floor();
        let fit = |i: isize| match self.mapping.wrap {
            Wrap::Repeat => i.rem_euclid(side as isize) as usize,
            Wrap::Clamp => i.clamp(0, side as isize - 1) as usize,
        };
        (fit(first as isize), fit(first as isize + 1), at - first)
    }
}

fn mix(a: Vec4, b: Vec4, share: f32) -> Vec4 {
    a + (b - a) * share
}
