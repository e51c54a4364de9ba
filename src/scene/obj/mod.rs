//! Wavefront OBJ and MTL, through tobj. This is the only module that names tobj.
//!
//! ```text
//!   OBJ --clean: checked, normalised--> tobj --> polygons --triangulate--> Model
//!   MTL --mtl: checked, normalised----> tobj --> materials -----------------^
//!     `--maps: texture statements--> picture files --> textures ------------'
//! ```
//!
//! A file that cannot mean anything is an error that names the line. What can be repaired, dropped or ignored without
//! guessing is counted in the warnings. Vertices stay exactly what the file says, rounded once to f32.

mod bump;
mod clean;
mod lines;
mod maps;
mod mtl;
mod polygon;

use super::{
    Bump, BumpKind, Material, Part, Shape, TriangleMesh, area,
    tally::{DEGENERATE, Tally},
    text::read_lossy,
    texture::Textures,
};
use crate::error::{Error, Result};
use clean::{Cleaned, Section, clean};
use glam::{Vec2, Vec3};
use maps::{MapStatement, Slot};
use std::{
    collections::{HashMap, HashSet},
    hash::{DefaultHasher, Hash, Hasher},
    io::Read,
    path::{Path, PathBuf},
};

/// What one OBJ file holds, in its own coordinates.
pub(super) struct Model {
    /// All triangles, also those of zero area.
    pub(super) mesh: TriangleMesh,
    /// Materials of its MTL files, and the default one where a face has none.
    pub(super) materials: Vec<Material>,
    /// Counted warnings.
    pub(super) warnings: Vec<String>,
    /// Tells how its faces are joined: equal for files whose faces have the same corners in the same order.
    pub(super) joints: u64,
}

impl Model {
    /// Drops the triangles of exactly zero area, in `others`, too, which are the same vertices at other times, and counts
    /// them in the warnings. Comes last, because moving the vertices rounds them.
    pub(super) fn drop_degenerate(&mut self, path: &Path, others: &[Shape]) {
        let mut tally = Tally::new(path.display());
        tally.add(area::drop_degenerate(&mut self.mesh, others), DEGENERATE);
        self.warnings.extend(tally.sentences());
    }
}

/// Reads an OBJ file and the MTL files it names.
///
/// # Errors
/// [`Error::Line`] for a line that cannot be understood or names a texture that cannot be used, [`Error::File`] for a
/// file that cannot be read or holds no face.
pub(super) fn read(path: &Path, textures: &mut Textures) -> Result<Model> {
    let text = read_lossy(path)?;
    let mut tally = Tally::new(path.display());
    let cleaned = clean(path, &text, &mut tally)?;
    drop(text);
    let mut warnings = Vec::new();
    let mut materials = Materials::default();
    for library in libraries(path, &cleaned, &mut tally) {
        materials.read(&library, textures, &mut warnings)?;
    }
    let assigned = materials.assign(&cleaned.sections, &mut tally);
    let (mesh, joints) = assemble(path, cleaned, &assigned, &mut tally)?;
    bump::settle(&mesh, &mut materials.all, &textures.all);
    warnings.splice(0..0, tally.sentences());
    Ok(Model { mesh, materials: materials.all, warnings, joints })
}

/// Reads the vertices of an OBJ file whose faces are those of `model`, at another time: nothing is read of materials.
///
/// # Errors
/// As [`read`]; [`Error::File`] if the faces are others.
pub(super) fn read_shape(path: &Path, model: &Model, warnings: &mut Vec<String>) -> Result<Shape> {
    let mut tally = Tally::new(path.display());
    let cleaned = clean(path, &read_lossy(path)?, &mut tally)?;
    let assigned = vec![0; cleaned.sections.len()];
    let (mesh, joints) = assemble(path, cleaned, &assigned, &mut tally)?;
    let TriangleMesh { positions, normals, .. } = mesh;
    let other = |what: String| {
        let remedy = "export all frames with the same vertices and faces in the same order";
        Err(Error::file(path, format!("does not fit the first frame: {what}"), remedy))
    };
    let [own, first] = [positions.len(), model.mesh.positions.len()];
    if own != first {
        return other(format!("its faces use {own} different vertices instead of {first}"));
    }
    if joints != model.joints {
        return other("its faces have other corners, or there are more or fewer of them".into());
    }
    if normals.is_empty() != model.mesh.normals.is_empty() {
        return other("only one of them has normals".into());
    }
    warnings.extend(tally.sentences());
    Ok(Shape { positions, normals })
}

