//! Scenes that move, and effects, by scripts.

use super::*;
use crate::scene::{Motion, Shape, Track};

/// All of a small scene sways; three shapes in a second.
pub(super) fn swaying() -> Scene {
    let mut scene = scene();
    let still = &scene.mesh.positions;
    let shape = |by: f32| Shape {
        positions: still.iter().map(|p| *p + by * p.y.sin() * glam::Vec3::X).collect(),
        normals: scene.mesh.normals.clone(),
    };
    let shapes = vec![shape(0.0), shape(0.4), shape(-0.2)];
    let track = Track { vertices: 0..still.len(), shapes, rate: 2.0, keys: vec![] };
    scene.motion = Some(Motion { tracks: vec![track] });
    scene
}

fn at(scene: &Scene, time: f64) -> Scene {
    let mut scene = scene.clone();
    scene.pose(time);
    scene
}

#[test]
fn every_picture_of_a_moving_scene_is_of_one_moment() {
    let scene = swaying();
    let options = RenderOptions { size: [75, 50], ..OPTIONS };
    // Time enough for all pixels of each picture.
    let frame_time = Duration::from_millis(300);
    let script = Script::parse("0 rest\n0 set motion play\n0.3 rest", Path::new("test")).unwrap();
    let mut seen = vec![];
    let played = play(&scene, &options, frame_time, &script, |_, picture, _| {
        let Frame { moment, share, .. } = &picture.frame;
        if *share == 1.0 && seen.len() < 5 {
            seen.push((moment.unwrap().time, picture.bytes()));
        }
        Ok(())
    })
    .unwrap();
    assert!(seen.len() > 2 && seen[0].0 == 0.0 && seen[2].0 > 0.0, "{} pictures", seen.len());
    for (time, bytes) in seen {
        let film = render(&at(&scene, time), &options, &Control::unattended()).unwrap().film;
        let whole: Vec<u8> = film.pixels().flatten().map(crate::math::linear_to_srgb8).collect();
        assert!(bytes == whole, "the picture at {time} s shows something else");
    }
    let times: Vec<f64> = played.frames.iter().map(|frame| frame.moment.unwrap().time).collect();
    assert!(times.iter().all(|time| (0.0..=1.0).contains(time)), "{times:?}");
    // Where it came to rest, it is the image of that moment.
    let end = at(&scene, times[times.len() - 1]);
    assert_eq!(played.hashes[1], hash(&end, &options));
    assert_ne!(played.hashes[0], played.hashes[1]);
    let updates = played.frames.iter().filter(|frame| frame.moment.unwrap().update.is_some());
    assert!(updates.count() > 1);
}

#[test]
fn time_can_be_set_and_goes_from_moment_to_moment() {
    let scene = swaying();
    let script = "0 set time 0.3\n0 rest\n0 press .\n0 rest\n0 press .\n0 press .\n0 rest\n0 press ,\n0 rest\n\
                  0 press space\n0.05 press space\n0.05 set time 0.3\n0.05 rest\n0 size 60x40\n0 rest";
    let played = played(&scene, script).unwrap();
    let expected: Vec<String> =
        [0.3, 0.5, 0.0, 1.0, 0.3].map(|time| hash(&at(&scene, time), &OPTIONS)).into();
    assert_eq!(played.hashes[..5], expected);
    let small = RenderOptions { size: [60, 40], ..OPTIONS };
    assert_eq!(played.hashes[5], hash(&at(&scene, 0.3), &small), "a new size keeps the moment");
}

#[test]
fn the_error_of_a_picture_is_that_at_its_own_moment() {
    let scene = swaying();
    let played = played(&scene, "0 rest\n0 set frame-time 1\n0 set motion play\n0.3 rest").unwrap();
    let own = errors(&scene, &OPTIONS, &played).unwrap();
    assert!(!own.is_empty());
    let mut elsewhere = played;
    for (_, picture) in &mut elsewhere.kept {
        let moment = picture.frame.moment.as_mut().unwrap();
        moment.time = 1.0 - 0.5 * moment.time;
    }
    let sum = |errors: &[(usize, f64)]| errors.iter().map(|(_, error)| error).sum::<f64>();
    assert!(sum(&own) < sum(&errors(&scene, &OPTIONS, &elsewhere).unwrap()));
}

#[test]
fn effects_are_switched_while_the_picture_is_there() {
    let scene = procedural::build("gallery", 0.1).unwrap();
    let options = RenderOptions { size: [30, 20], ..OPTIONS };
    let script = "0 rest\n0 press x\n0 rest\n0 press x\n0 rest\n0 set effects none\n0 rest\n0 set effects auto\n0 rest";
    let script = Script::parse(script, Path::new("test")).unwrap();
    let played = play(&scene, &options, Duration::from_millis(33), &script, |_, _, _| Ok(())).unwrap();
    let first = crate::effects::Reasons::new(&scene).set().iter().next().unwrap();
    let [whole, without, none] = ["auto", &format!("without={first}"), "none"]
        .map(|effects| hash(&scene, &RenderOptions { effects: effects.parse().unwrap(), ..options }));
    assert!(whole != without && without != none);
    assert_eq!(played.hashes, [whole.clone(), whole.clone(), without, none, whole]);
}
