//! Meshes that move: sequences of files, and keys between which a mesh is turned and moved as a whole.

use super::{MeshUse, place::rotation, schema, source::Source};
use crate::{
    error::Result,
    scene::{
        DEFAULT_RATE, Key, Library, MAX_COORDINATE, Shape, Track,
        library::MeshPlace,
        numbered,
        obj::{self, Model},
        texture::Textures,
    },
};
use glam::{DMat3, DVec3};
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Most files of a sequence.
const MOST_FRAMES: i64 = 100_000;
/// Most files of a sequence per second.
const MOST_RATE: f32 = 1000.0;

/// How a mesh moves, if it does.
#[derive(Debug, PartialEq)]
pub(super) struct Moving {
    /// First and last number of the files.
    frames: Option<[u64; 2]>,
    rate: f64,
    keys: Vec<Key>,
}

pub(super) fn moving(source: &Source<'_>, mesh: &schema::Mesh) -> Result<Moving> {
    let frames = mesh.frames.as_ref().map(|frames| numbers(source, &mesh.file, frames)).transpose()?;
    if let Some(fps) = &mesh.fps {
        source.check("fps", fps, frames.is_some(), "belongs to a sequence of `frames`")?;
        source.within(
            "fps",
            fps,
            |fps| fps > 0.0 && fps <= MOST_RATE,
            "must be positive and at most 1000",
        )?;
    }
    let rate = mesh.fps.as_ref().map_or(DEFAULT_RATE, |fps| *fps.get_ref());
    let keys: Vec<Key> = mesh.key.iter().map(|value| key(source, value)).collect::<Result<_>>()?;
    if let [only] = &mesh.key[..] {
        return Err(source.error(only.span(), "one key moves nothing", "give another `[[mesh.key]]`"));
    }
    for (pair, value) in keys.windows(2).zip(mesh.key.iter().skip(1)) {
        let time = &value.get_ref().time;
        source.check(
            "time",
            time,
            pair[0].time < pair[1].time,
            "must be later than that of the key before",
        )?;
    }
    Ok(Moving { frames, rate, keys })
}

fn numbers(source: &Source<'_>, file: &Spanned<String>, frames: &Spanned<[i64; 2]>) -> Result<[u64; 2]> {
    let [first, last] = *frames.get_ref();
    let ordered = 0 <= first && first < last && last - first < MOST_FRAMES;
    source.check(
        "frames",
        frames,
        ordered,
        "must be two numbers, the first not negative and the last greater",
    )?;
    if numbered(file.get_ref(), 0).is_none() {
        let what = "`file` must have one `%d`, or `%04d` for four digits, in place of the number of a frame";
        return Err(source.error(file.span(), what, "add it, or remove `frames`"));
    }
    Ok([first as u64, last as u64])
}

fn key(source: &Source<'_>, value: &Spanned<schema::Key>) -> Result<Key> {
    let schema::Key { time, rotate, translate } = value.get_ref();
    source.within("time", time, |time| time >= 0.0, "must not be negative")?;
    let (mut turned, mut translation) = (DMat3::IDENTITY, DVec3::ZERO);
    if let Some(rotate) = rotate {
        source.vector("rotate", rotate)?;
        turned = rotation(*rotate.get_ref());
    }
    if let Some(translate) = translate {
        source.vector("translate", translate)?;
        translation = DVec3::from_array(*translate.get_ref());
    }
    Ok(Key { time: *time.get_ref(), rotation: turned, translation })
}

impl MeshUse {
    /// Where each of its files was looked for, in the order of time.
    pub(super) fn places(&self, library: &Library, folder: &Path) -> Vec<MeshPlace> {
        let file = self.file.get_ref();
        match self.moving.frames {
            None => vec![library.locate(folder, file)],
            Some([first, last]) => (first..=last)
                .map(|number| library.locate(folder, &numbered(file, number).unwrap_or_default()))
                .collect(),
        }
    }

    /// Reads it and puts it in its place: as it is at first, and the shapes that follow.
    pub(super) fn read(
        &self,
        source: &Source<'_>,
        files: &[PathBuf],
        textures: &mut Textures,
        warnings: &mut Vec<String>,
    ) -> Result<(Model, Vec<Shape>)> {
        let too_far = || {
            let what = format!("it is moved beyond the range of coordinates, {MAX_COORDINATE:e}");
            source.error(self.file.span(), what, "use smaller ones")
        };
        let mut model = obj::read(&files[0], textures)?;
        let mut later = Vec::with_capacity(files.len() - 1);
        for file in &files[1..] {
            let mut shape = obj::read_shape(file, &model, warnings)?;
            if !self.placement.move_vertices(&mut shape.positions, &mut shape.normals) {
                return Err(too_far());
            }
            later.push(shape);
        }
        self.placement.apply_to_bumps(&mut model.materials);
        if !self.placement.apply(&mut model.mesh) {
            return Err(too_far());
        }
        model.drop_degenerate(&files[0], &later);
        Ok((model, later))
    }

    /// How its vertices, the first of which gets this number, move; `None` if they do not.
    pub(super) fn track(
        &self,
        source: &Source<'_>,
        model: &Model,
        later: Vec<Shape>,
        first: usize,
    ) -> Result<Option<Track>> {
        let Moving { rate, keys, .. } = &self.moving;
        if later.is_empty() && keys.is_empty() {
            return Ok(None);
        }
        let mesh = &model.mesh;
        let own = Shape { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
        let vertices = first..first + own.positions.len();
        let shapes = [own].into_iter().chain(later).collect();
        let track = Track { vertices, shapes, rate: *rate, keys: keys.clone() };
        if track.reach() > f64::from(MAX_COORDINATE) {
            let what = format!("its keys move it beyond the range of coordinates, {MAX_COORDINATE:e}");
            return Err(source.error(self.file.span(), what, "use smaller ones"));
        }
        Ok(Some(track))
    }
}
