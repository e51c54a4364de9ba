//! Loading scenes: what each kind of bad input gives, and where everything is looked for.

use crate::support::Random;
use glam::Vec3;
use irt::scene::{Falloff, Library, Light, Scene, load};
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

/// Loads `s.toml` with this text beside a mesh `t.obj` with a material `m`.
fn toml(text: &str) -> Result<Scene, String> {
    let mesh = format!("mtllib t.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let folder = folder(&[("t.obj", &mesh), ("t.mtl", "newmtl m\nKd 0.1 0.2 0.3\n")]);
    load_path(&write(&folder, "s.toml", text.as_bytes()))
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
fn malformed_lines_of_an_obj_are_errors_that_name_the_line() {
    for (last, line, what) in [
        ("v 0 0", 4, "a vertex needs three coordinates"),
        ("v 0 nan 0", 4, "`nan` is not a finite 32-bit number"),
        ("v 0 inf 0", 4, "`inf` is not a finite"),
        ("v 0 0 1e39", 4, "`1e39` is not a finite"),
        ("v 0 0 -2e18", 4, "`-2e18` is beyond the range of coordinates, 1e18"),
        ("v 1 1 1 1e-30", 4, "dividing by the weight"),
        ("v 0 0 0,5", 4, "`0,5` is not a number"),
        ("v 1 2 3 0", 4, "dividing by the weight 0"),
        ("vn 0 1", 4, "a normal needs three components"),
        ("vn 0 1 x", 4, "`x` is not a number"),
        ("f 1 2 0", 4, "vertex index 0 is out of range"),
        ("f 1 2 -4", 4, "vertex index -4 is out of range, there are 3"),
        ("f 1 2 4", 4, "vertex index 4 is out of range, the file has 3"),
        ("f 1 2 99999999999999999999", 4, "is not a face corner"),
        ("f 1 2 9223372036854775807", 4, "out of range"),
        ("f 1 2 -9223372036854775808", 4, "out of range"),
        ("f 1//1 2//1 3//1", 4, "normal index 1 is out of range"),
        ("f 1//-1 2//1 3//1", 4, "normal index -1 is out of range"),
        ("f 1 2 x", 4, "`x` is not a face corner"),
        ("f 1 2 3/1/1/1", 4, "`3/1/1/1` is not a face corner"),
        ("f 1 2 /1/1", 4, "`/1/1` is not a face corner"),
        ("# two\n\nf 1 2 \\\n 9", 6, "vertex index 9"),
    ] {
        let place = format!("a.obj:{line}: ");
        fails(obj(&format!("{TRIANGLE}{last}\nf 1 2 3\n"), &[]), &[&place, what, "; "]);
    }
}

#[test]
fn files_without_a_face_or_text_are_errors() {
    fails(obj("", &[]), &["a.obj: holds no mesh"]);
    fails(obj("# only a comment\n", &[]), &["holds no mesh"]);
    fails(obj(TRIANGLE, &[]), &["holds vertices but no face"]);
    fails(obj(&format!("{TRIANGLE}f 1 2 2\n"), &[]), &["only triangles of zero area"]);
    fails(obj("v 0 0 0\n\0", &[]), &["a.obj:2: ", "zero byte"]);
    fails(load_path(Path::new("nowhere/a.obj")), &["nowhere/a.obj: cannot be read", "check the path"]);
    let folder = folder(&[("x.obj/y", "")]);
    fails(load_path(&folder.path().join("x.obj")), &["is not a regular file"]);
    let other = write(&folder, "a.stl", b"solid");
    fails(load_path(&other), &["is of no kind that can be read", ".obj"]);
}

#[test]
fn what_an_obj_may_say_in_many_ways_is_understood() {
    let text = "\u{feff}# head\r\nv 0 0 0 # origin\r\nv 1 0 \\\r\n 0\r\nv 2 2 0 2\n  v 0 1 0 1 0.5 0\n\
                vn 0 0 -2e-30\nvt 0 0\ng left\nf 1/1 2/1/1 -2//-1\nf 1 3 4\ng right side\ns 1\nfo 2//1 3//1 4//1";
    let scene = good(obj(text, &[]));
    assert_eq!(scene.mesh.corners(0), [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    assert_eq!(scene.mesh.corners(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    let normal = |prim: usize, k: usize| scene.mesh.normals[scene.mesh.triangles[prim][k] as usize];
    assert_eq!([normal(0, 0), normal(0, 1), normal(0, 2)], [Vec3::ZERO, -Vec3::Z, -Vec3::Z]);
    assert_eq!([normal(1, 0), normal(2, 0)], [Vec3::ZERO, -Vec3::Z]);
    let parts: Vec<_> = scene.mesh.parts.iter().map(|part| (&*part.name, part.first, part.count)).collect();
    assert_eq!(parts, [("left", 0, 2), ("right side", 2, 1)]);
    warns(&scene, "vertex colours ignored: 1 (first in line 6)");
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
}

#[test]
fn polygons_are_cut_properly_and_forward_references_work() {
    let arrow = "f 1 2 3 4\nv 0 0 0\nv 2 2 0\nv 0 1 0\nv -2 2 0\n";
    let scene = good(obj(arrow, &[]));
    let area = |prim| {
        let [a, b, c] = scene.mesh.corners(prim);
        0.5 * (b - a).cross(c - a).z
    };
    assert_eq!((scene.mesh.len(), area(0) + area(1)), (2, 2.0));
    assert!(area(0) > 0.0 && area(1) > 0.0);
    let tie = good(obj("v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\nv -1 1 0\nf 1 2 3 4 5\n", &[]));
    warns(&tie, "polygons that cross themselves or have no area cut into a fan: 1");
}

#[test]
fn what_an_obj_asks_in_vain_is_counted() {
    let text = format!(
        "{TRIANGLE}vn nan 0 0\nf 1 2 3\nf 1//1 3 2\nf 1 1 2\nf 1 2\nl 1 2\np 1\ncurv 0 1\ncurv 0 1\n\
         usemtl\nf 2 1 3\nusemtl none\nf 3 2 1\nmtllib gone.mtl\nmtllib\nf 1 2 1\n"
    );
    let scene = good(obj(&text, &[]));
    for warning in [
        "normals that are not finite (flat shading there): 1 (first in line 4)",
        "triangles of exactly zero area dropped: 2",
        "faces with fewer than three corners dropped: 1 (first in line 8)",
        "points and lines dropped: 2 (first in line 9)",
        "unsupported statement `curv` ignored: 2 (first in line 11)",
        "`usemtl` without a name (default material used): 1 (first in line 13)",
        "material `none` not defined (default used): 1 (first in line 15)",
        "material file `gone.mtl` not found: 1 (first in line 17)",
        "`mtllib` without a name: 1 (first in line 18)",
    ] {
        warns(&scene, warning);
    }
    assert_eq!(scene.warnings.len(), 9, "{:?}", scene.warnings);
    assert_eq!((scene.mesh.len(), scene.report().degenerate_dropped), (4, 2));
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].name, "default");
}

#[test]
fn a_file_of_garbage_gives_few_warnings() {
    let garbage: String = (0..5000).map(|i| format!("junk{i} 1 2\n")).collect();
    let scene = good(obj(&format!("{TRIANGLE}f 1 2 3\n{garbage}"), &[]));
    assert!(scene.warnings.len() < 50, "{}", scene.warnings.len());
    warns(&scene, ": 4960 (first in line 45)");
}

#[test]
fn materials_come_from_all_files_with_all_their_values() {
    let text = format!(
        "mtllib a.mtl b.mtl\nmtllib with space.mtl\nmtllib C:\\dir\\a.mtl\n{TRIANGLE}\
         usemtl grey#1\nf 1 2 3\nusemtl glass ball\nf 2 3 1\nusemtl spaced\nf 3 1 2\n"
    );
    let a = "Kd 1 1 1\nnewmtl grey#1 # comment\nKd 0.8\nKs .1 .2 .3\nNs 50\nKe 1 2 3\nKa 0.5\nNi 1.5\nd 0.25\nillum 7\n";
    let b = "newmtl glass ball\nKd spectral x.rfl\nTr 0.75\nmap_Kd -s 2 2 1 t.png\nPr 0.5\nillum 99\nNs -3\nNi 0\n\
             newmtl twice\nd 1\nTr 1\nnewmtl grey#1\nKd 0 0 0\nd -halo 0.5\n";
    let files = [("a.mtl", a), ("b.mtl", b), ("with space.mtl", "newmtl spaced\nKd 1.5 -1 \\\n 0\n")];
    let scene = good(obj(&text, &files));
    let of = |prim: usize| &scene.materials[scene.mesh.materials[prim] as usize];
    let grey = of(0);
    assert_eq!(
        (grey.kd, grey.ks, grey.ke),
        (Vec3::splat(0.8), Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 2.0, 3.0))
    );
    assert_eq!((grey.ka, grey.ns, grey.ni, grey.d, grey.illum), (Vec3::splat(0.5), 50.0, 1.5, 0.25, 7));
    let glass = of(1);
    assert_eq!((&*glass.name, glass.kd, glass.d), ("glass ball", Vec3::splat(0.7), 0.25));
    assert_eq!((glass.illum, glass.ns, glass.ni), (2, 0.0, 1.0));
    assert_eq!(of(2).kd, Vec3::new(1.5, 0.0, 0.0));
    for warning in [
        "a.mtl: statements before the first `newmtl` ignored: 1 (first in line 1)",
        "b.mtl: colours given as `spectral` or `xyz` ignored: 1 (first in line 2)",
        "b.mtl: textures ignored: 1 (first in line 4)",
        "b.mtl: unsupported statement `Pr` ignored: 1 (first in line 5)",
        "b.mtl: values of `illum` out of range brought into it: 1 (first in line 6)",
        "b.mtl: values of `Ns` out of range brought into it: 1 (first in line 7)",
        "b.mtl: values of `Ni` out of range brought into it: 1 (first in line 8)",
        "b.mtl: materials whose `d` and `Tr` contradict each other (`d` used): 1 (first in line 12)",
        "b.mtl: `-halo` ignored: 1 (first in line 14)",
        "b.mtl: further definitions of material `grey#1` ignored: 1",
        "with space.mtl: values of `Kd` out of range brought into it: 1 (first in line 2)",
    ] {
        warns(&scene, warning);
    }
    assert_eq!(scene.warnings.len(), 11, "{:#?}", scene.warnings);
}

#[test]
fn malformed_lines_of_an_mtl_are_errors_that_name_the_line() {
    for (line, what) in [
        ("Kd 1 1", "`Kd` needs one or three numbers, not 2"),
        ("Kd", "`Kd` needs one or three numbers, not 0"),
        ("Kd x", "`Kd` needs a finite number, not `x`"),
        ("Ke 1 nan 1", "`Ke` needs a finite number, not `nan`"),
        ("Ns", "`Ns` needs a finite number, not ``"),
        ("d opaque", "`d` needs a finite number"),
        ("Tr", "`Tr` needs a finite number"),
        ("newmtl", "`newmtl` without a name"),
    ] {
        let result = obj(
            &format!("mtllib a.mtl\n{TRIANGLE}f 1 2 3\n"),
            &[("a.mtl", &format!("newmtl m\n# c\n{line}\n"))],
        );
        fails(result, &["a.mtl:3: ", what]);
    }
}

const MESH: &str = "[[mesh]]\nfile = \"t.obj\"\n";

#[test]
fn mistakes_in_a_scene_file_are_errors_with_line_and_column() {
    let cases: &[(&str, usize, usize, &str)] = &[
        ("size = [1, ", 3, 11, "unclosed array"),
        (
            "[camera]\neye = [0, 0, 1]\nat = [0, 0, 0]\nfov = 45\nzoom = 2",
            7,
            1,
            "unknown field `zoom`, expected one of",
        ),
        ("[camera]\neye = [0, 0, 1]\nfov = 45", 3, 1, "missing field `at`"),
        ("[camera]\neye = [0, 0]\nat = [0, 0, 0]\nfov = 45", 4, 7, "invalid length 2"),
        (
            "[camera]\neye = [0, 0, nan]\nat = [0, 0, 0]\nfov = 45",
            4,
            7,
            "`eye` must be three finite numbers, at most 1e18",
        ),
        ("[camera]\neye = [0, 0, 1]\nat = [0, 0, 1]\nfov = 45", 5, 6, "`at` must differ from `eye`"),
        ("[camera]\neye = [0, 0, 1e-30]\nat = [0, 0, 0]\nfov = 45", 5, 6, "`at` must differ from `eye`"),
        ("[camera]\neye = [0, 0, 1]\nat = [0, 0, 0]\nfov = 180", 6, 7, "`fov` must be between 0 and 180"),
        (
            "[camera]\neye = [0, 0, 1]\nat = [0, 0, 0]\nup = [0, 0, 2]\nfov = 45",
            6,
            6,
            "`up` must be neither zero",
        ),
        ("[camera]\neye = [0, 1, 0]\nat = [0, 0, 0]\nfov = 45", 3, 1, "`up` must be neither zero"),
        ("[[light]]\nkind = \"area\"", 4, 8, "unknown variant `area`, expected one of"),
        ("[[light]]\nkind = \"point\"", 3, 1, "a point light needs `position`"),
        ("[[light]]\nkind = \"directional\"", 3, 1, "a directional light needs `direction`"),
        (
            "[[light]]\nkind = \"directional\"\ndirection = [0, 0, 0]",
            5,
            13,
            "`direction` must not have zero length",
        ),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\nouter = 3",
            6,
            9,
            "a point light has no `outer`",
        ),
        (
            "[[light]]\nkind = \"directional\"\ndirection = [0, 0, 1]\nfalloff = \"none\"",
            6,
            11,
            "has no `falloff`",
        ),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\nintensity = -1",
            6,
            13,
            "`intensity` must not be negative",
        ),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\ncolor = [1, 1]",
            6,
            9,
            "invalid length 2, expected a number or",
        ),
        ("[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\ncolor = [1, 1, 1, 1]", 6, 9, "invalid length 4"),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\ncolor = \"red\"",
            6,
            9,
            "expected a number or an array",
        ),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\ncolor = 3e38\nintensity = 10",
            3,
            1,
            "is too great",
        ),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 0, 1e39]",
            5,
            12,
            "`position` must be three finite numbers, at most 1e18",
        ),
        (
            "[[light]]\nkind = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 0, 1]",
            3,
            1,
            "a spot light needs `outer`",
        ),
        (
            "[[light]]\nkind = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 0, 1]\ninner = 30\nouter = 30",
            7,
            9,
            "`inner` must be at least 0 degrees and below `outer`",
        ),
        (
            "[[light]]\nkind = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 0, 1]\nouter = 91",
            7,
            9,
            "`outer` must be above 0",
        ),
        ("[[material]]\nname = \"m\"\nkd = 1.5", 5, 6, "`kd` must be in 0 to 1"),
        ("[[material]]\nname = \"m\"\nke = [0, -1, 0]", 5, 6, "`ke` must be finite and not negative"),
        ("[[material]]\nname = \"m\"\nns = -1", 5, 6, "`ns` must not be negative"),
        ("[[material]]\nname = \"m\"\nni = 0", 5, 6, "`ni` must be positive"),
        ("[[material]]\nname = \"m\"\nd = 2", 5, 5, "`d` must be in 0 to 1"),
        ("[[material]]\nname = \"m\"\nillum = 11", 5, 9, "`illum` must be in 0 to 10"),
        ("[[material]]\nkd = 1", 3, 1, "missing field `name`"),
        ("scale = [1, 0, 1]", 3, 9, "`scale` must be finite and not zero"),
        ("scale = true", 3, 9, "expected a number or an array of three numbers"),
        ("rotate = [0, inf, 0]", 3, 10, "`rotate` must be three finite numbers"),
        ("translate = 3", 3, 13, "invalid type: integer `3`"),
        ("material = \"x\"", 3, 12, "there is no material `x`"),
        ("scale = 3e38\ntranslate = [1e18, 0, 0]", 2, 8, "beyond the range of coordinates, 1e18"),
        ("colour = 1", 3, 1, "unknown field `colour`"),
    ];
    for &(text, line, column, what) in cases {
        let place = format!("s.toml:{line}: column {column}: ");
        fails(toml(&format!("{MESH}{text}\n")), &[&place, what, "; "]);
    }
    fails(
        toml(&format!("size = [0, 10]\n{MESH}")),
        &["s.toml:1: column 8: `size` must be two integers in 1 to 32768"],
    );
    fails(toml(&format!("ambient = -1\n{MESH}")), &["s.toml:1: column 11: `ambient` must be"]);
    fails(toml(&format!("x = 'ä' # ä\nambient = 1\n{MESH}")), &["s.toml:1: column 1: unknown field `x`"]);
    fails(toml("mesh = []"), &["s.toml:1: ", "at least one `[[mesh]]`"]);
    fails(toml(""), &["missing field `mesh`"]);
    let folder = folder(&[]);
    fails(load_path(&write(&folder, "u.toml", b"# \xff\n")), &["u.toml:1: holds a byte that is not UTF-8"]);
}

