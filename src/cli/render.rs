//! `irt render`.

use super::{
    animate,
    args::{RenderArgs, Talk},
    export::Export,
    interrupt,
    options::{check, render_options, replace_sampling, replace_view},
    terminal::{self, Progress},
    wish::{grant, refuse_for_many_images},
};
use crate::{
    effects::Effect,
    error::Result,
    film::Film,
    output::{OutputFile, Tev},
    render::{FrameReport, RenderOptions, Rendered, render_watched},
    report::{BuildSummary, FrameSummary, RayCounts, StageSeconds, Summary, WorkerSummary, to_json},
    scene::{Scene, load},
    schedule::{Control, Machine, Placement},
};
use std::collections::BTreeMap;
use std::time::Instant;

/// Renders a scene to a file and sums up what it took.
///
/// # Errors
/// Whatever is wrong with the arguments, the scene or the disk; no file is left behind then.
pub(super) fn run(args: &RenderArgs, talk: Talk) -> Result<()> {
    check(args)?;
    interrupt::install()?;
    // Of numbered images the first: whatever would prevent writing is known before the work.
    let first = animate::image(&args.output, 0);
    let output = OutputFile::create(first.as_ref().unwrap_or(&args.output))?;
    let export = Export::open(args.export_json.as_deref())?;

    let start = Instant::now();
    let mut scene = load(&args.scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    for warning in &scene.warnings {
        log::warn!("{warning}");
    }
    let own_camera = scene.camera;
    replace_view(&mut scene, &args.view)?;
    replace_sampling(&mut scene, &args.sampling);
    animate::pose(&mut scene, args)?;
    if first.is_some() {
        refuse_for_many_images(&args.wish)?;
        drop(output);
        return animate::run(args, scene, load_seconds, export, talk);
    }
    let mut options = render_options(args, &scene)?;
    // What accuracy costs is known from the scene's own camera, for all others as well.
    let camera = std::mem::replace(&mut scene.camera, own_camera);
    grant(&args.wish, &mut scene, &mut options, talk)?;
    scene.camera = camera;
    let mut viewer =
        args.tev.as_deref().map(|tev| Tev::connect(tev, &scene.name, options.size)).transpose()?;
    let rendered = render_with_progress(&scene, &options, &mut viewer, talk)?;
    warn_about(&scene, &rendered);

    let start = Instant::now();
    output.write(&rendered.film, args.exposure)?;
    let write_seconds = start.elapsed().as_secs_f64();
    log::info!("{} is written", args.output.display());
    let summary = summarise(&scene, &options, &rendered, load_seconds, write_seconds);
    let stdout_taken = export.is_stdout();
    export.write(|| to_json(&summary))?;
    if talk.quiet { Ok(()) } else { terminal::results(&summary.to_string(), stdout_taken, talk) }
}

fn render_with_progress(
    scene: &Scene,
    options: &RenderOptions,
    viewer: &mut Option<Tev>,
    talk: Talk,
) -> Result<Rendered> {
    let placement = Placement::new(Machine::get(), options.threads, options.pin);
    placement.notes().iter().for_each(|note| log::warn!("{note}"));
    let bar = Progress::new(options.frames, talk);
    let tick = |frame: crate::schedule::Progress| bar.tick(frame.total as u64 * u64::from(options.frames));
    let mut watch = |tile, film: &Film| {
        if let Some(Err(error)) = viewer.as_mut().map(|viewer| viewer.update(tile, film)) {
            log::warn!("the viewer of --tev was closed ({error}); rendering goes on without it");
            *viewer = None;
        }
    };
    render_watched(scene, options, &Control::new(interrupt::flag(), &tick), &mut watch)
}

/// Tells about what is probably not what the user wanted.
fn warn_about(scene: &Scene, rendered: &Rendered) {
    let lit =
        rendered.effects.has_any(&[Effect::SoftShadows, Effect::EnvironmentLight, Effect::IndirectLight]);
    if scene.lights.is_empty() && !lit {
        log::warn!("the scene has no light, only ambient light is seen; add some with --light X,Y,Z");
    }
    if let Some(nan) = rendered.nan {
        log::warn!(
            "{} pixels, the first at ({}, {}), came out as NaN or infinite and were written black; weaken the lights, or \
             please report this",
            nan.count,
            nan.x,
            nan.y
        );
    }
}

fn summarise(
    scene: &Scene,
    options: &RenderOptions,
    rendered: &Rendered,
    load_seconds: f64,
    write_seconds: f64,
) -> Summary {
    let workers = workers(&rendered.frames);
    let per_worker = 1.0 / workers.len().max(1) as f64;
    let sum = |seconds: fn(&FrameReport) -> f64| rendered.frames.iter().map(seconds).sum::<f64>();
    Summary {
        scene: scene.name.clone(),
        triangles: scene.mesh.len() as u64,
        size: options.size,
        threads: workers.len(),
        isa: rendered.isa.to_string(),
        kernel: options.kernel.to_string(),
        order: options.order.to_string(),
        schedule: options.schedule.strategy.to_string(),
        film: options.schedule.film.to_string(),
        tile: options.tile,
        visibility: options.visibility.to_string(),
        effects: rendered.effects.iter().map(|effect| effect.to_string()).collect(),
        build: BuildSummary {
            seconds: rendered.build_seconds,
            bytes: rendered.tree_bytes as u64,
            preset: options.build.to_string(),
        },
        load_seconds,
        stages: StageSeconds {
            load: load_seconds,
            build: rendered.build_seconds,
            trace: sum(|frame| frame.trace_seconds) * per_worker,
            shade: sum(|frame| frame.shade_seconds) * per_worker,
            write: write_seconds,
        },
        frames: rendered.frames.iter().map(frame_summary).collect(),
        counters: counters(rendered, &workers),
        workers,
    }
}

/// Rays by kind.
pub(super) fn ray_counts(FrameReport { rays, .. }: &FrameReport) -> RayCounts {
    RayCounts {
        primary: rays.primary,
        shadow: rays.shadow,
        reflection: rays.reflection,
        refraction: rays.refraction,
        indirect: rays.indirect,
        ambient: rays.ambient,
    }
}

fn frame_summary(frame: &FrameReport) -> FrameSummary {
    let rays = ray_counts(frame);
    FrameSummary {
        seconds: frame.seconds,
        rays,
        mrays_per_s: rays.total() as f64 / frame.seconds.max(1e-9) * 1e-6,
        image_sha256: frame.image_sha256.clone(),
    }
}

/// Each worker, over all frames.
fn workers(frames: &[FrameReport]) -> Vec<WorkerSummary> {
    let mut sums: Vec<WorkerSummary> = vec![];
    for frame in frames {
        sums.resize_with(frame.workers.len(), || WorkerSummary {
            pinned: String::new(),
            busy_seconds: 0.0,
            tiles: 0,
        });
        for (sum, worker) in sums.iter_mut().zip(&frame.workers) {
            sum.pinned = worker.pinned.to_string();
            sum.busy_seconds += worker.busy_seconds;
            sum.tiles += worker.tiles as u64;
        }
    }
    sums
}

fn counters(rendered: &Rendered, workers: &[WorkerSummary]) -> BTreeMap<String, u64> {
    let sum = |doubts: fn(&FrameReport) -> u64| rendered.frames.iter().map(doubts).sum();
    BTreeMap::from([
        ("exact_primary".into(), sum(|frame| frame.doubts.primary)),
        ("exact_shadow".into(), sum(|frame| frame.doubts.shadow)),
        ("tiles".into(), workers.iter().map(|worker| worker.tiles).sum()),
        ("nan_pixels".into(), rendered.nan.map_or(0, |nan| nan.count)),
    ])
}
