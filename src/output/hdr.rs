//! Radiance HDR: three 8-bit mantissas with one exponent per pixel.

use super::io_error;
use crate::film::Film;
use image::Rgb;
use image::codecs::hdr::HdrEncoder;
use std::io::{self, Write};

/// The largest exponent RGBE has is 127; a little below 2^127 no rounding can exceed it.
const LARGEST: f32 = 1.6e38;

/// Writes `film`; what RGBE cannot hold (negative and infinite values) is clamped.
pub(super) fn write(file: impl Write, film: &Film) -> io::Result<()> {
    let pixels: Vec<_> =
        film.pixels().map(|pixel| Rgb(pixel.map(|value| value.clamp(0.0, LARGEST)))).collect();
    HdrEncoder::new(file).encode(&pixels, film.width() as usize, film.height() as usize).map_err(io_error)
}
