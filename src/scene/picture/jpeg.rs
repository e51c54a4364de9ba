//! JPEG, baseline and progressive, through the crate `zune-jpeg`.

use super::{Fault, MAX_SIDE, Picture, check_size};
use zune_jpeg::{
    JpegDecoder,
    zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions},
};

pub(super) fn decode(bytes: &[u8]) -> Result<Picture, Fault> {
    let broken = |error: zune_jpeg::errors::DecodeErrors| Fault::broken("JPEG", format!("{error:?}"));
    // Strict: a file that is cut off is an error, not a grey area. The limits are ours, with their own message.
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    debug_assert!(MAX_SIDE < usize::from(u16::MAX));
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    check_size([width, height])?;
    let pixels = decoder.decode().map_err(broken)?;
    if pixels.len() != 3 * width * height {
        return Err(Fault::broken("JPEG", "its channels are not understood"));
    }
    let texels = pixels.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]).collect();
    Ok(Picture { size: [width, height], texels, has_alpha: false })
}
