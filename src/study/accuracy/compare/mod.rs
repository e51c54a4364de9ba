//! How far one image is from another, by the measures that people use.
//!
//! | measure | of | equal images |
//! | --- | --- | --- |
//! | RMSE | linear values in [0, 1], all channels | 0 |
//! | PSNR | the same, in decibels, `-20 log10(RMSE)` | infinite |
//! | greatest difference | the same, of one channel | 0 |
//! | SSIM | brightness as sRGB: likeness of structure, at most 1 | 1 |
//! | FLIP | sRGB: what people see who flip between the two, 0 to 1 | 0 |
//!
//! Values are clamped to [0, 1] first, because that is what a screen shows: a highlight of 30 that ought to be 40 is no
//! error, and a single such pixel would outweigh all others.

mod filter;
mod flip;
mod ssim;

pub use flip::{flip, flip_map};
pub use ssim::ssim;

use crate::film::Film;

/// An image in linear values between 0 and 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    size: [usize; 2],
    pixels: Vec<[f32; 3]>,
}

/// All measures between an image and the one that it should be.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Distance {
    /// Root of the mean square over all channels.
    pub rmse: f64,
    /// Peak signal-to-noise ratio in decibels; infinite for equal images.
    pub psnr: f64,
    /// Mean structural similarity.
    pub ssim: f64,
    /// Mean of FLIP.
    pub flip: f64,
    /// Greatest difference of a channel.
    pub max: f64,
    /// Share of the pixels that differ at all.
    pub changed: f64,
}

impl Picture {
    /// An image of `width` columns, row by row from the top; values are clamped, and NaN is black.
    ///
    /// # Panics
    /// If there are not as many pixels as `size` says.
    pub fn new([width, height]: [u32; 2], pixels: impl IntoIterator<Item = [f32; 3]>) -> Picture {
        let clamp = |value: f32| if value > 0.0 { value.min(1.0) } else { 0.0 };
        let pixels: Vec<[f32; 3]> = pixels.into_iter().map(|pixel| pixel.map(clamp)).collect();
        let size = [width as usize, height as usize];
        assert_eq!(pixels.len(), size[0] * size[1], "a colour for each pixel");
        Picture { size, pixels }
    }

    /// What a film shows.
    pub fn of(film: &Film) -> Picture {
        Picture::new([film.width(), film.height()], film.pixels())
    }

    /// The mean of two images of one size.
    ///
    /// # Panics
    /// If their sizes differ.
    pub fn mean(&self, other: &Picture) -> Picture {
        assert_eq!(self.size, other.size, "images of one size");
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]));
        Picture { size: self.size, pixels: self.pixels.iter().zip(&other.pixels).map(mean).collect() }
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.size.map(|side| side as u32)
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The difference of each pixel: of the channel where it is greatest.
    ///
    /// # Panics
    /// If their sizes differ.
    pub fn differences(&self, other: &Picture) -> Vec<f32> {
        assert_eq!(self.size, other.size, "images of one size");
        let worst = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        self.pixels.iter().zip(&other.pixels).map(worst).collect()
    }

    /// Root of the mean square difference over all channels.
    ///
    /// # Panics
    /// If their sizes differ.
    pub fn rmse(&self, other: &Picture) -> f64 {
        assert_eq!(self.size, other.size, "images of one size");
        let square = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).powi(2);
        let channels = |picture: &'_ Picture| picture.pixels.as_flattened().to_vec();
        let (a, b) = (channels(self), channels(other));
        let sum: f64 = a.iter().zip(&b).map(square).sum();
        (sum / a.len().max(1) as f64).sqrt()
    }

    /// All measures of this image against `right`, the one that it should be.
    ///
    /// # Panics
    /// If their sizes differ.
    pub fn distance(&self, right: &Picture) -> Distance {
        let differences = self.differences(right);
        if differences.iter().all(|&difference| difference == 0.0) {
            return Distance::NONE;
        }
        let rmse = self.rmse(right);
        let changed = differences.iter().filter(|&&difference| difference > 0.0).count();
        Distance {
            rmse,
            psnr: psnr(rmse),
            ssim: ssim(right, self),
            flip: flip(right, self),
            max: f64::from(differences.iter().copied().fold(0.0, f32::max)),
            changed: changed as f64 / differences.len() as f64,
        }
    }
}

impl Distance {
    /// Between equal images.
    pub const NONE: Distance =
        Distance { rmse: 0.0, psnr: f64::INFINITY, ssim: 1.0, flip: 0.0, max: 0.0, changed: 0.0 };
}

/// Peak signal-to-noise ratio of values in [0, 1], in decibels.
pub fn psnr(rmse: f64) -> f64 {
    if rmse > 0.0 { -20.0 * rmse.log10() } else { f64::INFINITY }
}

/// sRGB of a linear value (IEC 61966-2-1), not rounded.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_what_the_formulas_say() {
        let a = Picture::new([2, 2], [[0.0, 0.5, 1.0], [0.25; 3], [0.0; 3], [1.0; 3]]);
        let b = Picture::new([2, 2], [[0.0, 0.0, 1.0], [0.25; 3], [0.0; 3], [1.0, 1.0, 0.0]]);
        let distance = a.distance(&b);
        assert!((distance.rmse - (1.25f64 / 12.0).sqrt()).abs() < 1e-12, "{distance:?}");
        // 10 log10(12 / 1.25)
        assert!((distance.psnr - 9.822_712).abs() < 1e-6, "{distance:?}");
        assert_eq!((distance.max, distance.changed), (1.0, 0.5));
        assert_eq!(a.distance(&a), Distance::NONE);
        assert_eq!(psnr(0.1), 20.0);
    }

    #[test]
    fn what_a_screen_cannot_show_is_no_difference() {
        let right = Picture::new([2, 1], [[1.0, 1.0, 0.0], [0.0; 3]]);
        let wild = Picture::new([2, 1], [[30.0, f32::INFINITY, -5.0], [f32::NAN, 0.0, -0.0]]);
        assert_eq!(wild.distance(&right), Distance::NONE);
    }

    #[test]
    fn the_mean_lies_in_the_middle() {
        let a = Picture::new([1, 1], [[0.0, 0.5, 1.0]]);
        let b = Picture::new([1, 1], [[1.0, 0.5, 0.5]]);
        assert_eq!(a.mean(&b).pixels(), [[0.5, 0.5, 0.75]]);
    }
}
