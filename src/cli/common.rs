//! What the commands that study several scenes have in common.

use crate::{
    error::{Error, Result},
    output::PendingFile,
    scene::{Scene, load},
};
use std::io::Write;
use std::path::Path;

/// The scenes that were named, each once, or else those of `unless_named`.
pub(super) fn specs<'a>(named: &'a [String], unless_named: &[&'a str]) -> Vec<&'a str> {
    match named {
        [] => unless_named.to_vec(),
        named => once_each(named.iter().map(String::as_str)),
    }
}

/// Loads scene after scene, tells what is odd about it, and visits it with the name it was asked for by and what to tell
/// people while it is worked on.
///
/// # Errors
/// What a scene or `visit` returns.
pub(super) fn each_scene(
    specs: &[&str],
    mut visit: impl FnMut(&str, &Scene, &str) -> Result<()>,
) -> Result<()> {
    for (index, spec) in specs.iter().enumerate() {
        let scene = load(spec)?;
        scene.warnings.iter().for_each(|warning| log::warn!("{warning}"));
        if scene.lights.is_empty() {
            log::warn!("{} has no light, so that there are no shadow rays", scene.name);
        }
        let place = format!("scene {} of {}, {}", index + 1, specs.len(), scene.name);
        visit(spec, &scene, &place)?;
    }
    Ok(())
}

/// What is named twice is studied once.
pub(super) fn once_each<T: PartialEq>(list: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut once = Vec::new();
    for item in list {
        if !once.contains(&item) {
            once.push(item);
        }
    }
    once
}

/// Makes a folder for pictures, unless it is there.
///
/// # Errors
/// [`Error::File`] if the system refuses.
pub(super) fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::file(folder, format!("cannot be made ({error})"), "name another folder"))
}

/// Writes a whole file.
///
/// # Errors
/// As [`PendingFile::create`] and [`PendingFile::complete`].
pub(super) fn write_text(path: &Path, text: &str) -> Result<()> {
    PendingFile::create(path)?.complete(|out| out.write_all(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_those_named_each_once_or_else_the_usual_ones() {
        let named = ["b", "a", "b"].map(String::from);
        assert_eq!(specs(&named, &["c"]), ["b", "a"]);
        assert_eq!(specs(&[], &["c", "d"]), ["c", "d"]);
    }
}
