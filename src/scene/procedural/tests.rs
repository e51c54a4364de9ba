//! What every procedural scene promises, checked on each of them.

use super::*;
use crate::scene::TriangleMesh;
use glam::Vec3;

/// Triangles at detail 1, and lights.
const STATED: &[(&str, usize, usize)] = &[
    ("atrium", 68_000, 8),
    ("nave", 75_000, 4),
    ("hairball", 1_000_000, 1),
    ("office", 34_000, 8),
    ("hall", 331_000, 6),
    ("statue", 70_000, 3),
];

/// Scenes that are small at every detail.
const SMALL: &[&str] = &["gallery", "cornell"];

/// Every scene of this file at a detail that is coarse and one that is as stated.
fn for_each(check: impl Fn(&str, Scene)) {
    for name in STATED.iter().map(|(name, ..)| name).chain(SMALL) {
        for detail in [0.35, 1.0] {
            check(&format!("{name} at {detail}"), build(name, detail).unwrap());
        }
    }
}

fn count(name: &str, detail: f32) -> f64 {
    build(name, detail).unwrap().mesh.len() as f64
}

fn normal(mesh: &TriangleMesh, prim: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(prim);
    (b - a).cross(c - a)
}

/// Distance along `dir` to the nearest triangle, by trying them all in f64.
fn nearest(mesh: &TriangleMesh, org: Vec3, dir: Vec3) -> Option<f64> {
    let (org, dir) = (org.as_dvec3(), dir.as_dvec3());
    let hit = |prim| {
        let [a, b, c] = mesh.corners(prim).map(|v| v.as_dvec3() - org);
        let sides = [c.cross(b).dot(dir), a.cross(c).dot(dir), b.cross(a).dot(dir)];
        let inside = sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
        let normal = (b - a).cross(c - a);
        let t = a.dot(normal) / dir.dot(normal);
        (inside && t > 0.0).then_some(t)
    };
    (0..mesh.len()).filter_map(hit).min_by(f64::total_cmp)
}

#[test]
fn triangles_and_lights_are_as_stated() {
    for &(name, triangles, lights) in STATED {
        let scene = build(name, 1.0).unwrap();
        let ratio = scene.mesh.len() as f64 / triangles as f64;
        assert!((0.85..1.15).contains(&ratio), "{name} has {} triangles", scene.mesh.len());
        assert_eq!(scene.lights.len(), lights, "{name}");
        assert_eq!(scene.name, name);
    }
}

#[test]
fn triangles_grow_with_the_square_of_detail() {
    for &(name, ..) in STATED {
        let (coarse, one) = (count(name, 0.35), count(name, 1.0));
        // Little below detail 1, where many shapes are as coarse as they can be.
        assert!((2.5..10.0).contains(&(one / coarse)), "{name}: {coarse} to {one}");
        if one < 500_000.0 {
            let two = count(name, 2.0);
            assert!((3.2..4.6).contains(&(two / one)), "{name}: {one} to {two}");
            // So much for growth: from some ten thousand to over ten million.
            let [least, most] = [count(name, MIN_DETAIL), two * f64::from(MAX_DETAIL / 2.0).powi(2)];
            assert!(least < 25_000.0 && most > 1e7, "{name}: {least} to {most}");
        }
    }
}

#[test]
fn summaries_tell_the_number_of_triangles() {
    for name in STATED.iter().map(|&(name, ..)| name).chain(["gallery"]) {
        let words: Vec<&str> = summary(name).split(' ').collect();
        let unit = words.iter().position(|word| ["thousand", "million"].contains(word)).unwrap();
        let factor = if words[unit] == "million" { 1e6 } else { 1e3 };
        let told = factor * words[unit - 1].parse::<f64>().unwrap();
        let made = count(name, 1.0);
        assert!((made / told - 1.0).abs() < 0.02, "{name}: {told} told, {made} made");
    }
}

#[test]
fn meshes_are_valid() {
    for_each(|name, scene| {
        let mesh = &scene.mesh;
        assert!(mesh.positions.iter().all(|p| p.is_finite()), "{name}");
        assert_eq!(mesh.normals.len(), mesh.positions.len(), "{name}");
        assert_eq!(mesh.materials.len(), mesh.len(), "{name}");
        assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()), "{name}");
        assert!(mesh.materials.iter().all(|&m| (m as usize) < scene.materials.len()), "{name}");
        let unit = |n: &Vec3| *n == Vec3::ZERO || (n.length() - 1.0).abs() < 1e-4;
        assert!(mesh.normals.iter().all(unit), "{name}");
        for prim in 0..mesh.len() {
            assert!(normal(mesh, prim).length_squared() > 0.0, "{name}: triangle {prim} has no area");
        }
    });
}

#[test]
fn parts_follow_each_other_without_gaps() {
    for_each(|name, scene| {
        let mut next = 0;
        for part in &scene.mesh.parts {
            assert_eq!(part.first, next, "{name}: {}", part.name);
            assert!(part.count > 0, "{name}: {} is empty", part.name);
            next += part.count;
        }
        assert_eq!(next as usize, scene.mesh.len(), "{name}");
    });
}

