//! One image, from a scene to a film: the only place that knows all the parts.
//!
//! ```text
//!   scene -> tree, surface table                                  once
//!   tiles in order -> workers: rays -> hits -> surfaces -> light  per frame
//!         -> film
//! ```
//!
//! Where triangles move, tree and table follow from moment to moment, and the workers begin anew.
//!
//! A scene that calls for more than hard shadows, highlights and smooth normals has its light followed further.

mod animation;
mod adaptive;
mod follow;
mod passes;
mod places;
mod progressive;
mod scatter;
mod seeds;
mod session;
mod stage;
mod task;

pub use crate::{bvh::Update, shade::RayTally};
pub use animation::{Moment, animate};
pub use progressive::{Canvas, Level, Limit, Progressive, RayMap, Refined, Target, Tone, Traced};
pub use session::Session;
pub use stage::{Geometry, Stage};

use crate::{
    bvh::BuildPreset,
    effects::{EffectChoice, EffectSet},
    error::{Error, Result},
    film::{Film, NanPixels},
    kernels::{Isa, Kernels, Visibility},
    scene::Scene,
    schedule::{Control, Machine, Placement, Schedule, WorkerStats},
    tile::{Order, Tile},
    trace::{EarlyTermination, KernelChoice},
};

/// How to render; says nothing about what.
#[derive(Clone, Copy, Debug)]
pub struct RenderOptions {
    /// Instruction set; `None` takes the widest one of this machine.
    pub isa: Option<Isa>,
    /// Kernel for rays with a common origin.
    pub kernel: KernelChoice,
    /// How hits are decided.
    pub visibility: Visibility,
    /// Workers; `None` takes one per core.
    pub threads: Option<usize>,
    /// Pin each worker to a core.
    pub pin: bool,
    /// Order of the tiles.
    pub order: Order,
    /// Which worker gets which tile when, and how pixels reach the film.
    pub schedule: Schedule,
    /// Side of a tile in pixels, >= 1.
    pub tile: u32,
    /// Width and height of the image in pixels, each >= 1.
    pub size: [u32; 2],
    /// How often to render the image, >= 1.
    pub frames: u32,
    /// Quality of the tree.
    pub build: BuildPreset,
    /// Seed of the samplers.
    pub seed: u64,
    /// Which searches of the tile kernel end early, and what they begin with.
    pub early: EarlyTermination,
    /// Which effects are simulated, and by which kernel.
    pub effects: EffectChoice,
}

/// One finished frame.
#[derive(Clone, Debug)]
pub struct FrameReport {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Rays traced.
    pub rays: RayTally,
    /// Pairs of a ray and a triangle that were in doubt and decided exactly, by the kind of the ray.
    pub doubts: RayTally,
    /// Seconds the workers spent tracing, all together.
    pub trace_seconds: f64,
    /// Seconds the workers spent on everything else, all together.
    pub shade_seconds: f64,
    /// Hash of the linear pixels.
    pub image_sha256: String,
    /// What each worker did.
    pub workers: Vec<WorkerStats>,
}

/// An image and what it took.
#[derive(Debug)]
pub struct Rendered {
    /// The image.
    pub film: Film,
    /// Instruction set used.
    pub isa: Isa,
    /// Seconds to build the tree and the surface table.
    pub build_seconds: f64,
    /// Bytes of the tree with its triangles.
    pub tree_bytes: usize,
    /// Effects that were simulated.
    pub effects: EffectSet,
    /// One entry per frame.
    pub frames: Vec<FrameReport>,
    /// Pixels that came out as NaN or infinite and were written black: a defect to report, or lights beyond the range of
    /// f32.
    pub nan: Option<NanPixels>,
}

/// Chooses the kernels that `isa` asks for, with exact visibility.
///
/// # Errors
/// [`Error::Flag`] if this machine lacks that instruction set.
pub fn choose_kernels(isa: Option<Isa>) -> Result<Kernels> {
    let Some(isa) = isa else { return Ok(Kernels::detect()) };
    Kernels::for_isa(isa).ok_or_else(|| {
        let available: Vec<&str> = Isa::available().map(Isa::name).collect();
        let remedy = format!("use auto, or one of: {}", available.join(", "));
        Error::flag("--isa", format!("this machine has no {isa}"), remedy)
    })
}

/// Renders `scene`.
///
/// # Errors
/// [`Error::Flag`] for an instruction set that this machine lacks, [`Error::Interrupted`] if `control` was cancelled,
/// [`Error::Worker`] if a tile panicked, [`Error::Failed`] if the scene breaks a promise (see [`Scene::check`]) or the
/// tree cannot be built.
pub fn render(scene: &Scene, options: &RenderOptions, control: &Control) -> Result<Rendered> {
    render_watched(scene, options, control, &mut |_, _| {})
}

/// The same; `watch` gets each finished tile and the film that it is on, on this thread.
///
/// # Errors
/// As [`render`].
pub fn render_watched(
    scene: &Scene,
    options: &RenderOptions,
    control: &Control,
    watch: &mut dyn FnMut(Tile, &Film),
) -> Result<Rendered> {
    // The machine is enumerated and the tree built before any thread is pinned: pins are inherited.
    let placement = Placement::new(Machine::get(), options.threads, options.pin);
    let stage = Stage::new(scene, options)?;
    if control.cancelled() {
        return Err(Error::Interrupted);
    }
    let tiles = stage.tiles(options.tile);
    let mut frames = Vec::new();
    let film = stage.with_session(&placement, |session| {
        for _ in 0..options.frames {
            frames.push(session.reported_frame(options.schedule, &tiles, control, watch)?);
        }
        Ok(session.take_film())
    })?;
    let nan = film.nan();
    Ok(Rendered {
        film,
        isa: stage.kernels.isa(),
        build_seconds: stage.build_seconds,
        tree_bytes: stage.geometry.bvh.bytes(),
        effects: stage.set(),
        frames,
        nan,
    })
}
