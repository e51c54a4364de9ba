//! Light that a surface gets by two ways, directly and along the ray that goes on from it, counts once; what comes by one of
//! them alone is not lost.

use super::{close, floor, matt, radiance, rectangle, scene_of, sources::over_origin};
use crate::support::mesh_of;
use glam::{Vec2, Vec3};
use irt::scene::{Environment, Material, Scene, Texture, Wrap};

const ALBEDO: f32 = 0.5;
const LAMP: f32 = 2.0;
/// Where the lamp is.
const X: [f64; 2] = [0.5, 3.0];
const Z: [f64; 2] = [-2.0, 2.0];

/// A lamp one above a floor, and a large plane of another material at some height.
fn under(height: f32, material: Material) -> Scene {
    let mut triangles = floor();
    let corner = Vec3::new(X[0] as f32, 1.0, Z[0] as f32);
    triangles.extend(rectangle(corner, (X[1] - X[0]) as f32 * Vec3::X, (Z[1] - Z[0]) as f32 * Vec3::Z));
    triangles.extend(rectangle(Vec3::new(-999.0, height, -999.0), 1998.0 * Vec3::X, 1998.0 * Vec3::Z));
    let mut mesh = mesh_of(&triangles);
    mesh.materials = vec![0, 0, 1, 1, 2, 2];
    mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    let lamp = Material { ke: Vec3::splat(LAMP), ..matt(0.0) };
    let mut scene = scene_of(mesh, vec![matt(ALBEDO), lamp, material]);
    scene.textures.push(Texture::new("hole", [1, 1], vec![[0.0, 0.0, 0.0, 1.0]], Wrap::Repeat));
    let settings = &mut scene.settings;
    (settings.emitters, settings.bounces, settings.samples, settings.light_samples) = (true, 1, 4096, 1);
    scene
}

/// The middle of the floor, from right above it.
fn seen(scene: &Scene) -> f32 {
    radiance(scene, Vec3::new(-0.2, 0.3, 0.1), Vec3::ZERO).x
}

fn direct() -> f64 {
    f64::from(ALBEDO * LAMP) * over_origin(X, Z, 1.0)
}

#[test]
fn a_lamp_behind_holes_or_clear_panes_lights_once() {
    let hole = Material { map_d: Some(0), ..matt(0.0) };
    let pane = Material { d: 0.0, ni: 1.0, illum: 6, ..matt(0.0) };
    for material in [hole, pane] {
        close(seen(&under(0.6, material.clone())), direct(), 0.02, &format!("{material:?}"));
    }
}

#[test]
fn the_sky_behind_holes_or_clear_panes_lights_once() {
    let hole = Material { map_d: Some(0), ..matt(0.0) };
    let pane = Material { d: 0.0, ni: 1.0, illum: 6, ..matt(0.0) };
    for material in [hole, pane] {
        let mut scene = under(0.6, material.clone());
        scene.materials[1].ke = Vec3::ZERO;
        (scene.background, scene.environment) =
            (Vec3::ONE, Environment { light: true, ..Default::default() });
        // All of the sky, but for the black plate that was the lamp.
        let want = f64::from(ALBEDO) * (1.0 - over_origin(X, Z, 1.0));
        close(seen(&scene), want, 0.02, &format!("{material:?}"));
    }
}

#[test]
fn mirrors_throw_light_of_lamps_and_of_the_sky_onto_the_floor() {
    let mirror = Material { ks: Vec3::ONE, illum: 3, ..matt(0.0) };
    let mut scene = under(2.0, mirror);
    // Of the floor, so little that it does not light itself.
    scene.mesh.positions[..6].iter_mut().for_each(|p| *p *= 1.0e-3);
    let image = f64::from(ALBEDO * LAMP) * over_origin(X, Z, 3.0);
    // The image is three times as high as the lamp, which is in front of a part of it.
    let both = f64::from(ALBEDO * LAMP) * over_origin([X[0], X[1] / 3.0], [Z[0] / 3.0, Z[1] / 3.0], 1.0);
    close(seen(&scene), direct() + image - both, 0.02, "lamp and image");
    // A mirror that stands upright beside the floor shows the other half of the sky.
    scene.materials[1].ke = Vec3::ZERO;
    let wall = rectangle(Vec3::new(-0.5, 0.0, -999.0), 999.0 * Vec3::Y, 1998.0 * Vec3::Z);
    let first = scene.mesh.triangles[4][0] as usize;
    for (to, from) in scene.mesh.positions[first..].iter_mut().zip(wall.iter().flatten()) {
        *to = *from;
    }
    (scene.background, scene.environment) = (Vec3::ONE, Environment { light: true, ..Default::default() });
    let plate = over_origin(X, Z, 1.0) + over_origin([-1.0 - X[1], -1.0 - X[0]], Z, 1.0);
    close(
        radiance(&scene, Vec3::new(0.3, 0.2, 0.1), Vec3::ZERO).x,
        f64::from(ALBEDO) * (1.0 - plate),
        0.02,
        "sky",
    );
}
