//! `irt scaling`.

use super::{
    args::Talk,
    common::{each_scene, make_folder, once_each, specs, write_text},
    export::TableExports,
    interrupt, options,
    study_args::ScalingArgs,
    terminal,
};
use crate::{
    effects::EffectChoice,
    error::{Error, Result},
    kernels::Visibility,
    output::OutputFile,
    render::{RenderOptions, choose_kernels},
    report::{
        ScalingRecord, idle_table, limits_table, scaling_table, significant, sizes_table, thesis_table,
        timeline_svg, timeline_trace, to_json, validation_table, worker_map,
    },
    scene::Scene,
    schedule::{Control, FilmMode, Machine, Placement, Schedule, Strategy},
    study::scaling::{Costs, Flow, ScalingOptions, ScalingRow, overhead_per_tile, scaling, tile_sizes},
    trace::{EarlyTermination, KernelChoice},
};
use std::path::Path;

/// Scenes unless others are named: those built in as counterparts of the thesis' four.
const SCENES: [&str; 4] = ["statue", "office", "nave", "atrium"];
/// Sides of the tiles that `--tiles` compares.
const SIDES: [u32; 6] = [16, 32, 64, 128, 256, 512];

/// Measures and simulates strategies, or sizes of tiles.
///
/// # Errors
/// Whatever is wrong with the arguments, a scene or an export; [`Error::Failed`] if two strategies give different
/// images.
pub(super) fn run(args: &ScalingArgs, talk: Talk) -> Result<()> {
    choose_kernels(args.kernels.isa())?;
    let schedule = if args.tiles { Some(one_schedule(args)?) } else { None };
    interrupt::install()?;
    let exports = TableExports::open(&args.export)?;
    if let Some(folder) = &args.pictures {
        make_folder(folder)?;
    }
    let pin = args.pin.pin();
    Placement::new(Machine::get(), None, pin).notes().iter().for_each(|note| log::warn!("{note}"));
    let costs = Costs::measure(pin)?;
    log::debug!("messages in seconds: {costs:?}");
    match schedule {
        Some(schedule) => sizes(args, schedule, talk, &costs, exports),
        None => strategies(args, talk, &costs, exports),
    }
}

fn strategies(args: &ScalingArgs, talk: Talk, costs: &Costs, exports: TableExports) -> Result<()> {
    let mut told = told_costs(costs, args.pin.pin())?;
    let mut all: Vec<ScalingRow> = vec![];
    each_scene(&specs(&args.scenes, &SCENES), |spec, scene, place| {
        terminal::tell(talk, place);
        let options = study_options(args, scene, spec)?;
        let rows = scaling(scene, &options, costs, &Control::new(interrupt::flag(), &|_| {}))?;
        if let Some(folder) = &args.pictures {
            rows.iter().try_for_each(|row| pictures(folder, row, options.render.size))?;
        }
        for film in FilmMode::ALL.into_iter().filter(|film| rows.iter().any(|row| row.schedule.film == *film))
        {
            told += &thesis_table(&rows, &scene.name, film).to_terminal();
        }
        all.extend(rows);
        Ok(())
    })?;
    told += "* simulated. A cell is frames per second and efficiency T1 / (n Tn).\n";
    told += &told_flow(flow(args));
    for table in [idle_table(&all), validation_table(&all), limits_table(&all)] {
        if !table.rows().is_empty() {
            told += &format!("\n{}", table.to_terminal());
        }
    }
    let records: Vec<ScalingRecord> = all.iter().map(ScalingRecord::from).collect();
    let taken = exports.is_stdout();
    exports.write_files(&records, &scaling_table(&all))?;
    terminal::results(&told, taken, talk)
}

fn sizes(
    args: &ScalingArgs,
    schedule: Schedule,
    talk: Talk,
    costs: &Costs,
    exports: TableExports,
) -> Result<()> {
    let mut all = vec![];
    each_scene(&specs(&args.scenes, &SCENES), |spec, scene, place| {
        terminal::tell(talk, place);
        let options = study_options(args, scene, spec)?;
        let options = ScalingOptions { render: RenderOptions { schedule, ..options.render }, ..options };
        let [width, height] = options.render.size;
        let sides: Vec<u32> = SIDES.into_iter().filter(|&side| side <= width.max(height)).collect();
        let control = Control::new(interrupt::flag(), &|_| {});
        all.extend(tile_sizes(scene, &options, &sides, costs, &control)?);
        Ok(())
    })?;
    exports.write(&sizes_table(&all))
}

/// The schedule under which `--tiles` compares sizes.
fn one_schedule(args: &ScalingArgs) -> Result<Schedule> {
    let Some(strategy) = at_most_one(&args.strategies) else { return Err(too_many("--strategies")) };
    let Some(film) = at_most_one(&args.films) else { return Err(too_many("--films")) };
    Ok(Schedule { strategy, film })
}

