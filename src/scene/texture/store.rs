//! The textures of one scene while it is read: each picture is decoded once for a role and mapping.

use super::{Mapping, Role, Texture};
use crate::scene::picture::{self, Fault};
use std::path::{Path, PathBuf};

/// Textures read so far, in order; an index into them is what materials keep.
#[derive(Default)]
pub(in crate::scene) struct Textures {
    /// The textures.
    pub(in crate::scene) all: Vec<Texture>,
    /// Where each came from and what it is for.
    keys: Vec<(PathBuf, Role, Mapping)>,
}

impl Textures {
    /// The index of a picture file as a texture.
    pub(in crate::scene) fn read(&mut self, path: &Path, role: Role, mapping: Mapping) -> Result<u32, Fault> {
        let key = (path.to_path_buf(), role, mapping);
        let index = match self.keys.iter().position(|known| *known == key) {
            Some(index) => index,
            None => {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                self.all.push(Texture::of_picture(name, &picture::read(path)?, role, mapping));
                self.keys.push(key);
                self.all.len() - 1
            }
        };
        Ok(index as u32)
    }
}
