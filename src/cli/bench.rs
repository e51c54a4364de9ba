//! `irt bench`.

use super::{
    args::{BenchArgs, Talk},
    export::TableExports,
    interrupt, terminal,
};
use crate::{
    error::Result,
    report::{BenchRow, bench_summary, bench_table, builds_table, micro_table},
    scene::{Scene, load},
    study::bench::{BenchOptions, Row, bench, best_rows, builds, check, micro, micro_verdict, verdict},
};

/// Scenes unless others are named: those built in as counterparts of the thesis' five.
const SCENES: [&str; 5] = ["atrium", "nave", "office", "hall", "statue"];
/// Scene for single steps unless others are named.
const STEPS_OF: &str = SCENES[0];
/// Size of the image whose rays are traced.
const SIZE: [u32; 2] = [1024; 2];
/// The same for single steps, whose data shall stay in the cache.
const STEPS_SIZE: [u32; 2] = [256; 2];

/// Times traversal kernels side by side.
///
/// # Errors
/// Whatever is wrong with the arguments, a scene or an export; [`crate::error::Error::Failed`] if engines disagree
/// about what is hit, after the figures have been told.
pub(super) fn run(args: &BenchArgs, talk: Talk) -> Result<()> {
    let options = options(args);
    check(&options)?;
    interrupt::install()?;
    let exports = TableExports::open(&args.export)?;
    if args.builds {
        let tree = |scene: &Scene, place: &str| {
            builds(scene, &options, |what| tell(talk, &format!("{place}: {what}")))
        };
        let rows = each_scene(args, tree)?;
        exports.write(&builds_table(&rows, &options.kinds))?;
        let traced: Vec<Row> = rows.into_iter().flat_map(|row| row.traced).collect();
        return verdict(&traced);
    }
    if args.micro {
        let steps = |scene: &Scene, place: &str| {
            tell(talk, &format!("{place}: steps"));
            micro(scene, &options)
        };
        let rows = each_scene(args, steps)?;
        exports.write(&micro_table(&rows))?;
        return micro_verdict(&rows);
    }
    let kernels = |scene: &Scene, place: &str| {
        tell(talk, &format!("{place}: trees"));
        bench(scene, &options, |kind| tell(talk, &format!("{place}: {kind} rays")))
    };
    let rows = each_scene(args, kernels)?;

    let shown = if args.all_modes || talk.verbose { rows.clone() } else { best_rows(&rows) };
    let table = bench_table(&shown);
    let summary = bench_summary(&rows, &options.engines, &options.visibility);
    let told = format!("{}\n{}", table.to_terminal(), summary.to_terminal());
    let stdout_taken = exports.is_stdout();
    exports.write_files(&shown.iter().map(BenchRow::from).collect::<Vec<_>>(), &table)?;
    match (stdout_taken, talk.quiet) {
        (false, _) => terminal::print(&told)?,
        (true, false) => terminal::note(&told),
        (true, true) => {}
    }
    verdict(&rows)
}

fn options(args: &BenchArgs) -> BenchOptions {
    BenchOptions {
        kinds: once_each(&args.kinds),
        engines: once_each(&args.engines),
        isa: args.isa.isa(),
        visibility: once_each(&args.visibility),
        rounds: args.rounds,
        threads: args.threads,
        pin: args.pin.pin(),
        size: args.size.unwrap_or(if args.micro { STEPS_SIZE } else { SIZE }),
        build: args.build,
    }
}

/// What is named twice is measured once.
fn once_each<T: Copy + PartialEq>(list: &[T]) -> Vec<T> {
    let mut once = Vec::new();
    for item in list {
        if !once.contains(item) {
            once.push(*item);
        }
    }
    once
}

fn tell(talk: Talk, text: &str) {
    if !talk.quiet {
        terminal::note(&format!("irt: {text}\n"));
    }
}

/// What `measure` finds out about all scenes; it also gets the name to tell people.
fn each_scene<T>(args: &BenchArgs, measure: impl Fn(&Scene, &str) -> Result<Vec<T>>) -> Result<Vec<T>> {
    let scenes: Vec<&str> = match &args.scenes[..] {
        [] if args.micro => vec![STEPS_OF],
        [] => SCENES.to_vec(),
        named => named.iter().map(String::as_str).collect(),
    };
    let mut rows = Vec::new();
    for (index, spec) in once_each(&scenes).into_iter().enumerate() {
        let scene = load(spec)?;
        let place = format!("scene {} of {}, {}", index + 1, scenes.len(), scene.name);
        scene.warnings.iter().for_each(|warning| log::warn!("{warning}"));
        if scene.lights.is_empty() {
            log::warn!("{} has no light, so that there are no shadow rays", scene.name);
        }
        rows.extend(measure(&scene, &place)?);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::SCENES;
    use crate::scene::procedural;

    #[test]
    fn the_scenes_are_built_in() {
        assert!(SCENES.iter().all(|scene| procedural::NAMES.contains(scene)));
    }
}
