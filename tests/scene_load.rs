//! Loading scenes: what each kind of bad input gives, and where everything is looked for.

mod description;
mod effects;
mod mesh;
mod motion;
mod pictures;

use crate::support::Random;
use glam::Vec3;
use irt::scene::{Library, Scene, load};
use std::{
    fs,
    path::{Path, PathBuf},
};
use tempfile::TempDir;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    for (name, text) in files {
        write(&folder, name, text.as_bytes());
    }
    folder
}

fn write(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().expect("a parent")).expect("folders");
    fs::write(&path, bytes).expect("a file");
    path
}

fn load_path(path: &Path) -> Result<Scene, String> {
    load(path.to_str().expect("UTF-8")).map_err(|e| {
        assert_eq!(e.exit_code(), 2, "{e}");
        e.to_string()
    })
}

/// Loads `a.obj` with this text; other files beside it.
fn obj(text: &str, others: &[(&str, &str)]) -> Result<Scene, String> {
    let folder = folder(others);
    load_path(&write(&folder, "a.obj", text.as_bytes()))
}

fn good(result: Result<Scene, String>) -> Scene {
    let scene = result.unwrap_or_else(|e| panic!("{e}"));
    check(&scene);
    scene
}

/// What every loaded scene promises.
fn check(scene: &Scene) {
    let mesh = &scene.mesh;
    assert!(!mesh.is_empty() && mesh.materials.len() == mesh.len());
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len());
    assert!(mesh.normals.iter().all(|n| *n == Vec3::ZERO || (n.length() - 1.0).abs() < 1.0e-5));
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()));
    assert!(mesh.materials.iter().all(|&m| (m as usize) < scene.materials.len()));
    let mut next = 0;
    for part in &mesh.parts {
        assert_eq!(part.first, next);
        next += part.count;
    }
    assert_eq!(next as usize, mesh.len());
    let camera = &scene.camera;
    assert!((camera.at - camera.eye).normalize().cross(camera.up).length() > 0.0);
    for m in &scene.materials {
        assert!((0.0..=1.0).contains(&m.d) && m.ns >= 0.0 && m.ni > 0.0 && m.illum <= 10, "{m:?}");
        assert!([m.ka, m.kd, m.ks, m.ke].iter().all(|c| c.is_finite() && c.min_element() >= 0.0), "{m:?}");
    }
}

#[track_caller]
fn fails(result: Result<Scene, String>, parts: &[&str]) {
    let message = result.map(|_| ()).expect_err("an error");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
    assert!(!message.contains('\n'), "one sentence: {message}");
}

#[track_caller]
fn warns(scene: &Scene, warning: &str) {
    assert!(scene.warnings.iter().any(|w| w.ends_with(warning)), "no `{warning}` in {:?}", scene.warnings);
}

#[test]
fn a_bare_mesh_is_framed_and_lit() {
    let scene = good(obj(&format!("{TRIANGLE}f 1 2 3\nf 2 1 3\nf 3 2 1\nv -0.0 0 0\nf 2 3 4\n"), &[]));
    assert_eq!((scene.lights.len(), scene.size), (2, [1024, 1024]));
    let forward = (scene.camera.at - scene.camera.eye).normalize();
    let reach = (0.5 * scene.camera.fov_deg).to_radians().cos();
    for &p in &scene.mesh.positions {
        assert!((p - scene.camera.eye).normalize().dot(forward) > reach, "{p} is outside the view");
    }
    assert_eq!(scene.report().duplicates, 3);
    // Far away and tiny: the eye must not round to the point it looks at.
    let far = "v 7e8 4e8 1\nv 7e8 4e8 2\nv 7.00001e8 4e8 1\nf 1 2 3\n";
    good(obj(far, &[]));
    good(obj("v 0 0 0\nv 1e-40 0 0\nv 0 1e-40 0\nf 1 2 3\n", &[]));
}

#[test]
fn meshes_are_looked_for_beside_the_scene_then_in_each_folder() {
    let obj = |x: f32| format!("v 0 0 0\nv {x} 0 0\nv 0 1 0\nf 1 2 3\n");
    let (scenes, one, two) =
        (folder(&[("sub/s.toml", "[[mesh]]\nfile = \"m/m.obj\"\n")]), folder(&[]), folder(&[]));
    let library = Library {
        scenes: vec![scenes.path().into(), one.path().into()],
        meshes: vec![one.path().into(), two.path().into()],
    };
    let width = || library.load("sub/s").map(|scene| scene.mesh.bounds().max.x);
    let message = width().expect_err("no mesh yet").to_string();
    let [beside, one_path, two_path] =
        [scenes.path().join("sub"), one.path().into(), two.path().into()].map(|p| p.display().to_string());
    for part in [
        "s.toml:2: column 8: mesh `m/m.obj`",
        &beside,
        &one_path,
        &two_path,
        "IRT_SCENES",
        "scenes/README.md",
    ] {
        assert!(message.contains(part), "`{part}` is not in {message}");
    }
    let described = library.described();
    assert_eq!(described.len(), 1);
    assert_eq!((&*described[0].name, &described[0].problem), ("sub/s", &None));
    assert_eq!(described[0].meshes[0].found, None);
    assert_eq!(described[0].meshes[0].searched.len(), 3);
    for (place, x) in [(&two, 3.0), (&one, 2.0)] {
        write(place, "m/m.obj", obj(x).as_bytes());
        assert_eq!(width().ok(), Some(x));
    }
    write(&scenes, "sub/m/m.obj", obj(1.0).as_bytes());
    assert_eq!(width().ok(), Some(1.0));
    assert_eq!(library.described()[0].meshes[0].found, Some(scenes.path().join("sub/m/m.obj")));
}

