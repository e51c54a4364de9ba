//! Portable float map: a three-line header, then f32 triples from the bottom row to the top.
//!
//! Format: <https://www.pauldebevec.com/Research/HDR/PFM/>. A negative scale means little-endian.

use crate::film::Film;
use std::io::{self, Write};

/// Writes `film` losslessly.
pub(super) fn write(mut file: impl Write, film: &Film) -> io::Result<()> {
    write!(file, "PF\n{} {}\n-1.0\n", film.width(), film.height())?;
    let mut bytes = Vec::with_capacity(film.width() as usize * 12);
    for y in (0..film.height()).rev() {
        bytes.clear();
        bytes.extend(film.row(y).flatten().flat_map(f32::to_le_bytes));
        file.write_all(&bytes)?;
    }
    Ok(())
}
