//! `irt render`, and what all commands have in common: bad flags, files, pipes, Ctrl-C.

use super::{Folder, folder_with_scenes};
use serde_json::Value;
use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The JSON export of a small render with these flags.
fn rendered(flags: &str) -> Value {
    let folder = Folder::new();
    let text = folder.run(&format!("render --size 70x50 --quiet --export-json - {flags}"));
    serde_json::from_str(&text).unwrap()
}

#[test]
fn render_writes_the_default_image_and_a_short_summary() {
    let folder = Folder::new();
    let summary = folder.run("render --size 64x48");
    assert_eq!(folder.names(), ["render.png"]);
    assert_eq!(image::image_dimensions(folder.path().join("render.png")).unwrap(), (64, 48));
    for word in ["atrium", "triangles", "tree", "kernel", "workers", "primary", "shadow", "Mrays/s", "write"]
    {
        assert!(summary.contains(word), "{word} in {summary}");
    }
    assert!(summary.lines().count() < 12, "{summary}");
}

#[test]
fn every_format_is_written_and_can_be_read() {
    let folder = Folder::new();
    for name in ["a.png", "a.exr", "a.hdr"] {
        folder.run(&format!("render --size 33x17 -q -o {name}"));
        let image = image::open(folder.path().join(name)).unwrap().into_rgb32f();
        assert_eq!(image.dimensions(), (33, 17), "{name}");
        assert!(image.pixels().any(|pixel| pixel.0 != image.get_pixel(0, 0).0), "{name} shows something");
    }
    folder.run("render --size 33x17 -q -o a.pfm");
    let bytes = fs::read(folder.path().join("a.pfm")).unwrap();
    assert!(bytes.starts_with(b"PF\n33 17\n") && bytes.len() > 33 * 17 * 12);
    assert_eq!(folder.names().len(), 4);
}

