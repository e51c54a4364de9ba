//! Reading text files without surprises, and names of numbered files.

use crate::error::{Error, Result};
use std::{fs, path::Path};

/// The whole of a file, or what is wrong with it and what to do. Anything but a regular file is refused: a device or
/// pipe might never end.
pub(super) fn read_binary(path: &Path) -> std::result::Result<Vec<u8>, (String, &'static str)> {
    let unreadable = |e: std::io::Error| {
        let remedy = match e.kind() {
            std::io::ErrorKind::NotFound => "check the path",
            _ => "make it a readable file",
        };
        (format!("cannot be read ({e})"), remedy)
    };
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(("is not a regular file".into(), "give the path of a file"));
    }
    fs::read(path).map_err(unreadable)
}

/// The whole of a text file. A file with zero bytes in it, which is binary or in a 16-bit encoding, is refused.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let bytes = read_binary(path).map_err(|(what, remedy)| Error::file(path, what, remedy))?;
    match bytes.iter().position(|&byte| byte == 0) {
        None => Ok(bytes),
        Some(at) => {
            let line = 1 + bytes[..at].iter().filter(|&&byte| byte == b'\n').count();
            Err(Error::line(
                path,
                line,
                "holds a zero byte, so this is no text",
                "save the file as UTF-8 text",
            ))
        }
    }
}

/// A text file in which bytes that are not UTF-8 (names in an old encoding) become replacement characters.
pub(super) fn read_lossy(path: &Path) -> Result<String> {
    let bytes = read_bytes(path)?;
    Ok(String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()))
}

/// A text file that must be UTF-8.
pub(super) fn read_utf8(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path)?).map_err(|e| {
        let valid = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|&&byte| byte == b'\n').count();
        Error::line(path, line, "holds a byte that is not UTF-8", "save the file as UTF-8 text")
    })
}

/// The name with its only `%d`, or `%0Nd` for N digits from 1 to 9, replaced by the number; `None` if it has none or several.
pub fn numbered(name: &str, number: u64) -> Option<String> {
    let mut places = name.match_indices('%').filter_map(|(at, _)| {
        let (format, rest) = name[at + 1..].split_once('d')?;
        match format.as_bytes() {
            [] => Some((at, 0, rest)),
            [b'0', digit @ b'1'..=b'9'] => Some((at, usize::from(digit - b'0'), rest)),
            _ => None,
        }
    });
    let (at, digits, rest) = places.next()?;
    places.next().is_none().then(|| format!("{}{number:0digits$}{rest}", &name[..at]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_takes_the_place_of_the_only_mark() {
        for (name, expected) in [
            ("a%04d.obj", Some("a0012.obj")),
            ("%d/b.obj", Some("12/b.obj")),
            ("50%/c%01d", Some("50%/c12")),
            ("%d%d", None),
            ("plain.obj", None),
            ("%4d", None),
            ("%", None),
        ] {
            assert_eq!(numbered(name, 12).as_deref(), expected, "{name}");
        }
    }
}