#[test]
fn normals_agree_with_the_winding() {
    for_each(|name, scene| {
        let mesh = &scene.mesh;
        for prim in 0..mesh.len() {
            let face = normal(mesh, prim);
            for n in mesh.triangles[prim].map(|v| mesh.normals[v as usize]) {
                assert!(n == Vec3::ZERO || n.dot(face) > 0.0, "{name}: triangle {prim}");
            }
        }
    });
}

#[test]
fn the_same_call_makes_the_same_scene() {
    for (name, ..) in STATED {
        let [one, two] = [0, 1].map(|_| build(name, 0.35).unwrap());
        assert_eq!(format!("{:?}", one.mesh), format!("{:?}", two.mesh), "{name}");
        assert_eq!(one.materials, two.materials, "{name}");
        assert_eq!(one.lights, two.lights, "{name}");
    }
}

#[test]
fn the_camera_sees_the_scene_from_a_free_place() {
    for_each(|name, scene| {
        let camera = scene.camera;
        let forward = (camera.at - camera.eye).normalize();
        let ahead = nearest(&scene.mesh, camera.eye, forward);
        assert!(ahead.is_some_and(|t| t > 1.0), "{name}: the middle of the image is at {ahead:?}");
        if !name.starts_with("hairball") && !name.starts_with("cornell") {
            let bounds = scene.mesh.bounds();
            assert!(camera.eye.cmpge(bounds.min).all() && camera.eye.cmple(bounds.max).all(), "{name}");
        }
        // Nothing touches the eye, and the floor below it is seen from above.
        for dir in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            let near = nearest(&scene.mesh, camera.eye, dir);
            assert!(near.is_none_or(|t| t > 0.2), "{name}: {near:?} along {dir}");
        }
    });
}

#[test]
fn lights_are_not_inside_of_anything() {
    for_each(|name, scene| {
        for light in &scene.lights {
            let crate::scene::Light::Point { position, .. } = *light else { continue };
            let near = nearest(&scene.mesh, position, Vec3::new(0.37, -0.9, 0.21));
            assert!(near.is_none_or(|t| t > 0.3), "{name}: {near:?} below the light at {position}");
        }
    });
}

#[test]
fn the_scenes_of_effects_call_for_them() {
    let gallery = build("gallery", 0.35).unwrap();
    let used = |fits: &dyn Fn(&crate::scene::Material) -> bool| {
        gallery.mesh.materials.iter().any(|&m| fits(&gallery.materials[m as usize]))
    };
    assert!(used(&|m| m.refracts() && m.absorption != Vec3::ZERO) && used(&|m| m.map_d.is_some()));
    assert!(
        used(&|m| m.reflects() && m.roughness.is_none()) && used(&|m| m.reflects() && m.roughness.is_some())
    );
    assert!(used(&|m| m.bump.is_some()) && used(&|m| m.map_ke.is_some()) && used(&|m| m.map_kd.is_some()));
    assert!(gallery.area_lights.len() == 3 && gallery.settings.ambient_occlusion.is_some());
    assert_eq!(gallery.mesh.uvs.len(), gallery.mesh.positions.len());
    gallery.check().unwrap();
    let cornell = build("cornell", 1.0).unwrap();
    assert_eq!((cornell.mesh.len(), cornell.settings.emitters), (46, true));
    assert!(summary("cornell").contains(" 46 triangles"));
    cornell.check().unwrap();
}

#[test]
fn glass_is_closed_and_faces_outwards() {
    let scene = build("gallery", 0.5).unwrap();
    let mesh = &scene.mesh;
    for (index, _) in scene.materials.iter().enumerate().filter(|(_, m)| m.refracts()) {
        let prims: Vec<usize> = (0..mesh.len()).filter(|&p| mesh.materials[p] as usize == index).collect();
        // Six times the volume, which is positive if triangles face outwards; an open mesh also has a sum of areas.
        let corners = |&p: &usize| mesh.corners(p).map(|v| v.as_dvec3());
        let volume: f64 = prims.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        let open: glam::DVec3 = prims.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a)).sum();
        let area: f64 = prims.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a).length()).sum();
        assert!(
            volume > 0.0 && open.length() < 1.0e-5 * area,
            "{}: {volume} {open}",
            scene.materials[index].name
        );
    }
}

#[test]
fn unusable_names_and_details_are_refused() {
    let message = build("atrum", 1.0).unwrap_err().to_string();
    assert!(message.contains("'atrum'") && message.contains("atrium"), "{message}");
    for detail in [0.0, -1.0, 0.04, 20.5, f32::NAN, f32::INFINITY] {
        let error = build(DEFAULT, detail).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn every_name_has_a_summary() {
    assert!(NAMES.contains(&DEFAULT));
    for name in NAMES {
        let summary = summary(name);
        assert!(!summary.is_empty() && !summary.contains('\n'), "{name}");
    }
    assert_eq!(summary("nothing"), "");
}
