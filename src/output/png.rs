//! PNG: 8-bit sRGB.

use super::io_error;
use crate::film::Film;
use crate::math::linear_to_srgb8;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::io::{self, Write};

/// Writes `film`, brightened by `exposure` stops.
pub(super) fn write(file: impl Write, film: &Film, exposure: f32) -> io::Result<()> {
    let scale = exposure.exp2();
    let bytes: Vec<u8> = film.pixels().flatten().map(|value| linear_to_srgb8(value * scale)).collect();
    write_bytes(file, [film.width(), film.height()], &bytes)
}

/// Writes red, green and blue bytes of sRGB, row by row.
pub fn write_bytes(file: impl Write, [width, height]: [u32; 2], bytes: &[u8]) -> io::Result<()> {
    PngEncoder::new(file).write_image(bytes, width, height, ExtendedColorType::Rgb8).map_err(io_error)
}