/// The MTL files that exist, each once. `mtllib` may name several, and a name may hold spaces.
fn libraries(path: &Path, cleaned: &Cleaned, tally: &mut Tally) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let find = |name: &str| find(folder, name);
    let mut found = Vec::new();
    for (names, line) in &cleaned.libraries {
        if let Some(file) = find(names) {
            found.push(file);
            continue;
        }
        if names.is_empty() {
            tally.at(*line, "`mtllib` without a name");
        }
        for name in names.split_whitespace() {
            match find(name) {
                Some(file) => found.push(file),
                None => tally.at(*line, &format!("material file `{}` not found", name.escape_debug())),
            }
        }
    }
    let mut seen = HashSet::new();
    found.retain(|file| seen.insert(file.clone()));
    found
}

/// A file that another one in `folder` names.
fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = PathBuf::from(name.trim_matches('"').replace('\\', "/"));
    // Absolute paths from another machine: the file is usually beside the one that names it.
    let beside = folder.join(name.file_name().unwrap_or_default());
    [folder.join(&name), beside].into_iter().find(|candidate| candidate.is_file())
}

/// Reads the textures of a material of the MTL file `path`.
fn read_maps(
    path: &Path,
    material: &mut Material,
    maps: &[MapStatement],
    textures: &mut Textures,
) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    for map in maps {
        let name = map.file.escape_debug();
        let file = find(folder, &map.file).ok_or_else(|| {
            let what = format!("texture `{name}` was not found in {}", folder.join("").display());
            Error::line(path, map.line, what, "put it there or remove the statement")
        })?;
        let texture = textures.read(&file, map.slot.role(), map.mapping).map_err(|fault| {
            Error::line(path, map.line, format!("texture `{name}` {}", fault.what), fault.remedy)
        })?;
        let bump = |kind| Some(Bump { texture, kind, strength: map.multiplier });
        match map.slot {
            Slot::Diffuse => material.map_kd = Some(texture),
            Slot::Opacity => material.map_d = Some(texture),
            Slot::Emission => material.map_ke = Some(texture),
            // Normals say more than heights.
            Slot::Height if material.bump.is_none() => material.bump = bump(BumpKind::Height),
            Slot::Height => {}
            Slot::Normal => material.bump = bump(BumpKind::Normal),
        }
    }
    Ok(())
}

#[derive(Default)]
struct Materials {
    all: Vec<Material>,
    by_name: HashMap<String, u32>,
}

impl Materials {
    /// Adds the materials of an MTL file; where a name is defined again, the first definition counts.
    fn read(&mut self, path: &Path, textures: &mut Textures, warnings: &mut Vec<String>) -> Result<()> {
        let mut tally = Tally::new(path.display());
        for mtl::Unread { mut material, maps } in mtl::read(path, &read_lossy(path)?, &mut tally)? {
            if self.by_name.contains_key(&material.name) {
                let name = material.name.escape_debug();
                tally.add(1, &format!("further definitions of material `{name}` ignored"));
            } else {
                read_maps(path, &mut material, &maps, textures)?;
                self.add(material);
            }
        }
        warnings.extend(tally.sentences());
        Ok(())
    }

    fn add(&mut self, material: Material) -> u32 {
        let index = self.all.len() as u32;
        self.by_name.insert(material.name.clone(), index);
        self.all.push(material);
        index
    }

    /// Material index of each section; the default material is added where one is needed.
    fn assign(&mut self, sections: &[Section], tally: &mut Tally) -> Vec<u32> {
        let mut default = None;
        let mut use_default = |all: &mut Vec<Material>| {
            *default.get_or_insert_with(|| {
                all.push(Material::default());
                all.len() as u32 - 1
            })
        };
        let mut assigned = Vec::with_capacity(sections.len());
        for section in sections {
            let index = match &section.material {
                None => use_default(&mut self.all),
                Some((name, line)) => self.by_name.get(name).copied().unwrap_or_else(|| {
                    let what = format!("material `{}` not defined (default used)", name.escape_debug());
                    tally.at(*line, &what);
                    use_default(&mut self.all)
                }),
            };
            assigned.push(index);
        }
        assigned
    }
}

