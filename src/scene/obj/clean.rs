//! Checks an OBJ file line by line and rewrites it so that tobj cannot trip over it.
//!
//! tobj gives no line numbers, refuses comments after a statement, accepts NaN, and loses the normals of a mesh in
//! which only some corners have one. What it gets from here has none of that: positions, texture coordinates and
//! normals with zero ("none") as the first, then faces with absolute indices `p/t/n`, grouped by `o` statements whose
//! names are indices into [`Cleaned::sections`].

use super::lines::{Statement, for_each_statement};
use crate::{
    error::{Error, Result},
    scene::{MAX_COORDINATE, tally::Tally},
};
use std::{io::Write, path::Path};

/// Faces with the same part name and material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Section {
    /// Last name given by `o` or `g`; empty if there was none.
    pub(super) part: String,
    /// Last name given by `usemtl`, with the line it was in.
    pub(super) material: Option<(String, usize)>,
}

/// An OBJ file that tobj reads without error.
#[derive(Default)]
pub(super) struct Cleaned {
    /// Its `v`, `vt` and `vn` lines.
    pub(super) vertices: Vec<u8>,
    /// Its `o` and `f` lines.
    pub(super) faces: Vec<u8>,
    /// What the names in `faces` stand for.
    pub(super) sections: Vec<Section>,
    /// A corner has texture coordinates.
    pub(super) textured: bool,
    /// What follows each `mtllib`, with its line.
    pub(super) libraries: Vec<(String, usize)>,
}

/// Rewrites `text`, the contents of `path`.
pub(super) fn clean(path: &Path, text: &str, tally: &mut Tally) -> Result<Cleaned> {
    let mut cleaner = Cleaner {
        path,
        tally,
        out: Cleaned { vertices: b"vt 0 0\nvn 0 0 0\n".to_vec(), ..Cleaned::default() },
        current: Section::default(),
        fresh: true,
        positions: Counter::default(),
        coordinates: Counter::default(),
        normals: Counter::default(),
        face_count: 0,
    };
    for_each_statement(text, |statement| cleaner.statement(&statement))?;
    cleaner.finish()
}

/// How many there are, and the greatest index used so far with the line that uses it.
#[derive(Default)]
struct Counter {
    count: usize,
    greatest: usize,
    line: usize,
}

impl Counter {
    /// Turns an OBJ index (from 1, or negative from the end) into an absolute one, counted from 1. An index beyond
    /// what was read so far may still become valid, so it is checked at the end.
    fn resolve(&mut self, index: i64, line: usize) -> Option<usize> {
        let absolute = match index {
            0 => return None,
            1.. => usize::try_from(index).ok()?,
            _ => usize::try_from(index + i64::try_from(self.count).ok()? + 1).ok().filter(|&i| i > 0)?,
        };
        if absolute > self.greatest {
            (self.greatest, self.line) = (absolute, line);
        }
        Some(absolute)
    }
}

struct Cleaner<'a> {
    path: &'a Path,
    tally: &'a mut Tally,
    out: Cleaned,
    current: Section,
    /// `current` was not written since it changed.
    fresh: bool,
    positions: Counter,
    coordinates: Counter,
    normals: Counter,
    face_count: usize,
}

