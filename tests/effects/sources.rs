//! Direct light of sources with and without extent on a plane, and their shadows.

use super::{close, floor, matt, radiance, rectangle, scene};
use glam::{Vec2, Vec3};
use irt::scene::{AreaLight, Environment, Falloff, Light, Material, Scene, Sky, SkyMap, Texture, Wrap};
use std::f64::consts::PI;

/// Share of the hemisphere, weighted by the cosine, that a rectangle a x b takes up at height h over a point of a parallel
/// plane below one of its corners (any textbook of heat transfer, such as Howell's catalogue, B-4).
fn form_factor(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let part = |x: f64, y: f64| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    (part(x, y) + part(y, x)) / (2.0 * PI)
}

/// The same for a rectangle from (x0, z0) to (x1, z1), seen from above the origin.
pub(super) fn over_origin([x0, x1]: [f64; 2], [z0, z1]: [f64; 2], h: f64) -> f64 {
    let corner = |x: f64, z: f64| x.signum() * z.signum() * form_factor(x.abs(), z.abs(), h);
    corner(x1, z1) - corner(x0, z1) - corner(x1, z0) + corner(x0, z0)
}

fn lit_by(light: AreaLight, samples: u32) -> Scene {
    let mut scene = scene(&floor(), matt(0.5));
    scene.area_lights.push(light);
    scene.settings.light_samples = samples;
    scene
}

const EYE: Vec3 = Vec3::new(3.0, 2.0, -4.0);

#[test]
fn a_point_light_obeys_lambert_and_the_square_of_the_distance() {
    for position in [Vec3::new(0.0, 2.0, 0.0), Vec3::new(1.0, 0.5, -2.0), Vec3::new(-5.0, 0.1, 0.0)] {
        let mut scene = scene(&floor(), matt(0.5));
        let intensity = Vec3::splat(3.0);
        scene.lights.push(Light::Point { position, intensity, falloff: Falloff::InverseSquare });
        let square = f64::from(position.length_squared());
        let want = 0.5 * 3.0 / square * f64::from(position.y) / square.sqrt();
        close(radiance(&scene, EYE, Vec3::ZERO).x, want, 1.0e-4, "point");
    }
}

#[test]
fn a_rectangle_lights_a_plane_by_its_form_factor() {
    for (x, z, h) in
        [([-1.0, 1.0], [-0.5, 0.5], 1.0), ([0.3, 2.0], [-1.0, 0.2], 0.7), ([-3.0, 3.0], [1.0, 4.0], 2.0)]
    {
        let light = AreaLight::Rectangle {
            corner: Vec3::new(x[0] as f32, h as f32, z[0] as f32),
            edge_u: (x[1] - x[0]) as f32 * Vec3::X,
            edge_v: (z[1] - z[0]) as f32 * Vec3::Z,
            radiance: Vec3::new(2.0, 1.0, 0.0),
            two_sided: false,
        };
        // x cross z points down, to the floor.
        let got = radiance(&lit_by(light, 1024), EYE, Vec3::ZERO);
        let want = 0.5 * 2.0 * over_origin(x, z, h);
        close(got.x, want, 0.01, "rectangle");
        close(got.y, 0.5 * want, 0.01, "rectangle, green");
        assert_eq!(got.z, 0.0);
        let AreaLight::Rectangle { corner, edge_u, edge_v, radiance: sent, .. } = light else {
            unreachable!()
        };
        let turned =
            AreaLight::Rectangle { corner, edge_u: edge_v, edge_v: edge_u, radiance: sent, two_sided: false };
        assert_eq!(radiance(&lit_by(turned, 16), EYE, Vec3::ZERO), Vec3::ZERO, "from behind");
        let AreaLight::Rectangle { corner, edge_u, edge_v, radiance: sent, .. } = turned else {
            unreachable!()
        };
        let both = AreaLight::Rectangle { corner, edge_u, edge_v, radiance: sent, two_sided: true };
        close(radiance(&lit_by(both, 1024), EYE, Vec3::ZERO).x, want, 0.01, "from behind, two-sided");
    }
}

#[test]
fn a_sphere_lights_a_plane_like_a_point_of_its_solid_angle() {
    for (center, radius) in
        [(Vec3::new(0.0, 2.0, 0.0), 1.5f32), (Vec3::new(2.0, 1.0, 1.0), 0.9), (Vec3::new(0.0, 9.0, 3.0), 0.1)]
    {
        let light = AreaLight::Sphere { center, radius, radiance: Vec3::splat(4.0) };
        let distance = f64::from(center.length());
        let want = 0.5 * 4.0 * (f64::from(radius) / distance).powi(2) * f64::from(center.y) / distance;
        let mut scene = lit_by(light, 1024);
        close(radiance(&scene, EYE, Vec3::ZERO).x, want, 0.005, "sphere");
        // What is inside of it is behind its surface.
        let plate =
            rectangle(center - 0.3 * radius * Vec3::ONE, 0.6 * radius * Vec3::X, 0.6 * radius * Vec3::Z);
        scene.mesh = super::scene(&[floor(), plate].concat(), matt(0.5)).mesh;
        close(radiance(&scene, EYE, Vec3::ZERO).x, want, 0.005, "sphere with something inside");
    }
}

