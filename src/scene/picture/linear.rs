//! Pictures of linear light: Radiance (`.hdr`) through `zune-hdr`, OpenEXR through `exr`; also PNG and JPEG, decoded.

use super::{Fault, Kind, MAX_SIDE, check_size, jpeg, png, read_file};
use crate::math::srgb8_to_linear;
use std::{io::Cursor, path::Path};
use zune_hdr::HdrDecoder;
use zune_jpeg::zune_core::{bytestream::ZCursor, options::DecoderOptions};

/// A picture of linear light.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Linear {
    /// Width and height, at least 1.
    pub(in crate::scene) size: [usize; 2],
    /// Red, green, blue, finite and not negative; row by row from the top.
    pub(in crate::scene) texels: Vec<[f32; 3]>,
    /// Channels that were negative, which light cannot be, and became 0.
    pub(in crate::scene) negative: usize,
}

/// Reads a Radiance, OpenEXR, PNG or JPEG file.
pub(in crate::scene) fn read_linear(path: &Path) -> Result<Linear, Fault> {
    let bytes = read_file(path)?;
    let (size, texels) = match Kind::of(&bytes) {
        Some(Kind::Radiance) => radiance(&bytes)?,
        Some(Kind::OpenExr) => open_exr(&bytes)?,
        Some(kind @ (Kind::Png | Kind::Jpeg)) => {
            let picture = if kind == Kind::Png { png::decode(&bytes)? } else { jpeg::decode(&bytes)? };
            let linear = srgb8_to_linear();
            let decode = |&[r, g, b, _]: &[u8; 4]| [r, g, b].map(|c| linear[usize::from(c)]);
            (picture.size, picture.texels.iter().map(decode).collect())
        }
        None => {
            let what = "is no Radiance, OpenEXR, PNG or JPEG picture";
            return Err(Fault::new(what, "save it as .hdr or .exr"));
        }
    };
    usable(size, texels)
}

/// Refuses NaN and infinity, and counts what is negative.
fn usable(size: [usize; 2], mut texels: Vec<[f32; 3]>) -> Result<Linear, Fault> {
    if let Some(bad) = texels.iter().position(|texel| texel.iter().any(|c| !c.is_finite())) {
        let (x, y) = (bad % size[0], bad / size[0]);
        let what = format!("holds a value that is not finite, at pixel ({x}, {y})");
        return Err(Fault::new(what, "repair the picture"));
    }
    let mut negative = 0;
    for channel in texels.iter_mut().flatten().filter(|c| **c < 0.0) {
        *channel = 0.0;
        negative += 1;
    }
    Ok(Linear { size, texels, negative })
}

type Decoded = ([usize; 2], Vec<[f32; 3]>);

fn radiance(bytes: &[u8]) -> Result<Decoded, Fault> {
    let broken = |error: zune_hdr::HdrDecodeErrors| Fault::broken("Radiance picture", format!("{error:?}"));
    // The limits are ours, with their own message.
    let options =
        DecoderOptions::default().set_max_width(1 << 30).set_max_height(1 << 30).set_strict_mode(true);
    let mut decoder = HdrDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    check_size([width, height])?;
    let values = decoder.decode().map_err(broken)?;
    if values.len() != 3 * width * height {
        return Err(Fault::broken("Radiance picture", "it has the wrong length"));
    }
    Ok(([width, height], values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()))
}

fn open_exr(bytes: &[u8]) -> Result<Decoded, Fault> {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let broken = |error: exr::error::Error| Fault::broken("OpenEXR picture", error);
    let headers = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &headers.headers {
        check_size([header.layer_size.0, header.layer_size.1])?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.0, vec![[0.0f32; 3]; size.0 * size.1]),
            |(width, texels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                texels[at.1 * *width + at.0] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let (width, texels) = image.layer_data.channel_data.pixels;
    check_size([width, texels.len() / width.max(1)])?;
    debug_assert!(width <= MAX_SIDE);
    Ok(([width, texels.len() / width], texels))
}
