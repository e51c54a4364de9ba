//! Trees over triangles that move, and their images: those of a tree that was built there.

use crate::support::{RENDER, Random, mesh_of, soup, sphere};
use glam::{DMat3, DVec3, Vec3};
use irt::{
    bvh::{BuildPreset, Bvh, Update, WORN},
    kernels::Isa,
    render::{RenderOptions, animate, render},
    scene::{Falloff, Key, Light, Motion, Scene, Shape, Track, TriangleMesh, procedural},
    schedule::Control,
};

/// Every vertex is moved by up to `by`.
fn shaken(mesh: &TriangleMesh, by: f32, seed: u64) -> TriangleMesh {
    let (mut random, mut mesh) = (Random(seed), mesh.clone());
    mesh.positions.iter_mut().for_each(|position| *position += by * random.vec());
    mesh
}

#[test]
fn a_refitted_tree_keeps_every_promise() {
    let large = sphere(Vec3::ZERO, 1.0, 90);
    for (name, mesh) in [
        ("none", soup(1, 0, 0.1)),
        ("few", soup(2, 5, 0.1)),
        ("many", soup(3, 3000, 0.1)),
        ("a sphere", large),
    ] {
        for preset in BuildPreset::ALL {
            let mut bvh = Bvh::build(&mesh, preset).unwrap();
            let cost = bvh.sah_cost();
            for (moment, by) in [0.01, 0.5, 100.0, 1.0e-6].into_iter().enumerate() {
                let moved = shaken(&mesh, by, moment as u64);
                bvh.refit(&moved);
                bvh.validate(&moved).unwrap_or_else(|e| panic!("{name}, {preset}, moved by {by}: {e}"));
            }
            bvh.refit(&mesh);
            bvh.validate(&mesh).unwrap();
            let again = bvh.sah_cost();
            assert!(
                (again - cost).abs() <= 1e-12 * cost,
                "{name}, {preset}: {again} is not {cost}: boxes are not tight"
            );
        }
    }
}

#[test]
fn refitted_boxes_are_as_tight_as_built_ones() {
    // Far off the old place, nothing of it may be left in the boxes.
    let mesh = soup(4, 2000, 0.1);
    let mut bvh = Bvh::build(&mesh, BuildPreset::Medium).unwrap();
    let cost = bvh.sah_cost();
    let mut away = mesh.clone();
    away.positions.iter_mut().for_each(|position| *position = 2.0 * *position + 64.0 * Vec3::X);
    bvh.refit(&away);
    // Twice the size: the same cost but for the rounding of places.
    assert!((bvh.sah_cost() / cost - 1.0).abs() < 1e-3, "{} and {cost}", bvh.sah_cost());
}

#[test]
fn a_worn_tree_is_built_anew_and_another_one_is_kept() {
    let mesh = soup(5, 3000, 0.02);
    let mut bvh = Bvh::build(&mesh, BuildPreset::Medium).unwrap();
    let fresh = bvh.sah_cost();
    assert_eq!(bvh.follow(&shaken(&mesh, 0.002, 1), BuildPreset::Medium).unwrap(), Update::Refitted);
    // Little by little, it wears out: what counts is the cost of the build, not that of the moment before.
    let (mut by, mut before) = (0.002, fresh);
    let moved = loop {
        by *= 1.3;
        let moved = shaken(&mesh, by, 1);
        if bvh.follow(&moved, BuildPreset::Medium).unwrap() == Update::Rebuilt {
            break moved;
        }
        assert!(bvh.sah_cost() <= WORN * fresh && by < 1.0, "moved by {by}: {} of {fresh}", bvh.sah_cost());
        before = before.max(bvh.sah_cost());
    };
    assert!(before > 1.02 * fresh, "it was kept while it became worse");
    let built = Bvh::build(&moved, BuildPreset::Medium).unwrap();
    assert_eq!(bvh.sah_cost(), built.sah_cost());
    bvh.validate(&moved).unwrap();
    // From now on the new cost counts.
    assert_eq!(bvh.follow(&moved, BuildPreset::Medium).unwrap(), Update::Refitted);
}