#[test]
fn inside_of_a_light_that_is_a_sphere_it_is_dark() {
    let light = AreaLight::Sphere { center: Vec3::Y, radius: 1.5, radiance: Vec3::ONE };
    assert_eq!(radiance(&lit_by(light, 16), EYE, Vec3::ZERO), Vec3::ZERO);
}

#[test]
fn emitting_triangles_light_like_a_rectangle() {
    let mut triangles = floor();
    triangles.extend(rectangle(Vec3::new(-1.0, 1.5, 0.2), 2.0 * Vec3::X, Vec3::Z));
    let mut scene = scene(&triangles, matt(0.5));
    scene.materials.push(Material { ke: Vec3::splat(2.0), ..matt(0.0) });
    scene.mesh.materials = vec![0, 0, 1, 1];
    scene.settings.light_samples = 1024;
    assert_eq!(radiance(&scene, EYE, Vec3::ZERO), Vec3::ZERO, "only glows unless switched on");
    scene.settings.emitters = true;
    let want = 0.5 * 2.0 * over_origin([-1.0, 1.0], [0.2, 1.2], 1.5);
    close(radiance(&scene, EYE, Vec3::ZERO).x, want, 0.01, "triangles");
    // As many samples of the pixel with one of the light each are spread over it just so.
    (scene.settings.samples, scene.settings.light_samples) = (1024, 1);
    close(radiance(&scene, EYE, Vec3::ZERO).x, want, 0.01, "triangles, by samples of the pixel");
    (scene.settings.samples, scene.settings.light_samples) = (1, 1024);
    assert_eq!(radiance(&scene, EYE, Vec3::new(0.0, 1.5, 0.6)), Vec3::splat(2.0), "and is seen");
    // Another lamp of other size and colour, by a picture that is red up to a fifth of it and green in the rest.
    let (x, z, h) = ([-3.0, 1.0], [-2.0, -1.0], 1.0);
    triangles.extend(rectangle(Vec3::new(-3.0, 1.0, -2.0), 4.0 * Vec3::X, Vec3::Z));
    scene.mesh = super::scene(&triangles, matt(0.5)).mesh;
    scene.mesh.materials = vec![0, 0, 1, 1, 2, 2];
    scene.mesh.uvs = scene.mesh.positions.iter().map(|p| Vec2::new(0.25 * (p.x + 3.0), p.z + 2.0)).collect();
    scene.materials.push(Material { ke: Vec3::new(1.0, 4.0, 0.0), map_ke: Some(0), ..matt(0.0) });
    let colour = |column| if column < 20 { [1.0, 0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0, 1.0] };
    scene.textures.push(Texture::new("lamp", [100, 1], (0..100).map(colour).collect(), Wrap::Clamp));
    scene.settings.light_samples = 4096;
    let got = radiance(&scene, EYE, Vec3::ZERO);
    close(got.x, want + 0.5 * over_origin([x[0], -2.2], z, h), 0.01, "red");
    close(got.y, want + 0.5 * 4.0 * over_origin([-2.2, x[1]], z, h), 0.01, "green");
    close(got.z, want, 0.02, "blue");
}

#[test]
fn a_penumbra_is_as_wide_as_geometry_says() {
    // A light 1 wide at height 2, a screen that covers x < 0 at height 1: the penumbra goes from x = -1/2 to x = 1/2.
    let (wide, top, height) = (1.0, 2.0, 1.0);
    let mut triangles = floor();
    triangles.extend(rectangle(Vec3::new(-9.0, height, -9.0), 9.0 * Vec3::X, 18.0 * Vec3::Z));
    let light = AreaLight::Rectangle {
        corner: Vec3::new(-0.5 * wide, top, -1.0),
        edge_u: wide * Vec3::X,
        edge_v: 2.0 * Vec3::Z,
        radiance: Vec3::ONE,
        two_sided: false,
    };
    let mut scene = scene(&triangles, matt(1.0));
    scene.area_lights.push(light);
    scene.settings.light_samples = 2500;
    for x in [-0.6f32, -0.45, -0.25, 0.0, 0.2, 0.45, 0.6] {
        let at = Vec3::new(x, 0.0, 0.0);
        let got = radiance(&scene, Vec3::new(x + 0.6, 0.3, 0.0), at);
        // Seen from x, the screen's edge hides what lies left of -x at the light's height.
        let x = f64::from(x);
        let left = (-x).clamp(-0.5, 0.5);
        let want = if left < 0.5 { over_origin([left - x, 0.5 - x], [-1.0, 1.0], 2.0) } else { 0.0 };
        let whole = over_origin([-0.5 - x, 0.5 - x], [-1.0, 1.0], 2.0);
        assert!((f64::from(got.x) - want).abs() < 0.01 * whole, "{x}: {} of {whole}, not {want}", got.x);
    }
}

