//! What calls for effects: textures of materials, lights with an extent, skies, settings.

use super::{TRIANGLE, fails, folder, good, load_path, pictures, warns, write};
use glam::{Vec2, Vec3};
use image::ExtendedColorType;
use irt::{
    effects::{Effect, Reasons},
    scene::{AreaLight, BumpKind, Environment, RenderSettings, Scene, Sky},
};
use tempfile::TempDir;

/// A folder with `t.obj` (with texture coordinates and a material `m`), `p.png`, and `s.toml` with this text.
fn with_toml(text: &str) -> TempDir {
    let mesh = format!("mtllib t.mtl\n{TRIANGLE}vt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n");
    let folder = folder(&[("t.obj", &mesh), ("t.mtl", "newmtl m\nKd 0.1 0.2 0.3\n")]);
    pictures::png(&folder.path().join("p.png"), [2, 1], ExtendedColorType::Rgb8, &[255, 0, 0, 0, 0, 255]);
    write(&folder, "s.toml", format!("{MESH}{text}\n").as_bytes());
    folder
}

const MESH: &str = "[[mesh]]\nfile = \"t.obj\"\n";

fn toml(text: &str) -> Result<Scene, String> {
    load_path(&with_toml(text).path().join("s.toml"))
}

#[test]
fn texture_coordinates_are_read_and_missing_ones_are_zero() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.25\nvt 1 0.5 9\nvt nan 1\n\
        f 1/1 2/2 3/3\nf 1/-2 2 4/1\nf 1 2 3\n";
    let scene = good(super::obj(text, &[]));
    let uvs = |prim: usize| scene.mesh.triangles[prim].map(|v| scene.mesh.uvs[v as usize]);
    assert_eq!(uvs(0), [Vec2::new(0.25, 0.0), Vec2::new(1.0, 0.5), Vec2::ZERO]);
    assert_eq!(uvs(1), [Vec2::new(1.0, 0.5), Vec2::ZERO, Vec2::new(0.25, 0.0)]);
    assert_eq!(uvs(2), [Vec2::ZERO; 3]);
    warns(&scene, "texture coordinates that are not finite (0 used): 1 (first in line 7)");
    // A file without any keeps none.
    assert!(good(super::obj(&format!("{TRIANGLE}vt 0 0\nf 1 2 3\n"), &[])).mesh.uvs.is_empty());
    let far = format!("{TRIANGLE}vt 0 0\nf 1/1 2/2 3/1\n");
    fails(super::obj(&far, &[]), &["a.obj:5: texture coordinate index 2 is out of range, the file has 1"]);
    fails(super::obj(&format!("{TRIANGLE}vt\nf 1 2 3\n"), &[]), &["a.obj:4: a texture coordinate needs"]);
    fails(super::obj(&format!("{TRIANGLE}vt 0 x\nf 1 2 3\n"), &[]), &["a.obj:4: `x` is not a number"]);
}

