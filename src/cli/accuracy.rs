//! `irt accuracy`.

use super::{
    args::Talk,
    common::{each_scene, make_folder, specs},
    export::{Export, TableExports},
    interrupt,
    study_args::AccuracyArgs,
    terminal::{self, Meter},
};
use crate::{
    effects::EffectChoice,
    error::{Error, Result},
    kernels::Visibility,
    output::OutputFile,
    render::{RenderOptions, choose_kernels},
    report::{accuracy_page, accuracy_report},
    schedule::{Control, FilmMode, Machine, Placement, Schedule, Strategy},
    study::accuracy::{Battery, Effort, Patience, SceneAccuracy, Step, accuracy, heat},
    tile::Order,
    trace::{EarlyTermination, KernelChoice},
};
use std::path::Path;

/// Scenes unless others are named.
const SCENES: [&str; 2] = ["atrium", "gallery"];

/// Measures what accuracy costs.
///
/// # Errors
/// Whatever is wrong with the arguments, a scene or an export.
pub(super) fn run(args: &AccuracyArgs, talk: Talk) -> Result<()> {
    choose_kernels(args.kernels.isa())?;
    interrupt::install()?;
    let exports = TableExports::open(&args.export)?;
    let page = Export::open(args.report.as_deref())?;
    if page.is_stdout() && exports.is_stdout() {
        let remedy = "give one of them a file name";
        return Err(Error::flag("--report", "it cannot share standard output with an export", remedy));
    }
    args.maps.iter().try_for_each(|folder| make_folder(folder))?;
    let (options, effort) = (options(args), effort(args));
    let notes = Placement::new(Machine::get(), options.threads, options.pin);
    notes.notes().iter().for_each(|note| log::warn!("{note}"));
    let mut battery = Battery::new(interrupt::flag());
    let mut all = vec![];
    each_scene(&specs(&args.scenes, &SCENES), |_, scene, place| {
        terminal::tell(talk, place);
        let meter = Meter::new(talk);
        let milliseconds = |seconds: f64| (1e3 * seconds) as u64;
        let tell = |step: Step| meter.tell("modes", milliseconds(step.done), milliseconds(step.of));
        let control = Control::new(interrupt::flag(), &|_| {});
        let measured = accuracy(scene, &options, &effort, &mut battery, &control, &tell)?;
        if let Some(folder) = &args.maps {
            write_maps(folder, &measured)?;
        }
        all.push(measured);
        Ok(())
    })?;
    let report = accuracy_report(&all);
    let taken = exports.is_stdout() || page.is_stdout();
    page.write(|| accuracy_page(&all))?;
    exports.write_report(&report)?;
    if taken { Ok(()) } else { terminal::print(&report.to_terminal()) }
}

/// A map for each mode that differs anywhere.
fn write_maps(folder: &Path, scene: &SceneAccuracy) -> Result<()> {
    for row in scene.rows.iter().filter(|row| row.map.iter().any(|&difference| difference > 0.0)) {
        let name = format!("{}-{}.png", scene.scene, row.mode.to_string().replace([' ', '/'], "-"));
        OutputFile::create(&folder.join(name))?.write(&heat(&row.map, scene.size), 0.0)?;
    }
    Ok(())
}

fn effort(args: &AccuracyArgs) -> Effort {
    let effort = if args.quick { Effort::QUICK } else { Effort::FULL };
    let least = args.rounds.unwrap_or(effort.patience.least);
    let side = args.side.unwrap_or(effort.side);
    let rays = args.rays.unwrap_or(effort.aimed[0]);
    let asked = args.side.is_some()
        || rays > effort.aimed[0]
        || args.rounds.is_some()
        || args.converged > effort.converged;
    Effort {
        side,
        reference_side: effort.reference_side.min(side),
        converged: args.converged,
        aimed: [rays, rays.div_ceil(3)],
        patience: Patience { least, most: effort.patience.most.max(least), ..effort.patience },
        dearest: effort.dearest,
        // Who asks for more gets it.
        seconds: if asked { f64::INFINITY } else { effort.seconds },
    }
}

fn options(args: &AccuracyArgs) -> RenderOptions {
    RenderOptions {
        isa: args.kernels.isa(),
        kernel: KernelChoice::default(),
        visibility: Visibility::default(),
        threads: args.threads,
        pin: args.pin.pin(),
        order: Order::default(),
        schedule: Schedule { strategy: Strategy::default(), film: FilmMode::default() },
        tile: 32,
        size: [1, 1],
        frames: 1,
        build: args.kernels.build,
        seed: 0,
        early: EarlyTermination::default(),
        effects: EffectChoice::Auto,
    }
}
