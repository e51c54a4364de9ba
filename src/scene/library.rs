//! Where scenes and meshes are looked for.

use std::{
    collections::HashSet,
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
};

/// Environment variable that lists folders of scenes and meshes, separated by ':'.
pub const SCENES_VARIABLE: &str = "IRT_SCENES";

/// How deep below a folder scene descriptions are looked for.
const MAX_DEPTH: usize = 4;

/// The folders in which described scenes and meshes are looked for.
#[derive(Clone, Debug, Default)]
pub struct Library {
    /// Folders whose `*.toml`, at any depth up to four, are scenes known by name.
    pub scenes: Vec<PathBuf>,
    /// Folders in which meshes are looked for, after the folder of the scene that names them.
    pub meshes: Vec<PathBuf>,
}

/// A scene description that can be loaded by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Described {
    /// Path below its library folder, without extension: what a user types.
    pub name: String,
    /// The TOML file.
    pub path: PathBuf,
    /// The meshes it needs.
    pub meshes: Vec<MeshPlace>,
    /// Why the description cannot be used, if so.
    pub problem: Option<String>,
}

/// A mesh that a description names, and where it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshPlace {
    /// As the description names it.
    pub file: String,
    /// The file, if there is one.
    pub found: Option<PathBuf>,
    /// The folders looked in, in order.
    pub searched: Vec<PathBuf>,
}

impl Library {
    /// `./scenes` and the folders of `IRT_SCENES`.
    pub fn from_env() -> Library {
        let variable = std::env::var_os(SCENES_VARIABLE).unwrap_or_default();
        let meshes: Vec<PathBuf> =
            std::env::split_paths(&variable).filter(|folder| !folder.as_os_str().is_empty()).collect();
        let mut scenes = vec![PathBuf::from("scenes")];
        scenes.extend(meshes.iter().cloned());
        Library { scenes, meshes }
    }

    /// Looks for a mesh beside the scene that names it (in `folder`), then in each library folder.
    pub fn locate(&self, folder: &Path, file: &str) -> MeshPlace {
        let mut searched =
            vec![if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.into() }];
        searched.extend(self.meshes.iter().cloned());
        let found = searched.iter().map(|folder| folder.join(file)).find(|path| path.is_file());
        MeshPlace { file: file.into(), found, searched }
    }

    /// All `*.toml` below the scene folders as (name, path), sorted by folder and name; each file once.
    pub(super) fn descriptions(&self) -> Vec<(String, PathBuf)> {
        let mut all = Vec::new();
        let mut seen = HashSet::new();
        for root in &self.scenes {
            let mut files = Vec::new();
            collect(root, 0, &mut files);
            files.sort();
            for path in files {
                if seen.insert(fs::canonicalize(&path).unwrap_or_else(|_| path.clone())) {
                    let name = path.strip_prefix(root).unwrap_or(&path).with_extension("");
                    all.push((name.to_string_lossy().into_owned(), path));
                }
            }
        }
        all
    }
}

impl MeshPlace {
    /// The file, or that the `kind` of it is absent, and what to do about that.
    pub(super) fn require(self, kind: &str, remedy: &str) -> Result<PathBuf, (String, String)> {
        let MeshPlace { file, found, searched } = self;
        found.ok_or_else(|| {
            let folders: Vec<String> = searched.iter().map(|folder| folder.display().to_string()).collect();
            let file = file.escape_debug();
            (format!("{kind} `{file}` was not found in {}", folders.join(", ")), remedy.into())
        })
    }
}

/// Adds the TOML files below `folder`. A folder that cannot be read holds none; links to folders are not followed.
fn collect(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        match entry.file_type() {
            Ok(kind) if kind.is_dir() && depth < MAX_DEPTH => collect(&path, depth + 1, files),
            Ok(kind) if !kind.is_dir() && has_extension(&path, "toml") => files.push(path),
            _ => {}
        }
    }
}

/// True if the path ends in `.extension`, in any case.
pub(super) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().and_then(OsStr::to_str).is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
