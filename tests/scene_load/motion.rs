//! Sequences of meshes and keys in scene files.

use super::{folder, good, load_path};
use glam::Vec3;
use irt::scene::Scene;

/// A square of a quad and a triangle beside it, at a height; `v` and `f` lines to be changed.
fn frame(height: f32) -> String {
    format!(
        "v 0 {height} 0\nv 1 {height} 0\nv 1 {height} 1\nv 0 {height} 1\nv 2 {height} 0\nf 1 2 3 4\nf 2 5 3\n"
    )
}

const SEQUENCE: &str =
    "[[mesh]]\nfile = \"m/a%02d.obj\"\nframes = [8, 10]\nfps = 4\nscale = 2\ntranslate = [0, 0, 5]\n";

/// Loads three frames, the second of which is this.
fn sequence(second: Option<&str>, toml: &str) -> Result<Scene, String> {
    let [first, last] = [0.0, 2.0].map(frame);
    let mut files = vec![("m/a08.obj", &*first), ("m/a10.obj", &*last), ("s.toml", toml)];
    files.extend(second.map(|text| ("m/a09.obj", text)));
    let folder = folder(&files);
    load_path(&folder.path().join("s.toml"))
}

#[test]
fn a_sequence_is_read_frame_by_frame_and_put_in_its_place() {
    // The second frame is bent so that its quad would be cut along the other diagonal: the faces are still the same.
    let bent = "v 0 1 0\nv 0.3 1 0.3\nv 1 1 1\nv 0 1 1\nv 2 1 0\nf 1 2 3 4\nf 2 5 3\n";
    let mut scene = good(sequence(Some(bent), SEQUENCE));
    let motion = scene.motion.clone().unwrap();
    assert_eq!((motion.length(), motion.rate(), motion.tracks[0].shapes.len()), (0.5, 4.0, 3));
    assert_eq!(scene.mesh.positions[1], Vec3::new(2.0, 0.0, 5.0));
    scene.pose(0.25);
    assert_eq!(scene.mesh.positions[1], Vec3::new(0.6, 2.0, 5.6));
    scene.pose(0.375);
    assert_eq!(scene.mesh.positions[3], Vec3::new(0.0, 3.0, 7.0));
    scene.pose(0.5);
    assert_eq!(scene.mesh.positions[4], Vec3::new(4.0, 4.0, 5.0));
}

#[test]
fn a_triangle_without_area_at_one_moment_stays_for_the_others() {
    let flat = "v 0 1 0\nv 1 1 0\nv 1 1 0\nv 1 1 0\nv 2 1 0\nf 1 2 3 4\nf 2 5 3\n";
    let mut scene = good(sequence(Some(flat), SEQUENCE));
    assert_eq!(scene.mesh.len(), 3);
    scene.pose(0.25);
    scene.check().unwrap();
    let never = SEQUENCE.replace("frames = [8, 10]", "frames = [9, 10]");
    let folder = folder(&[("m/a09.obj", flat), ("m/a10.obj", flat), ("s.toml", &never)]);
    assert!(load_path(&folder.path().join("s.toml")).unwrap_err().contains("only triangles of zero area"));
}

#[test]
fn frames_that_do_not_fit_are_named_with_the_remedy() {
    let [middle, all] = [frame(1.0), String::from("export all frames with the same vertices and faces")];
    for (second, expected) in [
        (middle.replace("f 2 5 3", "f 2 5 4"), "faces have other corners"),
        (middle.replace("f 1 2 3 4\n", "f 1 2 3\nf 1 3 4\n"), "faces have other corners"),
        (middle.replace("f 2 5 3\n", "f 2 5 3\nf 1 2 5\n"), "faces have other corners"),
        (middle.replace("f 2 5 3", "v 7 7 7\nf 2 6 3\nf 1 2 5"), "6 different vertices instead of 5"),
        (middle.replace("f 2 5 3", "vn 0 1 0\nf 2//1 5//1 3//1"), "vertices instead of 5"),
        (
            middle.replace("f 1 2 3 4\nf 2 5 3", "vn 0 1 0\nf 1//1 2//1 3//1 4//1\nf 2//1 5//1 3//1"),
            "only one of them has normals",
        ),
    ] {
        let message = sequence(Some(&second), SEQUENCE).unwrap_err();
        assert!(message.contains("a09.obj: does not fit the first frame"), "{message}");
        assert!(message.contains(expected) && message.contains(&all), "{expected}: {message}");
    }
    let missing = sequence(None, SEQUENCE).unwrap_err();
    assert!(
        missing.contains("s.toml:2: ") && missing.contains("mesh `m/a09.obj` was not found"),
        "{missing}"
    );
    let nan = sequence(Some(&middle.replace("v 1 1 1", "v 1 nan 1")), SEQUENCE).unwrap_err();
    assert!(nan.contains("a09.obj:3: `nan` is not a finite"), "{nan}");
    let far = sequence(Some(&middle.replace("v 1 1 1", "v 1 9e17 1")), SEQUENCE).unwrap_err();
    assert!(far.contains("s.toml:2: ") && far.contains("beyond the range"), "{far}");
}