#[test]
fn the_furnace_shows_the_albedo() {
    let ball = crate::support::sphere(Vec3::ZERO, 1.0, 6);
    for albedo in [0.5, 1.0] {
        let mut scene = super::scene_of(ball.clone(), vec![matt(albedo)]);
        scene.background = Vec3::ONE;
        scene.environment = Environment { light: true, ..Environment::default() };
        scene.settings.bounces = 4;
        for at in [Vec3::ZERO, Vec3::new(0.3, 0.2, 0.0), Vec3::new(0.1, -0.6, 0.1)] {
            close(radiance(&scene, Vec3::new(3.0, 1.0, 2.0), at).x, f64::from(albedo), 1.0e-5, "furnace");
        }
    }
    // In a hole, light gets out only after some reflections: all of it, if nothing is absorbed.
    let mut walls = super::cuboid(Vec3::splat(-1.0), Vec3::ONE);
    walls.drain(8..10);
    let mut hole = scene(&walls, matt(1.0));
    (hole.background, hole.environment.light) = (Vec3::ONE, true);
    (hole.settings.bounces, hole.settings.samples, hole.settings.light_samples) = (60, 4096, 1);
    let got = radiance(&hole, Vec3::new(0.1, 2.0, 0.2), Vec3::new(0.2, -1.0, 0.3)).x;
    // Three standard errors of that many paths.
    close(got, 1.0, 0.05, "a hole in a furnace");
}

#[test]
fn a_small_sun_in_the_picture_of_the_sky_lights_as_its_integral() {
    // Sky of 0.5 with one pixel of a sun in the fifth of 32 rows.
    let (size, row, column, sun) = ([64, 32], 5, 40, 2000.0f32);
    let mut pixels = vec![[0.5, 0.5, 0.0]; 64 * 32];
    pixels[row * 64 + column] = [sun, 0.0, 0.0];
    let map = SkyMap { size, pixels, rotation: 0.7, strength: 2.0 };
    // The picture is linear between the centres of pixels: a pyramid of two pixels' width, a cosine and a solid angle.
    let (cell, n) = (PI / 32.0, 400);
    let mut light = 0.0;
    for step in 0..2 * n {
        let off = (f64::from(step) + 0.5) / f64::from(n) - 1.0;
        let theta = (row as f64 + 0.5 + off) * cell;
        light += (1.0 - off.abs()) * theta.cos() * theta.sin() * cell * cell / f64::from(n);
    }
    let want = 2.0 * (0.5 + f64::from(sun - 0.5) * light / PI);
    let mut scene = scene(&floor(), matt(0.5));
    scene.environment = Environment { sky: Sky::Map(map), light: true };
    for (samples, light_samples, tolerance) in [(1, 4096, 0.005), (1024, 1, 0.02), (1, 64, 0.1)] {
        (scene.settings.samples, scene.settings.light_samples) = (samples, light_samples);
        let got = radiance(&scene, EYE, Vec3::ZERO);
        close(got.x, 0.5 * want, tolerance, "sun and sky");
        close(got.y, 0.5 * 2.0 * 0.5, tolerance + 0.02, "the sky, with less light where the sun is");
        assert_eq!(got.z, 0.0);
    }
    // A wall hides the sun, and no more than that.
    let mut triangles = floor();
    triangles.extend(rectangle(Vec3::new(-20.0, 0.01, -20.0), 40.0 * Vec3::X, 40.0 * Vec3::Z));
    scene.mesh = super::scene(&triangles, matt(0.5)).mesh;
    let hidden = radiance(&scene, Vec3::new(0.0, 0.005, 0.001), Vec3::ZERO);
    assert_eq!(hidden, Vec3::ZERO, "between two floors it is dark");
}

#[test]
fn a_mirror_shows_the_picture_of_the_sky() {
    // Few rays are mirrored, so that lanes are left over.
    let mirror = Material { ks: Vec3::splat(0.5), illum: 3, ..matt(0.0) };
    let mut scene = scene(&floor(), mirror);
    let map = SkyMap { size: [5, 3], pixels: vec![[0.5, 2.0, 0.25]; 15], rotation: 0.4, strength: 2.0 };
    scene.environment.sky = Sky::Map(map);
    let got = radiance(&scene, EYE, Vec3::ZERO);
    assert!(got.distance(Vec3::new(0.5, 2.0, 0.25)) < 1.0e-6, "{got}");
}
