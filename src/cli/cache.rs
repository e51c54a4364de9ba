//! Prices that are remembered in the user's cache folder: one small JSON file for a scene, machine and version of irt.
//!
//! A file that cannot be read, belongs to something else or says what cannot be is as good as none.

use crate::{
    error::{Error, Result},
    film::Hash,
    kernels::Isa,
    output::PendingFile,
    render::RenderOptions,
    report::{from_json, to_json},
    scene::Scene,
    schedule::{Machine, Placement},
    study::accuracy::{Prices, Sampling, price_size},
};
use directories::ProjectDirs;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Changes whenever what is measured does.
const FORMAT: u32 = 1;

#[derive(Serialize, Deserialize)]
struct Entry {
    key: String,
    prices: Prices,
}

/// The folder for prices; `None` if the user has no home.
pub(super) fn folder() -> Option<PathBuf> {
    ProjectDirs::from("", "", "irt").map(|folders| folders.cache_dir().join("accuracy"))
}

/// What prices depend on: the scene but for its camera's place, the machine, the version, and how it is rendered.
pub(super) fn key(scene: &Scene, options: &RenderOptions) -> String {
    let RenderOptions { isa, kernel, visibility, threads, pin, order, schedule, tile, size, build, .. } =
        *options;
    let size = price_size(scene, size);
    let threads = Placement::new(Machine::get(), threads, pin).slots().len();
    let isa = isa.unwrap_or_else(Isa::detect);
    let how = format!(
        "{isa} {kernel} {visibility} {threads} {pin} {order} {schedule:?} {tile} {size:?} {build} {} {:?}",
        options.effects, options.early
    );
    let parts = [
        format!("irt {} {FORMAT}", env!("CARGO_PKG_VERSION")),
        processor(),
        format!("{} cores", Machine::get().cores()),
        how,
        scene_hash(scene),
    ];
    parts.join("; ")
}

/// The processor's name, where the system tells it.
fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.into(), |(_, name)| name.trim().into())
}

/// Of everything that can change an image of the scene, wherever its camera is.
fn scene_hash(scene: &Scene) -> String {
    let mut hasher = Hash::default();
    let Scene {
        mesh,
        materials,
        textures,
        lights,
        area_lights,
        environment,
        settings,
        ambient,
        background,
        ..
    } = scene;
    let mut vectors = |vectors: &[glam::Vec3]| {
        hasher.update(vectors.len().to_le_bytes());
        vectors.iter().flat_map(|v| v.to_array()).for_each(|x| hasher.update(x.to_le_bytes()));
    };
    vectors(&mesh.positions);
    vectors(&mesh.normals);
    mesh.uvs.iter().flat_map(|uv| uv.to_array()).for_each(|x| hasher.update(x.to_le_bytes()));
    mesh.triangles.iter().flatten().for_each(|index| hasher.update(index.to_le_bytes()));
    mesh.materials.iter().for_each(|index| hasher.update(index.to_le_bytes()));
    for texture in textures {
        hasher.update(format!("{} {:?} {}", texture.name, texture.size(), texture.bytes()));
    }
    let fov = scene.camera.fov_deg;
    hasher.update(format!(
        "{materials:?} {lights:?} {area_lights:?} {settings:?} {ambient} {background} {fov}"
    ));
    hasher.update(format!("{:?}", environment.light));
    hasher.hex()
}

/// The prices under `key` in a folder, if they are there.
pub(super) fn read(folder: &Path, key: &str) -> Option<Prices> {
    let text = fs::read_to_string(file(folder, key)).ok()?;
    let entry: Entry = from_json(&text)?;
    (entry.key == key && is_sane(&entry.prices)).then_some(entry.prices)
}

/// Remembers prices.
///
/// # Errors
/// [`Error::File`] or [`Error::Failed`] if the disk refuses.
pub(super) fn write(folder: &Path, key: &str, prices: &Prices) -> Result<()> {
    fs::create_dir_all(folder).map_err(|error| {
        Error::file(folder, format!("cannot be made ({error})"), "see to the cache folder")
    })?;
    let entry = Entry { key: key.into(), prices: prices.clone() };
    let text = to_json(&entry)?;
    PendingFile::create(&file(folder, key))?.complete(|out| out.write_all(text.as_bytes()))
}

