//! `irt inspect`, `irt scenes`, and scenes that cannot be read.

use super::{Folder, OBJ, TOML, folder_with_scenes};
use serde_json::Value;
use std::fs;

#[test]
fn inspect_tells_what_is_in_a_scene() {
    let folder = folder_with_scenes();
    let text = folder.run("inspect square.toml --export-json a.json");
    for word in
        ["square", "duplicates", "bounds", "materials", "lights", "camera", "effects", "SAH cost", "depth"]
    {
        assert!(text.contains(word), "{word} in {text}");
    }
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!(json["triangles"], 3);
    assert_eq!(json["duplicates"], 1);
    assert_eq!(json["degenerate_dropped"], 1);
    assert_eq!(json["bounds_max"], serde_json::json!([1.0, 1.0, 0.0]));
    assert_eq!(json["lights"][0]["kind"], "point");
    assert_eq!(json["camera"]["fov_deg"], 30.0);
    assert_eq!(json["tree"]["triangles"], 3);
    for field in ["sah_cost", "depth", "block_fill", "bytes", "build_seconds"] {
        assert!(json["tree"][field].as_f64().unwrap() > 0.0, "{field}");
    }
}

#[test]
fn inspect_tells_why_effects_are_simulated_and_what_they_cost() {
    let folder = folder_with_scenes();
    let text = folder.run("inspect square.toml --export-json a.json");
    assert!(text.contains("+ hard-shadows") && text.contains("- refraction"), "{text}");
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    let reasons = json["reasons"].as_array().unwrap();
    let called = reasons.iter().filter(|reason| reason["called"] == true).map(|reason| &reason["effect"]);
    assert_eq!(called.collect::<Vec<_>>(), json["effects"].as_array().unwrap().iter().collect::<Vec<_>>());
    assert!(reasons.iter().all(|reason| !reason["why"].as_str().unwrap().is_empty()));
    let text =
        folder.run("inspect square.toml --price --size 16x12 --rounds 2 --threads 1 --export-json p.json");
    assert!(text.contains("without hard-shadows") && text.contains("16x12"), "{text}");
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("p.json")).unwrap()).unwrap();
    assert_eq!(json["general"]["changed"], 0.0);
    let prices = json["prices"].as_array().unwrap();
    assert!(prices.iter().any(|price| price["effect"] == "hard-shadows"), "{json}");
    assert!(prices.iter().all(|price| price["seconds"].as_array().unwrap().len() == 2), "{json}");
}

#[test]
fn scenes_lists_built_in_and_described_ones() {
    let folder = Folder::new();
    let text = folder.run("scenes");
    assert!(text.contains("atrium") && text.contains("built-in"), "{text}");
    fs::create_dir(folder.path().join("scenes")).unwrap();
    fs::write(folder.path().join("scenes/square.toml"), TOML).unwrap();
    let listed = || -> Value {
        let list: Value = serde_json::from_str(&folder.run("scenes --export-json -")).unwrap();
        list.as_array().unwrap().iter().find(|scene| scene["scene"] == "square").unwrap().clone()
    };
    assert_eq!(listed()["usable"], false);
    assert!(listed()["about"].as_str().unwrap().contains("square.obj is not in"));
    let message = folder.fail("render square", 2);
    assert!(message.contains("square.obj") && message.contains("IRT_SCENES"), "{message}");
    fs::write(folder.path().join("scenes/square.obj"), OBJ).unwrap();
    assert_eq!(listed()["usable"], true);
    folder.run("render square -q");
    folder.run("scenes --export-csv a.csv --export-markdown a.md");
    assert!(
        fs::read_to_string(folder.path().join("a.csv")).unwrap().starts_with("scene,kind,usable,about\n")
    );
    assert!(folder.fail("scenes --export-csv - --export-json -", 2).starts_with("--export-"));
}

#[test]
fn an_unreadable_scene_is_answered_with_the_file_and_exit_code_2() {
    let folder = Folder::new();
    fs::write(folder.path().join("a.obj"), "v 0 0 0\nv 1 x 0\nf 1 2 3\n").unwrap();
    fs::write(folder.path().join("a.toml"), "name = \n").unwrap();
    fs::write(folder.path().join("a.txt"), "").unwrap();
    for scene in ["a.obj", "a.toml", "a.txt", "none.obj", "none.toml", "nonsense", "atrium@0"] {
        for command in ["render", "inspect"] {
            let message = folder.fail(&format!("{command} {scene}"), 2);
            assert!(message.contains(scene.trim_end_matches("@0")), "{command} {scene}: {message}");
        }
    }
    let output = folder.irt("render").arg("").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().starts_with("irt: SCENE: the name is empty; "));
    assert_eq!(folder.names(), ["a.obj", "a.toml", "a.txt"]);
}
