//! Where paths end, and what they keep on their way.

use super::{close, cuboid, floor, matt, radiance, rectangle, scene, scene_of};
use crate::support::{RENDER, mesh_of};
use glam::{Vec2, Vec3};
use irt::{
    render::{RenderOptions, render},
    scene::{AreaLight, CameraDescription, Environment, Falloff, Light, Material, Scene, Texture, Wrap},
    schedule::Control,
};

/// What a room is made of whose walls all shine, mirror and reflect diffusely.
const SHINE: f64 = 0.3;
const MIRROR: f64 = 0.5;
const MATT: f64 = 0.25;

/// What a ray of the given weight brings home in that room, by the rules in words: mirrored rays up to a depth in a row,
/// diffuse ones up to a number in all, which begin a new row; and only rays that count at least `cutoff`.
fn brings(weight: f64, depth: u32, bounces: u32, limits: (u32, u32, f64)) -> f64 {
    let (max_depth, max_bounces, cutoff) = limits;
    let mut sum = weight * SHINE;
    if depth < max_depth && weight * MIRROR >= cutoff {
        sum += brings(weight * MIRROR, depth + 1, bounces, limits);
    }
    if bounces < max_bounces && weight * MATT >= cutoff {
        sum += brings(weight * MATT, 0, bounces + 1, limits);
    }
    sum
}

#[test]
fn in_a_room_of_mirrors_paths_end_where_the_settings_say() {
    let inside: Vec<_> =
        cuboid(Vec3::splat(-1.0), Vec3::ONE).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let splat = |value: f64| Vec3::splat(value as f32);
    let material = Material { ke: splat(SHINE), ks: splat(MIRROR), illum: 3, ..matt(MATT as f32) };
    let mut scene = scene(&inside, material);
    // Weights are powers of two, so a cut-off can be hit exactly: what counts just as much is followed.
    for limits in [
        (0, 0, 0.0),
        (1, 0, 0.0),
        (4, 0, 0.0),
        (2, 1, 0.0),
        (1, 3, 0.0),
        (40, 0, 0.25),
        (40, 0, 0.26),
        (40, 5, 1.0 / 64.0),
    ] {
        let settings = &mut scene.settings;
        (settings.max_depth, settings.bounces, settings.cutoff) = (limits.0, limits.1, limits.2 as f32);
        let got = radiance(&scene, Vec3::new(0.2, 0.1, -0.3), Vec3::new(0.5, -1.0, 0.7));
        close(got.x, brings(1.0, 0, 0, limits), 1.0e-4, &format!("{limits:?}"));
    }
}

/// Clear in all its area, and unbent.
fn glass(absorption: f32) -> Material {
    let absorption = Vec3::splat(absorption);
    Material { kd: Vec3::ZERO, d: 0.0, ni: 1.0, illum: 6, absorption, ..Material::default() }
}

/// A floor of material 0, and something of material 1.
fn over_the_floor(what: &[[Vec3; 3]], materials: [Material; 2]) -> Scene {
    let mut triangles = floor();
    triangles.extend(what);
    let mut mesh = mesh_of(&triangles);
    mesh.materials = (0..triangles.len()).map(|prim| u32::from(prim >= 2)).collect();
    scene_of(mesh, materials.to_vec())
}

#[test]
fn behind_glass_nothing_weakens_light_any_more() {
    let shining = Material { ke: Vec3::ONE, ..matt(0.0) };
    let slab = cuboid(Vec3::new(-9.0, 3.0, -9.0), Vec3::new(9.0, 4.0, 9.0));
    let got = radiance(&over_the_floor(&slab, [shining, glass(0.5)]), 6.0 * Vec3::Y, Vec3::ZERO);
    close(got.x, (-0.5f64).exp(), 1.0e-4, "one unit of glass, five of air");
}

