//! Scenes made by this project: counterparts of the thesis' scenes in triangles and lights, and small ones that call for
//! the effects of light.
//!
//! Detail multiplies every subdivision, so that the number of triangles grows about with its square.

mod architecture;
mod atrium;
mod builder;
mod cornell;
mod furniture;
mod gallery;
mod garden;
mod hairball;
mod hall;
mod hash;
mod nave;
mod office;
#[cfg(test)]
mod office_tests;
mod paint;
mod shapes;
mod statue;

use super::Scene;
use crate::error::{Error, Result};

/// A scene that [`build`] can make.
struct Entry {
    name: &'static str,
    /// One line for lists.
    summary: &'static str,
    generator: fn(detail: f32) -> Scene,
}

/// Every scene, in the order in which they are listed.
const TABLE: &[Entry] = &[
    Entry {
        name: "atrium",
        summary: "two-storey arcaded court in the sun: 69 thousand triangles, 8 lights",
        generator: atrium::atrium,
    },
    Entry {
        name: "nave",
        summary: "rib-vaulted church with side aisles: 75 thousand triangles, 4 lights",
        generator: nave::nave,
    },
    Entry {
        name: "office",
        summary: "office for four, sun through the blinds: 37 thousand triangles, 8 lights",
        generator: office::office,
    },
    Entry {
        name: "hall",
        summary: "conference hall with 260 chairs before a stage: 331 thousand triangles, 6 lights",
        generator: hall::hall,
    },
    Entry {
        name: "statue",
        summary: "porcelain rabbit, one smooth closed mesh: 72 thousand triangles, 3 lights",
        generator: statue::statue,
    },
    Entry {
        name: "hairball",
        summary: "ball of thin curling tubes, the worst case of a tree: 1 million triangles, 1 light",
        generator: hairball::hairball,
    },
    Entry {
        name: "gallery",
        summary: "glass, mirrors, pictures, plants on a polished floor: 26 thousand triangles, 3 area lights",
        generator: gallery::gallery,
    },
    Entry {
        name: "cornell",
        summary: "the Cornell box, colours bleed from wall to wall: 46 triangles, 1 emitter",
        generator: cornell::cornell,
    },
];

/// Names of all scenes, as [`build`] takes them.
pub const NAMES: &[&str] = &{
    let mut names = [""; TABLE.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = TABLE[i].name;
        i += 1;
    }
    names
};

/// The scene that is rendered when none is asked for.
pub const DEFAULT: &str = "atrium";

/// Least detail that [`build`] accepts: arches are still recognised as such.
pub const MIN_DETAIL: f32 = 0.05;
/// Greatest detail that [`build`] accepts: the largest scene then has some 400 million triangles.
pub const MAX_DETAIL: f32 = 20.0;

/// Makes the scene called `name`. `detail` multiplies every subdivision: at 1 the scene has the number of triangles
/// that its [`summary`] tells, otherwise about `detail`^2 times as many.
///
/// # Errors
/// [`Error::Flag`] for a name that is not among [`NAMES`] or a detail outside [`MIN_DETAIL`] to [`MAX_DETAIL`].
pub fn build(name: &str, detail: f32) -> Result<Scene> {
    let Some(entry) = find(name) else {
        let remedy = format!("use one of: {}", NAMES.join(", "));
        return Err(Error::flag("SCENE", format!("there is no built-in scene '{name}'"), remedy));
    };
    if !(MIN_DETAIL..=MAX_DETAIL).contains(&detail) {
        let remedy = format!("use a number from {MIN_DETAIL} to {MAX_DETAIL}");
        return Err(Error::flag("SCENE", format!("scene '{name}' cannot have a detail of {detail}"), remedy));
    }
    Ok((entry.generator)(detail))
}

/// One line about the scene called `name`; empty if there is none.
pub fn summary(name: &str) -> &'static str {
    find(name).map_or("", |entry| entry.summary)
}

fn find(name: &str) -> Option<&'static Entry> {
    TABLE.iter().find(|entry| entry.name == name)
}

#[cfg(test)]
mod tests;
