//! `irt view --script`.

use super::Folder;
use serde_json::Value;
use std::fs;

const SCRIPT: &str = "0 rest\n0 press w\n0.2 drag left 20 3\n0.3 rest # then home\n0 reset\n0 rest\n";
const VIEW: &str = "view atrium@0.1 --size 120x90 --build fast --threads 2 --no-pin --script a.txt";

#[test]
fn a_script_is_reported_frame_by_frame_and_ends_at_the_image_of_a_render() {
    let folder = Folder::new();
    fs::write(folder.path().join("a.txt"), SCRIPT).unwrap();
    let text = folder.run(&format!("{VIEW} --export-json a.json --record frames"));
    for word in ["atrium", "120x90", "moving", "in time", "latency", "traced", "rest 3"] {
        assert!(text.contains(word), "{word} in {text}");
    }
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    let frames = json["frames"].as_array().unwrap();
    let moving = frames.iter().skip(1).filter(|frame| frame["moved"] == true).count();
    assert_eq!(json["moving_frames"], moving);
    assert!(moving > 0 && frames.iter().all(|frame| frame["share"].as_f64().unwrap() > 0.0));
    assert_eq!(fs::read_dir(folder.path().join("frames")).unwrap().count(), frames.len());
    folder.run("render atrium@0.1 --size 120x90 --build fast -q --export-json b.json");
    let render: Value = serde_json::from_slice(&fs::read(folder.path().join("b.json")).unwrap()).unwrap();
    let hashes = json["image_sha256"].as_array().unwrap();
    assert_eq!((hashes.len(), &hashes[0], &hashes[2]), (3, &render["frames"][0]["image_sha256"], &hashes[0]));
    assert_ne!(hashes[0], hashes[1]);
}

#[test]
fn mistakes_are_answered_with_the_line_or_flag() {
    let folder = Folder::new();
    let missing = folder.fail(VIEW, 2);
    assert!(missing.starts_with("a.txt: cannot be read"), "{missing}");
    fs::write(folder.path().join("a.txt"), "0 rest\n0 hop\n").unwrap();
    let message = folder.fail(VIEW, 2);
    assert!(message.starts_with("a.txt:2: 'hop' is no deed") && message.contains("press KEY"), "{message}");
    let message = folder.fail(&format!("{VIEW} --frame-time 0"), 2);
    assert!(message.starts_with("--frame-time: "), "{message}");
}

#[test]
fn without_a_display_or_a_terminal_that_is_told() {
    let folder = Folder::new();
    let output = folder
        .irt("view atrium@0.1 --size 60x40")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .assert()
        .code(1)
        .get_output()
        .clone();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.starts_with("irt: no window can be opened") && message.contains("set DISPLAY"),
        "{message}"
    );
    assert!(folder.fail("view atrium@0.1 --terminal", 2).starts_with("--terminal: "));
    let message = folder.fail("view atrium@0.1 --record x", 2);
    assert!(message.contains("--script"), "{message}");
}

#[test]
fn a_viewer_that_is_not_there_is_told_before_the_work() {
    let folder = Folder::new();
    let message = folder.fail("render atrium@0.1 --size 20x20 --tev 127.0.0.1:1", 2);
    assert!(message.starts_with("--tev: 127.0.0.1:1 cannot be reached"), "{message}");
    assert!(folder.names().is_empty());
}