#[test]
fn shadow_rays_take_the_tint_of_glass() {
    let tf = Vec3::new(1.0, 0.5, 0.25);
    let pane = |height| rectangle(Vec3::new(-4e3, height, -4e3), 8e3 * Vec3::Z, 8e3 * Vec3::X);
    let (direction, intensity, position) = (-Vec3::Y, Vec3::splat(2.0), 100.0 * Vec3::Y);
    let sun = Light::Directional { direction, intensity };
    let point = Light::Point { position, intensity, falloff: Falloff::None };
    let sphere = AreaLight::Sphere { center: position, radius: 1.0, radiance: Vec3::splat(2.0e4) };
    // A pane may also have holes, of any opacity.
    let half = Texture::new("half", [1, 1], vec![[0.5; 4]], Wrap::Repeat);
    for (panes, map_d) in [(1, None), (3, None), (5, None), (1, Some(0)), (3, Some(0))] {
        let all: Vec<_> = (0..panes).flat_map(|number| pane(2.0 + 0.1 * number as f32)).collect();
        let clear = Material { tf, d: 0.5, map_d, ..glass(0.0) };
        let mut scene = over_the_floor(&all, [matt(0.5), clear]);
        scene.mesh.uvs = vec![Vec2::ZERO; scene.mesh.positions.len()];
        scene.textures.push(half.clone());
        let tint = tf.to_array().map(|tf| {
            let through = 0.5 * f64::from(tf);
            (if map_d.is_some() { 0.5 + 0.5 * through } else { through }).powi(panes)
        });
        // From below the panes.
        let check = |scene: &Scene, within: f64, what: &str| {
            let got = radiance(scene, Vec3::new(1.0, 1.0, 0.0), Vec3::ZERO);
            (0..3).for_each(|k| close(got[k], tint[k], within, &format!("{what}, {panes} panes, {map_d:?}")));
        };
        for light in [sun, point] {
            check(&Scene { lights: vec![light], ..scene.clone() }, 1.0e-5, "light");
        }
        check(&Scene { area_lights: vec![sphere], ..scene.clone() }, 1.0e-3, "sphere");
        let environment = Environment { light: true, ..Environment::default() };
        check(&Scene { background: intensity, environment, ..scene.clone() }, 1.0e-5, "sky");
    }
}

#[test]
fn rays_go_on_as_long_as_any_colour_of_them_counts() {
    let ks = Vec3::new(0.0, 0.5, 0.25);
    let mut scene = scene(&floor(), Material { ks, illum: 3, ..matt(0.0) });
    scene.background = Vec3::ONE;
    for (cutoff, seen) in [(0.0, true), (0.5, true), (0.6, false)] {
        scene.settings.cutoff = cutoff;
        let got = radiance(&scene, Vec3::new(1.0, 1.0, 0.0), Vec3::ZERO);
        assert_eq!(got, if seen { ks } else { Vec3::ZERO }, "{cutoff}");
    }
}

#[test]
fn pictures_blur_by_the_width_of_the_ray_on_the_surface() {
    // Two by two texels, one unit wide; of the only smaller version, the mean, as much is mixed in as the logarithm to base 2
    // of the ray's width in texels.
    let mut scene = scene(&floor(), Material { ke: Vec3::ONE, map_ke: Some(0), ..matt(0.0) });
    let checks = [[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0], [1.0; 4]];
    scene.textures.push(Texture::new("checks", [2, 2], checks.to_vec(), Wrap::Repeat));
    scene.mesh.uvs = scene.mesh.positions.iter().map(|p| Vec2::new(p.x, p.z)).collect();
    let pixel = 2.0 * 0.005f64.to_radians().tan();
    for (distance, degrees) in [(4000.0f64, 0.0f64), (2062.0, 75.0), (2062.0, 60.0), (900.0, 80.0)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let level = (2.0 * distance * pixel / cos.sqrt()).log2().clamp(0.0, 1.0);
        let at = Vec3::new(0.75, 0.0, 0.25);
        let eye = at + Vec3::new((distance * sin) as f32, (distance * cos) as f32, 0.0);
        let got = f64::from(radiance(&scene, eye, at).x);
        let texel = if got < 0.5 { 0.0 } else { 1.0 };
        close(got as f32, texel + (0.5 - texel) * level, 5.0e-3, &format!("{distance}, {degrees} degrees"));
    }
}

