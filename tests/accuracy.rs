//! Accuracy against time, as the library offers it: the reference against the exact oracle, and promises that are kept.

use crate::support::{RENDER, Random, brute_force, soup, sphere};
use glam::{DVec3, Quat, Vec3};
use irt::{
    kernels::{MISS, Ray},
    render::{RenderOptions, render},
    scene::{CameraDescription, Scene, load},
    schedule::Control,
    study::accuracy::{
        Wish, choose,
        compare::Picture,
        error_of, prices,
        reference::{Line, Reference},
    },
};
use std::path::Path;

fn line(ray: &Ray) -> Line {
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let skip = (ray.skip != MISS).then_some(ray.skip);
    Line { org: wide(ray.org), dir: wide(ray.dir), end: f64::from(ray.tfar), skip }
}

/// Rays from the origin, so that relative vertices are the vertices and nothing is rounded: there the reference and the
/// kernels' contract mean the same.
#[test]
fn the_reference_agrees_with_the_exact_oracle_and_with_itself_without_a_tree() {
    let mut hits = 0;
    for (seed, mesh) in [(1, soup(7, 300, 0.4)), (2, soup(8, 40, 2.0)), (3, sphere(Vec3::ZERO, 1.0, 12))] {
        let reference = Reference::new(&mesh);
        let mut random = Random(seed);
        for i in 0..1500 {
            // Many of them straight at a vertex or the middle of an edge.
            let [a, b, _] = mesh.corners(random.below(mesh.len()));
            let dir = [random.vec(), a, 0.5 * (a + b)][i % 3];
            let skip = if i % 5 == 0 { random.below(mesh.len()) as u32 } else { MISS };
            let tfar = if i % 4 == 0 { 0.9 } else { f32::INFINITY };
            let ray = Ray { org: [0.0; 3], dir: dir.to_array(), tnear: 0.0, tfar, skip };
            let (oracle, line) = (brute_force(&mesh, &ray), line(&ray));
            let found = reference.intersect(&line);
            assert_eq!(found, reference.intersect_all(&line), "{ray:?}");
            assert_eq!(reference.occluded(&line), found.is_some(), "{ray:?}");
            match found {
                None => assert_eq!(oracle.prim, MISS, "{ray:?}"),
                Some(hit) => {
                    hits += 1;
                    let off = (hit.at.t - f64::from(oracle.t)).abs();
                    assert!(off <= 1e-6 * hit.at.t, "{hit:?} {oracle:?}");
                    // Another triangle only at the same depth.
                    let other = (hit.prim != oracle.prim).then(|| reference.crossing(oracle.prim, &line));
                    if let Some(other) = other {
                        let other = other.expect("the oracle's triangle is hit");
                        assert!((other.t - hit.at.t).abs() <= 1e-11 * hit.at.t, "{hit:?} {oracle:?}");
                    }
                }
            }
        }
    }
    assert!(hits > 2000, "{hits}");
}

/// Cameras that nothing was measured from.
fn held_back(camera: &CameraDescription) -> [CameraDescription; 3] {
    let CameraDescription { eye, at, up, .. } = *camera;
    let turn = |degrees: f32| Quat::from_axis_angle(up, f32::to_radians(degrees));
    [
        CameraDescription { eye: at + turn(-13.0) * (eye - at), ..*camera },
        CameraDescription { at: eye + turn(17.0) * (at - eye), ..*camera },
        CameraDescription { eye: at + 0.8 * (eye - at), ..*camera },
    ]
}

#[test]
fn promised_errors_are_kept_from_cameras_that_nothing_was_measured_from() {
    let effects = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/effects/soft-shadows.toml");
    let soft = effects.to_str().unwrap();
    for (name, size, errors) in [("atrium@0.1", [48, 36], [0.15, 0.05]), (soft, [24, 18], [0.2, 0.1])] {
        let scene = load(name).unwrap();
        let options = RenderOptions { size, tile: 16, ..RENDER };
        let prices = prices(&scene, &options, &Control::unattended(), &|_| {}).unwrap();
        for error in errors {
            let wish = Wish { error: Some(error), seconds: None, size, frames: 1 };
            let choice = choose(&prices, &scene, &options, &wish).unwrap();
            for camera in held_back(&scene.camera) {
                let view = Scene { camera, ..scene.clone() };
                let chosen = choice.modes.iter().fold((view.clone(), options), |(view, options), mode| {
                    (mode.scene(&view).into_owned(), mode.options(&options))
                });
                let rendered = render(&chosen.0, &chosen.1, &Control::unattended()).unwrap();
                let picture = Picture::of(&rendered.film);
                let (off, noise) = error_of(&picture, &view, &options, 128).unwrap();
                assert!(off <= error + noise, "{name}: {off} instead of {error} with {:?}", choice.modes);
            }
        }
    }
}
