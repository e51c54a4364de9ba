//! Direct light against a plain reference in f64: every kind of light, hard shadows, smooth normals, ambient.

use crate::support::{RENDER, brute_force, mesh_of};
use glam::{DVec3, Vec3};
use irt::{
    camera::Camera,
    film::Film,
    kernels::{Hit, Isa, MISS, Ray},
    render::{RenderOptions, render},
    scene::{CameraDescription, Falloff, Light, Material, Scene},
    schedule::Control,
    trace::KernelChoice,
};

const SIZE: [u32; 2] = [72, 50];

/// A square of two triangles around `center`.
fn square(center: Vec3, x: Vec3, z: Vec3) -> [[Vec3; 3]; 2] {
    let corner = |i: f32, j: f32| center + i * x + j * z;
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    [[a, c, b], [a, d, c]]
}

/// A floor, a small square that floats above it, and a triangle whose normals lean outwards, seen from above.
fn scene(light: Light) -> Scene {
    let mut triangles = square(Vec3::ZERO, 3.0 * Vec3::X, 3.0 * Vec3::Z).to_vec();
    triangles.extend(square(Vec3::new(0.4, 1.0, -0.2), Vec3::new(0.5, 0.1, 0.0), 0.6 * Vec3::Z));
    let bent = [Vec3::new(-1.6, 0.3, -0.8), Vec3::new(-1.5, 0.4, 0.9), Vec3::new(-0.4, 0.3, 0.1)];
    triangles.push(bent);
    let mut mesh = mesh_of(&triangles);
    mesh.normals = vec![Vec3::ZERO; mesh.positions.len()];
    let middle = (bent[0] + bent[1] + bent[2]) / 3.0;
    for (k, corner) in bent.iter().enumerate() {
        // On the side that is not seen: they have to be turned round.
        mesh.normals[12 + k] = -(Vec3::Y + 0.5 * (corner - middle)).normalize();
    }
    mesh.materials = vec![0, 0, 1, 1, 2];
    let material = |kd: [f32; 3], ks: f32, ns: f32| Material {
        kd: kd.into(),
        ks: Vec3::splat(ks),
        ns,
        ..Material::default()
    };
    Scene {
        name: "light".into(),
        mesh,
        materials: vec![
            material([0.5, 0.4, 0.3], 0.0, 0.0),
            Material { ke: Vec3::new(0.0, 0.1, 0.0), ..material([0.2, 0.5, 0.7], 0.3, 7.0) },
            material([0.6, 0.3, 0.5], 0.8, 30.0),
        ],
        camera: CameraDescription {
            eye: Vec3::new(0.5, 4.0, 1.5),
            at: Vec3::new(-0.2, 0.0, 0.0),
            up: Vec3::Y,
            fov_deg: 55.0,
        },
        lights: vec![light],
        ambient: Vec3::new(0.05, 0.06, 0.07),
        background: Vec3::new(0.2, 0.3, 0.4),
        size: SIZE,
        ..Scene::default()
    }
}

