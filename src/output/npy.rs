//! Rays and hits as NumPy arrays. The only file that names `npyz`.

use super::PendingFile;
use crate::{
    error::{Error, Result},
    kernels::{Hit, MISS, Ray},
};
use npyz::{DType, Field, NpyHeader, Order, WriteOptions, WriterBuilder};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

/// Bytes of one ray: eight floats.
const RAY: usize = 32;
/// Rays that are read or hits that are written at once.
const PART: usize = 4096;
/// What to do about an array of another kind.
const REMEDY: &str = "save it with numpy.save as a C-ordered float32 array of shape (N, 8): origin, tnear, direction, \
                      tfar";

/// Reads rays from a float32 array of shape (N, 8): origin x y z, tnear, direction x y z, tfar.
///
/// # Errors
/// [`Error::File`] for a file that cannot be read, holds something else, or is shorter or longer than it says.
pub fn read_rays(path: &Path) -> Result<Vec<Ray>> {
    let cannot = |error: &io::Error| Error::file(path, format!("cannot be read ({error})"), "check the name");
    let file = File::open(path).map_err(|error| cannot(&error))?;
    let length = file.metadata().map_err(|error| cannot(&error))?.len();
    let mut reader = BufReader::with_capacity(RAY * PART, file);
    let header = NpyHeader::from_reader(&mut reader)
        .map_err(|error| Error::file(path, format!("is no array of NumPy ({})", brief(&error)), REMEDY))?;
    let count = check(&header).map_err(|what| Error::file(path, what, REMEDY))?;
    // What the header says may be wrong: no more memory than the file could fill.
    let mut rays = Vec::with_capacity(count.min(length / RAY as u64) as usize);
    let mut bytes = vec![0; RAY * PART];
    while (rays.len() as u64) < count {
        let part = (count - rays.len() as u64).min(PART as u64) as usize;
        reader.read_exact(&mut bytes[..part * RAY]).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => {
                Error::file(path, format!("ends before its {count} rays are complete"), "save it again")
            }
            _ => cannot(&error),
        })?;
        rays.extend(bytes[..part * RAY].as_chunks::<RAY>().0.iter().map(ray));
    }
    match reader.read(&mut [0]) {
        Ok(0) => Ok(rays),
        Ok(_) => Err(Error::file(path, format!("goes on after its {count} rays"), "save it again")),
        Err(error) => Err(cannot(&error)),
    }
}

/// What is wrong with a header, without the excerpt of it on further lines.
fn brief(error: &io::Error) -> String {
    let text = error.to_string();
    text.split([':', '\n']).next().unwrap_or_default().trim_end().to_string()
}

/// The number of rays, or what is wrong with the array.
fn check(header: &NpyHeader) -> std::result::Result<u64, String> {
    let dtype = header.dtype().descr();
    if dtype != "'<f4'" {
        return Err(format!("holds values of type {dtype}, not little-endian float32 ('<f4')"));
    }
    let &[count, 8] = header.shape() else {
        let shape: Vec<String> = header.shape().iter().map(u64::to_string).collect();
        return Err(format!("has the shape ({}), not (N, 8)", shape.join(", ")));
    };
    if header.order() == Order::Fortran {
        return Err("is in Fortran order".into());
    }
    Ok(count)
}

fn ray(bytes: &[u8; RAY]) -> Ray {
    let [ox, oy, oz, tnear, dx, dy, dz, tfar] =
        std::array::from_fn(|i| f32::from_le_bytes(std::array::from_fn(|k| bytes[4 * i + k])));
    Ray { org: [ox, oy, oz], dir: [dx, dy, dz], tnear, tfar, skip: MISS }
}

/// Writes hits as a structured array: prim u32 (4294967295 = miss), t, u, v f32.
///
/// # Errors
/// As [`PendingFile::complete`].
pub fn write_hits(file: PendingFile, hits: &[Hit]) -> Result<()> {
    let fields = [("prim", "<u4"), ("t", "<f4"), ("u", "<f4"), ("v", "<f4")];
    let field = |(name, kind): (&str, &str)| Field { name: name.into(), dtype: plain(kind) };
    let dtype = DType::Record(fields.map(field).into());
    file.complete(|out| {
        write_header(out, dtype, hits.len())?;
        let mut bytes = Vec::with_capacity(16 * PART);
        for part in hits.chunks(PART) {
            bytes.clear();
            for hit in part {
                bytes.extend_from_slice(&hit.prim.to_le_bytes());
                [hit.t, hit.u, hit.v].iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
            }
            out.write_all(&bytes)?;
        }
        Ok(())
    })
}

/// Writes which rays are blocked as an array of bytes, 1 = blocked.
///
/// # Errors
/// As [`PendingFile::complete`].
pub fn write_blocked(file: PendingFile, blocked: &[u8]) -> Result<()> {
    file.complete(|out| {
        write_header(out, plain("|u1"), blocked.len())?;
        out.write_all(blocked)
    })
}

fn plain(kind: &str) -> DType {
    DType::new_scalar(kind.parse().expect("a type of NumPy"))
}

fn write_header(out: &mut impl Write, dtype: DType, len: usize) -> io::Result<()> {
    WriteOptions::new_header_only().dtype(dtype).shape(&[len as u64]).writer(out).write_header_only()?;
    Ok(())
}
