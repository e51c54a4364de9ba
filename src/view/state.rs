//! What the viewer shows and how: everything that events change.

use super::{
    clock::Clock,
    event::{Button, Event},
    overlay::Overlay,
    rig::{Rig, RigMode},
    setting::{Now, Setting},
};
use crate::{
    effects::{EffectSet, Reasons},
    render::{RenderOptions, Tone},
    scene::{MAX_PIXELS, MAX_SIDE, Scene},
    schedule::Machine,
};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Duration;

/// Turning by keys, radians per second.
const TURN: f32 = 1.0;
/// Radians per pixel of a dragged mouse.
const DRAG: f32 = 0.005;
/// Longest step of a held key: after a pause nobody wants to jump.
const LONGEST_STEP: f32 = 0.25;

/// What a frame is made of.
#[derive(Clone, Debug)]
pub struct State {
    /// The camera.
    pub rig: Rig,
    /// How to render; the size is that of the picture.
    pub options: RenderOptions,
    /// The moment of a scene that moves.
    pub clock: Clock,
    /// Effects that the scene calls for.
    called: EffectSet,
    /// From linear colours to the screen.
    pub tone: Tone,
    /// How long a frame may take while the camera moves.
    pub frame_time: Duration,
    /// Stops by which the picture is brightened.
    pub exposure: f32,
    /// What is laid over the picture.
    pub overlay: Overlay,
    /// At rest, pixels that differ from others get more samples.
    pub antialiasing: bool,
    /// Files that the next image at rest is written to.
    pub screenshots: Vec<PathBuf>,
    /// Somebody wants to be told when the image is at rest.
    pub settling: bool,
    held: BTreeSet<String>,
}

/// What events have changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// The picture is no longer that of the state.
    pub picture: bool,
    /// Workers and canvas must be made anew.
    pub engine: bool,
    /// The viewer ends.
    pub quit: bool,
}

impl State {
    /// The scene as it is described.
    pub fn new(scene: &Scene, options: &RenderOptions, frame_time: Duration) -> State {
        let bounds = scene.mesh.bounds();
        let diagonal = (bounds.max - bounds.min).length();
        State {
            rig: Rig::new(scene.camera, diagonal),
            options: *options,
            clock: Clock::new(scene.motion.as_ref()),
            called: Reasons::new(scene).set(),
            tone: Tone::new(0.0),
            frame_time,
            exposure: 0.0,
            overlay: Overlay::None,
            antialiasing: false,
            screenshots: vec![],
            settling: false,
            held: BTreeSet::new(),
        }
    }

    /// Takes an event in.
    pub fn apply(&mut self, event: &Event, change: &mut Change) {
        let (camera, time) = (self.rig.camera, self.clock.time);
        match event {
            Event::Press(key) => {
                self.held.insert(key.clone());
            }
            Event::Release(key) => {
                self.held.remove(key);
            }
            Event::ReleaseAll => self.held.clear(),
            Event::Settle => {
                self.held.clear();
                self.clock.play(false);
                self.settling = true;
            }
            Event::Drag(Button::Left, [x, y]) => self.rig.turn(x * DRAG, -y * DRAG),
            Event::Drag(Button::Right, [x, y]) => self.rig.pan(*x, *y, self.options.size[1]),
            Event::Wheel(steps) => self.rig.wheel(*steps),
            Event::Screenshot(path) => self.screenshots.push(path.clone()),
            Event::Reset => self.rig.reset(),
            Event::Resize(size) => {
                let [width, height] = size.map(|side| side.clamp(1, MAX_SIDE));
                let fits = u64::from(width) * u64::from(height) <= MAX_PIXELS;
                if fits && self.options.size != [width, height] {
                    self.options.size = [width, height];
                    change.engine = true;
                }
            }
            Event::Set(setting) => self.set(*setting, change),
            Event::Cycle(mode) => {
                let next = mode.next(&self.now());
                self.set(next, change);
            }
            Event::Step(ahead) => self.clock.step(*ahead),
            Event::Brighten(stops) => {
                let exposure = (self.exposure + stops).clamp(-50.0, 50.0);
                self.set(Setting::Exposure(exposure), change);
            }
            Event::Quit => change.quit = true,
        }
        change.picture |= change.engine || camera != self.rig.camera || time != self.clock.time;
    }

