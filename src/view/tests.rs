//! The viewer as a whole, driven by scripts.

use super::*;
use crate::{
    bvh::BuildPreset,
    error::Result,
    kernels::Visibility,
    render::{RenderOptions, render},
    scene::{Scene, procedural},
    schedule::{Control, Schedule},
    tile::Order,
    trace::{EarlyTermination, KernelChoice},
};
use std::path::Path;
use std::time::Duration;

mod end;
mod finer;
mod keys;
mod maps;
mod modes;
mod motion;
mod terminal;

/// A small picture, the plainest way.
pub(super) const OPTIONS: RenderOptions = RenderOptions {
    isa: None,
    kernel: KernelChoice::Auto,
    visibility: Visibility::Exact,
    threads: Some(2),
    pin: false,
    order: Order::Hilbert,
    schedule: Schedule {
        strategy: crate::schedule::Strategy::Stealing,
        film: crate::schedule::FilmMode::Shared,
    },
    tile: 64,
    size: [150, 101],
    frames: 1,
    build: BuildPreset::Fast,
    seed: 0,
    early: EarlyTermination::FASTEST,
    effects: crate::effects::EffectChoice::Auto,
};

fn scene() -> Scene {
    procedural::build("atrium", 0.1).expect("a built-in scene")
}

fn hash(scene: &Scene, options: &RenderOptions) -> String {
    render(scene, options, &Control::unattended()).unwrap().film.sha256()
}

fn played(scene: &Scene, script: &str) -> Result<Played> {
    let script = Script::parse(script, Path::new("test"))?;
    play(scene, &OPTIONS, Duration::from_millis(33), &script, |_, _, _| Ok(()))
}

#[test]
fn at_rest_the_image_is_that_of_a_plain_render() {
    let scene = scene();
    let script =
        "0 rest\n0 press w\n0.15 drag left 20 5\n0.2 release w\n0.2 reset\n0.25 rest\n0 size 64x33\n0 rest";
    let played = played(&scene, script).unwrap();
    let home = hash(&scene, &OPTIONS);
    let small = hash(&scene, &RenderOptions { size: [64, 33], ..OPTIONS });
    assert_eq!(played.hashes, [home.clone(), home, small]);
    assert!(played.frames.iter().filter(|frame| frame.moved).count() > 3);
    assert!(played.frames.iter().all(|frame| frame.share >= 1.0 / 16.0 && frame.end >= frame.start));
    // The press, the drag, the reset and the size were each shown for the first time by some frame.
    assert!(played.frames.iter().filter(|frame| frame.latency.is_some()).count() >= 4);
}

#[test]
fn where_the_camera_came_to_rest_a_plain_render_gives_the_same_image() {
    let mut scene = scene();
    let played =
        played(&scene, "0 set camera fly\n0 press w\n0.1 drag left 50 -20\n0.2 wheel 1\n0.2 rest").unwrap();
    scene.camera = played.frames.last().unwrap().camera;
    assert_eq!(played.hashes, [hash(&scene, &OPTIONS)]);
}

#[test]
fn a_held_key_moves_no_farther_than_there_was_time_for() {
    let scene = scene();
    let begin = std::time::Instant::now();
    let played = played(&scene, "0 rest\n0 press d\n0.4 release d\n0.4 rest").unwrap();
    let passed = begin.elapsed().as_secs_f32();
    let bounds = scene.mesh.bounds();
    // A tenth of the diagonal in a second.
    let way = played.frames.last().unwrap().camera.eye.distance(scene.camera.eye);
    assert!(way > 0.0 && way <= 0.1 * (bounds.max - bounds.min).length() * passed, "{way} in {passed} s");
}

#[test]
fn every_mode_renders_the_same_image_but_fast_visibility_may_not() {
    let scene = scene();
    let mut script = String::from("0 rest\n");
    let modes = [
        "order peano",
        "schedule static",
        "schedule cost-guided",
        "film messages",
        "threads 1",
        "threads 3",
        "pin on",
        "isa scalar",
        "isa auto",
        "kernel single",
        "kernel tile",
        "kernel auto",
        "early-termination none",
        "tile 16",
        "tile 100",
        "frame-time 5",
    ];
    modes.iter().for_each(|mode| script += &format!("0 set {mode}\n0 rest\n"));
    let played = played(&scene, &script).unwrap();
    assert_eq!(played.hashes, vec![hash(&scene, &OPTIONS); modes.len() + 1]);
}

#[test]
fn the_exposure_changes_what_is_shown_and_not_the_image() {
    let scene = scene();
    let script = Script::parse("0 rest\n0 set exposure 2\n0 rest", Path::new("test")).unwrap();
    let mut bright = vec![];
    let played = play(&scene, &OPTIONS, Duration::from_millis(33), &script, |_, picture, _| {
        bright.push(picture.bytes().iter().map(|&byte| u64::from(byte)).sum::<u64>());
        Ok(())
    })
    .unwrap();
    assert_eq!(played.hashes[0], played.hashes[1]);
    assert!(bright.last() > bright.first(), "{bright:?}");
}

