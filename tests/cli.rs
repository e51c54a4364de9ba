//! The commands as users run them: results, files, exit codes, and one sentence for each mistake.

mod accuracy;
mod bench;
mod coherence;
mod motion;
mod render;
mod scaling;
mod scenes;
mod stability;
mod trace;
mod view;

use assert_cmd::Command;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A folder of its own for each test.
struct Folder(TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(TempDir::new().unwrap())
    }

    /// `irt` with these arguments, to be run in the folder.
    fn irt(&self, line: &str) -> Command {
        let mut command = Command::cargo_bin("irt").unwrap();
        command.current_dir(self.0.path()).args(line.split_whitespace()).env_remove("IRT_SCENES");
        command
    }

    /// Runs `irt` and expects it to succeed.
    fn run(&self, line: &str) -> String {
        let output = self.irt(line).assert().success().get_output().clone();
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs `irt`, expects it to fail with `code` and returns the one line on standard error.
    fn fail(&self, line: &str, code: i32) -> String {
        let output = self.irt(line).assert().code(code).get_output().clone();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.stdout.is_empty(), "{line}");
        assert_eq!(message.lines().count(), 1, "{line}: {message}");
        assert!(message.starts_with("irt: ") && message.contains("; "), "{line}: {message}");
        message.trim_start_matches("irt: ").trim_end().to_string()
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn path(&self) -> &Path {
        self.0.path()
    }
}

/// A square of two triangles in the plane z = 0, one of them twice, and a triangle without area.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\nf 3 4 1\nf 1 1 2\n";

const TOML: &str = "\
name = \"square\"
size = [40, 30]
[[mesh]]
file = \"square.obj\"
[camera]
eye = [0.5, 0.5, 3]
at = [0.5, 0.5, 0]
fov = 30
[[light]]
kind = \"point\"
position = [0.5, 0.5, 2]
intensity = 1
";

/// A folder with an OBJ file and a TOML scene.
fn folder_with_scenes() -> Folder {
    let folder = Folder::new();
    fs::write(folder.path().join("square.obj"), OBJ).unwrap();
    fs::write(folder.path().join("square.toml"), TOML).unwrap();
    folder
}
