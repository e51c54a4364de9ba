//! `irt scenes`.

use super::{args::ScenesArgs, export::TableExports, terminal};
use crate::{
    error::Result,
    report::{Cell, Table},
    scene::{Described, described, procedural},
};

/// Lists the built-in scenes, then the described ones with where their meshes are or were looked for.
///
/// # Errors
/// Only what keeps an export from being written: a scene that cannot be used is listed with the reason.
pub(super) fn run(args: &ScenesArgs) -> Result<()> {
    let exports = TableExports::open(&args.export)?;
    let mut table = Table::new(["scene", "kind", "usable", "about"]);
    for &name in procedural::NAMES {
        table.push([name.into(), "built-in".into(), true.into(), procedural::summary(name).into()]);
    }
    let described = described();
    for scene in &described {
        table.push(row(scene));
    }
    exports.write(&table)?;
    if described.iter().any(|scene| scene.meshes.iter().any(|mesh| mesh.found.is_none())) {
        terminal::note("Set IRT_SCENES to the folders of the missing meshes, separated by ':'.\n");
    }
    Ok(())
}

fn row(scene: &Described) -> [Cell; 4] {
    let usable = scene.problem.is_none() && scene.meshes.iter().all(|mesh| mesh.found.is_some());
    let about = match &scene.problem {
        Some(problem) => problem.clone(),
        None => scene.meshes.iter().map(place).collect::<Vec<_>>().join("\n"),
    };
    [scene.name.as_str().into(), "described".into(), usable.into(), about.into()]
}

fn place(mesh: &crate::scene::MeshPlace) -> String {
    match &mesh.found {
        Some(path) => path.display().to_string(),
        None => {
            let folders: Vec<_> = mesh.searched.iter().map(|folder| folder.display().to_string()).collect();
            format!("{} is not in {}", mesh.file, folders.join(", "))
        }
    }
}