#[test]
fn the_picture_at_rest_is_the_png_of_the_image() {
    let scene = scene();
    let folder = tempfile::tempdir().unwrap();
    let [exr, png] = ["a.exr", "a.png"].map(|name| folder.path().join(name));
    let text = format!("0 screenshot {}\n0 screenshot {}\n0 rest", exr.display(), png.display());
    let script = Script::parse(&text, Path::new("test")).unwrap();
    let mut last = vec![];
    play(&scene, &OPTIONS, Duration::from_millis(33), &script, |_, picture, _| {
        last = picture.bytes();
        Ok(())
    })
    .unwrap();
    let film = render(&scene, &OPTIONS, &Control::unattended()).unwrap().film;
    let bytes: Vec<u8> = film.pixels().flatten().map(crate::math::linear_to_srgb8).collect();
    assert!(last == bytes);
    // Read back by nobody here; that the files are whole is tested where they are written.
    assert!(exr.metadata().unwrap().len() > 1000 && png.metadata().unwrap().len() > 1000);
}

#[test]
fn a_script_that_makes_no_sense_is_refused_by_its_line() {
    for (line, expected) in [
        ("x press w", "'x' is no time"),
        ("-1 rest", "'-1' is no time"),
        ("1 fly", "'fly' is no deed"),
        ("1", "there is a time, but no deed"),
        ("0 size 0x5", "'0x5' is no size"),
        ("0 wheel inf", "'inf' is not a finite number"),
        ("0 set order spiral", "'spiral' is no value of order; give scanline"),
        ("0 drag middle 1 1", "'middle' is no button"),
        ("0 screenshot a.gif", "'.gif' is not an image format"),
    ] {
        let text = format!("# first\n1 wheel 1 # more\n{}", line.replace("0 ", "1 "));
        let message = Script::parse(&text, Path::new("s.txt")).unwrap_err().to_string();
        assert!(message.starts_with("s.txt:3: ") && message.contains(expected), "{message}");
    }
}

#[test]
fn any_sequence_of_events_ends_at_rest() {
    let deeds = [
        "press w",
        "press left",
        "press shift",
        "release w",
        "release-all",
        "drag left 30 -7",
        "drag right 1000 1e9",
        "wheel 3",
        "wheel -50",
        "wheel 1e30",
        "size 1x1",
        "size 90x70",
        "size 33x200",
        "set threads 1",
        "set threads 3",
        "set film messages",
        "set schedule dynamic",
        "set tile 1",
        "set tile 40",
        "set camera fly",
        "set effects all",
        "press x",
        "press g",
        "press f",
        "press tab",
        "press h",
        "press 8",
        "press 1",
        "press 6",
        "set overlay lanes",
        "set motion play",
        "set motion stop",
        "set time 0.7",
        "press .",
        "press ,",
        "set camera orbit",
        "set fov 179",
        "set exposure -50",
        "set frame-time 1",
        "set isa scalar",
        "reset",
        "press nothing",
        "drag left 1e38 1e38",
    ];
    let mut random = 12345u64;
    for scene in [scene(), motion::swaying()].iter().cycle().take(6) {
        let mut text = String::new();
        for i in 0..40 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            text += &format!("{} {}\n", f64::from(i) * 0.004, deeds[(random >> 33) as usize % deeds.len()]);
        }
        text += "0.2 rest\n0 quit\n0 press w";
        let played = played(scene, &text).unwrap();
        assert_eq!(played.hashes.len(), 1, "{text}");
        let frame = played.frames.last().unwrap();
        assert_eq!(frame.share, 1.0, "{text}");
    }
}

#[test]
fn the_summary_tells_frames_shares_and_errors() {
    let scene = scene();
    let played = played(&scene, "0 rest\n0 set frame-time 1\n0 press d\n0.2 rest").unwrap();
    let errors = errors(&scene, &OPTIONS, &played).unwrap();
    assert!(
        errors.len() <= 16 && errors.iter().all(|&(_, error)| (0.0..80.0).contains(&error)),
        "{errors:?}"
    );
    let summary = summarise(&scene, &OPTIONS, Duration::from_millis(33), &played, &errors);
    assert_eq!(summary.frames.len(), played.frames.len());
    assert!(summary.moving_frames > 1 && summary.share[0] > 0.0 && summary.share[0] <= summary.share[1]);
    assert!((0.0..=1.0).contains(&summary.in_time) && summary.fps > 0.0);
    assert!(summary.seconds.is_sorted(), "{:?}", summary.seconds);
    assert!(summary.to_string().contains("of the pixels"), "{summary}");
}

