//! OpenEXR: the linear f32 values as they are.

use super::io_error;
use crate::film::Film;
use image::codecs::openexr::OpenExrEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::io::{self, Seek, Write};

/// Writes `film` losslessly.
pub(super) fn write(file: impl Write + Seek, film: &Film) -> io::Result<()> {
    // The encoder wants f32 in this machine's byte order.
    let bytes: Vec<u8> = film.pixels().flatten().flat_map(f32::to_ne_bytes).collect();
    OpenExrEncoder::new(file)
        .write_image(&bytes, film.width(), film.height(), ExtendedColorType::Rgb32F)
        .map_err(io_error)
}
