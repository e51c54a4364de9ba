//! `irt stability`.

use super::Folder;
use irt::kernels::Isa;
use serde_json::Value;
use std::fs;

#[test]
fn the_quick_battery_holds_and_exports_its_cells() {
    let folder = Folder::new();
    let text = folder.run("stability --quick --export-json a.json --export-csv a.csv --export-markdown a.md");
    for word in
        ["visibility is exact", "Closed meshes", "Random meshes", "self-hits", "lost neighbours", "2^-24"]
    {
        assert!(text.contains(word), "{word} in {text}");
    }
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!((&json["exact"], &json["first"]), (&true.into(), &Value::Null));
    let cells = json["cells"].as_array().unwrap();
    let sum = |column: &str| cells.iter().map(|cell| cell[column].as_u64().unwrap()).sum::<u64>();
    assert!(sum("aimed") >= 2_000_000 && sum("rays") > sum("aimed"));
    for column in ["leaks", "rejected", "differ", "NaN"] {
        assert_eq!(sum(column), 0, "{column}");
    }
    for isa in Isa::available() {
        for kernel in ["single", "tile", "beam", "flight", "stream", "shadow-stream"] {
            let of = cells.iter().filter(|cell| cell["isa"] == isa.name() && cell["kernel"] == kernel);
            assert_eq!(
                of.filter(|cell| cell["aimed"].as_u64() > Some(100)).count(),
                15,
                "places of {kernel} on {isa}"
            );
        }
    }
    let csv = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(csv.starts_with("engine,isa,kernel,center,radius,rays,aimed,leaks,"), "{csv}");
    assert_eq!(csv.lines().count(), 1 + cells.len());
}

#[test]
fn what_is_random_depends_on_the_seed_alone() {
    let folder = Folder::new();
    let run = |flags: &str| {
        let line = format!(
            "stability --quick --rays 100000 --isa scalar --kernel single,flight -q --export-json - {flags}"
        );
        let mut json: Value = serde_json::from_str(&folder.run(&line)).unwrap();
        json["threads"].take();
        json
    };
    let one = run("--threads 1");
    assert_eq!(run("--threads 3 --visibility exact"), one);
    assert_ne!(run("--seed 7")["errors"], one["errors"]);
}

#[test]
fn an_engine_that_leaks_is_seen_to_leak() {
    let folder = Folder::new();
    let line =
        "stability --quick --rays 100000 --isa scalar --kernel single --engines irt,obvhs -q --export-json -";
    let json: Value = serde_json::from_str(&folder.run(line)).unwrap();
    let of = |engine: &str| {
        let cells = json["cells"].as_array().unwrap().iter().filter(|cell| cell["engine"] == engine);
        cells.map(|cell| cell["leaks"].as_u64().unwrap()).sum::<u64>()
    };
    assert_eq!(of("irt"), 0);
    assert!(of("obvhs") > 1000, "its leaks: {}", of("obvhs"));
}

#[test]
fn stability_answers_mistakes_before_the_work() {
    let folder = Folder::new();
    for (flags, named) in [
        ("--rays 0", "--rays"),
        ("--isa mmx", "--isa"),
        ("--kernel tile,best", "--kernel"),
        ("--engines obvhs", "--engines"),
        ("--visibility none", "--visibility"),
        ("--threads 0", "--threads"),
        ("--seed -1", "--seed"),
        ("--export-json no/a.json", "no/a.json"),
    ] {
        let message = folder.fail(&format!("stability {flags}"), 2);
        assert!(message.starts_with(&format!("{named}: ")), "{flags}: {message}");
    }
    assert_eq!(folder.names(), [""; 0]);
}