/// A ball whose vertices move each for itself and a square that turns, above a floor.
fn scene() -> Scene {
    let ball = sphere(Vec3::new(0.0, 1.0, 0.0), 1.0, 24);
    let shapes: Vec<Shape> =
        (0..3).map(|seed| Shape { positions: shaken(&ball, 0.1, seed).positions, normals: vec![] }).collect();
    let square = [Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 0.0, 2.0), Vec3::new(1.0, 1.0, 2.0)];
    let floor = [Vec3::new(-9.0, 0.0, -9.0), Vec3::new(9.0, 0.0, 9.0), Vec3::new(9.0, 0.0, -9.0)];
    let corners: Vec<[Vec3; 3]> =
        (0..ball.len()).map(|prim| ball.corners(prim)).chain([square, floor]).collect();
    let mesh = mesh_of(&corners);
    let vertices = ball.positions.len();
    let turn = DMat3::from_rotation_y(2.0);
    let keys = vec![
        Key { time: 0.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO },
        Key { time: 0.9, rotation: turn, translation: DVec3::Y },
    ];
    let still = Shape { positions: square.to_vec(), normals: vec![] };
    let tracks = vec![
        Track { vertices: 0..vertices, shapes, rate: 2.0, keys: vec![] },
        Track { vertices: vertices..vertices + 3, shapes: vec![still], rate: 24.0, keys },
    ];
    let position = Vec3::new(4.0, 6.0, 5.0);
    Scene {
        name: "moving".into(),
        mesh,
        lights: vec![Light::Point { position, intensity: Vec3::ONE, falloff: Falloff::None }],
        motion: Some(Motion { tracks }),
        camera: irt::scene::CameraDescription { eye: Vec3::new(2.0, 3.0, 7.0), ..Scene::default().camera },
        ..Scene::default()
    }
}

/// Hashes and updates of the moments, and the hashes of scenes that were never anywhere else.
fn hashes(
    scene: &Scene,
    options: &RenderOptions,
    moments: &[f64],
) -> (Vec<String>, Vec<Option<Update>>, Vec<String>) {
    let (mut moving, mut got, mut updates) = (scene.clone(), vec![], vec![]);
    animate(&mut moving, options, moments, &Control::unattended(), &mut |number, moment, film| {
        assert_eq!((number, film.sha256()), (got.len(), moment.frame.image_sha256.clone()));
        got.push(film.sha256());
        updates.push(moment.update);
        Ok(())
    })
    .unwrap();
    let alone = moments.iter().map(|&time| {
        let mut scene = scene.clone();
        scene.pose(time);
        scene.motion = None;
        render(&scene, &RENDER, &Control::unattended()).unwrap().film.sha256()
    });
    (got, updates, alone.collect())
}

#[test]
fn every_moment_has_the_image_of_a_scene_that_was_never_at_another() {
    let scene = scene();
    let moments = [0.0, 0.3, 1.0, 0.5, 0.0];
    for isa in Isa::available() {
        let options = RenderOptions { isa: Some(isa), threads: Some(2), ..RENDER };
        let (got, updates, alone) = hashes(&scene, &options, &moments);
        assert_eq!(got, alone, "{isa}");
        assert!(updates[0].is_none() && updates[1..].contains(&Some(Update::Refitted)), "{updates:?}");
        assert!(got[1] != got[0] && got[2] != got[1] && got[4] == got[0], "{isa}");
    }
}

#[test]
fn what_follows_light_follows_what_moves() {
    // Glass, mirrors, textures and lamps among the triangles of the gallery, all of which move.
    let mut scene = procedural::build("gallery", 0.2).unwrap();
    scene.settings.light_samples = 1;
    scene.settings.samples = 1;
    scene.settings.emitters = true;
    let positions = scene.mesh.positions.clone();
    let moved = positions.iter().map(|p| *p + 0.1 * (3.0 * p.y).sin() * Vec3::X).collect();
    let shape = |positions| Shape { positions, normals: scene.mesh.normals.clone() };
    let track = Track {
        vertices: 0..positions.len(),
        shapes: vec![shape(positions.clone()), shape(moved)],
        rate: 1.0,
        keys: vec![],
    };
    scene.motion = Some(Motion { tracks: vec![track] });
    let options = RenderOptions { size: [75, 50], ..RENDER };
    let (got, _, _) = hashes(&scene, &options, &[0.0, 1.0, 0.0]);
    let mut there = scene.clone();
    there.pose(1.0);
    let alone = render(&there, &options, &Control::unattended()).unwrap().film.sha256();
    assert!(got[1] == alone && got[0] == got[2] && got[0] != got[1]);
}
