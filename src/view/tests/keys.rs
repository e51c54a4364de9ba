//! What each key does, from the hand to what the renderer is told.

use super::*;
use crate::{scene::CameraDescription, view::state::Change};

fn state() -> State {
    State::new(&motion::swaying(), &OPTIONS, Duration::from_millis(33))
}

/// The user's side and the renderer's, one after the other.
fn pressed(ui: &mut Ui, state: &mut State, key: &str) -> Vec<Wish> {
    let wishes = ui.key(key, true);
    for wish in &wishes {
        if let Wish::Send(event) = wish {
            state.apply(event, &mut Change::default());
        }
    }
    wishes
}

#[test]
fn keys_that_are_held_move_the_camera_where_they_say() {
    let home = state().rig.camera;
    let ahead = (home.at - home.eye).normalize();
    let right = ahead.cross(home.up).normalize();
    let up = right.cross(ahead);
    let moved = |key: &str, more: &str| {
        let (mut ui, mut state) = (Ui::default(), state());
        // Turns are seen best where the camera stays.
        pressed(&mut ui, &mut state, "o");
        [key, more]
            .iter()
            .filter(|key| !key.is_empty())
            .for_each(|key| drop(pressed(&mut ui, &mut state, key)));
        assert!(state.moving() && state.advance(0.1), "{key}");
        let there = state.rig.camera;
        ui.key(key, false).into_iter().for_each(|wish| {
            let Wish::Send(event) = wish else { panic!("{wish:?}") };
            state.apply(&event, &mut Change::default());
        });
        assert!(!state.moving() && !state.advance(0.1), "{key} is let go");
        there
    };
    let view = |camera: CameraDescription| (camera.at - camera.eye).normalize();
    for (key, way) in [("w", ahead), ("s", -ahead), ("d", right), ("a", -right), ("e", up), ("q", -up)] {
        let camera = moved(key, "");
        let step = camera.eye - home.eye;
        assert!(step.normalize().dot(way) > 0.999 && (view(camera) - ahead).length() < 1e-4, "{key}");
        let fast = moved(key, "shift").eye - home.eye;
        assert!((fast.length() / step.length() - 4.0).abs() < 0.01, "shift {key}");
    }
    for (key, way) in [("right", right), ("left", -right), ("up", up), ("down", -up)] {
        let camera = moved(key, "");
        let turn = view(camera) - ahead;
        assert!(camera.eye == home.eye && turn.normalize().dot(way) > 0.9, "{key}");
    }
}

#[test]
fn every_other_key_does_what_the_help_says() {
    for (key, command, _) in BINDINGS {
        let (mut ui, mut state) = (Ui::default(), state());
        state.rig.wheel(1.0);
        state.clock.set(0.5);
        let before = (state.exposure, state.clock.time, state.rig.camera);
        let wishes = pressed(&mut ui, &mut state, key);
        let after = (state.exposure, state.clock.time, state.rig.camera);
        let unchanged = before == after;
        match command {
            Command::Hold => assert!(unchanged && wishes == [Wish::Send(Event::Press(key.into()))]),
            Command::Cycle(mode) => assert_eq!(wishes, [Wish::Send(Event::Cycle(mode))]),
            Command::Help => {
                assert!(ui.help && wishes == [Wish::Redraw], "{key}");
                pressed(&mut ui, &mut state, key);
                assert!(!ui.help, "{key}");
            }
            Command::Figures => {
                assert!(ui.show_figures && wishes == [Wish::Redraw]);
                pressed(&mut ui, &mut state, key);
                assert!(!ui.show_figures);
            }
            Command::Difference => {
                assert!(ui.difference && wishes == [Wish::Redraw]);
                pressed(&mut ui, &mut state, key);
                assert!(!ui.difference);
            }
            Command::Freeze => assert!(ui.note.is_some() && wishes == [Wish::Redraw]),
            Command::Reset => assert_eq!(state.rig.camera, motion::swaying().camera),
            Command::Screenshot => {
                let names: Vec<_> = state.screenshots.iter().map(|path| path.extension().unwrap()).collect();
                assert_eq!(names, ["exr", "png"]);
            }
            // Nothing to copy before the first picture; then see the test of what is copied.
            Command::CopyToml | Command::CopyFlags => assert_eq!(wishes, []),
            Command::Brighter(more) => assert_eq!(state.exposure, if more { 0.5 } else { -0.5 }, "{key}"),
            Command::Step(ahead) => {
                assert_eq!((state.clock.time, state.clock.playing), (if ahead { 1.0 } else { 0.0 }, false));
            }
            Command::FullScreen => assert_eq!(wishes, [Wish::FullScreen]),
            Command::Quit => assert_eq!(wishes, [Wish::Send(Event::Quit)]),
        }
        // Coming up, keys that are not held do nothing.
        assert!(command == Command::Hold || ui.key(key, false).is_empty(), "{key}");
    }
    let (mut ui, mut state) = (Ui::default(), state());
    for playing in [true, false] {
        pressed(&mut ui, &mut state, "space");
        assert_eq!(state.clock.playing, playing);
    }
}
