//! A lost `#[inline(always)]` cannot slip in. An intrinsic in a function that is not inlined into an entry with
//! `#[target_feature]` becomes a call, and the kernel 10 to 100 times slower, without any wrong result.
//!
//! Every function of `irt_kernels::dispatch::<isa>` is disassembled, in this executable and in `irt`: the entries of
//! the table and all instantiations of `run`, which carry the renderer's own kernels. They may call what [`ALLOWED`]
//! lists and nothing else. If this test fails, put `#[inline(always)]` on the function that it names; only what runs
//! rarely may be `#[cold]`, `#[inline(never)]` and listed.

use std::collections::BTreeSet;
use std::path::Path;

mod machine_code;

use machine_code::{Executable, Function, Target};

/// The modules of entries whose instructions are wider than those of their callers.
const MODULES: [&str; 3] = ["sse42", "avx2", "avx512"];

/// Entries of each module, for each visibility.
const ENTRIES: [&str; 8] = [
    "tile_intersect",
    "tile_occluded",
    "beam_intersect",
    "beam_occluded",
    "intersect",
    "occluded",
    "intersect_each",
    "occluded_each",
];

/// What an entry may call: names without generic arguments, or beginnings of names that end in `:` or `_`.
const ALLOWED: [&str; 21] = [
    // Defects that are announced.
    "core::panicking::",
    "core::slice::index::slice_",
    "core::option::unwrap_failed",
    "core::option::expect_failed",
    "core::result::unwrap_failed",
    // Lanes in doubt, decided exactly.
    "irt_kernels::dispatch::scalar::apart",
    "irt_kernels::dispatch::sse42::apart",
    "irt_kernels::dispatch::avx2::apart",
    "irt_kernels::dispatch::avx512::apart",
    "irt_kernels::generic::tile::doubts::is_exactly_inside",
    "irt_kernels::generic::beam::rays::settle",
    "irt_kernels::generic::single::settle",
    "irt_kernels::generic::doubt::nearer",
    "irt_kernels::generic::probe::nearest_to_surface",
    "irt_kernels::exact::passes",
    "irt_kernels::exact::det_sign",
    "irt_kernels::exact::expansion_sign",
    // Another origin than the last packet's.
    "irt_kernels::generic::tile::scratch::LeafCache::change",
    // A vector that grows.
    "alloc::raw_vec::",
    // Whole blocks of memory.
    "memcpy",
    "memset",
];

fn is_allowed(name: &str) -> bool {
    let name = name.trim_start_matches('<');
    ALLOWED.iter().any(|allowed| {
        name == *allowed
            || allowed.ends_with(['_', ':']) && name.starts_with(allowed)
            || name.strip_prefix(allowed).is_some_and(|rest| rest.starts_with("::") || rest.starts_with('<'))
    })
}

/// The module of `irt_kernels::dispatch` that a function belongs to.
fn module_of(function: &Function) -> Option<&'static str> {
    let rest = function.name.split("irt_kernels::dispatch::").nth(1)?;
    MODULES.into_iter().find(|module| rest.strip_prefix(module).is_some_and(|rest| rest.starts_with("::")))
}

/// The entries of an executable, and a line for each call that is not allowed.
fn survey(path: &Path) -> (BTreeSet<String>, Vec<String>) {
    let executable = Executable::read(path);
    let (mut entries, mut wrong) = (BTreeSet::new(), BTreeSet::new());
    for function in executable.functions() {
        if module_of(function).is_none() {
            continue;
        }
        entries.insert(function.name.clone());
        for target in executable.calls(function) {
            match target {
                Target::Named(name) if is_allowed(&name) => {}
                Target::Named(name) => {
                    wrong.insert(format!("{} calls {name}", function.name));
                }
                Target::Unknown(place) => {
                    wrong.insert(format!("{} makes an indirect call at {place:#x}", function.name));
                }
            }
        }
    }
    (entries, wrong.into_iter().collect())
}

/// The names of the entries within a module.
fn names() -> Vec<String> {
    ["exact", "fast"]
        .iter()
        .flat_map(|visibility| ENTRIES.map(|name| format!("{visibility}::{name}")))
        .collect()
}

fn assert_entries_call_nothing(path: &Path, expected: &[String]) {
    let (entries, wrong) = survey(path);
    for module in MODULES {
        for name in expected {
            let entry = format!("irt_kernels::dispatch::{module}::{name}");
            assert!(entries.iter().any(|e| e.starts_with(&entry)), "{entry} is not in {}", path.display());
        }
    }
    assert!(wrong.is_empty(), "not inlined, in {}:\n{}", path.display(), wrong.join("\n"));
}

#[test]
fn entries_of_the_tests_call_nothing() {
    let this = std::env::current_exe().unwrap();
    assert_entries_call_nothing(&this, &names());
}

#[test]
fn entries_of_irt_call_nothing() {
    let irt = Path::new(env!("CARGO_BIN_EXE_irt"));
    assert_entries_call_nothing(irt, &[names(), vec!["run".into()]].concat());
}

#[test]
fn only_whole_names_are_allowed() {
    for name in ["memcpy", "core::panicking::panic_fmt", "core::slice::index::slice_index_fail"] {
        assert!(is_allowed(name), "{name}");
    }
    assert!(is_allowed("irt_kernels::generic::beam::rays::settle::<true>"));
    for name in [
        "memcpy_fast",
        "irt_kernels::exact::passes_all",
        "core::core_arch::x86::avx::_mm256_add_ps",
        "settle",
    ] {
        assert!(!is_allowed(name), "{name}");
    }
}

/// A function pointer that the compiler cannot see through is a call that is reported, as is one to a function that
/// is not inlined.
#[test]
fn calls_of_this_executable_are_found() {
    #[inline(never)]
    fn callee(x: u64) -> u64 {
        std::hint::black_box(x).wrapping_add(1)
    }
    #[inline(never)]
    fn direct(x: u64) -> u64 {
        callee(x).wrapping_add(callee(x ^ 1))
    }
    #[inline(never)]
    fn indirect(f: fn(u64) -> u64) -> u64 {
        f(1).wrapping_add(1)
    }
    assert_eq!(std::hint::black_box(direct(1)) + indirect(std::hint::black_box(callee)), 6);
    let executable = Executable::read(&std::env::current_exe().unwrap());
    let calls = |name: &str| {
        let name = format!("calls_of_this_executable_are_found::{name}");
        let function = executable.functions().find(|f| f.name.contains(&name)).expect("not inlined");
        executable.calls(function)
    };
    assert!(
        matches!(&calls("direct")[..], [Target::Named(a), Target::Named(b)] if a == b && a.contains("callee"))
    );
    assert!(matches!(&calls("indirect")[..], [Target::Unknown(_)]));
}
