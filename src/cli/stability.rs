//! `irt stability`.

use super::{
    args::Talk,
    export::TableExports,
    interrupt,
    study_args::StabilityArgs,
    terminal::{self, Meter},
};
use crate::{
    error::{Error, Result},
    kernels::{Isa, Kernels},
    render::choose_kernels,
    report::{
        Table, stability_cells, stability_errors, stability_fuzz, stability_images, stability_kernels,
        stability_places, stability_spawn,
    },
    schedule::{Machine, Placement},
    study::{
        bench::{Engine, check_engines},
        stability::{Kernel, Report, StabilityOptions, run as battery},
    },
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

/// Runs the battery and tells what it found.
///
/// # Errors
/// Whatever is wrong with the arguments or an export; [`Error::Failed`] if a promise is broken, after the figures have
/// been told.
pub(super) fn run(args: &StabilityArgs, talk: Talk) -> Result<()> {
    let options = options(args)?;
    check_engines(&options.engines)?;
    interrupt::install()?;
    let exports = TableExports::open(&args.export)?;
    let meter = Meter::new(talk);
    let tell = |stage: crate::study::stability::Stage| meter.tell(stage.name, stage.done, stage.of);
    let report = battery(&options, &tell, &|| interrupt::flag().load(Ordering::SeqCst))?;
    drop(meter);

    let cells = stability_cells(&report);
    let told = told(&report, &options, talk.verbose.then_some(&cells));
    let stdout_taken = exports.is_stdout();
    exports.write_files(&Export::new(&report, &options, &cells), &cells)?;
    terminal::results(&told, stdout_taken, talk)?;
    report.verdict()
}

fn options(args: &StabilityArgs) -> Result<StabilityOptions> {
    let kernels = match args.isa.isa() {
        Some(isa) => vec![choose_kernels(Some(isa))?],
        None => Isa::available().filter_map(Kernels::for_isa).collect(),
    };
    let kernels: Vec<Kernels> =
        kernels.into_iter().map(|kernels| kernels.with_visibility(args.visibility)).collect();
    let amounts = if args.quick { StabilityOptions::QUICK } else { StabilityOptions::FULL };
    let rays = args.rays.unwrap_or(amounts.rays);
    let engines: Vec<Engine> = args.engines.iter().copied().filter(|&engine| engine != Engine::Irt).collect();
    if engines.len() == args.engines.len() {
        return Err(Error::flag(
            "--engines",
            "irt is not among them",
            "add irt: it is what the battery tests",
        ));
    }
    Ok(StabilityOptions {
        kernels,
        ways: args.kernel.clone().unwrap_or_else(|| Kernel::ALL.into()),
        engines,
        rays,
        // The rest of the battery grows and shrinks with it.
        meshes: scaled(amounts.meshes, rays, amounts.rays),
        spawned: scaled(amounts.spawned, rays, amounts.rays),
        // Few tell what each option does on its own; more than these tell nothing new.
        images: scaled(amounts.images, rays, amounts.rays).clamp(FEWEST_IMAGES, amounts.images),
        threads: args.threads.unwrap_or_else(|| Placement::new(Machine::get(), None, false).slots().len()),
        seed: args.seed,
    })
}

/// Of each scene: each value of each option alone, and some combinations.
const FEWEST_IMAGES: u64 = 50;

fn scaled(amount: u64, rays: u64, of: u64) -> u64 {
    (u128::from(amount) * u128::from(rays)).div_ceil(u128::from(of)) as u64
}

/// Everything for people.
fn told(report: &Report, options: &StabilityOptions, cells: Option<&Table>) -> String {
    let mut text = String::new();
    let mut section =
        |title: &str, table: &Table| text.push_str(&format!("{title}\n{}\n", table.to_terminal()));
    if let Some(cells) = cells {
        section("Closed meshes, by cell", cells);
    }
    section("Closed meshes, by kernel", &stability_kernels(report));
    section("Closed meshes, by place", &stability_places(report));
    section("Random meshes", &stability_fuzz(report));
    section("Errors against the oracle, in units in the last place", &stability_errors(report));
    section("Rays that start or end on a surface", &stability_spawn(report));
    section("Images", &stability_images(report));
    let isas: Vec<&str> = options.kernels.iter().map(|kernels| kernels.isa().name()).collect();
    let double = report.leaks.double;
    text.push_str(&format!(
        "{double} of {} judged rays hit two triangles at one depth, through an edge or a vertex; the lower number wins\n\
         {}, {} images, {}: {}\n",
        report.leaks.accuracy.judged,
        isas.join(", "),
        report.images.images,
        format_args!("seed {}", options.seed),
        if report.broken().is_empty() { "visibility is exact" } else { "visibility is NOT exact" }
    ));
    text
}

/// `--export-json`.
#[derive(Serialize)]
struct Export<'a> {
    seed: u64,
    threads: usize,
    isas: Vec<&'static str>,
    exact: bool,
    /// Promises broken, by name.
    broken: BTreeMap<&'static str, u64>,
    first: Option<&'a str>,
    cells: &'a Table,
    random_meshes: Table,
    errors: Table,
    spawned: Table,
    images: Table,
    double_hits: u64,
}

impl<'a> Export<'a> {
    fn new(report: &'a Report, options: &StabilityOptions, cells: &'a Table) -> Export<'a> {
        let broken: BTreeMap<&str, u64> = report.broken().into_iter().collect();
        Export {
            seed: options.seed,
            threads: options.threads,
            isas: options.kernels.iter().map(|kernels| kernels.isa().name()).collect(),
            exact: broken.is_empty(),
            broken,
            first: report.first(),
            cells,
            random_meshes: stability_fuzz(report),
            errors: stability_errors(report),
            spawned: stability_spawn(report),
            images: stability_images(report),
            double_hits: report.leaks.double,
        }
    }
}