fn lights() -> [(&'static str, Light); 4] {
    let position = Vec3::new(1.2, 2.5, 0.3);
    let intensity = Vec3::new(1.0, 0.8, 0.6);
    [
        ("point", Light::Point { position, intensity, falloff: Falloff::None }),
        ("fading point", Light::Point { position, intensity, falloff: Falloff::InverseSquare }),
        ("directional", Light::Directional { direction: Vec3::new(-0.4, -0.8, 0.2).normalize(), intensity }),
        (
            "spot",
            Light::Spot {
                position,
                direction: Vec3::new(-0.45, -0.9, -0.1).normalize(),
                intensity,
                falloff: Falloff::None,
                inner: 0.3,
                outer: 0.6,
            },
        ),
    ]
}

fn film(scene: &Scene, isa: Option<Isa>, kernel: KernelChoice, tile: u32) -> (Film, String) {
    let options = RenderOptions { isa, kernel, threads: Some(2), tile, size: SIZE, ..RENDER };
    let mut rendered = render(scene, &options, &Control::unattended()).expect("renders");
    assert_eq!(rendered.nan, None);
    (rendered.film, rendered.frames.remove(0).image_sha256)
}

/// Unit direction to the light, its distance, and the strength that would arrive.
fn arriving(light: &Light, point: DVec3) -> (DVec3, f64, f64) {
    let to = |position: Vec3| (position.as_dvec3() - point, (position.as_dvec3() - point).length());
    let fade = |falloff, distance: f64| if falloff == Falloff::None { 1.0 } else { distance.powi(-2) };
    match *light {
        Light::Directional { direction, .. } => (-direction.as_dvec3(), f64::INFINITY, 1.0),
        Light::Point { position, falloff, .. } => {
            let (d, distance) = to(position);
            (d / distance, distance, fade(falloff, distance))
        }
        Light::Spot { position, direction, falloff, inner, outer, .. } => {
            let (d, distance) = to(position);
            let cosine = -direction.as_dvec3().dot(d) / distance;
            let [inner, outer] = [inner, outer].map(|angle| f64::from(angle).cos());
            let ramp = ((cosine - outer) / (inner - outer)).clamp(0.0, 1.0);
            (d / distance, distance, fade(falloff, distance) * ramp * ramp * (3.0 - 2.0 * ramp))
        }
    }
}

/// Colour seen along `dir`, and whether the light reaches the surface there.
fn reference(scene: &Scene, dir: Vec3) -> (DVec3, bool) {
    let mesh = &scene.mesh;
    let trace = |org: DVec3, dir: DVec3, tfar: f64, skip: u32| -> Hit {
        let [org, dir] = [org, dir].map(|v| v.as_vec3().to_array());
        brute_force(mesh, &Ray { org, dir, tnear: 0.0, tfar: tfar as f32, skip })
    };
    let eye = scene.camera.eye.as_dvec3();
    let hit = trace(eye, dir.as_dvec3(), f64::INFINITY, MISS);
    if hit.prim == MISS {
        return (scene.background.as_dvec3(), false);
    }
    let prim = hit.prim as usize;
    let view = -dir.as_dvec3().normalize();
    let point = eye + f64::from(hit.t) * dir.as_dvec3();
    let [a, b, c] = mesh.corners(prim).map(|v| v.as_dvec3());
    let towards = |n: DVec3, side: DVec3| if n.dot(side) < 0.0 { -n } else { n };
    let ng = towards((b - a).cross(c - a).normalize(), view);
    let [u, v] = [hit.u, hit.v].map(f64::from);
    let [na, nb, nc] = mesh.triangles[prim].map(|i| mesh.normals[i as usize].as_dvec3());
    let smooth = (na * (1.0 - u - v) + nb * u + nc * v).normalize_or_zero();
    let n = if smooth == DVec3::ZERO { ng } else { towards(smooth, ng) };

    let material = &scene.materials[mesh.materials[prim] as usize];
    let [kd, ks] = [material.kd, material.ks].map(|k| k.as_dvec3());
    let mut color = material.ke.as_dvec3() + kd * scene.ambient.as_dvec3();
    let light = &scene.lights[0];
    let (Light::Point { intensity, .. }
    | Light::Directional { intensity, .. }
    | Light::Spot { intensity, .. }) = *light;
    let (l, distance, strength) = arriving(light, point);
    let lit = ng.dot(l) > 0.0 && trace(point, l, distance, hit.prim).prim == MISS;
    if lit {
        let cosine = n.dot(l).max(0.0);
        let half = (l + view).normalize();
        let gloss = if cosine > 0.0 { n.dot(half).max(0.0).powf(f64::from(material.ns)) } else { 0.0 };
        color += strength * intensity.as_dvec3() * (kd * cosine + ks * gloss);
    }
    (color, lit)
}

#[test]
fn every_pixel_is_what_the_reference_says() {
    for (name, light) in lights() {
        let scene = scene(light);
        let camera = Camera::new(&scene.camera, SIZE[0], SIZE[1]);
        let (film, _) = film(&scene, None, KernelChoice::Tile, 32);
        let (mut lit, mut wrong) = (0, Vec::new());
        for (i, got) in film.pixels().enumerate() {
            let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
            let (want, reached) = reference(&scene, camera.direction(x, y));
            lit += usize::from(reached);
            let got = Vec3::from(got).as_dvec3();
            if (got - want).abs().max_element() > 2.0e-4 {
                wrong.push((x, y, got, want));
            }
        }
        // Where a shadow's edge runs through the centre of a pixel, f32 may decide otherwise.
        assert!(wrong.len() <= 3, "{name}: {} pixels, such as {:?}", wrong.len(), &wrong[..4]);
        let all = film.pixels().len();
        assert!(lit > all / 10 && lit < all * 9 / 10, "{name}: {lit} of {all} lit: the test proves little");
    }
}

#[test]
fn every_kind_of_light_has_one_image() {
    for (name, light) in lights() {
        let scene = scene(light);
        let want = film(&scene, None, KernelChoice::Tile, 64).1;
        for isa in Isa::available() {
            for kernel in KernelChoice::ALL {
                for tile in [16, 23] {
                    assert_eq!(
                        film(&scene, Some(isa), kernel, tile).1,
                        want,
                        "{name}, {isa}, {kernel}, {tile}"
                    );
                }
            }
        }
    }
}
