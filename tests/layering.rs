//! The house rules about who may know whom: modules import in one direction only, and each outside crate is named in
//! one module. Read from the text of `src`, so that a violation is named by file and line.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules in import order: each may name only those before it.
const ORDER: [&str; 19] = [
    "kernels", "error", "math", "scene", "effects", "bvh", "camera", "tile", "trace", "shade", "film",
    "schedule", "render", "output", "study", "report", "view", "cli", "main",
];

/// Outside crates that every module may name: vocabulary rather than a dependency on somebody's design.
const EVERYWHERE: [&str; 7] = ["std", "core", "alloc", "glam", "serde", "log", "irt_kernels"];

/// One thing that must not be named where it is.
#[derive(Debug, PartialEq, Eq)]
struct Violation {
    line: usize,
    text: String,
}

/// Takes comments and texts out of Rust source, keeping its lines.
fn code_only(source: &str) -> String {
    let mut code = String::with_capacity(source.len());
    let mut rest = source;
    while let Some(next) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = text_length(rest) {
            length
        } else {
            code.push(next);
            rest = &rest[next.len_utf8()..];
            continue;
        };
        code.extend(rest[..skipped].chars().filter(|&c| c == '\n'));
        rest = &rest[skipped..];
    }
    code
}

/// Length of the string or character literal at the start of `rest`, if there is one.
fn text_length(rest: &str) -> Option<usize> {
    if let Some(raw) = rest.strip_prefix('r') {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        if raw[hashes..].starts_with('"') {
            let close = format!("\"{}", "#".repeat(hashes));
            let body = 1 + hashes + 1;
            return rest[body..].find(&close).map(|end| body + end + close.len());
        }
    }
    let quote = rest.chars().next().filter(|&c| c == '"' || c == '\'')?;
    if quote == '\'' {
        // A lifetime has no closing quote right behind its first character.
        let mut chars = rest.chars().skip(1);
        let first = chars.next()?;
        if first != '\\' && chars.next() != Some('\'') {
            return None;
        }
    }
    let mut escaped = false;
    for (i, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            c if c == quote => return Some(i + 1),
            _ => {}
        }
    }
    None
}

/// Every first segment of a path that starts at the crate root (`crate::x`, `irt::x`, also in braces), with its line.
fn named_modules(code: &str) -> Vec<(usize, String)> {
    let mut found = vec![];
    for root in ["crate::", "irt::"] {
        for (at, _) in code.match_indices(root).filter(|&(at, _)| starts_a_word(code, at)) {
            // `$crate` and `pub(in crate::...)` are paths like any other.
            found.extend(heads(code, at + root.len()));
        }
    }
    found
}

/// The names that a path continues with at `at`: one, or the first of each branch in braces.
fn heads(code: &str, at: usize) -> Vec<(usize, String)> {
    let line = |at: usize| code[..at].matches('\n').count() + 1;
    let word =
        |at: usize| code[at..].chars().take_while(|&c| c.is_alphanumeric() || c == '_').collect::<String>();
    if !code[at..].starts_with('{') {
        return vec![(line(at), word(at))];
    }
    let mut found = vec![];
    let (mut depth, mut fresh) = (0, false);
    for (i, c) in code[at..].char_indices() {
        match c {
            '{' => (depth, fresh) = (depth + 1, depth == 0),
            '}' if depth == 1 => break,
            '}' => depth -= 1,
            ',' if depth == 1 => fresh = true,
            c if fresh && depth == 1 && !c.is_whitespace() => {
                found.push((line(at + i), word(at + i)));
                fresh = false;
            }
            _ => {}
        }
    }
    found
}

fn starts_a_word(code: &str, at: usize) -> bool {
    !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':')
}

/// What the code of `module` names although it comes later in the order.
fn violations(module: &str, source: &str) -> Vec<Violation> {
    let place = |name: &str| ORDER.iter().position(|&m| m == name);
    let own = place(module).unwrap_or_else(|| panic!("module {module} has no place in the order"));
    named_modules(&code_only(source))
        .into_iter()
        .filter(|(_, name)| place(name).is_some_and(|other| other > own))
        .map(|(line, name)| Violation { line, text: format!("{module} names {name}") })
        .collect()
}

