//! `irt bench`.

use super::{
    args::Talk,
    common::{each_scene, once_each, specs},
    export::TableExports,
    interrupt,
    study_args::BenchArgs,
    terminal,
};
use crate::{
    error::Result,
    report::{BenchRow, bench_summary, bench_table, builds_table, micro_table},
    scene::Scene,
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
            builds(scene, &options, |what| terminal::tell(talk, &format!("{place}: {what}")))
        };
        let rows = of_each_scene(args, tree)?;
        exports.write(&builds_table(&rows, &options.kinds))?;
        let traced: Vec<Row> = rows.into_iter().flat_map(|row| row.traced).collect();
        return verdict(&traced);
    }
    if args.micro {
        let steps = |scene: &Scene, place: &str| {
            terminal::tell(talk, &format!("{place}: steps"));
            micro(scene, &options)
        };
        let rows = of_each_scene(args, steps)?;
        exports.write(&micro_table(&rows))?;
        return micro_verdict(&rows);
    }
    let kernels = |scene: &Scene, place: &str| {
        terminal::tell(talk, &format!("{place}: trees"));
        bench(scene, &options, |kind| terminal::tell(talk, &format!("{place}: {kind} rays")))
    };
    let rows = of_each_scene(args, kernels)?;

    let shown = if args.all_modes || talk.verbose { rows.clone() } else { best_rows(&rows) };
    let table = bench_table(&shown);
    let summary = bench_summary(&rows, &options.engines, &options.visibility);
    let told = format!("{}\n{}", table.to_terminal(), summary.to_terminal());
    let stdout_taken = exports.is_stdout();
    exports.write_files(&shown.iter().map(BenchRow::from).collect::<Vec<_>>(), &table)?;
    terminal::results(&told, stdout_taken, talk)?;
    verdict(&rows)
}

fn options(args: &BenchArgs) -> BenchOptions {
    BenchOptions {
        kinds: once_each(args.kinds.iter().copied()),
        engines: once_each(args.engines.iter().copied()),
        isa: args.isa.isa(),
        visibility: once_each(args.visibility.iter().copied()),
        rounds: args.rounds,
        threads: args.threads,
        pin: args.pin.pin(),
        size: args.size.unwrap_or(if args.micro { STEPS_SIZE } else { SIZE }),
        build: args.build,
    }
}

/// What `measure` finds out about all scenes; it also gets what to tell people.
fn of_each_scene<T>(args: &BenchArgs, measure: impl Fn(&Scene, &str) -> Result<Vec<T>>) -> Result<Vec<T>> {
    let unless_named: &[&str] = if args.micro { &[STEPS_OF] } else { &SCENES };
    let mut rows = Vec::new();
    each_scene(&specs(&args.scenes, unless_named), |_, scene, place| {
        rows.extend(measure(scene, place)?);
        Ok(())
    })?;
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
