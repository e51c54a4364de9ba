//! Scene files in TOML.

use super::{TRIANGLE, fails, folder, good, load_path, warns, write};
use glam::Vec3;
use irt::scene::{Falloff, Light, Scene};

/// Loads `s.toml` with this text beside a mesh `t.obj` with a material `m`.
fn toml(text: &str) -> Result<Scene, String> {
    let mesh = format!("mtllib t.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let folder = folder(&[("t.obj", &mesh), ("t.mtl", "newmtl m\nKd 0.1 0.2 0.3\n")]);
    load_path(&write(&folder, "s.toml", text.as_bytes()))
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
        &["s.toml:1: column 8: `size` must be two integers in 1 to 65536"],
    );
    fails(
        toml(&format!("size = [65536, 65536]\n{MESH}")),
        &["s.toml:1: column 8: `size` must be at most 268435456 pixels in all"],
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
fn the_example_in_the_readme_is_a_scene() {
    let readme = std::fs::read_to_string("scenes/README.md").expect("scenes/README.md");
    let example = readme.split("```").find_map(|block| block.strip_prefix("toml\n")).expect("a TOML block");
    let folder = folder(&[("demo.obj", &format!("{TRIANGLE}f 1 2 3\n"))]);
    let scene = good(load_path(&write(&folder, "s.toml", example.as_bytes())));
    assert_eq!((scene.lights.len(), scene.materials.len()), (3, 1));
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn the_example_of_effects_in_the_readme_is_a_scene() {
    let readme = std::fs::read_to_string("scenes/README.md").expect("scenes/README.md");
    let example =
        readme.split("```").filter_map(|block| block.strip_prefix("toml\n")).nth(1).expect("a block");
    let mesh =
        format!("mtllib demo.mtl\n{TRIANGLE}vt 0 0\nusemtl wall\nf 1/1 2/1 3/1\nusemtl glass\nf 1 2 3\n");
    let folder = folder(&[("demo.obj", &mesh), ("demo.mtl", "newmtl wall\nnewmtl glass\n")]);
    super::pictures::png(&folder.path().join("demo.png"), [1, 1], image::ExtendedColorType::Rgb8, &[9, 9, 9]);
    let scene = good(load_path(&write(&folder, "s.toml", example.as_bytes())));
    assert_eq!((scene.area_lights.len(), scene.textures.len(), scene.materials.len()), (2, 4, 2));
    assert_eq!((scene.settings.bounces, scene.settings.without.len()), (2, 1));
    assert_eq!(scene.warnings, [""; 0]);
}
