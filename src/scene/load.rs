//! From what a user types to a scene.

use super::{
    CameraDescription, Scene, description, framing,
    library::{Described, Library, has_extension},
    obj, procedural,
    texture::Textures,
};
use crate::error::{Error, Result};
use glam::Vec3;
use std::path::{Path, PathBuf};

/// Loads `spec`: the path of a scene description (`.toml`) or mesh (`.obj`), the name of a built-in scene, as `NAME`
/// or `NAME@DETAIL`, or the name of a described scene (see [`described`]). A built-in name comes before a described
/// one.
///
/// # Errors
/// What is wrong with the file and where; for an unknown name, all names there are.
pub fn load(spec: &str) -> Result<Scene> {
    Library::from_env().load(spec)
}

/// The scene descriptions in `./scenes` and in the folders of `IRT_SCENES`.
pub fn described() -> Vec<Described> {
    Library::from_env().described()
}

impl Library {
    /// The function [`load`], with these folders.
    ///
    /// # Errors
    /// As [`load`].
    pub fn load(&self, spec: &str) -> Result<Scene> {
        if spec.is_empty() {
            return Err(Error::flag(
                "SCENE",
                "the name is empty",
                "give one that irt scenes lists, or a file",
            ));
        }
        let path = Path::new(spec);
        if has_extension(path, "toml") {
            return description::read(path)?.load(self);
        }
        if has_extension(path, "obj") {
            return bare(path);
        }
        if path.is_file() {
            let what = "is of no kind that can be read";
            return Err(Error::file(path, what, "give a scene (.toml) or a mesh (.obj)"));
        }
        let (name, detail) = match spec.rsplit_once('@') {
            Some((name, detail)) => (name, Some(detail)),
            None => (spec, None),
        };
        if procedural::NAMES.contains(&name) {
            return procedural::build(name, detail.map_or(Ok(1.0), |detail| parse_detail(spec, detail))?);
        }
        let descriptions = self.descriptions();
        match find(&descriptions, name)[..] {
            [] => Err(self.unknown(spec)),
            [(_, path)] if detail.is_none() => description::read(path)?.load(self),
            [(name, _)] => {
                let what = format!("is the scene {name}, which has no detail to choose");
                Err(Error::file(spec, what, "leave out the @"))
            }
            ref several => {
                let names: Vec<&str> = several.iter().map(|(name, _)| &**name).collect();
                Err(Error::file(
                    spec,
                    "is the name of several scenes",
                    format!("choose {}", names.join(" or ")),
                ))
            }
        }
    }

    /// The function [`described`], with these folders.
    pub fn described(&self) -> Vec<Described> {
        let describe = |(name, path): (String, PathBuf)| match description::read(&path) {
            Ok(description) => Described { name, meshes: description.places(self), problem: None, path },
            Err(e) => Described { name, meshes: Vec::new(), problem: Some(e.to_string()), path },
        };
        self.descriptions().into_iter().map(describe).collect()
    }

    fn unknown(&self, spec: &str) -> Error {
        let mut names: Vec<String> = procedural::NAMES.iter().map(ToString::to_string).collect();
        names.extend(self.descriptions().into_iter().map(|(name, _)| name));
        // In full, because the first of them is meant from where the user is.
        let full = |folder: &PathBuf| std::path::absolute(folder).unwrap_or_else(|_| folder.clone());
        let folders: Vec<String> =
            self.scenes.iter().map(|folder| full(folder).display().to_string()).collect();
        let what =
            format!("is neither a file nor a scene that is built in or described in {}", folders.join(", "));
        Error::file(spec, what, format!("give a .toml or .obj file or one of {}", names.join(", ")))
    }
}

/// The descriptions of that full name, or else those whose name ends so.
fn find<'a, P>(descriptions: &'a [(String, P)], name: &str) -> Vec<&'a (String, P)> {
    let full: Vec<_> = descriptions.iter().filter(|(known, _)| known == name).take(1).collect();
    if !full.is_empty() {
        return full;
    }
    let last = |known: &str| known.rsplit(['/', '\\']).next() == Some(name);
    descriptions.iter().filter(|(known, _)| last(known)).collect()
}

fn parse_detail(spec: &str, detail: &str) -> Result<f32> {
    detail.parse().ok().filter(|detail: &f32| detail.is_finite() && *detail > 0.0).ok_or_else(|| {
        let what = format!("the detail `{detail}` is not a positive number");
        Error::file(spec, what, "write NAME@2 for twice the subdivision")
    })
}

/// A mesh without a scene file: [`framing`] gives it a camera and lights.
fn bare(path: &Path) -> Result<Scene> {
    let mut textures = Textures::default();
    let mut model = obj::read(path, &mut textures)?;
    model.drop_degenerate(path, &[]);
    let obj::Model { mesh, materials, warnings, .. } = model;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let textures = textures.all;
    finish(path, Scene { name, mesh, materials, textures, warnings, ..Scene::default() }, None)
}

/// What all readers end with: where there is no camera, or no light at all, [`framing`] gives one.
pub(super) fn finish(path: &Path, mut scene: Scene, camera: Option<CameraDescription>) -> Result<Scene> {
    if scene.mesh.is_empty() {
        return Err(Error::file(path, "holds only triangles of zero area", "check its vertices and scale"));
    }
    scene.pose(0.0);
    let bounds = scene.mesh.bounds();
    if !is_lit(&scene) {
        scene.lights = framing::lights(&bounds);
    }
    scene.camera = camera.unwrap_or_else(|| framing::camera(&bounds));
    Ok(scene)
}

/// True if there is any source of light, bright or not.
fn is_lit(scene: &Scene) -> bool {
    let emits = |&material: &u32| scene.materials[material as usize].ke != Vec3::ZERO;
    !scene.lights.is_empty()
        || !scene.area_lights.is_empty()
        || scene.ambient != Vec3::ZERO
        || scene.environment.light
        || scene.settings.emitters && scene.mesh.materials.iter().any(emits)
}
