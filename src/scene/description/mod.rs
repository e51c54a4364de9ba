//! Scene files in TOML: meshes, where they stand and how they move, materials, lights, camera. `scenes/README.md` lists all keys.

mod check;
mod light;
mod material;
mod moving;
mod place;
mod schema;
mod source;
mod surroundings;

use super::{
    CameraDescription, Motion, Part, RenderSettings, Scene, TriangleMesh,
    library::{Library, MeshPlace, SCENES_VARIABLE},
    load::finish,
    text::read_utf8,
    texture::Textures,
};
use crate::error::Result;
use glam::{Vec2, Vec3};
use light::AnyLight;
use material::{Change, Reader};
use moving::Moving;
use place::Placement;
use source::Source;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A scene file, checked, without the meshes and pictures it names.
pub(super) struct Description {
    path: PathBuf,
    text: String,
    name: Option<String>,
    size: [u32; 2],
    background: Vec3,
    ambient: Vec3,
    camera: Option<CameraDescription>,
    meshes: Vec<MeshUse>,
    changes: Vec<Change>,
    lights: Vec<AnyLight>,
    environment: surroundings::Unread,
    settings: RenderSettings,
}

/// A mesh file and what to do with it.
struct MeshUse {
    file: Spanned<String>,
    name: Option<String>,
    material: Option<Spanned<String>>,
    placement: Placement,
    moving: Moving,
}

/// Reads and checks a scene file.
///
/// # Errors
/// Names line and column of whatever is not understood or not usable.
pub(super) fn read(path: &Path) -> Result<Description> {
    let text = read_utf8(path)?;
    let source = Source { path, text: &text };
    let file = toml::from_str(&text).map_err(|e| source.syntax(&e))?;
    check::check(&source, file)
}

impl Description {
    /// Where the files of each mesh were looked for, in the order of time.
    fn all_places(&self, library: &Library) -> Vec<Vec<MeshPlace>> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.meshes.iter().map(|mesh| mesh.places(library, folder)).collect()
    }

    /// Where each mesh was looked for: of a sequence its first file, and the first that is missing.
    pub(super) fn places(&self, library: &Library) -> Vec<MeshPlace> {
        let telling = |places: Vec<MeshPlace>| {
            let missing = places.iter().position(|place| place.found.is_none());
            let tell = |&(number, _): &(usize, MeshPlace)| number == 0 || missing == Some(number);
            places.into_iter().enumerate().filter(tell).map(|(_, place)| place).collect::<Vec<_>>()
        };
        self.all_places(library).into_iter().flat_map(telling).collect()
    }

    /// Reads the meshes and pictures and puts everything together.
    pub(super) fn load(self, library: &Library) -> Result<Scene> {
        let source = Source { path: &self.path, text: &self.text };
        let (mut mesh, mut materials, mut warnings) = (TriangleMesh::default(), Vec::new(), Vec::new());
        let (mut files, mut textures) = (Vec::new(), Textures::default());
        // All of them, before the first is read: reading may take long.
        for (wanted, places) in self.meshes.iter().zip(self.all_places(library)) {
            let remedy =
                format!("scenes/README.md says where to get it; set {SCENES_VARIABLE} to its folder");
            let require = |place: MeshPlace| place.require("mesh", &remedy);
            let found = places.into_iter().map(require).collect::<std::result::Result<Vec<_>, _>>();
            files.push(found.map_err(|(what, remedy)| source.error(wanted.file.span(), what, remedy))?);
        }
        let (mut painted, mut tracks) = (Vec::new(), Vec::new());
        for (wanted, files) in self.meshes.iter().zip(&files) {
            let (mut model, later) = wanted.read(&source, files, &mut textures, &mut warnings)?;
            tracks.extend(wanted.track(&source, &model, later, mesh.positions.len())?);
            if let Some(material) = &wanted.material {
                painted.push((mesh.len()..mesh.len() + model.mesh.len(), material));
                model.materials.clear();
                model.mesh.materials.fill(0);
            }
            warnings.append(&mut model.warnings);
            append(&mut mesh, model.mesh, wanted.name.as_deref(), materials.len() as u32);
            materials.append(&mut model.materials);
        }
        let added = materials.len();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let mut reader = Reader { source: &source, library, folder, textures: &mut textures };
        for change in &self.changes {
            change.apply(&mut materials, &mut reader)?;
        }
        for (triangles, name) in painted {
            let index =
                materials.iter().position(|material| material.name == *name.get_ref()).ok_or_else(|| {
                    let what = format!("there is no material `{}`", name.get_ref().escape_debug());
                    source.error(name.span(), what, "define it in a `[[material]]`")
                })?;
            mesh.materials[triangles].fill(index as u32);
        }
        for (index, unused) in materials.iter().enumerate().skip(added) {
            if !mesh.materials.contains(&(index as u32)) {
                let name = unused.name.escape_debug();
                warnings.push(format!("{}: no mesh has or uses material `{name}`: 1", self.path.display()));
            }
        }
        let environment = self.environment.read(&source, library, folder, &mut warnings)?;
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let name = self.name.unwrap_or_else(|| stem.into_owned());
        let Description { size, background, ambient, camera, settings, .. } = self;
        let textures = textures.all;
        let mut scene = Scene {
            name,
            mesh,
            materials,
            textures,
            environment,
            settings,
            ambient,
            background,
            motion: (!tracks.is_empty()).then_some(Motion { tracks }),
            size,
            warnings,
            ..Scene::default()
        };
        for light in self.lights {
            match light {
                AnyLight::Point(light) => scene.lights.push(light),
                AnyLight::Area(light) => scene.area_lights.push(light),
            }
        }
        finish(&self.path, scene, camera)
    }
}

/// Adds a model's mesh, whose material indices count from `first_material`.
fn append(mesh: &mut TriangleMesh, model: TriangleMesh, name: Option<&str>, first_material: u32) {
    let (first_vertex, first_triangle) = (mesh.positions.len() as u32, mesh.len() as u32);
    // Normals are there for all vertices or for none, and so are texture coordinates.
    if !mesh.normals.is_empty() || !model.normals.is_empty() {
        mesh.normals.resize(mesh.positions.len(), Vec3::ZERO);
        mesh.normals.extend(model.normals);
        mesh.normals.resize(mesh.positions.len() + model.positions.len(), Vec3::ZERO);
    }
    if !mesh.uvs.is_empty() || !model.uvs.is_empty() {
        mesh.uvs.resize(mesh.positions.len(), Vec2::ZERO);
        mesh.uvs.extend(model.uvs);
        mesh.uvs.resize(mesh.positions.len() + model.positions.len(), Vec2::ZERO);
    }
    mesh.positions.extend(model.positions);
    mesh.triangles.extend(model.triangles.iter().map(|triangle| triangle.map(|v| first_vertex + v)));
    mesh.materials.extend(model.materials.iter().map(|material| first_material + material));
    mesh.parts.extend(model.parts.into_iter().map(|part| Part {
        name: name.map_or(part.name.clone(), |name| format!("{name}/{}", part.name)),
        first: first_triangle + part.first,
        count: part.count,
    }));
}