#[test]
fn a_renderer_that_fails_is_told_and_nobody_waits_for_it() {
    let mut scene = scene();
    scene.mesh.triangles[0][0] = u32::MAX;
    let message = played(&scene, "0 rest").unwrap_err().to_string();
    assert!(!message.contains("before the script"), "{message}");
}

/// The last picture of a script, as the window would show it.
fn shown(scene: &Scene, script: &str) -> Vec<u32> {
    let script = Script::parse(script, Path::new("test")).unwrap();
    let (mut pixels, mut last) = (vec![], None);
    play(scene, &OPTIONS, Duration::from_millis(33), &script, |_, picture, ui| {
        pixels = vec![0; picture.pixels.len()];
        ui.compose(picture, &mut Surface { size: picture.size, pixels: &mut pixels }, Scale::Small);
        last = Some(picture.size);
        Ok(())
    })
    .unwrap();
    assert!(last.is_some());
    pixels
}

#[test]
fn every_overlay_and_panel_is_laid_over_the_picture_and_taken_away_again() {
    let scene = scene();
    let plain = shown(&scene, "0 rest");
    let mut seen = vec![plain.clone()];
    for overlay in Overlay::ALL.into_iter().skip(1) {
        let picture = shown(&scene, &format!("0 rest\n0 set overlay {}\n0 rest", overlay.name()));
        assert!(!seen.contains(&picture), "{overlay:?} shows nothing of its own");
        seen.push(picture);
        let again = shown(
            &scene,
            &format!("0 rest\n0 set overlay {}\n0 rest\n0 set overlay none\n0 rest", overlay.name()),
        );
        assert!(again == plain, "{overlay:?} stays");
    }
    // A key that only the user's side knows shows with the next picture.
    for key in ["h", "i"] {
        let picture = shown(&scene, &format!("0 press {key}\n0 set exposure 1\n0 set exposure 0\n0 rest"));
        assert!(picture != plain, "{key}");
    }
    let through = shown(&scene, &"0 press tab\n0 release tab\n0 rest\n".repeat(Overlay::ALL.len()));
    assert!(through == plain, "the key goes through all overlays and back to none");
}

#[test]
fn a_frozen_picture_differs_by_what_was_switched_and_by_nothing_else() {
    let scene = scene();
    let frozen = "0 rest\n0 press f\n0 set tile 32\n0 rest\n0 press g\n";
    let dark = |pixels: &[u32]| pixels.iter().filter(|&&pixel| pixel == 0).count();
    let same = shown(&scene, &format!("{frozen}0 set order scanline\n0 rest"));
    let other = shown(&scene, &format!("{frozen}0 set exposure 1\n0 rest"));
    // All but the text is black: another order gives the same image.
    assert!(dark(&same) > same.len() / 3, "{}", dark(&same));
    assert!(dark(&other) < dark(&same), "{} {}", dark(&other), dark(&same));
}

#[test]
fn keys_copy_the_camera_in_a_form_that_irt_reads_again() {
    let scene = scene();
    let script = Script::parse("0 wheel 2\n0 drag left 31 17\n0 rest", Path::new("test")).unwrap();
    let mut copied = vec![];
    let played = play(&scene, &OPTIONS, Duration::from_millis(33), &script, |_, _, ui| {
        copied = ["c", "v"].map(|key| ui.key(key, true)).concat();
        Ok(())
    })
    .unwrap();
    let [Wish::Copy(toml), _, Wish::Copy(flags), _] = &copied[..] else { panic!("{copied:?}") };
    let camera = played.frames.last().unwrap().camera;
    let table: toml_camera::File = toml_camera::read(toml);
    assert_eq!((table.eye, table.at), (camera.eye.to_array(), camera.at.to_array()));
    let numbers: Vec<f32> = flags
        .split([' ', ','])
        .filter(|word| !word.starts_with("--"))
        .map(|word| word.parse().unwrap())
        .collect();
    let expected = [camera.eye.to_array(), camera.at.to_array(), camera.up.to_array()].concat();
    assert_eq!((&numbers[..9], numbers[9]), (&expected[..], camera.fov_deg));
}

/// The few lines of TOML that are copied, without the crate that another module owns.
mod toml_camera {
    pub(super) struct File {
        pub(super) eye: [f32; 3],
        pub(super) at: [f32; 3],
    }

    pub(super) fn read(text: &str) -> File {
        assert!(text.starts_with("[camera]\n"), "{text}");
        let vector = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(&format!("{name} = ["))).unwrap();
            let numbers: Vec<f32> =
                line.trim_end_matches(']').split(", ").map(|number| number.parse().unwrap()).collect();
            numbers.try_into().unwrap()
        };
        File { eye: vector("eye"), at: vector("at") }
    }
}