/// Lets tobj read the cleaned file and makes one mesh of the models it gives, one per section. Also gives
/// [`Model::joints`].
fn assemble(
    path: &Path,
    cleaned: Cleaned,
    materials: &[u32],
    tally: &mut Tally,
) -> Result<(TriangleMesh, u64)> {
    let Cleaned { vertices, faces, sections, textured, .. } = cleaned;
    let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
    let no_materials = |_: &Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut vertices.chain(&faces[..]), &options, no_materials)
        .map_err(|e| Error::file(path, format!("cannot be read ({e})"), "report this file to us"))?;
    let fallback = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut mesh = TriangleMesh::default();
    let (mut smooth, mut joints) = (false, DefaultHasher::new());
    for model in models {
        (&model.mesh.indices, &model.mesh.face_arities).hash(&mut joints);
        // The names are indices that `clean` wrote.
        let Some((section, &material)) = model
            .name
            .parse::<usize>()
            .ok()
            .and_then(|index| Some((sections.get(index)?, materials.get(index)?)))
        else {
            continue;
        };
        let name = if section.part.is_empty() { &*fallback } else { &section.part };
        smooth |= append(&mut mesh, &model.mesh, name, material, tally);
        if u32::try_from(mesh.positions.len().max(mesh.len())).is_err() {
            let what = "has more triangles or vertices than 32-bit indices can count";
            return Err(Error::file(path, what, "split the file"));
        }
    }
    if !smooth {
        mesh.normals.clear();
    }
    if !textured {
        mesh.uvs.clear();
    }
    Ok((mesh, joints.finish()))
}

/// Adds a model under the part `name`. True if any vertex has a normal.
fn append(mesh: &mut TriangleMesh, from: &tobj::Mesh, name: &str, material: u32, tally: &mut Tally) -> bool {
    let first = mesh.positions.len() as u32;
    let first_triangle = mesh.len() as u32;
    mesh.positions.extend(from.positions.chunks_exact(3).map(Vec3::from_slice));
    mesh.uvs.extend(from.texcoords.chunks_exact(2).map(Vec2::from_slice));
    // In f64, so that no finite normal is too long or too short to be normalised.
    mesh.normals.extend(
        from.normals.chunks_exact(3).map(|n| Vec3::from_slice(n).as_dvec3().normalize_or_zero().as_vec3()),
    );
    let smooth = mesh.normals[first as usize..].iter().any(|&n| n != Vec3::ZERO);
    let mut improper = 0;
    let mut rest = &from.indices[..];
    // No arities means that all faces are triangles.
    let mut arities = from.face_arities.iter();
    while !rest.is_empty() {
        let corners = arities.next().map_or(3, |&corners| corners as usize);
        let Some((face, others)) = rest.split_at_checked(corners) else { break };
        rest = others;
        match face {
            &[a, b, c] => mesh.triangles.push([first + a, first + b, first + c]),
            _ => improper += usize::from(!append_polygon(mesh, first, face)),
        }
    }
    tally.add(improper, "polygons that cross themselves or have no area cut into a fan");
    mesh.materials.resize(mesh.triangles.len(), material);
    let count = mesh.len() as u32 - first_triangle;
    match mesh.parts.last_mut() {
        Some(part) if part.name == name => part.count += count,
        _ => mesh.parts.push(Part { name: name.into(), first: first_triangle, count }),
    }
    smooth
}

fn append_polygon(mesh: &mut TriangleMesh, first: u32, face: &[u32]) -> bool {
    let corners: Vec<Vec3> = face.iter().map(|&v| mesh.positions[(first + v) as usize]).collect();
    polygon::triangulate(&corners, |triangle| {
        mesh.triangles.push(triangle.map(|i| first + face[i]));
    })
}
