//! Picture files: PNG and JPEG for textures, Radiance and OpenEXR for environments.
//!
//! What a file is, its first bytes say. A broken, cut off or oversized file is a [`Fault`], never half a picture.

mod jpeg;
mod linear;
mod png;

pub(super) use linear::read_linear;

use super::text::read_binary;
use std::path::Path;

/// Most pixels along a side of a picture.
const MAX_SIDE: usize = 1 << 14;
/// Most pixels of a picture: 512 MiB as a texture, without its smaller versions.
const MAX_TEXELS: usize = 1 << 26;

/// Why a picture cannot be used, for an error that names the place which asks for it.
#[derive(Debug)]
pub(super) struct Fault {
    /// What is wrong, after the file's name.
    pub(super) what: String,
    /// What to do about it.
    pub(super) remedy: String,
}

impl Fault {
    fn new(what: impl ToString, remedy: &str) -> Fault {
        Fault { what: what.to_string(), remedy: remedy.into() }
    }

    /// For whatever a decoder complains about.
    fn broken(kind: &str, error: impl ToString) -> Fault {
        let error = error.to_string();
        let error: Vec<&str> = error.split_whitespace().collect();
        Fault::new(format!("is a broken {kind} ({})", error.join(" ")), "save it again")
    }
}

/// A picture of 8 bits per channel, in the encoding of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    /// Width and height, at least 1.
    pub(super) size: [usize; 2],
    /// Red, green, blue, alpha; row by row from the top.
    pub(super) texels: Vec<[u8; 4]>,
    /// The file has alpha; else all of it is 255.
    pub(super) has_alpha: bool,
}

/// Kinds of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Jpeg,
    Radiance,
    OpenExr,
}

impl Kind {
    fn of(bytes: &[u8]) -> Option<Kind> {
        let starts = |magic: &[u8]| bytes.starts_with(magic);
        match () {
            () if starts(b"\x89PNG\r\n\x1a\n") => Some(Kind::Png),
            () if starts(b"\xff\xd8\xff") => Some(Kind::Jpeg),
            () if starts(b"#?RADIANCE") || starts(b"#?RGBE") => Some(Kind::Radiance),
            () if starts(b"\x76\x2f\x31\x01") => Some(Kind::OpenExr),
            () => None,
        }
    }
}

/// Reads a PNG or JPEG file.
pub(super) fn read(path: &Path) -> Result<Picture, Fault> {
    let bytes = read_file(path)?;
    match Kind::of(&bytes) {
        Some(Kind::Png) => png::decode(&bytes),
        Some(Kind::Jpeg) => jpeg::decode(&bytes),
        Some(Kind::Radiance | Kind::OpenExr) => {
            Err(Fault::new("is a high-dynamic-range picture, not a texture", "save it as PNG or JPEG"))
        }
        None => Err(Fault::new("is no PNG or JPEG picture", "save it as PNG or JPEG")),
    }
}

fn read_file(path: &Path) -> Result<Vec<u8>, Fault> {
    read_binary(path).map_err(|(what, remedy)| Fault { what, remedy: remedy.into() })
}

/// Refuses sizes for which no memory should be spent.
fn check_size(size: [usize; 2]) -> Result<(), Fault> {
    let [width, height] = size;
    if width == 0 || height == 0 {
        return Err(Fault::new("has no pixels", "save it again"));
    }
    if width.max(height) > MAX_SIDE || width * height > MAX_TEXELS {
        let what = format!("has {width}x{height} pixels, which is too large");
        let remedy = format!("scale it to at most {MAX_SIDE} a side and {MAX_TEXELS} in all");
        return Err(Fault::new(what, &remedy));
    }
    Ok(())
}