#[test]
fn render_exports_the_documented_json() {
    let json = rendered("--frames 2 --threads 2 --tile 16");
    assert_eq!(json["scene"], "atrium");
    assert!(json["triangles"].as_u64().unwrap() > 0);
    assert_eq!(json["size"], serde_json::json!([70, 50]));
    assert_eq!(json["threads"], 2);
    assert_eq!(json["order"], "hilbert");
    assert_eq!(json["schedule"], "stealing");
    assert_eq!(json["film"], "shared");
    assert_eq!(json["visibility"], "exact");
    assert!(json["isa"].is_string() && json["effects"].is_array() && json["counters"].is_object());
    assert!(json["build"]["seconds"].as_f64().unwrap() > 0.0 && json["build"]["bytes"].as_u64().unwrap() > 0);
    assert!(json["load_seconds"].as_f64().unwrap() >= 0.0);
    let frames = json["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 2);
    for frame in frames {
        assert!(frame["seconds"].as_f64().unwrap() > 0.0 && frame["mrays_per_s"].as_f64().unwrap() > 0.0);
        assert_eq!(frame["rays"]["primary"], 70 * 50);
        assert!(frame["rays"]["shadow"].as_u64().unwrap() > 0);
        assert!(frame["rays"]["reflection"].is_u64() && frame["rays"]["refraction"].is_u64());
        let hash = frame["image_sha256"].as_str().unwrap();
        assert!(hash.len() == 64 && hash == frames[0]["image_sha256"], "{hash}");
    }
    assert_eq!(json["counters"]["tiles"], 2 * 5 * 4);
    assert_eq!(json["workers"].as_array().unwrap().len(), 2);
    for stage in ["load", "build", "trace", "shade", "write"] {
        assert!(json["stages"][stage].is_f64(), "{stage}");
    }
}

#[test]
fn the_image_depends_on_nothing_but_scene_camera_and_size() {
    let hash = |flags: &str| rendered(flags)["frames"][0]["image_sha256"].as_str().unwrap().to_string();
    let expected = hash("");
    let mut all: Vec<String> =
        ["--threads 1", "--threads 3", "--no-pin", "--order scanline", "--kernel single", "--kernel tile"]
            .map(String::from)
            .to_vec();
    all.extend(["--tile 1", "--tile 7", "--tile 100", "--build fast", "--build slow"].map(String::from));
    for isa in irt::kernels::Isa::available() {
        all.push(format!("--isa {isa}"));
        all.push(format!("--isa {isa} --kernel tile"));
        all.push(format!("--isa {isa} --kernel single --order scanline --tile 24"));
    }
    for flags in all {
        assert_eq!(hash(&flags), expected, "{flags}");
    }
    assert_ne!(hash("--fov 20"), expected, "another camera gives another image");
    assert_ne!(hash("--light 0,5,0"), expected, "another light gives another image");
}

#[test]
fn adaptive_samples_are_fewer_and_the_pixels_without_edges_have_one() {
    let primary = |flags: &str| rendered(flags)["frames"][0]["rays"]["primary"].as_u64().unwrap();
    let pixels = 70 * 50;
    assert_eq!(primary("--samples 8"), 8 * pixels);
    // Two to find the edges, then eight for some.
    let adaptive = primary("--samples 8 --adaptive 0.3");
    assert!(adaptive > 2 * pixels && adaptive < 8 * pixels, "{adaptive}");
    assert_eq!(primary("--adaptive 0.3"), pixels, "of one sample there are no fewer");
}

#[test]
fn json_goes_to_a_file_or_to_standard_output_with_the_summary_aside() {
    let folder = Folder::new();
    folder.run("render --size 16x16 -o a.png --export-json a.json");
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!(json["size"], serde_json::json!([16, 16]));
    let output = folder.irt("render --size 16x16 -o a.png --export-json -").output().unwrap();
    serde_json::from_slice::<Value>(&output.stdout).unwrap();
    assert!(String::from_utf8(output.stderr).unwrap().contains("Mrays/s"));
    assert_eq!(folder.names(), ["a.json", "a.png"]);
}

#[test]
fn quiet_says_nothing() {
    let output = Folder::new().irt("render --size 16x16 --quiet").output().unwrap();
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn each_bad_flag_is_answered_with_one_sentence_that_names_it() {
    let folder = Folder::new();
    for (flags, named) in [
        ("--size 0x5", "--size"),
        ("--size 5", "--size"),
        ("--size 99999x99999", "--size"),
        ("--frames 0", "--frames"),
        ("--threads 0", "--threads"),
        ("--threads 99999", "--threads"),
        ("--threads x", "--threads"),
        ("--tile 0", "--tile"),
        ("--tile 1 --size 9000x9000", "--tile"),
        ("--fov 0", "--fov"),
        ("--fov 180", "--fov"),
        ("--fov -3", "--fov"),
        ("--fov nan", "--fov"),
        ("--exposure inf", "--exposure"),
        ("--camera-eye 1,2", "--camera-eye"),
        ("--camera-eye nan,0,0", "--camera-eye"),
        ("--camera-eye 1,2,3 --camera-at 1,2,3", "--camera-at"),
        ("--camera-eye 0,0,0 --camera-at 1,0,0 --camera-up -2,0,0", "--camera-up"),
        ("--camera-up 0,0,0", "--camera-up"),
        ("--light 1,2,3,4", "--light"),
        ("--isa neon", "--isa"),
        ("--order spiral", "--order"),
        ("--schedule eager", "--schedule"),
        ("--film paper", "--film"),
        ("--kernel best", "--kernel"),
        ("--build best", "--build"),
        ("--seed -1", "--seed"),
        ("--adaptive 0", "--adaptive"),
        ("--adaptive 2", "--adaptive"),
        ("--nonsense", "--nonsense"),
        ("--output", "--output"),
        ("-q -v", "--quiet"),
        ("-o a.png --export-json a.png", "--export-json"),
    ] {
        let message = folder.fail(&format!("render {flags}"), 2);
        assert!(message.starts_with(&format!("{named}: ")), "{flags}: {message}");
        assert_eq!(folder.names(), [""; 0], "{flags}");
    }
}

#[test]
fn unknown_values_are_answered_with_those_there_are() {
    let message = Folder::new().fail("render --order spiral", 2);
    assert!(message.ends_with("use one of: scanline, serpentine, hilbert, morton, peano"), "{message}");
    for isa in irt::kernels::Isa::ALL.into_iter().filter(|isa| !isa.is_available()) {
        let message = Folder::new().fail(&format!("render --isa {isa}"), 2);
        assert!(message.starts_with("--isa: this machine has no") && message.contains("scalar"), "{message}");
    }
}

#[test]
fn a_file_that_cannot_be_written_is_refused_before_the_work() {
    let folder = Folder::new();
    let start = Instant::now();
    for (flags, named) in [
        ("-o a.gif", "a.gif"),
        ("-o no/a.png", "no/a.png"),
        ("--export-json no/a.json", "no/a.json"),
        ("-o .", "."),
        // Nobody may create files there, not even root.
        #[cfg(target_os = "linux")]
        ("-o /proc/a.png", "/proc/a.png"),
    ] {
        let message = folder.fail(&format!("render --size 4000x4000 --frames 1000 {flags}"), 2);
        assert!(message.starts_with(&format!("{named}: ")), "{message}");
        assert_eq!(folder.names(), [""; 0], "{flags}");
    }
    assert!(start.elapsed() < Duration::from_secs(60));
}

#[test]
fn a_missing_scene_leaves_the_old_image_alone() {
    let folder = Folder::new();
    fs::write(folder.path().join("render.png"), "old").unwrap();
    let message = folder.fail("render no-such-scene.obj", 2);
    assert!(message.contains("no-such-scene.obj"), "{message}");
    assert_eq!(folder.names(), ["render.png"]);
    assert_eq!(fs::read_to_string(folder.path().join("render.png")).unwrap(), "old");
}

#[test]
fn wrong_commands_exit_with_2_and_help_with_0() {
    let folder = Folder::new();
    assert!(folder.fail("rendr", 2).ends_with("did you mean render?"));
    folder.irt("").assert().code(2);
    for line in ["--help", "scenes --help", "render --help", "--version"] {
        assert!(!folder.run(line).is_empty());
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_exits_with_130_and_leaves_no_file() {
    let folder = Folder::new();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("irt"))
        .args(["render", "--size", "4000x4000", "--frames", "100000", "--export-json", "a.json"])
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while folder.names().len() < 2 {
        assert!(start.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none());
        sleep(Duration::from_millis(10));
    }
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "irt: interrupted; nothing was written\n");
    assert_eq!(folder.names(), [""; 0]);
}

#[cfg(unix)]
#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let folder = Folder::new();
    for line in ["render --size 16x16", "render --size 16x16 --export-json -", "--help", "scenes"] {
        let shell = format!(
            "{} {line} | true; echo ${{PIPESTATUS[0]}}",
            assert_cmd::cargo::cargo_bin("irt").display()
        );
        let output = std::process::Command::new("bash")
            .args(["-c", &shell])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), "0\n", "{line}");
        assert!(!String::from_utf8_lossy(&output.stderr).contains("panic"), "{line}");
    }
}

