use super::*;
use crate::scene::Part;
use glam::DMat3;

const ABOUT_Z: DMat3 = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);

fn key(time: f64, rotation: DMat3, translation: DVec3) -> Key {
    Key { time, rotation, translation }
}

/// A scene of two triangles, of which the second moves.
fn scene(shapes: &[Shape], rate: f64, keys: &[Key]) -> Scene {
    let still = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = TriangleMesh {
        positions: still.into_iter().chain(shapes[0].positions.iter().copied()).collect(),
        normals: vec![Vec3::Z; 6],
        triangles: vec![[0, 1, 2], [3, 4, 5]],
        materials: vec![0; 2],
        parts: vec![Part { name: "all".into(), first: 0, count: 2 }],
        ..TriangleMesh::default()
    };
    let track = Track { vertices: 3..6, shapes: shapes.to_vec(), rate, keys: keys.to_vec() };
    let scene = Scene { mesh, motion: Some(Motion { tracks: vec![track] }), ..Scene::default() };
    scene.check().unwrap();
    scene
}

fn shape(at: Vec3, normal: Vec3) -> Shape {
    Shape { positions: [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p + at).into(), normals: vec![normal; 3] }
}

/// The first moving vertex and its normal at a time.
fn at(scene: &mut Scene, time: f64) -> (Vec3, Vec3) {
    scene.pose(time);
    assert_eq!(scene.mesh.positions[..3], [Vec3::ZERO, Vec3::X, Vec3::Y], "the other triangle stays");
    (scene.mesh.positions[3], scene.mesh.normals[3])
}

#[test]
fn shapes_follow_each_other_in_straight_lines() {
    let shapes = [shape(Vec3::X, Vec3::Z), shape(3.0 * Vec3::X, Vec3::X), shape(Vec3::Y, Vec3::ZERO)];
    let mut scene = scene(&shapes, 2.0, &[]);
    let halfway = Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt());
    for (time, place, normal) in [
        (0.0, Vec3::X, Vec3::Z),
        (0.125, 1.5 * Vec3::X, Vec3::new(1.0, 0.0, 3.0).normalize()),
        (0.25, 2.0 * Vec3::X, halfway),
        (0.5, 3.0 * Vec3::X, Vec3::X),
        (0.75, Vec3::new(1.5, 0.5, 0.0), Vec3::ZERO),
        (1.0, Vec3::Y, Vec3::ZERO),
        (-1.0, Vec3::X, Vec3::Z),
        (7.0, Vec3::Y, Vec3::ZERO),
    ] {
        let (found, lit) = at(&mut scene, time);
        assert_eq!(found, place, "at {time}");
        assert!(lit.distance(normal) < 1e-7, "at {time}: {lit}");
    }
    let motion = scene.motion.unwrap();
    assert_eq!((motion.length(), motion.rate()), (1.0, 2.0));
    assert_eq!(motion.moments(3.0).len(), 4);
    assert_eq!(motion.moments(0.4), [0.0]);
}

#[test]
fn keys_turn_along_the_shorter_way_and_then_move() {
    let keys = [key(1.0, DMat3::IDENTITY, DVec3::ZERO), key(3.0, ABOUT_Z, 2.0 * DVec3::Z)];
    let mut scene = scene(&[shape(Vec3::X, Vec3::X)], 24.0, &keys);
    let turned = |degrees: f32| Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
    let (quarter, eighth) = (turned(22.5), turned(45.0));
    for (time, place, normal) in [
        (0.0, Vec3::X, Vec3::X),
        (1.0, Vec3::X, Vec3::X),
        (1.5, quarter + 0.5 * Vec3::Z, quarter),
        (2.0, eighth + Vec3::Z, eighth),
        (3.0, Vec3::new(0.0, 1.0, 2.0), Vec3::Y),
        (9.0, Vec3::new(0.0, 1.0, 2.0), Vec3::Y),
    ] {
        let (found, lit) = at(&mut scene, time);
        assert!(found.distance(place) < 1e-6 && lit.distance(normal) < 1e-6, "at {time}: {found} {lit}");
        // At a key, and wherever nothing turns, walls stay exactly upright.
        assert!(time == 1.5 || time == 2.0 || found == place, "at {time}: {found}");
    }
    let motion = scene.motion.unwrap();
    assert_eq!((motion.length(), motion.rate()), (3.0, DEFAULT_RATE));
}

#[test]
fn a_moment_of_a_file_is_that_file_bit_by_bit() {
    // Thirds, at a rate for which times are not exact (24 is a sum of two powers of two, for which they are).
    let shapes: Vec<Shape> =
        (0..200).map(|i| shape(Vec3::splat((i * i) as f32 / 3.0), Vec3::new(0.6, 0.8, 0.0))).collect();
    let rate = 49.0;
    let mut scene = scene(&shapes, rate, &[]);
    let inexact = (0..200).filter(|&i| (f64::from(i) / rate) * rate < f64::from(i)).count();
    assert!(inexact > 0);
    let moments = scene.motion.as_ref().unwrap().moments(rate);
    assert_eq!(moments.len(), 200);
    for (time, shape) in moments.into_iter().zip(&shapes) {
        assert_eq!(at(&mut scene, time), (shape.positions[0], shape.normals[0]), "at {time}");
    }
}

#[test]
fn where_something_is_does_not_depend_on_where_it_was() {
    let keys = [key(0.0, DMat3::IDENTITY, DVec3::ZERO), key(1.0, ABOUT_Z, DVec3::splat(0.3))];
    let mut scene = scene(&[shape(Vec3::X, Vec3::X), shape(Vec3::splat(0.7), Vec3::Y)], 1.3, &keys);
    let first = at(&mut scene, 0.37);
    for time in [0.1, 0.9, 0.2, 0.37] {
        scene.pose(time);
    }
    assert_eq!((scene.mesh.positions[3], scene.mesh.normals[3]), first);
}

#[test]
fn motion_that_does_not_fit_is_found() {
    let good = scene(&[shape(Vec3::X, Vec3::X)], 24.0, &[key(0.0, DMat3::IDENTITY, DVec3::ZERO)]);
    let found = |spoil: fn(&mut Motion)| {
        let mut scene = good.clone();
        spoil(scene.motion.as_mut().unwrap());
        scene.check().unwrap_err().to_string()
    };
    for (expected, spoil) in [
        ("vertices that do not exist", (|motion| motion.tracks[0].vertices = 3..7) as fn(&mut Motion)),
        ("vertices of another one", |motion| motion.tracks.push(motion.tracks[0].clone())),
        ("no shape", |motion| motion.tracks[0].shapes.clear()),
        ("a shape with other vertices", |motion| motion.tracks[0].shapes[0].positions.truncate(2)),
        ("not finite", |motion| motion.tracks[0].shapes[0].positions[1].y = f32::NAN),
        ("not finite", |motion| motion.tracks[0].shapes[0].normals[1].y = f32::NAN),
        ("a rate", |motion| motion.tracks[0].rate = 0.0),
        ("order of time", |motion| motion.tracks[0].keys.push(key(0.0, DMat3::IDENTITY, DVec3::X))),
        ("range of coordinates", |motion| motion.tracks[0].keys[0].translation.x = 2.0e18),
    ] {
        let message = found(spoil);
        assert!(message.contains(expected), "{expected}: {message}");
    }
}
