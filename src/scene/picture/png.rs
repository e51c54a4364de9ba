//! PNG, through the crate `png`. Palettes, greys, 16 bits and transparent colours become 8-bit RGBA.

use super::{Fault, MAX_TEXELS, Picture, check_size};
use png::{ColorType, Decoder, Limits, Transformations};
use std::io::Cursor;

pub(super) fn decode(bytes: &[u8]) -> Result<Picture, Fault> {
    let broken = |error: png::DecodingError| Fault::broken("PNG", error);
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 8 * MAX_TEXELS });
    decoder.set_transformations(Transformations::normalize_to_color8());
    let (width, height) = decoder.read_header_info().map_err(broken)?.size();
    let size = [width as usize, height as usize];
    check_size(size)?;
    let mut reader = decoder.read_info().map_err(broken)?;
    let mut buffer = vec![0; reader.output_buffer_size().unwrap_or_default()];
    let frame = reader.next_frame(&mut buffer).map_err(broken)?;
    // What follows the picture holds its checksums.
    reader.finish().map_err(broken)?;
    let buffer = &buffer[..frame.buffer_size()];
    let texels = match frame.color_type {
        ColorType::Grayscale => buffer.iter().map(|&l| [l, l, l, 255]).collect(),
        ColorType::GrayscaleAlpha => buffer.chunks_exact(2).map(|p| [p[0], p[0], p[0], p[1]]).collect(),
        ColorType::Rgb => buffer.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]).collect(),
        ColorType::Rgba => buffer.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect(),
        ColorType::Indexed => return Err(Fault::broken("PNG", "its palette is missing")),
    };
    let has_alpha = matches!(frame.color_type, ColorType::GrayscaleAlpha | ColorType::Rgba);
    Ok(Picture { size, texels, has_alpha })
}