fn file(folder: &Path, key: &str) -> PathBuf {
    let mut hash = Hash::default();
    hash.update(key);
    folder.join(format!("{}.json", &hash.hex()[..32]))
}

/// Whether numbers are such as can be measured.
fn is_sane(prices: &Prices) -> bool {
    let time = |value: f64| value.is_finite() && value > 0.0;
    let error = |value: f64| (0.0..=1.0).contains(&value);
    let Prices { size, frame, noise, builds, samplings, extras } = prices;
    let size = size.iter().all(|&side| side > 0);
    let builds = !builds.is_empty() && builds.iter().all(|(_, seconds)| time(*seconds));
    let sampling = |s: &Sampling| s.samples > 0 && s.light_samples > 0 && time(s.ratio) && error(s.error);
    let samplings = !samplings.is_empty() && samplings.iter().all(sampling);
    let extras = extras.iter().all(|extra| time(extra.ratio) && error(extra.change));
    size && time(*frame) && error(*noise) && builds && samplings && extras
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::accuracy::{Extra, options};
    use glam::Vec3;
    use tempfile::TempDir;

    fn prices() -> Prices {
        Prices {
            size: [64, 48],
            frame: 0.01,
            noise: 0.001,
            builds: vec![("fast".into(), 0.1)],
            samplings: vec![Sampling { samples: 1, light_samples: 16, ratio: 1.0, error: 0.05 }],
            extras: vec![Extra { mode: "visibility fast".into(), ratio: 0.9, change: 0.001 }],
        }
    }

    #[test]
    fn what_is_written_is_read_back_under_its_key_alone() {
        let folder = TempDir::new().unwrap();
        let at = folder.path().join("new/folders");
        assert_eq!(read(&at, "a"), None);
        write(&at, "a", &prices()).unwrap();
        assert_eq!((read(&at, "a"), read(&at, "b")), (Some(prices()), None));
        // Under a's name, but of b.
        write(&at, "b", &prices()).unwrap();
        fs::copy(file(&at, "b"), file(&at, "a")).unwrap();
        assert_eq!(read(&at, "a"), None);
    }

    #[test]
    fn garbage_is_as_good_as_nothing() {
        let folder = TempDir::new().unwrap();
        let path = file(folder.path(), "a");
        write(folder.path(), "a", &prices()).unwrap();
        let good = fs::read_to_string(&path).unwrap();
        for (old, new) in [
            ("0.01", "-0.01"),
            ("0.01", "1e999"),
            ("0.05", "null"),
            ("\"samples\": 1", "\"samples\": 0"),
            ("64", "-1"),
            ("{", ""),
            ("prices", "price"),
        ] {
            assert!(good.contains(old), "{old} in {good}");
            fs::write(&path, good.replace(old, new)).unwrap();
            assert_eq!(read(folder.path(), "a"), None, "{old} as {new}");
        }
        for bytes in [&b"\xff\xfe\x00"[..], b"", b"[]", &good.as_bytes()[..good.len() / 2]] {
            fs::write(&path, bytes).unwrap();
            assert_eq!(read(folder.path(), "a"), None);
        }
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        assert_eq!(read(folder.path(), "a"), None);
        assert!(write(folder.path(), "a", &prices()).is_err());
    }

    #[test]
    fn the_key_knows_the_scene_and_how_it_is_rendered_but_not_where_the_camera_is() {
        let scene = crate::scene::load("atrium@0.1").unwrap();
        let now = key(&scene, &options());
        let mut moved = scene.clone();
        moved.camera.eye += Vec3::ONE;
        assert_eq!(key(&moved, &options()), now);
        let change = |change: fn(&mut Scene)| {
            let mut other = scene.clone();
            change(&mut other);
            key(&other, &options())
        };
        for other in [
            change(|scene| scene.mesh.positions[7].x += 1.0e-3),
            change(|scene| scene.settings.light_samples += 1),
            change(|scene| scene.materials[0].kd.x *= 0.5),
            change(|scene| scene.lights.truncate(1)),
            key(&scene, &RenderOptions { threads: Some(2), ..options() }),
            key(&scene, &RenderOptions { size: [61, 40], ..options() }),
        ] {
            assert_ne!(other, now);
        }
    }
}
