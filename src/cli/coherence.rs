//! `irt coherence`.

use super::{
    args::{CoherenceArgs, Talk},
    export::TableExports,
    interrupt, terminal,
};
use crate::{
    error::{Error, Result},
    film::Film,
    output::{OutputFile, PendingFile},
    render::choose_kernels,
    report::{Report, coherence_report, finding_table, sweep_plots, sweep_report},
    scene::{Scene, load, procedural},
    study::coherence::{
        CoherenceOptions, SceneCoherence, coherence, findings, primary_map, shadow_map, sweep,
    },
    tile::Order,
};
use std::{io::Write, path::Path};

/// Scenes unless others are named: those built in as counterparts of the thesis' five.
const SCENES: [&str; 5] = ["statue", "office", "nave", "atrium", "hall"];
/// Size of the image unless another is given: the thesis'.
const SIZE: [u32; 2] = [256; 2];

/// Repeats the thesis' study of coherence.
///
/// # Errors
/// Whatever is wrong with the arguments, a scene or an export; [`Error::Failed`] if a pass gives another image.
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
    each_scene(args, |scene, place| {
        let result = coherence(scene, &options, |what| tell(talk, &format!("{place}: {what}")))?;
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
    for scene in scenes(args) {
        let built_in = procedural::NAMES.contains(&scene);
        let specs: Vec<String> = if built_in {
            DETAILS.iter().map(|detail| format!("{scene}{detail}")).collect()
        } else {
            vec![scene.into()]
        };
        for spec in specs {
            let scene = load(&spec)?;
            for side in SIDES {
                tell(talk, &format!("{spec}, {side}x{side}"));
                points.extend(sweep(&scene, &spec, [side; 2], args.isa.isa(), args.build)?);
            }
        }
    }
    let findings = findings(&points);
    if let Some(folder) = &args.plots {
        for (name, plot) in sweep_plots(&findings) {
            let svg = plot.to_svg()?;
            PendingFile::create(&folder.join(name))?.complete(|out| out.write_all(svg.as_bytes()))?;
        }
    }
    let taken = exports.is_stdout();
    exports.write_report(&sweep_report(&points, &findings))?;
    if taken { Ok(()) } else { terminal::print(&finding_table(&findings).to_terminal()) }
}

fn scenes(args: &CoherenceArgs) -> Vec<&str> {
    let named: Vec<&str> = args.scenes.iter().map(String::as_str).collect();
    if named.is_empty() { SCENES.to_vec() } else { named }
}

fn show(exports: TableExports, report: &Report) -> Result<()> {
    let taken = exports.is_stdout();
    exports.write_report(report)?;
    if taken { Ok(()) } else { terminal::print(&report.to_terminal()) }
}

fn options(args: &CoherenceArgs) -> CoherenceOptions {
    let mut orders: Vec<Order> = Vec::new();
    for &order in &args.orders {
        if !orders.contains(&order) {
            orders.push(order);
        }
    }
    CoherenceOptions {
        isa: args.isa.isa(),
        build: args.build,
        size: args.size.unwrap_or(SIZE),
        orders,
        tile: args.tile,
        rounds: args.rounds,
        shadow_rays: args.shadow_rays,
        end_at_light: args.end_at_light,
        caches: !args.no_caches,
    }
}

fn each_scene(args: &CoherenceArgs, mut measure: impl FnMut(&Scene, &str) -> Result<()>) -> Result<()> {
    let scenes = scenes(args);
    for (index, spec) in scenes.iter().enumerate() {
        let scene = load(spec)?;
        scene.warnings.iter().for_each(|warning| log::warn!("{warning}"));
        if scene.lights.is_empty() {
            log::warn!("{} has no light, so that there are no shadow rays", scene.name);
        }
        measure(&scene, &format!("scene {} of {}, {}", index + 1, scenes.len(), scene.name))?;
    }
    Ok(())
}

fn tell(talk: Talk, text: &str) {
    if !talk.quiet {
        terminal::note(&format!("irt: {text}\n"));
    }
}

fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::file(folder, format!("cannot be made ({error})"), "name another folder"))
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
