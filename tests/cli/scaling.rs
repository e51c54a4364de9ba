//! `irt scaling`.

use super::{Folder, folder_with_scenes};
use serde_json::Value;
use std::fs;

const SMALL: &str = "scaling atrium@0.1 --size 64x48 --tile 16 --rounds 2";

fn rows(text: &str) -> Vec<Value> {
    serde_json::from_str::<Value>(text).unwrap().as_array().unwrap().clone()
}

#[test]
fn scaling_exports_the_documented_json_and_marks_what_is_simulated() {
    let folder = Folder::new();
    let rows = rows(&folder.run(&format!("{SMALL} --workers 1,1000 --export-json -")));
    // Eight strategies, two film modes, two numbers of workers.
    assert_eq!(rows.len(), 8 * 2 * 2);
    for row in &rows {
        assert_eq!(row["scene"], "atrium");
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"));
        assert!(number("fps") > 0.0 && number("efficiency") > 0.0);
        assert!(row["strategy"].is_string() && row["film"].is_string());
        let workers = row["workers"].as_u64().unwrap();
        assert_eq!(row["simulated"], workers == 1000, "{row}");
        assert_eq!(row["idle"].as_array().unwrap().len() as u64, workers);
        // The built-in scene is none of the thesis'.
        assert!(row["thesis_fps"].is_null() && row["thesis_efficiency"].is_null());
        assert_eq!(row["predicted_efficiency"].is_null(), workers == 1000);
        // Four for each worker, at most 64 of them simulated; one worker renders half of a round at a time.
        assert_eq!(row["frames"], if workers == 1 { 4 } else { 64 });
        assert_eq!(number("inflation"), 1.0, "against itself, and where nothing else was given");
        assert_eq!(number("scheduling_efficiency"), number("efficiency"));
        if workers == 1 {
            assert_eq!(number("efficiency"), 1.0);
        } else {
            // 12 tiles, cut to 16x16 at least, of each of two frames in flight are all the work there is.
            assert!(number("efficiency") <= 0.025, "{row}");
        }
    }
}

#[test]
fn scaling_says_how_frames_followed_each_other_and_inflation_is_obeyed() {
    let folder = Folder::new();
    let few = format!("{SMALL} --workers 4 --strategies dynamic --films shared");
    for (flags, told) in [
        (
            "--frames 3 --in-flight 1",
            "single frames, 3 for each worker, each begun when the one before was complete",
        ),
        ("", "streams of 4 frames for each worker, 2 of them in flight"),
        ("--frames 1 --in-flight 9", "streams of 1 frames for each worker, 9 of them in flight"),
    ] {
        let text = folder.run(&format!("{few} {flags}"));
        assert!(text.contains(told), "{flags}: {text}");
    }
    let few = format!("{SMALL} --workers 4 --strategies stealing --films shared");
    let rows = rows(&folder.run(&format!("{few} --inflation 1.5 --export-json -")));
    let many = rows.iter().find(|row| row["workers"] == 4 && row["simulated"] == true);
    // Where the machine has four cores, nothing is simulated.
    if let Some(row) = many {
        assert_eq!(row["inflation"], 1.5);
    }
}

#[test]
fn scaling_tells_tables_and_writes_pictures() {
    let folder = Folder::new();
    let text = folder.run(&format!(
        "{SMALL} --workers 1,1024 --strategies dynamic,stealing --films shared --pictures p --export-csv a.csv"
    ));
    for word in
        ["atrium, shared", "dynamic", "stealing", "1024 *", "simulated", "limited by", "us per empty tile"]
    {
        assert!(text.contains(word), "{word} in {text}");
    }
    for strategy in ["dynamic", "stealing"] {
        for run in ["1", "1024-simulated"] {
            let read = |ending: &str| {
                fs::read(folder.path().join(format!("p/atrium-{strategy}-shared-{run}.{ending}"))).unwrap()
            };
            assert!(read("svg").starts_with(b"<svg"));
            assert!(read("png").starts_with(b"\x89PNG"));
            let trace: Value = serde_json::from_slice(&read("trace.json")).unwrap();
            assert!(trace.as_array().unwrap().iter().all(|event| event["ph"] == "X"));
        }
    }
    assert!(
        fs::read_to_string(folder.path().join("a.csv")).unwrap().starts_with("scene,strategy,film,workers,")
    );
}

#[test]
fn scenes_of_the_thesis_have_its_figures_beside_them() {
    let folder = folder_with_scenes();
    fs::create_dir(folder.path().join("thesis")).unwrap();
    for file in ["square.obj", "square.toml"] {
        let name = file.replace("square.toml", "bunny.toml");
        fs::rename(folder.path().join(file), folder.path().join("thesis").join(name)).unwrap();
    }
    let flags =
        "--size 16x16 --tile 16 --rounds 1 --workers 1,16,1000 --strategies dynamic,stealing --films shared";
    let text = folder.run(&format!("scaling thesis/bunny.toml {flags} --export-json a.json"));
    assert!(text.contains("15.50 92.4 %"), "16 workers in table 2: {text}");
    let rows = rows(&fs::read_to_string(folder.path().join("a.json")).unwrap());
    let of = |strategy: &str, workers: u64| {
        let row = rows.iter().find(|row| row["strategy"] == strategy && row["workers"] == workers).unwrap();
        (row["thesis_fps"].as_f64(), row["thesis_efficiency"].as_f64())
    };
    assert_eq!(of("dynamic", 1), (Some(1.0482), None));
    assert_eq!(of("dynamic", 16), (Some(15.4969), Some(0.924_054)));
    assert_eq!([of("dynamic", 1000), of("stealing", 16)], [(None, None); 2]);
}

#[test]
fn scaling_compares_sizes_of_tiles() {
    let folder = Folder::new();
    let rows = rows(&folder.run(&format!("{SMALL} --tiles --workers 1,1000 --export-json -")));
    assert_eq!(rows.len(), 3 * 2, "sides 16, 32 and 64 by two numbers of workers");
    for workers in [1, 1000] {
        let group: Vec<&Value> = rows.iter().filter(|row| row["workers"] == workers).collect();
        assert_eq!(group.iter().filter(|row| row["best"] == true).count(), 1);
        assert!(group.iter().filter(|row| row["by_rule"] == true).count() <= 1);
        assert!(group.iter().all(|row| row["simulated"] == (workers == 1000)));
    }
}

#[test]
fn mistakes_are_told_by_flag() {
    let folder = Folder::new();
    for (flags, named) in [
        ("--workers 0", "--workers"),
        ("--workers 1025", "--workers"),
        ("--strategies eager", "--strategies"),
        ("--films paper", "--films"),
        ("--network 10", "--network"),
        ("--network 0,10", "--network"),
        ("--rounds 0", "--rounds"),
        ("--frames 0", "--frames"),
        ("--in-flight 0", "--in-flight"),
        ("--inflation 0.5", "--inflation"),
        ("--inflation NaN", "--inflation"),
        ("--tiles --inflation 2", "--tiles"),
        ("--tiles --pictures p", "--tiles"),
        ("--tiles --network 10,10", "--tiles"),
        ("--tiles --strategies static,dynamic", "--strategies"),
        ("--tiles --films shared,messages", "--films"),
    ] {
        let message = folder.fail(&format!("scaling {flags}"), 2);
        assert!(message.starts_with(&format!("{named}: ")), "{flags}: {message}");
        assert_eq!(folder.names(), [""; 0], "{flags}");
    }
}