#[test]
fn texture_statements_of_mtl_files_become_textures() {
    let folder = pictures::with_map(
        "map_Kd -s 2 2 -clamp on p.png\nmap_d p.png\nmap_Ke sub\\p.png\nbump -bm 4 p.png\nTf 1 0.5 2\nPr 0.25\nmap_Ns p.png",
    );
    pictures::png(&folder.path().join("p.png"), [2, 1], ExtendedColorType::Rgb8, &[255, 0, 0, 0, 0, 255]);
    let scene = good(load_path(&folder.path().join("a.obj")));
    let m = &scene.materials[0];
    assert_eq!((m.map_kd, m.map_d, m.map_ke, scene.textures.len()), (Some(0), Some(1), Some(2), 4));
    assert_eq!((m.tf, m.roughness), (Vec3::new(1.0, 0.5, 1.0), Some(0.25)));
    let bump = m.bump.expect("a bump map");
    assert_eq!((bump.texture, bump.kind), (3, BumpKind::Height));
    // The triangle shows one unit square of the picture on one of space: sqrt(2) texels per unit.
    assert!((bump.strength - 4.0 / 2.0f32.sqrt()).abs() < 1.0e-6, "{}", bump.strength);
    warns(&scene, "a.mtl: textures of unsupported kinds ignored: 1 (first in line 9)");
    warns(&scene, "a.mtl: values of `Tf` out of range brought into it: 1 (first in line 7)");
    // Clamped, and twice as dense.
    let red = scene.textures[0].sample(Vec2::new(-1.0, 0.5), 0.0);
    assert_eq!(red, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(scene.textures[0].sample(Vec2::new(0.375, 0.5), 0.0), [0.0, 0.0, 1.0, 1.0]);
    // A normal map says more than heights, whatever their order; one picture for two maps is read once.
    let folder = pictures::with_map("norm p.png\nmap_Bump p.png\nmap_Kd p.png\nmap_Ke p.png\nPr 0");
    pictures::png(&folder.path().join("p.png"), [1, 1], ExtendedColorType::Rgb8, &[128, 128, 255]);
    let scene = good(load_path(&folder.path().join("a.obj")));
    let m = &scene.materials[0];
    assert_eq!(m.bump.map(|bump| (bump.kind, bump.strength)), Some((BumpKind::Normal, 1.0)));
    assert_eq!((m.map_kd, m.roughness, scene.textures.len()), (m.map_ke, None, 3));
}

#[test]
fn a_scene_file_says_everything_about_effects() {
    let text = "[[material]]\nname = \"m\"\nillum = 7\nd = 0.25\ntf = [1, 0.9, 0.8]\nabsorption = 3\nroughness = 0.5\n\
        map_kd = \"p.png\"\nmap_ke = { file = \"p.png\", scale = [2, 1], offset = [0, 0.5], wrap = \"clamp\" }\n\
        map_bump = { file = \"p.png\", height = 0.25 }\n\
        [[light]]\nkind = \"rectangle\"\ncorner = [0, 5, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 2]\nintensity = 3\n\
        [[light]]\nkind = \"sphere\"\nposition = [0, 5, 0]\nradius = 0.5\ncolor = [1, 0, 0]\n\
        [environment]\nzenith = [0, 0, 1]\nhorizon = 1\nground = 0.1\nlight = false\n\
        [settings]\nsamples = 4\nadaptive = 0.25\nlight_samples = 8\nbounces = 2\nmax_depth = 3\ncutoff = 0\nemitters = true\n\
        smooth_terminator = true\nambient_occlusion = { radius = inf }\n\
        depth_of_field = { aperture = 0.1, focus = 4 }\nwithout = [\"glossy\", \"highlights\"]\n";
    let scene = good(toml(text));
    let m = &scene.materials[0];
    assert_eq!((m.tf, m.absorption), (Vec3::new(1.0, 0.9, 0.8), Vec3::splat(3.0)));
    assert_eq!((m.roughness, m.map_kd, m.map_ke), (Some(0.5), Some(0), Some(1)));
    let bump = m.bump.expect("a bump map");
    assert_eq!((bump.texture, bump.kind, bump.strength), (2, BumpKind::Height, 0.25));
    assert_eq!(scene.textures[1].sample(Vec2::new(9.0, 0.0), 0.0), [0.0, 0.0, 1.0, 1.0]);
    let radiance = Vec3::splat(3.0);
    let (corner, edge_u, edge_v) = (5.0 * Vec3::Y, Vec3::X, 2.0 * Vec3::Z);
    assert_eq!(
        scene.area_lights,
        [
            AreaLight::Rectangle { corner, edge_u, edge_v, radiance, two_sided: false },
            AreaLight::Sphere { center: corner, radius: 0.5, radiance: Vec3::X },
        ]
    );
    assert!(scene.lights.is_empty(), "no lights of a bare mesh are added");
    let (horizon, ground) = (Vec3::ONE, Vec3::splat(0.1));
    let sky = Sky::Gradient { zenith: Vec3::Z, horizon, ground };
    assert_eq!(scene.environment, Environment { sky, light: false });
    let RenderSettings { ambient_occlusion, depth_of_field, without, .. } = scene.settings;
    let counts = [
        scene.settings.samples,
        scene.settings.light_samples,
        scene.settings.bounces,
        scene.settings.max_depth,
    ];
    assert_eq!((counts, scene.settings.cutoff), ([4, 8, 2, 3], 0.0));
    assert_eq!(scene.settings.adaptive, Some(0.25));
    assert!(scene.settings.emitters && scene.settings.smooth_terminator);
    assert_eq!(ambient_occlusion.map(|of| (of.radius, of.samples)), Some((f32::INFINITY, 16)));
    assert_eq!(depth_of_field.map(|of| (of.aperture, of.focus)), Some((0.1, 4.0)));
    assert_eq!(without.to_string(), "highlights,glossy");
    let set = Reasons::new(&scene).set();
    for effect in [Effect::SoftShadows, Effect::Refraction, Effect::NormalMap, Effect::Sky] {
        assert!(set.has(effect), "{effect} is not in {set}");
    }
    assert!(!set.has(Effect::Glossy) && !set.has(Effect::HardShadows), "{set}");
}

#[test]
fn mistakes_about_effects_are_errors_with_line_and_column() {
    let rectangle = "[[light]]\nkind = \"rectangle\"\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\n";
    let material = "[[material]]\nname = \"m\"\n";
    let cases: &[(&str, usize, usize, &str)] = &[
        (&format!("{rectangle}edge_v = [2, 0, 0]"), 7, 10, "`edge_v` must span an area with `edge_u`"),
        (&format!("{rectangle}edge_v = [0, 0, 0]"), 7, 10, "`edge_v` must span an area"),
        (&format!("{rectangle}edge_v = [0, 1, 0]\nradius = 1"), 8, 10, "a rectangle light has no `radius`"),
        (rectangle, 3, 1, "a rectangle light needs `edge_v`"),
        ("[[light]]\nkind = \"sphere\"\nposition = [0, 0, 0]", 3, 1, "a sphere light needs `radius`"),
        (
            "[[light]]\nkind = \"sphere\"\nposition = [0, 0, 0]\nradius = 0",
            6,
            10,
            "`radius` must be positive",
        ),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 0, 0]\ntwo_sided = true",
            6,
            13,
            "a point light has no `two_sided`",
        ),
        (&format!("{material}map_kd = \"q.png\""), 5, 10, "texture `q.png` was not found in "),
        (&format!("{material}map_kd = \"t.obj\""), 5, 10, "texture `t.obj` is no PNG or JPEG picture"),
        (&format!("{material}map_kd = 3"), 5, 10, "expected a picture file or a table with `file`"),
        (&format!("{material}map_kd = {{ scale = [1, 1] }}"), 5, 10, "missing field `file`"),
        (&format!("{material}map_kd = {{ file = \"p.png\", size = 1 }}"), 5, 28, "unknown field `size`"),
        (
            &format!("{material}map_kd = {{ file = \"p.png\", scale = [1, inf] }}"),
            5,
            36,
            "`scale` must be two finite numbers",
        ),
        (
            &format!("{material}map_kd = {{ file = \"p.png\", height = 1 }}"),
            5,
            37,
            "`height` belongs to `map_bump` or `norm` only",
        ),
        (&format!("{material}map_bump = \"p.png\""), 5, 12, "`map_bump` needs `height`"),
        (
            &format!("{material}norm = \"p.png\"\nmap_bump = {{ file = \"p.png\", height = 1 }}"),
            5,
            8,
            "either `map_bump` or `norm`",
        ),
        (&format!("{material}roughness = 2"), 5, 13, "`roughness` must be in 0 to 1"),
        (&format!("{material}absorption = -1"), 5, 14, "`absorption` must be finite and not negative"),
        (&format!("{material}tf = 1.5"), 5, 6, "`tf` must be in 0 to 1"),
        ("[environment]\nzenith = 1\nhorizon = 1", 3, 1, "a gradient needs `ground`"),
        ("[environment]\nzenith = 1\nmap = \"p.png\"", 3, 1, "a sky is either a picture or a gradient"),
        ("[environment]\nstrength = 1", 4, 12, "`strength` belongs to a `map`"),
        ("[environment]\nmap = \"p.png\"\nstrength = -1", 5, 12, "`strength` must not be negative"),
        ("[environment]\nmap = \"p.png\"\nrotation = nan", 5, 12, "`rotation` must be finite"),
        ("[environment]\nmap = \"t.mtl\"", 4, 7, "environment `t.mtl` is no Radiance"),
        ("[settings]\nsamples = 0", 4, 11, "`samples` must be an integer in 1 to 65536"),
        ("[settings]\nbounces = -1", 4, 11, "`bounces` must be an integer in 0 to 65536"),
        ("[settings]\nsamples = 1.5", 4, 11, "invalid type: floating point `1.5`"),
        ("[settings]\nadaptive = 0", 4, 12, "`adaptive` must be positive"),
        ("[settings]\ncutoff = -0.1", 4, 10, "`cutoff` must not be negative"),
        ("[settings]\nambient_occlusion = { radius = 0 }", 4, 32, "`radius` must be positive"),
        ("[settings]\ndepth_of_field = { aperture = 1 }", 4, 18, "missing field `focus`"),
        ("[settings]\ndepth_of_field = { aperture = 1, focus = -2 }", 4, 42, "`focus` must be positive"),
        (
            "[settings]\nwithout = [\"glossy\", \"shine\"]",
            4,
            22,
            "'shine' is no effect; there are hard-shadows,",
        ),
        ("[settings]\nindirect = true", 4, 1, "unknown field `indirect`"),
    ];
    for &(text, line, column, what) in cases {
        let place = format!("s.toml:{line}: column {column}: ");
        fails(toml(text), &[&place, what, "; "]);
    }
}

#[test]
fn hills_grow_with_the_mesh_and_only_as_told() {
    let text = "scale = [1, 2, 4]\n";
    let folder = with_toml(text);
    write(&folder, "t.mtl", b"newmtl m\nmap_Bump p.png\n");
    let scene = good(load_path(&folder.path().join("s.toml")));
    let bump = scene.materials[0].bump.expect("a bump map");
    assert!((bump.strength - 2.0 / 2.0f32.sqrt()).abs() < 1.0e-6, "{}", bump.strength);
    let told = "scale = 3\n[[material]]\nname = \"m\"\nmap_bump = { file = \"p.png\", height = 0.125 }\n";
    let bump = good(toml(told)).materials[0].bump.expect("a bump map");
    assert_eq!(bump.strength, 0.125);
}
