//! `irt coherence`.

use super::{
    args::Talk,
    common::{each_scene, make_folder, once_each, specs, write_text},
    export::TableExports,
    interrupt,
    study_args::CoherenceArgs,
    terminal,
};
use crate::{
    error::Result,
    film::Film,
    output::OutputFile,
    render::choose_kernels,
    report::{Report, coherence_report, finding_table, sweep_plots, sweep_report},
    scene::procedural,
    study::coherence::{
        CoherenceOptions, SceneCoherence, coherence, findings, primary_map, shadow_map, sweep,
    },
};
use std::path::Path;

/// Scenes unless others are named: those built in as counterparts of the thesis' five.
const SCENES: [&str; 5] = ["statue", "office", "nave", "atrium", "hall"];
/// Size of the image unless another is given: the thesis'.
const SIZE: [u32; 2] = [256; 2];

/// Repeats the thesis' study of coherence.
///
/// # Errors
/// Whatever is wrong with the arguments, a scene or an export; [`crate::error::Error::Failed`] if a pass gives another
/// image.
pub(super) fn run(args: &CoherenceArgs, talk: Talk) -> Result<()> {
    let options = options(args);
    choose_kernels(options.isa)?;
    interrupt::install()?;
    let exports = TableExports::open(&args.export)?;
    for folder in args.maps.iter().chain(&args.plots) {
        make_folder(folder)?;
    }
    if args.sweep {
        return sweep_all(args, talk, exports);
    }
    let mut measured = Vec::new();
    each_scene(&specs(&args.scenes, &SCENES), |_, scene, place| {
        let result = coherence(scene, &options, |what| terminal::tell(talk, &format!("{place}: {what}")))?;
        if let Some(folder) = &args.maps {
            write_maps(folder, &result)?;
        }
        measured.push(result);
        Ok(())
    })?;
    show(exports, &coherence_report(&measured))
}

/// Details of built-in scenes in the sweep, and sides of its images in pixels.
const DETAILS: [&str; 3] = ["@0.2", "@0.5", ""];
const SIDES: [u32; 3] = [64, 128, 256];

/// `irt coherence --sweep`.
fn sweep_all(args: &CoherenceArgs, talk: Talk, exports: TableExports) -> Result<()> {
    let mut points = Vec::new();
    let in_details = |scene: &str| match procedural::NAMES.contains(&scene) {
        true => DETAILS.map(|detail| format!("{scene}{detail}")).to_vec(),
        false => vec![scene.to_string()],
    };
    let all: Vec<String> = specs(&args.scenes, &SCENES).into_iter().flat_map(in_details).collect();
    each_scene(&specs(&all, &[]), |spec, scene, _| {
        for side in SIDES {
            terminal::tell(talk, &format!("{spec}, {side}x{side}"));
            points.extend(sweep(scene, spec, [side; 2], args.kernels.isa(), args.kernels.build)?);
        }
        Ok(())
    })?;
    let findings = findings(&points);
    if let Some(folder) = &args.plots {
        for (name, plot) in sweep_plots(&findings) {
            write_text(&folder.join(name), &plot.to_svg()?)?;
        }
    }
    let taken = exports.is_stdout();
    exports.write_report(&sweep_report(&points, &findings))?;
    if taken { Ok(()) } else { terminal::print(&finding_table(&findings).to_terminal()) }
}

fn show(exports: TableExports, report: &Report) -> Result<()> {
    let taken = exports.is_stdout();
    exports.write_report(report)?;
    if taken { Ok(()) } else { terminal::print(&report.to_terminal()) }
}

fn options(args: &CoherenceArgs) -> CoherenceOptions {
    CoherenceOptions {
        isa: args.kernels.isa(),
        build: args.kernels.build,
        size: args.size.unwrap_or(SIZE),
        orders: once_each(args.orders.iter().copied()),
        tile: args.tile,
        rounds: args.rounds,
        shadow_rays: args.shadow_rays,
        end_at_light: args.end_at_light,
        caches: !args.no_caches,
    }
}

/// Figures 15 to 30: a map of each kind for each order.
fn write_maps(folder: &Path, scene: &SceneCoherence) -> Result<()> {
    let write = |name: String, film: &Film| OutputFile::create(&folder.join(name))?.write(film, 0.0);
    for walk in &scene.walks {
        let name = |kind: &str| {
            format!("{}-{}-{}x{}-{kind}.png", scene.scene, walk.order, scene.size[0], scene.size[1])
        };
        write(name("primary"), &primary_map(&walk.primary.map, scene.size))?;
        write(name("shadow"), &shadow_map(&walk.map, scene.size))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{SCENES, procedural};

    #[test]
    fn the_scenes_are_built_in() {
        assert!(SCENES.iter().all(|scene| procedural::NAMES.contains(scene)));
    }
}