/// The outside crates among `crates` that the source names, as `krate::`, `use krate` or `extern crate krate`.
fn named_crates<'a>(source: &str, crates: &'a [String]) -> Vec<&'a str> {
    let code = code_only(source);
    let names = |krate: &&String| {
        code.match_indices(krate.as_str()).any(|(at, _)| {
            let rest = &code[at + krate.len()..];
            let used =
                code[..at].ends_with("use ") && !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
            starts_a_word(&code, at) && (used || rest.starts_with("::"))
        })
    };
    crates.iter().filter(names).map(String::as_str).collect()
}

/// Every Rust file below `src` with the module it belongs to.
fn sources() -> Vec<(String, PathBuf)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![src.clone()];
    let mut files = vec![];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("src/lib.rs") {
                let first = path.strip_prefix(&src).unwrap().components().next().unwrap();
                let module = first.as_os_str().to_str().unwrap().trim_end_matches(".rs").to_string();
                files.push((module, path));
            }
        }
    }
    files
}

/// Names of the dependencies in Cargo.toml, as code writes them.
fn dependencies() -> Vec<String> {
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    let section = manifest.split("\n[dependencies]\n").nth(1).unwrap().split("\n[").next().unwrap();
    section
        .lines()
        .filter_map(|line| line.split_once('='))
        .map(|(name, _)| name.trim().replace('-', "_"))
        .collect()
}

#[test]
fn modules_import_only_from_those_before_them() {
    let mut all = vec![];
    for (module, path) in sources() {
        for Violation { line, text } in violations(&module, &fs::read_to_string(&path).unwrap()) {
            all.push(format!("{}:{line}: {text}", path.display()));
        }
    }
    assert!(all.is_empty(), "against the import order:\n{}", all.join("\n"));
}

#[test]
fn each_outside_crate_is_named_in_one_module() {
    let crates: Vec<String> =
        dependencies().into_iter().filter(|name| !EVERYWHERE.contains(&name.as_str())).collect();
    assert!(crates.contains(&"obvhs".to_string()), "{crates:?}");
    let mut users: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (module, path) in sources() {
        for name in named_crates(&fs::read_to_string(&path).unwrap(), &crates) {
            let modules = users.entry(name).or_default();
            if !modules.contains(&module) {
                modules.push(module.clone());
            }
        }
    }
    let shared: Vec<_> = users.iter().filter(|(_, modules)| modules.len() > 1).collect();
    assert!(shared.is_empty(), "named in more than one module: {shared:?}");
}

#[test]
fn lib_lists_the_modules_in_import_order() {
    let lib = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let listed: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod "))
        .map(|m| m.trim_end_matches(';'))
        .collect();
    let expected: Vec<&str> = ORDER.into_iter().filter(|m| listed.contains(m)).collect();
    assert_eq!(listed, expected);
}

#[test]
fn a_planted_violation_is_found_in_every_form() {
    for (source, line) in [
        ("use crate::render::render;", 1),
        ("\nuse crate::{\n    math::Aabb,\n    render::{self, render},\n};", 4),
        ("fn f() {\n    let x = crate::cli::main();\n}", 2),
        ("/* a\n b */ use irt::film::Film;", 2),
        ("use crate::{math::{Aabb, x}, film};", 1),
        ("fn f<'a>(x: &'a str) -> char { let _ = crate::film::Film::new(1, 1); '\"' }", 1),
    ] {
        let found = violations("scene", source);
        assert_eq!(found.iter().map(|v| v.line).collect::<Vec<_>>(), [line], "{source}: {found:?}");
    }
}

#[test]
fn what_is_allowed_is_not_found() {
    for source in [
        "use crate::math::Aabb;",
        "use crate::scene::Light; use super::render;",
        "// use crate::render::render;\n/// crate::cli",
        "let a = \"crate::cli::main \\\" crate::film\"; let b = r#\"crate::\"cli\"#; let c = '\"';",
        "use crate::{error::{Error, Result}, math::Aabb};",
        "use mycrate::render;",
    ] {
        assert_eq!(violations("scene", source), [], "{source}");
    }
}

#[test]
fn crates_are_found_by_use_and_by_path() {
    let crates = ["clap", "toml", "image"].map(String::from);
    assert_eq!(named_crates("use clap::Parser;\nlet x = toml::from_str(y);", &crates), ["clap", "toml"]);
    assert_eq!(named_crates("use clap;", &crates), ["clap"]);
    let none = "use crate::image::x; // clap::x\nlet clap = 1; my_image::f(); let t = \"toml::x\";";
    assert_eq!(named_crates(none, &crates), [""; 0]);
}
