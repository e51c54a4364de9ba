//! Effects against closed forms and independent estimates, and one image whatever simulates them.

mod ambient;
mod box_light;
mod ends;
mod glass;
mod gloss;
mod leaning;
mod once;
mod pictures;
mod reasons;
mod same;
mod sources;
mod spheres;
mod terminator;

use crate::support::{RENDER, mesh_of};
use glam::Vec3;
use irt::{
    effects::EffectChoice,
    render::{RenderOptions, render},
    scene::{CameraDescription, Material, RenderSettings, Scene, TriangleMesh},
    schedule::Control,
};

/// A rectangle of two triangles, counter-clockwise as seen from the side that `u` x `v` points to.
pub(crate) fn rectangle(corner: Vec3, u: Vec3, v: Vec3) -> Vec<[Vec3; 3]> {
    let [a, b, c, d] = [corner, corner + u, corner + u + v, corner + v];
    vec![[a, b, c], [a, c, d]]
}

/// The six sides of a box, seen from outside.
pub(crate) fn cuboid(min: Vec3, max: Vec3) -> Vec<[Vec3; 3]> {
    let size = max - min;
    let [x, y, z] = [size.x * Vec3::X, size.y * Vec3::Y, size.z * Vec3::Z];
    [(min, z, y), (min, x, z), (min, y, x), (max, -y, -z), (max, -z, -x), (max, -x, -y)]
        .into_iter()
        .flat_map(|(corner, u, v)| rectangle(corner, u, v))
        .collect()
}

/// A floor of side 40 in y = 0, facing up.
pub(crate) fn floor() -> Vec<[Vec3; 3]> {
    rectangle(Vec3::new(-20.0, 0.0, -20.0), 40.0 * Vec3::Z, 40.0 * Vec3::X)
}

/// A diffuse material.
pub(crate) fn matt(kd: f32) -> Material {
    Material { kd: Vec3::splat(kd), ..Material::default() }
}

/// Triangles of one material, with settings that leave out nothing that counts.
pub(crate) fn scene(triangles: &[[Vec3; 3]], material: Material) -> Scene {
    scene_of(mesh_of(triangles), vec![material])
}

pub(crate) fn scene_of(mesh: TriangleMesh, materials: Vec<Material>) -> Scene {
    let settings = RenderSettings { cutoff: 0.0, max_depth: 40, ..RenderSettings::default() };
    Scene { name: "effects".into(), mesh, materials, settings, ..Scene::default() }
}

/// The light that arrives at `eye` from where it looks, by the kernel for just these effects; the kernel for all must agree.
pub(crate) fn radiance(scene: &Scene, eye: Vec3, at: Vec3) -> Vec3 {
    let up = if (at - eye).normalize().y.abs() > 0.9 { Vec3::Z } else { Vec3::Y };
    let scene = Scene { camera: CameraDescription { eye, at, up, fov_deg: 0.01 }, ..scene.clone() };
    let one = |effects| {
        let options = RenderOptions { size: [1, 1], effects, ..RENDER };
        let rendered = render(&scene, &options, &Control::unattended()).expect("renders");
        assert_eq!(rendered.nan, None);
        Vec3::from(rendered.film.pixels().next().expect("a pixel"))
    };
    let auto = one(EffectChoice::Auto);
    assert_eq!(auto.to_array().map(f32::to_bits), one(EffectChoice::All).to_array().map(f32::to_bits));
    auto
}

/// Fails unless the two differ by at most the share `within`.
#[track_caller]
pub(crate) fn close(got: f32, want: f64, within: f64, what: &str) {
    let off = (f64::from(got) - want).abs();
    assert!(off <= within * want.abs().max(1.0e-3), "{what}: {got}, not {want}");
}
