//! `irt bench`.

use super::{Folder, folder_with_scenes};
use irt::kernels::Isa;
use serde_json::Value;
use std::fs;

const SMALL: &str = "bench --size 48x48 --rounds 3";

fn rows(text: &[u8]) -> Vec<Value> {
    serde_json::from_slice::<Value>(text).unwrap().as_array().unwrap().clone()
}

#[test]
fn bench_tells_the_best_modes_and_exports_the_documented_json() {
    let folder = folder_with_scenes();
    let text = folder.run(&format!("{SMALL} atrium@0.1 square.toml --export-json a.json --export-csv a.csv"));
    for word in ["atrium", "square", "primary", "diffuse", "Mrays/s", "irt / obvhs", "geometric mean"] {
        assert!(text.contains(word), "{word} in {text}");
    }
    let rows = rows(&fs::read(folder.path().join("a.json")).unwrap());
    let of = |scene: &str, kind: &str, engine: &str| {
        let wanted = |row: &&Value| row["scene"] == scene && row["kind"] == kind && row["engine"] == engine;
        let found: Vec<Value> = rows.iter().filter(wanted).cloned().collect();
        assert_eq!(found.len(), 1, "{scene} {kind} {engine}: one best mode");
        found[0].clone()
    };
    for (kind, engine) in
        ["primary", "shadow", "mirror", "diffuse"].map(|kind| [(kind, "irt"), (kind, "obvhs")]).concat()
    {
        let row = of("atrium", kind, engine);
        assert!(row["isa"].is_string() && row["kernel"].is_string() && row["width"].as_u64().unwrap() > 0);
        assert_eq!((&row["threads"], &row["rounds"]), (&Value::from(1), &Value::from(3)));
        assert_eq!(row["rays"], of("atrium", kind, "irt")["rays"], "the same rays for all");
        assert!(row["hits"].as_u64().unwrap() <= row["rays"].as_u64().unwrap());
        let speed = |key: &str| row["mrays_per_s"][key].as_f64().unwrap();
        assert!(0.0 < speed("min") && speed("min") <= speed("median") && speed("median") <= speed("max"));
    }
    assert_eq!(of("atrium", "primary", "irt")["rays"], 48 * 48);
    assert!(fs::read_to_string(folder.path().join("a.csv")).unwrap().starts_with("scene,kind,engine,isa,"));
}

#[test]
fn bench_measures_what_is_asked_for() {
    let folder = folder_with_scenes();
    let run = |flags: &str| {
        let output = folder.irt(&format!("{SMALL} square.toml -q --export-json - {flags}")).output().unwrap();
        assert!(output.status.success(), "{flags}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stderr.is_empty(), "{flags}");
        rows(&output.stdout)
    };
    let one = run("--kinds primary --engines irt --isa scalar --threads 2 --no-pin --build fast");
    assert_eq!(one.len(), 1);
    assert_eq!((&one[0]["isa"], &one[0]["threads"]), (&Value::from("scalar"), &Value::from(2)));
    let all = run("--kinds primary,shadow,primary --engines irt --all-modes");
    assert_eq!(all.len(), 4, "tiles and single rays, for two kinds");
}

#[test]
fn bench_times_the_steps_of_a_frame_for_each_instruction_set() {
    let folder = folder_with_scenes();
    let run = |flags: &str| {
        let line = format!("bench --micro atrium@0.1 --size 40x24 --rounds 2 -q --export-json - {flags}");
        rows(folder.run(&line).as_bytes())
    };
    let all = run("");
    let steps = [
        "ray generation",
        "box test",
        "leaf set-up",
        "triangle test",
        "finishing hits",
        "primary packets",
        "primary, single rays",
        "shadow ray generation",
        "shadow regrouping",
        "shadow streams",
        "adding light",
        "stream sort",
    ];
    let isas: Vec<Isa> = Isa::available().collect();
    let expected: Vec<_> =
        steps.iter().flat_map(|step| isas.iter().map(move |isa| (*step, isa.name()))).collect();
    let told: Vec<_> =
        all.iter().map(|row| (row["step"].as_str().unwrap(), row["isa"].as_str().unwrap())).collect();
    assert_eq!(told, expected);
    for (row, isa) in all.iter().zip(isas.iter().cycle()) {
        assert_eq!((&row["scene"], &row["agrees"]), (&"atrium".into(), &true.into()));
        assert_eq!((&row["rounds"], &row["width"]), (&2.into(), &isa.lanes().into()));
        assert!(row["unit"].is_string() && row["units"].as_u64().unwrap() > 0);
        let ns = ["min", "ns/unit", "max"].map(|key| row[key].as_f64().unwrap());
        assert!(0.0 < ns[0] && ns.is_sorted(), "{row}");
    }
    assert_eq!(all[0]["units"], 40 * 24, "a primary ray for each pixel");
    let one = run("--isa scalar");
    assert_eq!(one.len(), steps.len());
    assert!(one.iter().all(|row| row["isa"] == "scalar"));
    // A leaf alone has no boxes to test, and the table is told without an export.
    let text = folder.run("bench --micro square.toml --size 16x16 --rounds 1 -q --isa scalar");
    assert!(text.contains("triangle test") && !text.contains("box test"), "{text}");
}

#[test]
fn bench_answers_mistakes_before_the_work() {
    let folder = Folder::new();
    for (flags, named) in [
        ("--kinds primary,best", "--kinds"),
        ("--engines irt,best", "--engines"),
        ("--rounds 0", "--rounds"),
        ("--threads 0", "--threads"),
        ("--size 0x1", "--size"),
        ("--micro --kinds primary", "--micro"),
        ("--export-csv no/a.csv", "no/a.csv"),
        ("--export-csv - --export-json -", "--export-csv"),
    ] {
        let message = folder.fail(&format!("bench {flags}"), 2);
        assert!(message.starts_with(&format!("{named}: ")), "{flags}: {message}");
    }
    assert!(folder.fail("bench no-such-scene.obj -q", 2).contains("no-such-scene.obj"));
    if cfg!(not(feature = "embree")) {
        let message = folder.fail("bench --engines irt,embree", 2);
        assert!(
            message.starts_with("--engines: Embree is not available")
                && message.contains("--features embree")
        );
    }
    assert_eq!(folder.names(), [""; 0]);
}
