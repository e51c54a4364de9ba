//! `irt coherence`.

use super::{Folder, folder_with_scenes};
use serde_json::Value;
use std::fs;

const SMALL: &str = "coherence atrium@0.1 --size 40x30";

#[test]
fn coherence_tells_the_tables_beside_the_thesis_and_writes_them_and_the_maps() {
    let folder = Folder::new();
    let text = folder.run(&format!(
        "{SMALL} --rounds 1 --maps maps --export-json a.json --export-csv a.csv --export-markdown a.md"
    ));
    for word in [
        "Table 1",
        "Tables 6 and 7",
        "Table 8",
        "Tables 9 and 10",
        "Where the time goes",
        "Caches",
        "Voorhies",
        "thesis",
        "peano",
    ] {
        assert!(text.contains(word), "{word} in {text}");
    }
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    let of = |table: &str, order: &str| -> Vec<Value> {
        let rows = json[table].as_array().unwrap();
        rows.iter().filter(|row| row["order"] == order).cloned().collect()
    };
    assert_eq!(of("table1", "hilbert")[0]["thesis same"], 45_645);
    assert_eq!(of("table9_10", "scanline").len(), 7);
    let all = &of("table9_10", "scanline")[6];
    assert_eq!(all["technique"], "SET-OCC-PET");
    assert_eq!(all["thesis gain %"], 84.5166);
    assert!(
        all["work gain %"].as_f64().unwrap() > 0.0 && all["gain %"].is_number() && all["fps"].is_number()
    );
    assert_eq!(of("caches", "morton").len(), 12);
    assert_eq!(json["scenes"][0]["image_sha256"].as_str().unwrap().len(), 64);
    for text in ["a.csv", "a.md"] {
        assert!(fs::read_to_string(folder.path().join(text)).unwrap().contains("Table 1: "), "{text}");
    }
    for order in ["scanline", "serpentine", "hilbert", "morton", "peano"] {
        for kind in ["primary", "shadow"] {
            let map = folder.path().join(format!("maps/atrium-{order}-40x30-{kind}.png"));
            assert!(fs::read(&map).unwrap().starts_with(b"\x89PNG"), "{}", map.display());
        }
    }
}

#[test]
fn counts_alone_are_the_same_on_every_run() {
    let folder = Folder::new();
    let run = || folder.run(&format!("{SMALL} -q --rounds 0 --orders hilbert --tile 8 --export-json -"));
    let first = run();
    assert_eq!(first, run());
    let json: Value = serde_json::from_str(&first).unwrap();
    assert!(json["table9_10"][0]["fps"].is_null(), "nothing was timed");
}

#[test]
fn the_sweep_finds_lines_and_draws_them() {
    let folder = folder_with_scenes();
    let line = "coherence square.toml --sweep --plots plots --export-json s.json -q";
    let text = folder.run(line);
    assert!(text.contains("hilbert over scanline") && text.contains("zero at"), "{text}");
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("s.json")).unwrap()).unwrap();
    // Three sizes, five orders, eight caches.
    assert_eq!(json["points"].as_array().unwrap().len(), 120);
    assert_eq!(fs::read_dir(folder.path().join("plots")).unwrap().count(), 7);
}

#[test]
fn early_termination_of_render_is_a_list_and_keeps_the_image() {
    let folder = Folder::new();
    let hash = |flag: &str| {
        let json = folder.run(&format!("render atrium@0.1 --size 50x40 -q -o x.png --export-json - {flag}"));
        serde_json::from_str::<Value>(&json).unwrap()["frames"][0]["image_sha256"].clone()
    };
    let want = hash("");
    for list in ["none", "pet-bound,pet-seed,set,occ,area", "set,area4"] {
        assert_eq!(hash(&format!("--early-termination {list}")), want, "{list}");
    }
    let message = folder.fail("render atrium@0.1 --early-termination pet", 2);
    assert!(message.starts_with("--early-termination: ") && message.contains("pet-bound"), "{message}");
    let message = folder.fail("render atrium@0.1 --kernel single --early-termination none", 2);
    assert!(message.starts_with("--early-termination: "), "{message}");
}

#[test]
fn mistakes_of_coherence_are_answered_in_a_sentence() {
    let folder = Folder::new();
    assert!(folder.fail("coherence nowhere", 2).contains("nowhere"));
    assert!(folder.fail("coherence --orders spiral", 2).contains("--orders"));
    fs::write(folder.path().join("file"), "").unwrap();
    assert!(folder.fail(&format!("{SMALL} --maps file"), 2).contains("file: "));
    folder.irt("coherence --sweep --size 10x10").assert().code(2);
}