    fn now(&self) -> Now<'_> {
        Now {
            options: &self.options,
            fly: self.rig.mode == RigMode::Fly,
            overlay: self.overlay,
            antialiasing: self.antialiasing,
            playing: self.clock.playing,
            cores: Machine::get().default_workers(),
            called: self.called,
        }
    }

    fn set(&mut self, setting: Setting, change: &mut Change) {
        match setting {
            Setting::Exposure(stops) => {
                (self.tone, self.exposure) = (Tone::new(stops), stops);
                change.picture = true;
            }
            Setting::Fov(degrees) => self.rig.camera.fov_deg = degrees,
            Setting::Fly(fly) => self.rig.mode = if fly { RigMode::Fly } else { RigMode::Orbit },
            Setting::FrameTime(time) => self.frame_time = time,
            Setting::Overlay(overlay) => self.overlay = overlay,
            Setting::AntiAliasing(on) => self.antialiasing = on,
            Setting::Time(time) => self.clock.set(time),
            Setting::Play(playing) => self.clock.play(playing),
            other => change.engine |= other.apply(&mut self.options),
        }
    }

    /// Moves the camera by the keys that are held, and all that moves by itself, for this many seconds; true if anything
    /// has moved.
    pub fn advance(&mut self, seconds: f32) -> bool {
        let (camera, time) = (self.rig.camera, self.clock.time);
        let seconds = seconds.clamp(0.0, LONGEST_STEP);
        self.clock.advance(seconds.into());
        let axis = |more: &str, less: &str| {
            f32::from(u8::from(self.held.contains(more))) - f32::from(u8::from(self.held.contains(less)))
        };
        let fast = if self.held.contains("shift") { 4.0 } else { 1.0 };
        let step = self.rig.speed * fast * seconds;
        let travel = [axis("d", "a"), axis("e", "q"), axis("w", "s")];
        let turn = [axis("right", "left"), axis("up", "down")];
        if travel != [0.0; 3] {
            let [right, up, ahead] = travel.map(|axis| axis * step);
            self.rig.travel(right, up, ahead);
        }
        if turn != [0.0; 2] {
            let [right, up] = turn.map(|axis| axis * TURN * seconds);
            self.rig.turn(right, up);
        }
        camera != self.rig.camera || time != self.clock.time
    }

    /// The overlay of a picture that was just begun: maps of what rays do come when it rests.
    pub fn laid(&self) -> Overlay {
        if self.overlay.needs_map() { Overlay::None } else { self.overlay }
    }

    /// A key that moves the camera is held, or time passes.
    pub fn moving(&self) -> bool {
        const KEYS: [&str; 10] = ["w", "s", "a", "d", "q", "e", "left", "right", "up", "down"];
        self.clock.playing || KEYS.iter().any(|&key| self.held.contains(key))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scene::{Motion, Shape, Track, procedural},
        view::setting::NAMES,
    };

    fn state() -> State {
        let scene = procedural::build("atrium", 0.1).expect("a built-in scene");
        State::new(&scene, &super::super::tests::OPTIONS, Duration::from_millis(33))
    }

    fn changed(state: &mut State, event: Event) -> Change {
        let mut change = Change::default();
        state.apply(&event, &mut change);
        change
    }

    #[test]
    fn held_keys_move_the_camera_until_they_are_let_go() {
        let mut state = state();
        let home = state.rig.camera;
        assert!(!state.advance(1.0));
        changed(&mut state, Event::Press("w".into()));
        assert!(state.moving() && state.advance(0.1));
        let near = state.rig.camera.eye.distance(home.eye);
        assert!((near / (0.1 * state.rig.speed) - 1.0).abs() < 1e-3);
        changed(&mut state, Event::Press("s".into()));
        assert!(!state.advance(0.1), "opposite keys hold each other");
        for end in [Event::Release("w".into()), Event::ReleaseAll] {
            changed(&mut state, end);
        }
        assert!(!state.moving() && !state.advance(0.1));
        assert!(changed(&mut state, Event::Reset).picture);
        assert_eq!(state.rig.camera, home);
    }

    #[test]
    fn every_mode_can_be_switched_and_says_what_it_takes() {
        let values = [
            ("order", "morton"),
            ("schedule", "static"),
            ("film", "messages"),
            ("threads", "1"),
            ("pin", "on"),
            ("isa", "scalar"),
            ("visibility", "fast"),
            ("kernel", "single"),
            ("early-termination", "none"),
            ("tile", "32"),
            ("exposure", "1.5"),
            ("fov", "20"),
            ("camera", "fly"),
            ("frame-time", "50"),
            ("overlay", "steps"),
            ("anti-aliasing", "on"),
            ("effects", "without=hard-shadows"),
            ("time", "0.5"),
            ("motion", "play"),
        ];
        assert_eq!(values.map(|(name, _)| name), NAMES.map(|(name, _)| name));
        for (name, value) in values {
            let mut state = state();
            let shape = Shape { positions: vec![], normals: vec![] };
            let track = Track { vertices: 0..0, shapes: vec![shape.clone(), shape], rate: 1.0, keys: vec![] };
            state.clock = Clock::new(Some(&Motion { tracks: vec![track] }));
            let before = format!("{state:?}");
            let setting = Setting::parse(name, value).unwrap();
            let change = changed(&mut state, Event::Set(setting));
            assert_ne!(format!("{state:?}"), before, "{name}");
            // What concerns the workers makes them anew, once.
            let ours =
                ["exposure", "fov", "camera", "frame-time", "overlay", "anti-aliasing", "time", "motion"];
            let engine = !ours.contains(&name);
            assert_eq!(
                (change.engine, change.picture),
                (engine, engine || ["exposure", "fov", "time"].contains(&name)),
                "{name}"
            );
            assert!(!changed(&mut state, Event::Set(setting)).engine, "{name}");
            let message = Setting::parse(name, "nonsense").unwrap_err();
            assert!(message.starts_with("'nonsense' is no value of"), "{message}");
        }
        assert!(Setting::parse("colour", "red").unwrap_err().contains("use one of: order, "));
    }

    #[test]
    fn no_size_is_too_odd() {
        let mut state = state();
        assert_eq!(
            changed(&mut state, Event::Resize([0, 0])),
            Change { engine: true, picture: true, quit: false }
        );
        assert_eq!(state.options.size, [1, 1]);
        changed(&mut state, Event::Resize([u32::MAX, u32::MAX]));
        assert_eq!(state.options.size, [1, 1], "too many pixels are refused");
        assert_eq!(changed(&mut state, Event::Resize([1, 1])), Change::default());
    }
}