#[test]
fn names_are_found_by_their_end_and_unknown_ones_list_all() {
    let mesh = format!("{TRIANGLE}f 1 2 3\n");
    let scene = "[[mesh]]\nfile = \"m.obj\"\n";
    let scenes = folder(&[
        ("a/m.obj", &mesh),
        ("b/m.obj", &mesh),
        ("a/one.toml", scene),
        ("a/both.toml", scene),
        ("b/both.toml", scene),
        ("b/bad.toml", "x"),
    ]);
    let library = Library { scenes: vec![scenes.path().into()], meshes: Vec::new() };
    let error = |spec: &str| library.load(spec).map(|_| ()).expect_err(spec).to_string();
    assert_eq!(library.load("one").expect("found").name, "one");
    assert_eq!(library.load("b/both").expect("found").name, "both");
    assert!(error("both").contains("a/both or b/both"), "{}", error("both"));
    assert!(error("one@2").contains("no detail"), "{}", error("one@2"));
    assert!(error("bad").contains("bad.toml:1: column"), "{}", error("bad"));
    let unknown = error("nothing");
    assert!(unknown.starts_with("nothing: is neither"), "{unknown}");
    assert!(unknown.contains(&scenes.path().display().to_string()), "{unknown}");
    for name in ["a/both", "a/one", "b/bad", "b/both"].iter().chain(irt::scene::procedural::NAMES) {
        assert!(unknown.contains(name), "`{name}` is not in {unknown}");
    }
    let problems: Vec<_> = library.described().into_iter().filter(|d| d.problem.is_some()).collect();
    assert_eq!((problems.len(), &*problems[0].name), (1, "b/bad"));
}

#[test]
fn the_scenes_of_the_thesis_are_described() {
    let library = Library::from_env();
    let described = library.described();
    for (name, lights) in [("bunny", 3), ("office", 8), ("sibenik", 4), ("sponza", 8), ("conference", 6)] {
        let name = format!("thesis/{name}");
        let found = described.iter().find(|d| d.name == name).expect(&name);
        assert_eq!(found.problem, None);
        if std::env::var_os("IRT_SCENES").is_none() || found.meshes.iter().any(|mesh| mesh.found.is_none()) {
            continue;
        }
        let scene = library.load(&name).unwrap_or_else(|e| panic!("{e}"));
        check(&scene);
        assert_eq!(scene.lights.len(), lights, "{name}");
        let bounds = scene.mesh.bounds();
        let reach = 2.0 * bounds.extent().length();
        assert!((scene.camera.eye - bounds.center()).length() < reach, "{name}: the camera is elsewhere");
    }
}

/// Replaces, removes, inserts and duplicates bytes.
fn mutate(random: &mut Random, text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=random.below(6) {
        let at = random.below(bytes.len());
        match random.below(5) {
            0 => bytes[at] = random.bits() as u8,
            1 if bytes.len() > 1 => drop(bytes.remove(at)),
            2 => bytes.insert(at, b"0123456789-./\\#\n\r e"[random.below(19)]),
            3 => bytes.truncate(at + 1),
            _ => {
                let end = (at + random.below(20)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, copy);
            }
        }
    }
    bytes
}

#[test]
fn random_damage_never_panics() {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5 2\nvt 0 0\nvt 1 1\nvn 0 0 1\no a\nusemtl m\nf 1//1 2//1 3//1\n\
               g b\nf 1/2/1 2 -1 3\nusemtl n\nf 3 \\\n 2 1\n";
    let mtl = "newmtl m\nKd 0.5\nKs 1 1 1\nNs 10\nd 0.5\nTr 0.5\nillum 2\nnewmtl n\nKe 1 2 3\nmap_Kd -s 2 2 a.png\n";
    let toml = "size = [4, 4]\nambient = 0.1\n[[mesh]]\nfile = \"m.obj\"\nscale = [1, 2, 3]\nrotate = [1, 2, 3]\n\
                [camera]\neye = [0, 0, 5]\nat = [0, 0, 0]\nfov = 45\n[[material]]\nname = \"m\"\nd = 0.5\nmap_d = \"a.png\"\n\
                [settings]\nsamples = 2\n[environment]\nmap = \"a.png\"\n\
                [[light]]\nkind = \"spot\"\nposition = [1, 2, 3]\ndirection = [0, 0, 1]\ninner = 1\nouter = 20\n";
    let files = [("m.obj", obj), ("m.mtl", mtl), ("s.toml", toml)];
    let folders = files.map(|_| folder(&files));
    for folder in &folders {
        pictures::png(&folder.path().join("a.png"), [1, 1], image::ExtendedColorType::L8, &[9]);
    }
    good(load_path(&folders[0].path().join("s.toml")));
    let mut random = Random(11);
    let mut loaded = [0; 3];
    for round in 0..1500 {
        let kind = round % 3;
        let (name, text) = files[kind];
        write(&folders[kind], name, &mutate(&mut random, text));
        if let Ok(scene) = load_path(&folders[kind].path().join("s.toml")) {
            check(&scene);
            loaded[kind] += 1;
        }
    }
    assert!(loaded.iter().all(|&n| n > 4 && n < 495), "not much was tried: {loaded:?}");
}
