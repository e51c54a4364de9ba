//! Files of images and of traced rays. The format follows the extension; the file is opened before the work and replaced only when complete.

mod atomic;
mod exr;
mod hdr;
mod npy;
mod pfm;
mod png;
mod tev;

pub use self::png::write_bytes;
pub use atomic::{PendingFile, discard_pending};
pub use npy::{read_rays, write_blocked, write_hits};
pub use tev::Tev;

// By these names, because `png` and `exr` are crates, too.
use self::exr::write as write_exr;
use self::png::write as write_png;
use crate::error::{Error, Result};
use crate::film::Film;
use std::path::Path;

/// An image format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB after exposure.
    Png,
    /// OpenEXR, linear f32.
    Exr,
    /// Radiance RGBE, linear with 8 bits of mantissa.
    Hdr,
    /// Portable float map, linear f32.
    Pfm,
}

impl Format {
    /// The format that the extension of `path` names, in either case; an error listing the formats if it names none.
    pub fn of(path: &Path) -> Result<Format> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Format::Png),
            Some("exr") => Ok(Format::Exr),
            Some("hdr") => Ok(Format::Hdr),
            Some("pfm") => Ok(Format::Pfm),
            Some(other) => {
                Err(unknown_format(path, format!("'.{other}' is not an image format irt can write")))
            }
            None => Err(unknown_format(path, "the name has no extension that tells the image format".into())),
        }
    }
}

fn unknown_format(path: &Path, what: String) -> Error {
    Error::file(path, what, "use a name that ends in .png, .exr, .hdr or .pfm")
}

/// An image file that will exist once [`OutputFile::write`] is done.
#[derive(Debug)]
pub struct OutputFile {
    format: Format,
    file: PendingFile,
}

impl OutputFile {
    /// Chooses the format and opens a temporary file beside `path`, so that whatever would prevent writing is known
    /// before the work starts. If the `OutputFile` is dropped unwritten, `path` is as it was.
    ///
    /// # Errors
    ///
    /// [`Error::File`] for an unknown extension, a missing or read-only folder, or a target that is no regular file.
    pub fn create(path: &Path) -> Result<OutputFile> {
        Ok(OutputFile { format: Format::of(path)?, file: PendingFile::create(path)? })
    }

    /// Encodes `film` and puts the file in place. `exposure` in stops (factor 2^exposure) applies to 8-bit formats only;
    /// the others keep the linear values.
    ///
    /// # Errors
    ///
    /// [`Error::Failed`] if the disk fails or is full; the target is then as it was.
    pub fn write(self, film: &Film, exposure: f32) -> Result<()> {
        let format = self.format;
        self.file.complete(|file| match format {
            Format::Png => write_png(file, film, exposure),
            Format::Exr => write_exr(file, film),
            Format::Hdr => hdr::write(file, film),
            Format::Pfm => pfm::write(file, film),
        })
    }
}

/// `image` reports failures of the file in its own wrapping.
fn io_error(error: image::ImageError) -> std::io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        other => std::io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::linear_to_srgb8;
    use crate::tile::Tile;
    use std::fs;
    use tempfile::TempDir;

    /// Colours over many magnitudes, some of them negative or out of range, different in every pixel.
    fn film(width: u32, height: u32) -> Film {
        let film = Film::new(width, height);
        let value = |i: u32, c: u32| {
            let magnitude = 10f32.powi((i % 9) as i32 - 5);
            (i as f32 * 0.37 + c as f32).sin().abs() * magnitude
        };
        let plane = |c| (0..width * height).map(|i| value(i, c)).collect::<Vec<_>>();
        film.write_tile(Tile { x: 0, y: 0, width, height }, &plane(0), &plane(1), &plane(2));
        film
    }

    fn written(film: &Film, name: &str, exposure: f32) -> (TempDir, std::path::PathBuf) {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join(name);
        OutputFile::create(&path).unwrap().write(film, exposure).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "only the image is left in the folder");
        (folder, path)
    }

    #[test]
    fn exr_keeps_every_bit() {
        for (width, height) in [(1, 1), (37, 20), (70, 3)] {
            let film = film(width, height);
            let (_folder, path) = written(&film, "a.exr", 3.0);
            let back = image::open(path).unwrap().into_rgb32f();
            assert_eq!(back.dimensions(), (width, height));
            assert!(back.pixels().map(|p| p.0).eq(film.pixels()));
        }
    }

    #[test]
    fn pfm_keeps_every_bit_bottom_row_first() {
        let film = film(5, 3);
        let (_folder, path) = written(&film, "a.pfm", 3.0);
        let bytes = fs::read(path).unwrap();
        let header = b"PF\n5 3\n-1.0\n";
        assert_eq!(&bytes[..header.len()], header);
        let values: Vec<f32> = bytes[header.len()..]
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect();
        let expected: Vec<f32> = (0..3).rev().flat_map(|y| film.row(y).flatten()).collect();
        assert_eq!(values, expected);
    }

    #[test]
    fn hdr_keeps_eight_bits_of_the_largest_channel() {
        for (width, height) in [(3, 4), (64, 9)] {
            let film = film(width, height);
            let (_folder, path) = written(&film, "a.HDR", 3.0);
            let back = image::open(path).unwrap().into_rgb32f();
            for (got, want) in back.pixels().zip(film.pixels()) {
                let step = want.iter().fold(0f32, |a, &b| a.max(b)) / 128.0;
                for c in 0..3 {
                    assert!((got.0[c] - want[c]).abs() <= step, "{:?} became {:?}", want, got.0);
                }
            }
        }
    }

    #[test]
    fn hdr_survives_huge_and_negative_values() {
        let film = Film::new(1, 1);
        let tile = Tile { x: 0, y: 0, width: 1, height: 1 };
        film.write_tile(tile, &[f32::MAX], &[-1.0], &[f32::MAX]);
        let (_folder, path) = written(&film, "a.hdr", 0.0);
        let [r, g, b] = image::open(path).unwrap().into_rgb32f().get_pixel(0, 0).0;
        assert!(r > 1e37 && r.is_finite() && g == 0.0 && b == r, "{r} {g} {b}");
    }

    #[test]
    fn png_is_srgb_after_exposure() {
        let film = film(40, 10);
        for exposure in [0.0, -1.5, 2.0] {
            let (_folder, path) = written(&film, "a.png", exposure);
            let back = image::open(path).unwrap().into_rgb8();
            let scale = exposure.exp2();
            let expected = film.pixels().map(|p| p.map(|v| linear_to_srgb8(v * scale)));
            assert!(back.pixels().map(|p| p.0).eq(expected));
        }
    }

    #[test]
    fn an_unknown_extension_is_answered_with_the_formats() {
        for name in ["a.gif", "a", "a.png.txt", ".png"] {
            let message = Format::of(Path::new(name)).unwrap_err().to_string();
            assert!(message.starts_with(name) && message.ends_with(".png, .exr, .hdr or .pfm"), "{message}");
        }
    }
}