impl Cleaner<'_> {
    fn error<T>(&self, line: usize, what: impl ToString, remedy: &str) -> Result<T> {
        Err(Error::line(self.path, line, what, remedy))
    }

    fn statement(&mut self, &Statement { line, keyword, rest }: &Statement<'_>) -> Result<()> {
        match keyword {
            "v" => self.position(line, rest),
            "vt" => self.coordinates(line, rest),
            "vn" => self.normal(line, rest),
            // `fo` is a face in files from before 1992.
            "f" | "fo" => self.face(line, rest),
            "o" | "g" => {
                let part = if rest.is_empty() { "unnamed" } else { rest };
                self.switch(|section| section.part = part.into());
                Ok(())
            }
            "usemtl" if rest.is_empty() => {
                self.tally.at(line, "`usemtl` without a name (default material used)");
                self.switch(|section| section.material = None);
                Ok(())
            }
            "usemtl" => {
                self.switch(|section| section.material = Some((rest.into(), line)));
                Ok(())
            }
            "mtllib" => {
                self.out.libraries.push((rest.into(), line));
                Ok(())
            }
            // What smoothing groups ask for is given by normals.
            "s" => Ok(()),
            "p" | "l" => {
                self.tally.at(line, "points and lines dropped");
                Ok(())
            }
            _ => {
                let keyword: String = keyword.chars().take(20).collect();
                self.tally.at(line, &format!("unsupported statement `{}` ignored", keyword.escape_debug()));
                Ok(())
            }
        }
    }

    fn switch(&mut self, change: impl FnOnce(&mut Section)) {
        change(&mut self.current);
        self.fresh = true;
    }

    /// A finite number, as it fits into f32.
    fn number(&self, line: usize, word: &str) -> Result<f32> {
        match word.parse::<f32>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => self.error(line, format!("`{word}` is not a finite 32-bit number"), "remove the vertex"),
            Err(_) => self.error(line, format!("`{word}` is not a number"), "correct the line"),
        }
    }

    /// A number that may be a coordinate.
    fn coordinate(&self, line: usize, word: &str) -> Result<f32> {
        let value = self.number(line, word)?;
        if value.abs() > MAX_COORDINATE {
            let what = format!("`{word}` is beyond the range of coordinates, {MAX_COORDINATE:e}");
            return self.error(line, what, "scale the mesh down");
        }
        Ok(value)
    }

    fn position(&mut self, line: usize, rest: &str) -> Result<()> {
        let words: Vec<&str> = rest.split_whitespace().collect();
        let &[x, y, z, ref more @ ..] = &words[..] else {
            return self.error(line, "a vertex needs three coordinates", "complete the line");
        };
        let position = [self.coordinate(line, x)?, self.coordinate(line, y)?, self.coordinate(line, z)?];
        let w = match more {
            &[w] => self.number(line, w)?,
            [] => 1.0,
            _ => {
                self.tally.at(line, "vertex colours ignored");
                1.0
            }
        };
        let out = &mut self.out.vertices;
        if w == 1.0 {
            // Vec as a writer never fails.
            let _ = writeln!(out, "v {x} {y} {z}");
        } else {
            let [x, y, z] = position.map(|c| (f64::from(c) / f64::from(w)) as f32);
            if ![x, y, z].iter().all(|c| c.abs() <= MAX_COORDINATE) {
                let what = format!("dividing by the weight {w} gives no usable position");
                return self.error(line, what, "correct the fourth number");
            }
            let _ = writeln!(out, "v {x} {y} {z}");
        }
        self.positions.count += 1;
        Ok(())
    }

    /// The first `N` of the numbers in `rest`, finite or not; where there are fewer than `needed`, `complaint`.
    fn numbers<const N: usize>(
        &self,
        line: usize,
        rest: &str,
        needed: usize,
        complaint: &str,
    ) -> Result<[f32; N]> {
        let mut numbers = [0.0; N];
        let mut words = rest.split_whitespace();
        for (i, number) in numbers.iter_mut().enumerate() {
            match words.next().map(|word| (word, word.parse())) {
                Some((_, Ok(value))) => *number = value,
                Some((word, Err(_))) => {
                    return self.error(line, format!("`{word}` is not a number"), "correct the line");
                }
                None if i < needed => return self.error(line, complaint, "complete the line"),
                None => {}
            }
        }
        Ok(numbers)
    }

    fn coordinates(&mut self, line: usize, rest: &str) -> Result<()> {
        let mut uv: [f32; 2] = self.numbers(line, rest, 1, "a texture coordinate needs a number")?;
        if uv.iter().any(|c| !c.is_finite()) {
            self.tally.at(line, "texture coordinates that are not finite (0 used)");
            uv = [0.0; 2];
        }
        let _ = writeln!(self.out.vertices, "vt {} {}", uv[0], uv[1]);
        self.coordinates.count += 1;
        Ok(())
    }

    fn normal(&mut self, line: usize, rest: &str) -> Result<()> {
        let mut xyz: [f32; 3] = self.numbers(line, rest, 3, "a normal needs three components")?;
        if xyz.iter().any(|c| !c.is_finite()) {
            self.tally.at(line, "normals that are not finite (flat shading there)");
            xyz = [0.0; 3];
        }
        let _ = writeln!(self.out.vertices, "vn {} {} {}", xyz[0], xyz[1], xyz[2]);
        self.normals.count += 1;
        Ok(())
    }

    fn face(&mut self, line: usize, rest: &str) -> Result<()> {
        let corners = rest.split_whitespace().count();
        if corners < 3 {
            self.tally.at(line, "faces with fewer than three corners dropped");
            return Ok(());
        }
        if self.fresh {
            self.fresh = false;
            if self.out.sections.last() != Some(&self.current) {
                let _ = writeln!(self.out.faces, "o {}", self.out.sections.len());
                self.out.sections.push(self.current.clone());
            }
        }
        self.out.faces.push(b'f');
        for corner in rest.split_whitespace() {
            let [position, coordinates, normal] = self.corner(line, corner)?;
            let _ = write!(self.out.faces, " {position}/{coordinates}/{normal}");
        }
        self.out.faces.push(b'\n');
        self.face_count += 1;
        Ok(())
    }

    /// Absolute indices, from 1, of a corner `p`, `p/t`, `p//n` or `p/t/n`; 1 is "none" but for the position.
    fn corner(&mut self, line: usize, corner: &str) -> Result<[usize; 3]> {
        let mut fields = corner.split('/');
        let mut index = |required: bool| match fields.next() {
            None | Some("") if !required => Ok(None),
            field => field.unwrap_or_default().parse::<i64>().map(Some),
        };
        let parsed = (index(true), index(false), index(false), fields.next());
        let (Ok(Some(position)), Ok(coordinates), Ok(normal), None) = parsed else {
            return self.error(
                line,
                format!("`{corner}` is not a face corner"),
                "write it as `v`, `v/vt`, `v//vn` or `v/vt/vn`",
            );
        };
        self.out.textured |= coordinates.is_some();
        let resolve = |counter: &mut Counter, index: i64, of: &str| {
            let count = counter.count;
            counter.resolve(index, line).ok_or_else(|| {
                let what = format!("{of} index {index} is out of range, there are {count} so far");
                Error::line(self.path, line, what, "indices count from 1, or from -1 backwards")
            })
        };
        let position = resolve(&mut self.positions, position, "vertex")?;
        let coordinates = match coordinates {
            None => 1,
            Some(index) => 1 + resolve(&mut self.coordinates, index, "texture coordinate")?,
        };
        let normal = match normal {
            None => 1,
            Some(index) => 1 + resolve(&mut self.normals, index, "normal")?,
        };
        Ok([position, coordinates, normal])
    }

    fn finish(mut self) -> Result<Cleaned> {
        for (counter, of) in [
            (&self.positions, "vertex"),
            (&self.coordinates, "texture coordinate"),
            (&self.normals, "normal"),
        ] {
            if counter.greatest > counter.count {
                let what = format!(
                    "{of} index {} is out of range, the file has {}",
                    counter.greatest, counter.count
                );
                return self.error(counter.line, what, "correct the index or complete the file");
            }
        }
        if self.positions.count == 0 && self.face_count == 0 {
            return Err(Error::file(
                self.path,
                "holds no mesh",
                "give an OBJ file with `v` and `f` statements",
            ));
        }
        if self.face_count == 0 {
            let what = "holds vertices but no face";
            return Err(Error::file(self.path, what, "export it with polygons"));
        }
        self.out.vertices.shrink_to_fit();
        Ok(self.out)
    }
}