#[test]
fn a_mirror_shows_a_lamp_once() {
    let lamp = rectangle(Vec3::new(-1.0, 2.0, -1.0), 2.0 * Vec3::X, 2.0 * Vec3::Z);
    let mirror = Material { ks: Vec3::splat(0.5), ns: 20.0, illum: 3, ..matt(0.0) };
    let mut scene = over_the_floor(&lamp, [mirror, Material { ke: Vec3::splat(3.0), ..matt(0.0) }]);
    scene.settings.emitters = true;
    let look = |scene: &Scene| radiance(scene, Vec3::new(0.4, 1.0, 0.0), Vec3::ZERO).x;
    close(look(&scene), 1.5, 1.0e-5, "its image, and no highlight beside it");
    scene.materials[0].illum = 2;
    assert!(look(&scene) > 0.1, "a highlight stands for the image where there is none");
}

#[test]
fn far_away_and_in_mirrors_pictures_are_seen_as_their_mean() {
    let checks = [[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0], [1.0; 4]];
    let picture = Material { ke: Vec3::ONE, map_ke: Some(0), ..matt(0.0) };
    let mirror = Material { ks: Vec3::ONE, illum: 3, ..matt(0.0) };
    let mut scene = over_the_floor(&[], [picture, mirror]);
    scene.textures.push(Texture::new("checks", [2, 2], checks.to_vec(), Wrap::Repeat));
    let uv = |scene: &Scene| scene.mesh.positions.iter().map(|p| Vec2::new(p.x, p.z)).collect();
    scene.mesh.uvs = uv(&scene);
    // The image is one pixel of 0.01 degrees: at a distance of 10^4 it is 1.7 wide, at 30 it is 0.005.
    let at = Vec3::new(0.25, 0.0, 0.25);
    let see = |scene: &Scene, height: f32| radiance(scene, at + height * Vec3::Y, at).x;
    assert!(see(&scene, 30.0) % 1.0 == 0.0, "one texel");
    close(see(&scene, 1.0e4), 0.5, 1.0e-5, "far away");
    // Along x for as long, and down by a mirror one above the picture: the cone goes on from where it was.
    let mirror_at = at + Vec3::Y;
    let slope = Vec3::new(1.0, 1.0, 0.0);
    let slanted = rectangle(mirror_at - 0.5 * (slope + Vec3::Z), slope, Vec3::Z);
    let mut mirrored = over_the_floor(&slanted, scene.materials.clone().try_into().expect("two"));
    mirrored.textures = scene.textures.clone();
    mirrored.mesh.uvs = uv(&mirrored);
    let aside = |by: f32| radiance(&mirrored, mirror_at + by * Vec3::X, mirror_at).x;
    assert!((aside(30.0) - see(&scene, 30.0)).abs() < 1.0e-5, "one texel");
    close(aside(1.0e4), 0.5, 1.0e-5, "in a mirror");
}

#[test]
fn rays_are_counted_by_what_sent_them_on() {
    for (illum, d, expected) in [(3, 1.0, [1, 0]), (6, 0.0, [0, 1]), (7, 0.0, [1, 1])] {
        let ks = if illum == 3 { Vec3::ONE } else { Vec3::ZERO };
        let mut scene = scene(&floor(), Material { ks, d, ni: 1.5, illum, ..matt(0.0) });
        scene.camera = CameraDescription { eye: 2.0 * Vec3::Y, at: Vec3::ZERO, up: Vec3::Z, fov_deg: 40.0 };
        let options = RenderOptions { size: [16, 16], ..RENDER };
        let rendered = render(&scene, &options, &Control::unattended()).expect("renders");
        let rays = rendered.frames[0].rays;
        assert_eq!([rays.reflection, rays.refraction], expected.map(|of: u64| of * 256), "illum {illum}");
    }
}