/// The one that is named, or the default; `None` if there are several.
fn at_most_one<T: Copy + Default + PartialEq>(named: &[T]) -> Option<T> {
    match once_each(named.iter().copied())[..] {
        [] => Some(T::default()),
        [one] => Some(one),
        _ => None,
    }
}

fn too_many(flag: &str) -> Error {
    Error::flag(flag, "--tiles compares sizes under one of them only", "name one, or leave the flag out")
}

/// What the scheduler itself takes on this machine.
fn told_costs(costs: &Costs, pin: bool) -> Result<String> {
    let mut told = String::new();
    let micro = |seconds: f64| significant(seconds * 1e6, 3);
    for strategy in Strategy::ALL {
        let schedule = Schedule { strategy, film: FilmMode::Shared };
        let seconds = overhead_per_tile(schedule, 1, pin)?;
        told += &format!("{strategy}: {} us per empty tile, one worker\n", micro(seconds));
    }
    let Costs { send, to_master, collect, steal, .. } = *costs;
    told += &format!(
        "message: {} us to send to who waits, {} us until it is read; report: {} us of the master; steal: {} us\n",
        micro(send),
        micro(to_master),
        micro(collect),
        micro(steal)
    );
    Ok(told)
}

fn study_options(args: &ScalingArgs, scene: &Scene, spec: &str) -> Result<ScalingOptions> {
    Ok(ScalingOptions {
        render: render_options(args, scene)?,
        schedules: schedules(args),
        workers: sorted(&args.workers),
        rounds: args.rounds,
        flow: flow(args),
        inflation: args.inflation,
        network: args.network,
        thesis_scene: thesis_scene(spec),
    })
}

fn flow(args: &ScalingArgs) -> Flow {
    Flow { frames: args.frames, in_flight: args.in_flight }
}

fn told_flow(Flow { frames, in_flight }: Flow) -> String {
    match in_flight {
        1 => format!(
            "Measured: single frames, {frames} for each worker, each begun when the one before was complete.\n"
        ),
        _ => {
            format!("Measured: streams of {frames} frames for each worker, {in_flight} of them in flight.\n")
        }
    }
}

/// The thesis' name of a scene that was described after it.
fn thesis_scene(spec: &str) -> Option<String> {
    let path = Path::new(spec);
    let folder = path.parent()?.file_name()?;
    (folder == "thesis").then(|| path.file_stem().map(|name| name.to_string_lossy().into_owned()))?
}

fn schedules(args: &ScalingArgs) -> Vec<Schedule> {
    let ScalingArgs { strategies, films, .. } = args;
    let asked_for = |schedule: &Schedule| {
        (strategies.is_empty() || strategies.contains(&schedule.strategy))
            && (films.is_empty() || films.contains(&schedule.film))
    };
    Schedule::all().filter(asked_for).collect()
}

fn sorted(workers: &[usize]) -> Vec<usize> {
    let mut sorted = workers.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    sorted
}

fn render_options(args: &ScalingArgs, scene: &Scene) -> Result<RenderOptions> {
    let size = args.size.unwrap_or(scene.size);
    options::check_tiles(size, args.tile)?;
    Ok(RenderOptions {
        isa: args.kernels.isa(),
        visibility: Visibility::default(),
        kernel: KernelChoice::default(),
        threads: None,
        pin: args.pin.pin(),
        order: args.order,
        schedule: Schedule::default(),
        tile: args.tile,
        size,
        frames: 1,
        build: args.kernels.build,
        early: EarlyTermination::default(),
        effects: EffectChoice::default(),
        seed: 0,
    })
}

/// Timeline and map of one row's frame.
fn pictures(folder: &Path, row: &ScalingRow, size: [u32; 2]) -> Result<()> {
    let Schedule { strategy, film } = row.schedule;
    let simulated = if row.simulated { "-simulated" } else { "" };
    let scene = row.scene.replace(['/', ' '], "-");
    let file =
        |ending: &str| folder.join(format!("{scene}-{strategy}-{film}-{}{simulated}.{ending}", row.workers));
    let title = format!(
        "{}: {strategy}, film {film}, {} workers{}, {} frames of {} ms",
        row.scene,
        row.workers,
        if row.simulated { " (simulated)" } else { "" },
        row.frame.frames,
        significant(row.frame.per_frame() * 1e3, 4)
    );
    write_text(&file("svg"), &timeline_svg(&title, &row.frame))?;
    write_text(&file("trace.json"), &to_json(&timeline_trace(&row.frame))?)?;
    OutputFile::create(&file("png"))?.write(&worker_map(&row.frame, size), 0.0)
}
