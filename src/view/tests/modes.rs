//! Every value of every mode, and every key that goes through them, by scripts.

use super::*;
use crate::kernels::Isa;

/// Small, since every value makes workers anew.
const SMALL: RenderOptions = RenderOptions { size: [40, 27], ..OPTIONS };

/// What a mode is at, as far as a picture tells; by the name of the mode in scripts.
fn reading(name: &str, picture: &Picture) -> String {
    let Frame { options, exposure, camera, refined, .. } = &picture.frame;
    match name {
        "order" => options.order.to_string(),
        "schedule" => options.schedule.strategy.to_string(),
        "film" => options.schedule.film.to_string(),
        "threads" => options.threads.map_or("auto".into(), |threads| threads.to_string()),
        "pin" => if options.pin { "on" } else { "off" }.into(),
        "isa" => options.isa.map_or("auto".into(), |isa| isa.to_string()),
        "visibility" => options.visibility.to_string(),
        "kernel" => options.kernel.to_string(),
        "early-termination" => options.early.to_string(),
        "tile" => options.tile.to_string(),
        "exposure" => exposure.to_string(),
        "fov" => camera.fov_deg.to_string(),
        "overlay" => picture.overlay.name().into(),
        "anti-aliasing" => if refined.is_some() { "on" } else { "off" }.into(),
        "effects" => options.effects.to_string(),
        _ => panic!("{name} shows in no picture"),
    }
}

/// The modes that a picture tells of, with values for `set`, and whether the image at rest is the same by all of them.
fn values() -> Vec<(&'static str, Vec<&'static str>, bool)> {
    let isas = std::iter::once("auto").chain(Isa::available().map(Isa::name)).collect();
    let words = |text: &'static str| text.split(' ').collect();
    vec![
        ("order", words("scanline serpentine hilbert morton peano"), true),
        (
            "schedule",
            words("static static-cyclic dynamic overlap non-blocking refinement stealing cost-guided"),
            true,
        ),
        ("film", words("messages shared"), true),
        ("threads", words("1 2 3 auto"), true),
        ("pin", words("on off"), true),
        ("isa", isas, true),
        ("visibility", words("fast exact"), false),
        ("kernel", words("auto single tile"), true),
        (
            "early-termination",
            words("none pet-bound pet-seed set occ pet-bound,pet-seed,set,occ pet-bound,set,occ,area"),
            true,
        ),
        ("tile", words("1 16 33 256 1024"), true),
        ("exposure", words("-50 -1.5 0 50"), true),
        ("fov", words("1 20.5 179"), false),
        ("overlay", Overlay::ALL.map(Overlay::name).into(), true),
        ("anti-aliasing", words("on off"), true),
        ("effects", words("all none hard-shadows without=highlights auto"), false),
    ]
}

/// Plays a script; what `name` was at, one after the other, and the hashes.
fn readings(scene: &Scene, name: &str, script: &str) -> (Vec<String>, Vec<String>) {
    let (script, mut seen) = (Script::parse(script, Path::new("test")).unwrap(), vec![]);
    let played = play(scene, &SMALL, Duration::from_millis(33), &script, |_, picture, _| {
        seen.push(reading(name, picture));
        Ok(())
    });
    seen.dedup();
    (seen, played.unwrap().hashes)
}

#[test]
fn every_value_is_taken_and_changes_the_image_only_where_it_may() {
    let scene = scene();
    let home = hash(&scene, &SMALL);
    for (name, values, same) in values() {
        let sets: String = values.iter().map(|value| format!("0 set {name} {value}\n0 rest\n")).collect();
        let (mut seen, hashes) = readings(&scene, name, &format!("0 rest\n{sets}"));
        // What it was at first, unless the first value is just that.
        if seen[0] != values[0] {
            seen.remove(0);
        }
        assert_eq!(seen, values, "{name}");
        if same {
            assert_eq!(hashes, vec![home.clone(); values.len() + 1], "{name}");
        } else {
            assert!(name == "visibility" || hashes.iter().any(|hash| *hash != home), "{name}");
        }
    }
    // Those that do not show in a picture are tested by what they do: with the state, and with motion.
    let others = ["camera", "frame-time", "time", "motion"];
    for (name, _) in NAMES {
        let known = values().iter().any(|(known, ..)| *known == name);
        assert!(known != others.contains(&name), "{name} is tested nowhere");
    }
}

/// The mode that a key goes through, by its name for `set`, with the number of its values; `None` if no picture tells.
fn cycled(mode: Mode, scene: &Scene) -> Option<(&'static str, usize)> {
    let effects = 2 + crate::effects::Reasons::new(scene).set().iter().count();
    Some(match mode {
        Mode::Order => ("order", 5),
        Mode::Schedule => ("schedule", 8),
        Mode::Film => ("film", 2),
        Mode::Threads => ("threads", 1 + crate::schedule::Machine::get().default_workers()),
        Mode::Isa => ("isa", 1 + Isa::available().count()),
        Mode::Visibility => ("visibility", 2),
        Mode::Kernel => ("kernel", 3),
        Mode::Early => ("early-termination", 6),
        Mode::Tile => ("tile", 5),
        Mode::Pin => ("pin", 2),
        Mode::Overlay => ("overlay", 7),
        Mode::AntiAliasing => ("anti-aliasing", 2),
        Mode::Effects => ("effects", effects),
        Mode::Camera | Mode::Play => return None,
    })
}

#[test]
fn keys_go_through_all_values_and_back_to_the_first() {
    let scene = scene();
    let home = hash(&scene, &SMALL);
    for (key, command, _) in BINDINGS {
        let Command::Cycle(mode) = command else { continue };
        let Some((name, count)) = cycled(mode, &scene) else { continue };
        let presses = format!("0 press {key}\n0 release {key}\n0 rest\n").repeat(count);
        let (seen, hashes) = readings(&scene, name, &format!("0 set threads auto\n0 rest\n{presses}"));
        let seen = &seen[seen.len().saturating_sub(count + 1)..];
        let distinct: std::collections::BTreeSet<&String> = seen.iter().collect();
        assert_eq!((seen.len(), distinct.len()), (count + 1, count), "{key}: {seen:?}");
        assert_eq!(seen.first(), seen.last(), "{key}");
        assert_eq!(hashes.last(), Some(&home), "{key}");
        let same = values().iter().any(|(known, _, same)| *known == name && *same);
        assert!(!same || hashes.iter().all(|hash| *hash == home), "{key}");
    }
}

#[test]
fn the_camera_orbits_or_flies_by_its_key() {
    let mut scene = scene();
    let home = scene.camera;
    let turned = |scene: &Scene, keys: &str| {
        played(scene, &format!("{keys}0 drag left 30 0\n0 rest")).unwrap().frames.last().unwrap().camera
    };
    for keys in ["", "0 press o\n0 press o\n"] {
        let camera = turned(&scene, keys);
        assert!(camera.at == home.at && camera.eye != home.eye, "{keys}");
    }
    for keys in ["0 press o\n", "0 set camera fly\n"] {
        let camera = turned(&scene, keys);
        assert!(camera.at != home.at && camera.eye == home.eye, "{keys}");
        scene.camera = home;
    }
}