#[test]
fn an_obj_file_is_rendered_with_the_given_camera_and_light() {
    let folder = folder_with_scenes();
    let flags = "--camera-eye 0.5,0.5,3 --camera-at 0.5,0.5,0 --fov 30 --light 0.5,0.5,2";
    let text = folder.run(&format!("render square.obj {flags} --size 40x30 -q -o x.png --export-json -"));
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["triangles"], 3);
    assert!(json["frames"][0]["rays"]["shadow"].as_u64().unwrap() > 100);
    let image = image::open(folder.path().join("x.png")).unwrap().into_rgb8();
    assert!(image.get_pixel(20, 15).0[0] > 100, "the square is lit");
    assert_eq!(image.get_pixel(0, 0).0, [0, 0, 0], "and there is nothing around it");
    // The scene file says the same.
    let text = folder.run("render square.toml -q --export-json -");
    let same: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(same["frames"][0]["image_sha256"], json["frames"][0]["image_sha256"]);
    // A negative coordinate is a value, not a flag.
    folder.run("render square.obj --light -1,-2,-3 --camera-eye -1,0,5 -q");
}

#[test]
fn what_was_repaired_is_told_unless_quiet() {
    let folder = folder_with_scenes();
    let told = |flags: &str| {
        let output = folder.irt(&format!("render square.obj --size 8x8 {flags}")).output().unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(told("").contains("irt: warning: square.obj: "), "{}", told(""));
    assert_eq!(told("--quiet"), "");
}