#[test]
fn a_scene_file_says_everything() {
    let text = "name = \"demo\"\nsize = [640, 480]\nbackground = [0.1, 0.2, 0.3]\nambient = 0.5\n\
        [[mesh]]\nfile = \"t.obj\"\n[[mesh]]\nfile = \"t.obj\"\nname = \"second\"\nmaterial = \"new\"\nscale = 2\n\
        rotate = [0, 0, 90]\ntranslate = [5, 0, 0]\n\
        [[material]]\nname = \"m\"\nks = 0.5\n[[material]]\nname = \"new\"\nkd = [1, 0, 0]\nd = 0.5\n\
        [[material]]\nname = \"typo\"\n\
        [camera]\neye = [0, 0, 9]\nat = [0, 0, 0]\nup = [0, 5, 0]\nfov = 30.5\n\
        [[light]]\nkind = \"point\"\nposition = [1, 2, 3]\ncolor = [1, 0.5, 0]\nintensity = 2\nfalloff = \"inverse-square\"\n\
        [[light]]\nkind = \"directional\"\ndirection = [0, -3, 0]\n\
        [[light]]\nkind = \"spot\"\nposition = [0, 0, 0]\ndirection = [0, 0, 2]\ninner = 45\nouter = 90\n";
    let scene = good(toml(text));
    assert_eq!((&*scene.name, scene.size, scene.ambient), ("demo", [640, 480], Vec3::splat(0.5)));
    assert_eq!(scene.background, Vec3::new(0.1, 0.2, 0.3));
    let moved = [Vec3::new(5.0, 0.0, 0.0), Vec3::new(5.0, 2.0, 0.0), Vec3::new(3.0, 0.0, 0.0)];
    assert_eq!((scene.mesh.corners(0), scene.mesh.corners(1)), ([Vec3::ZERO, Vec3::X, Vec3::Y], moved));
    let of = |prim: usize| &scene.materials[scene.mesh.materials[prim] as usize];
    assert_eq!((of(0).kd, of(0).ks), (Vec3::new(0.1, 0.2, 0.3), Vec3::splat(0.5)));
    assert_eq!((&*of(1).name, of(1).kd, of(1).d), ("new", Vec3::X, 0.5));
    assert_eq!((scene.camera.eye, scene.camera.up, scene.camera.fov_deg), (Vec3::Z * 9.0, Vec3::Y, 30.5));
    let right = std::f32::consts::FRAC_PI_2;
    let (falloff, intensity) = (Falloff::InverseSquare, Vec3::new(2.0, 1.0, 0.0));
    let spot = (Falloff::None, right / 2.0, right);
    assert_eq!(
        scene.lights,
        [
            Light::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity, falloff },
            Light::Directional { direction: -Vec3::Y, intensity: Vec3::ONE },
            Light::Spot {
                position: Vec3::ZERO,
                direction: Vec3::Z,
                intensity: Vec3::ONE,
                falloff: spot.0,
                inner: spot.1,
                outer: spot.2
            },
        ]
    );
    let parts: Vec<_> = scene.mesh.parts.iter().map(|part| &*part.name).collect();
    assert_eq!(parts, ["t", "second/t"]);
    warns(&scene, "no mesh has or uses material `typo`: 1");
    let report = serde_json::to_value(scene.report()).expect("JSON");
    assert_eq!(report["lights"][2]["cone_deg"], serde_json::json!([45.0, 90.0]));
    assert_eq!(report["materials"][1], serde_json::json!({"name": "new", "triangles": 1}));
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
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5 2\nvn 0 0 1\no a\nusemtl m\nf 1//1 2//1 3//1\n\
               g b\nf 1/2/1 2 -1 3\nusemtl n\nf 3 \\\n 2 1\n";
    let mtl = "newmtl m\nKd 0.5\nKs 1 1 1\nNs 10\nd 0.5\nTr 0.5\nillum 2\nnewmtl n\nKe 1 2 3\nmap_Kd a.png\n";
    let toml = "size = [4, 4]\nambient = 0.1\n[[mesh]]\nfile = \"m.obj\"\nscale = [1, 2, 3]\nrotate = [1, 2, 3]\n\
                [camera]\neye = [0, 0, 5]\nat = [0, 0, 0]\nfov = 45\n[[material]]\nname = \"m\"\nd = 0.5\n\
                [[light]]\nkind = \"spot\"\nposition = [1, 2, 3]\ndirection = [0, 0, 1]\ninner = 1\nouter = 20\n";
    let files = [("m.obj", obj), ("m.mtl", mtl), ("s.toml", toml)];
    let folders = files.map(|_| folder(&files));
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
