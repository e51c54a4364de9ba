//! Moving scenes: `irt render` to numbered images, and what `irt scenes` and `irt inspect` say of them.

use super::Folder;
use serde_json::Value;
use std::fs;

/// A tetrahedron that rises in front of a wall, in three files.
fn folder() -> Folder {
    let folder = Folder::new();
    for (number, y) in [0.0, 0.2, 0.5].into_iter().enumerate() {
        let text = format!(
            "v -3 -3 -1\nv 3 -3 -1\nv 0 5 -1\nv 0 {y} 0\nv 1 {y} 0\nv 0 {y} 1\nv 0 {} 0\n\
             f 1 2 3\nf 4 6 5\nf 4 5 7\nf 5 6 7\nf 6 4 7\n",
            y + 1.0
        );
        fs::write(folder.path().join(format!("a{number}.obj")), text).unwrap();
    }
    let toml = "size = [40, 30]\n[[mesh]]\nfile = \"a%d.obj\"\nframes = [0, 2]\nfps = 10\n\
                [camera]\neye = [1, 2, 5]\nat = [0, 0.5, 0]\nfov = 40\n";
    fs::create_dir(folder.path().join("scenes")).unwrap();
    fs::write(folder.path().join("scenes/rise.toml"), toml.replace("a%d", "../a%d")).unwrap();
    folder
}

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.path().join(name)).unwrap()).unwrap()
}

#[test]
fn all_of_the_motion_becomes_numbered_images_like_those_of_its_moments() {
    let folder = folder();
    let text = folder.run("render rise -o out%03d.png --export-json a.json --threads 1 --no-pin");
    for word in ["3 of 0.200 s, 10 per second", "1 built", "2 refitted", "SAH"] {
        assert!(text.contains(word), "{word} in {text}");
    }
    let moments = json(&folder, "a.json")["moments"].as_array().unwrap().clone();
    assert_eq!(moments.len(), 3);
    for (number, moment) in moments.iter().enumerate() {
        assert_eq!(moment["file"], format!("out{number:03}.png"));
        folder.run(&format!("render rise --time {} -o one.png --export-json b.json -q", moment["time"]));
        assert_eq!(json(&folder, "b.json")["frames"][0]["image_sha256"], moment["image_sha256"], "{number}");
        let same = |a: &str, b: &str| {
            fs::read(folder.path().join(a)).unwrap() == fs::read(folder.path().join(b)).unwrap()
        };
        assert!(same("one.png", &format!("out{number:03}.png")), "{number}");
    }
    assert_ne!(moments[0]["image_sha256"], moments[1]["image_sha256"]);
    // Twice as many a second: every second one is one of those.
    folder.run("render rise -o twice%d.pfm --fps 20 --export-json c.json -q");
    let twice = json(&folder, "c.json")["moments"].as_array().unwrap().clone();
    assert_eq!(twice.len(), 5);
    assert!((0..3).all(|i| twice[2 * i]["image_sha256"] == moments[i]["image_sha256"]));
}

#[test]
fn mistakes_with_moving_scenes_name_flag_and_remedy() {
    let folder = folder();
    for (line, expected) in [
        ("render rise -o a%d.png --time 1", "--time: a numbered --output takes all"),
        ("render rise -o a%d.png --frames 2", "--frames: it repeats one image"),
        ("render rise -o a%d.png --tev 127.0.0.1:1", "--tev: it shows one image"),
        ("render rise --fps 3", "--fps: it belongs to numbered images"),
        ("render rise --fps 0 -o a%d.png", "--fps: '0' is no rate"),
        ("render rise --time -1", "--time: '-1' is no moment"),
        ("render atrium@0.1 --time 1", "--time: nothing moves in the scene atrium"),
        ("render atrium@0.1 -o a%d.png", "--output: nothing moves in the scene atrium"),
        ("render rise -o none/a%d.png", "none/a0.png: "),
    ] {
        let message = folder.fail(line, 2);
        assert!(message.starts_with(expected), "{line}: {message}");
    }
    assert_eq!(folder.names(), ["a0.obj", "a1.obj", "a2.obj", "scenes"]);
}

#[test]
fn scenes_and_inspect_tell_of_motion_and_of_the_frame_that_is_missing() {
    let folder = folder();
    let text = folder.run("inspect rise --export-json a.json");
    assert!(text.contains("motion     0.200 s") && text.contains("3 shapes, 10 per second"), "{text}");
    assert_eq!(json(&folder, "a.json")["motion"]["length"], 0.2);
    let listed = || folder.run("scenes --export-csv -");
    assert!(listed().contains("scenes/../a0.obj") && !listed().contains("a2.obj"), "{}", listed());
    fs::remove_file(folder.path().join("a2.obj")).unwrap();
    let missing = listed();
    assert!(missing.contains("a2.obj is not in"), "{missing}");
    let message = folder.fail("render rise", 2);
    assert!(message.contains("a2.obj` was not found"), "{message}");
}