/// A mesh and these lines after `file`.
fn moved(lines: &str) -> Result<Scene, String> {
    let text = format!("[[mesh]]\nfile = \"a.obj\"\n{lines}");
    let folder = folder(&[("a.obj", &frame(0.0)), ("s.toml", &text)]);
    load_path(&folder.path().join("s.toml"))
}

#[test]
fn keys_turn_about_x_y_z_and_then_move() {
    let keys = "rotate = [0, 90, 0]\n[[mesh.key]]\ntime = 0.5\ntranslate = [0, 1, 0]\n\
                [[mesh.key]]\ntime = 2\nrotate = [90, 0, 90]\ntranslate = [0, 0, 3]\n";
    let mut scene = good(moved(keys));
    // x is turned to -z by the mesh's own rotation; before the first key it is where that puts it.
    assert_eq!(scene.mesh.positions[1], Vec3::new(0.0, 1.0, -1.0));
    scene.pose(2.0);
    // About x, -z goes to y, and about z that goes to -x.
    assert_eq!(scene.mesh.positions[1], Vec3::new(-1.0, 0.0, 3.0));
    assert_eq!(scene.motion.unwrap().length(), 2.0);
}

#[test]
fn mistakes_in_motion_are_errors_with_line_and_column() {
    for (lines, place, expected) in [
        ("frames = [0, 3]", "2: column 8", "must have one `%d`"),
        ("fps = 4", "3: column 7", "`fps` belongs to a sequence"),
        ("[[mesh.key]]\ntime = 0", "3: column 1", "one key moves nothing"),
        ("[[mesh.key]]\ntime = 1\n[[mesh.key]]\ntime = 1", "6: column 8", "must be later"),
        ("[[mesh.key]]\ntime = -1\n[[mesh.key]]\ntime = 1", "4: column 8", "must not be negative"),
        ("[[mesh.key]]\ntime = nan\n[[mesh.key]]\ntime = 1", "4: column 8", "must be finite"),
        ("[[mesh.key]]\nrotate = [0, 0, 0]", "3: column 1", "missing field `time`"),
        ("[[mesh.key]]\ntime = 1\nscale = 2", "5: column 1", "unknown field `scale`"),
        ("[[mesh.key]]\ntime = 0\ntranslate = [0, inf, 0]", "5: column 13", "three finite numbers"),
        (
            "[[mesh.key]]\ntime = 0\ntranslate = [1e18, 0, 0]\n[[mesh.key]]\ntime = 1",
            "2: column 8",
            "keys move it beyond the range",
        ),
    ] {
        let message = moved(lines).unwrap_err();
        assert!(
            message.contains(&format!("s.toml:{place}")) && message.contains(expected),
            "{lines}: {message}"
        );
    }
    for frames in ["[3, 3]", "[-1, 3]", "[0, 100000]"] {
        let message = sequence(None, &SEQUENCE.replace("[8, 10]", frames)).unwrap_err();
        assert!(message.contains("s.toml:3: column 10") && message.contains("the last greater"), "{message}");
    }
    let message = sequence(None, &SEQUENCE.replace("fps = 4", "fps = 0")).unwrap_err();
    assert!(message.contains("`fps` must be positive"), "{message}");
}

#[test]
fn the_example_of_motion_in_the_readme_is_a_scene() {
    let readme = std::fs::read_to_string("scenes/README.md").expect("scenes/README.md");
    let example =
        readme.split("```").filter_map(|block| block.strip_prefix("toml\n")).nth(2).expect("a block");
    let frames = [0.0, 1.0, 2.0, 3.0].map(frame);
    let names = ["cloth_0000.obj", "cloth_0001.obj", "cloth_0002.obj", "wheel.obj"];
    let mut files: Vec<(&str, &str)> = names.into_iter().zip(frames.iter().map(String::as_str)).collect();
    files.push(("s.toml", example));
    let folder = folder(&files);
    let motion = good(load_path(&folder.path().join("s.toml"))).motion.unwrap();
    assert_eq!((motion.tracks.len(), motion.length(), motion.rate()), (2, 1.5, 24.0));
}
