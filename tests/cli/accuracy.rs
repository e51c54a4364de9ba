//! `irt accuracy`.

use super::Folder;
use serde_json::Value;
use std::fs;

const SMALL: &str = "accuracy atrium@0.1 --quick --side 40 --converged 64 --rounds 1 --rays 20000";

fn rows<'a>(json: &'a Value, table: &str, mode: &str) -> Vec<&'a Value> {
    json[table].as_array().unwrap().iter().filter(|row| row["mode"] == mode).collect()
}

#[test]
fn accuracy_tells_times_and_errors_of_every_mode_and_writes_page_maps_and_tables() {
    let folder = Folder::new();
    let text = folder.run(&format!(
        "{SMALL} --report r.html --maps maps --export-json a.json --export-csv a.csv --export-markdown a.md"
    ));
    for word in ["visibility fast", "leaks per million", "Verdicts", "Left out", "no light has an extent"] {
        assert!(text.contains(word), "{word} in {text}");
    }
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    let number =
        |table: &str, mode: &str, column: &str| rows(&json, table, mode)[0][column].as_f64().unwrap();
    for same in ["default", "kernel single", "kernel tile", "tree slow"] {
        assert_eq!(rows(&json, "modes", same)[0]["same"], true, "{same}");
        assert_eq!(number("geometry", same, "errors"), 0.0, "{same}");
    }
    assert_eq!(number("geometry", "default", "leaks"), 0.0);
    assert!(number("geometry", "visibility fast", "leaks") > 0.0, "fast visibility leaks");
    assert!(number("geometry", "default", "shadows") > 0.0);
    let errors = ["samples 64", "samples 16", "samples 4", "default", "fill quarter", "fill sixteenth"]
        .map(|mode| number("modes", mode, "RMSE"));
    assert!(errors.is_sorted(), "{errors:?}");
    let best = number("modes", "samples 64", "FLIP");
    assert!(best < 0.5 * number("modes", "default", "FLIP") && number("modes", "samples 64", "SSIM") > 0.9);

    let page = fs::read_to_string(folder.path().join("r.html")).unwrap();
    for word in ["<svg", "data:image/png;base64,", "What accuracy costs", "samples 64", "Definitions"] {
        assert!(page.contains(word), "{word}");
    }
    for outside in ["src=\"http", "href=\"http", "<script", "<link"] {
        assert!(!page.contains(outside), "the page needs {outside}");
    }
    let map = fs::read(folder.path().join("maps/atrium-fill-quarter.png")).unwrap();
    assert!(map.starts_with(b"\x89PNG"));
    assert!(!folder.path().join("maps/atrium-tree-slow.png").exists(), "it differs nowhere");
    for text in ["a.csv", "a.md"] {
        assert!(fs::read_to_string(folder.path().join(text)).unwrap().contains("visibility fast"), "{text}");
    }
}

#[test]
fn errors_are_the_same_on_every_run() {
    let folder = Folder::new();
    let run = |threads: u32| {
        let json = folder.run(&format!("{SMALL} -q --threads {threads} --export-json -"));
        let mut json: Value = serde_json::from_str(&json).unwrap();
        for row in json["modes"].as_array_mut().unwrap() {
            for time in ["ms", "ratio", "from", "to", "rounds", "Mrays/s", "front"] {
                assert!(!row[time].is_null(), "{time} of {row}");
                row[time].take();
            }
        }
        // What kernels remember from earlier rays decides some of the leaks of fast visibility.
        for row in json["geometry"].as_array_mut().unwrap() {
            if row["mode"] == "visibility fast" {
                ["leaks", "leaks per million", "self-hits", "NaN"]
                    .into_iter()
                    .for_each(|count| drop(row[count].take()));
            }
        }
        (json["modes"].take(), json["geometry"].take(), json["omitted"].take())
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn mistakes_of_accuracy_are_answered_in_a_sentence() {
    let folder = Folder::new();
    assert!(folder.fail("accuracy nowhere", 2).contains("nowhere"));
    assert!(folder.fail("accuracy --side 5", 2).contains("--side"));
    assert!(folder.fail("accuracy --report no/r.html", 2).contains("no/r.html"));
    assert!(folder.fail("accuracy --report - --export-csv -", 2).contains("--report"));
    fs::write(folder.path().join("file"), "").unwrap();
    assert!(folder.fail(&format!("{SMALL} --maps file"), 2).contains("file: "));
    assert!(folder.names().iter().all(|name| name == "file"), "{:?}", folder.names());
}

/// `irt` with a cache of its own in the folder.
fn render(folder: &Folder, flags: &str) -> std::process::Output {
    let line = format!("render atrium@0.1 --size 32x24 --threads 1 -o x.png --export-json x.json {flags}");
    folder.irt(&line).env("XDG_CACHE_HOME", folder.path().join("cache")).output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn wishes_are_granted_by_what_was_measured_once_and_garbage_is_measured_again() {
    let folder = Folder::new();
    let told = |flags: &str| {
        let output = render(&folder, flags);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{told}");
        told
    };
    let first = told("--max-error 0.06");
    assert!(first.contains("not measured yet") && first.contains("chosen: "), "{first}");
    assert!(first.contains("--samples "), "one sample misses that: {first}");
    let again = told("--max-error 0.06");
    assert!(!again.contains("not measured yet") && again.contains("chosen: "), "{again}");
    let lazy = told("--max-error 1 --camera-eye 0,2,0");
    assert!(lazy.contains("chosen: ") && !lazy.contains("--samples "), "{lazy}");
    let quick = told("--time-budget 1000");
    assert!(quick.contains("--samples 64"), "the best there is: {quick}");
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("x.json")).unwrap()).unwrap();
    assert!(json["effects"].as_array().unwrap().iter().any(|effect| effect == "antialiasing"), "{json}");

    let cache = folder.path().join("cache/irt/accuracy");
    let files: Vec<_> = fs::read_dir(&cache).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    fs::write(&files[0], "{\"key\": 1").unwrap();
    assert!(told("--max-error 0.06").contains("not measured yet"));
    assert!(!told("--max-error 0.06").contains("not measured yet"));

    // What cannot be had is refused, and nothing is written.
    fs::remove_file(folder.path().join("x.png")).unwrap();
    for flags in ["--max-error 1e-9", "--time-budget 1e-9", "--max-error 0.06 --time-budget 1e-9"] {
        let output = render(&folder, flags);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{flags}: {told}");
        assert!(told.contains("allow ") && !folder.path().join("x.png").exists(), "{flags}: {told}");
    }
}

#[test]
fn mistakes_of_wishes_are_answered_in_a_sentence() {
    let folder = Folder::new();
    for error in ["0", "-1", "2", "nan", "x"] {
        assert!(folder.fail(&format!("render --max-error {error}"), 2).starts_with("--max-error: "));
    }
    for seconds in ["0", "-1", "inf", "x"] {
        assert!(folder.fail(&format!("render --time-budget {seconds}"), 2).starts_with("--time-budget: "));
    }
    for flag in ["--samples 4", "--visibility fast", "--build slow", "--cutoff 0"] {
        let message = folder.fail(&format!("render --max-error 0.1 {flag}"), 2);
        assert!(message.contains("cannot be used with"), "{message}");
    }
}
