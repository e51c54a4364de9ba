//! What was typed. Values are checked one by one here; what they mean together is settled in `options`.

use super::study_args::{AccuracyArgs, BenchArgs, CoherenceArgs, ScalingArgs, StabilityArgs};
use super::value::{
    IsaChoice, budget, field_of_view, max_error, milliseconds, number, one_of, positive_share, rate, seconds,
    share, size, vector, whole,
};
use crate::{
    bvh::BuildPreset,
    effects::EffectChoice,
    kernels::{Isa, Visibility},
    scene::procedural,
    schedule::{FilmMode, Strategy},
    tile::Order,
    trace::{EarlyTermination, KernelChoice},
};
use clap::{Args, Parser, Subcommand};
use glam::Vec3;
use std::path::PathBuf;

/// Render, inspect and list scenes with pinned workers, ordered tiles and SIMD kernels.
#[derive(Debug, Parser)]
#[command(name = "irt", version, propagate_version = true)]
pub(super) struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub(super) command: Command,
    /// How much to tell.
    #[command(flatten)]
    pub(super) talk: Talk,
}

/// How much is told on the terminal.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct Talk {
    /// Tell nothing but results and errors: no progress, no warnings, no summary of a render
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(super) quiet: bool,
    /// Tell also what helps to find a fault
    #[arg(short, long, global = true)]
    pub(super) verbose: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a scene to an image file
    Render(Box<RenderArgs>),
    /// Look around in a scene in a window, or play a script of what a user does there, and tell how it felt
    View(Box<ViewerArgs>),
    /// Tell what is in a scene, and how good the tree over it is
    Inspect(InspectArgs),
    /// List the built-in and the described scenes
    Scenes(ScenesArgs),
    /// Time traversal kernels side by side, on the same rays
    Bench(BenchArgs),
    /// Trace a file of arbitrary rays
    Trace(TraceArgs),
    /// Prove that visibility is exact: aimed rays, hard meshes, spawned rays, every kernel and instruction set
    Stability(StabilityArgs),
    /// Show what accuracy costs: every approximation's time, and its error against a reference
    Accuracy(AccuracyArgs),
    /// Repeat the thesis' study of coherence: what consecutive rays share, and what remembering it saves
    Coherence(CoherenceArgs),
    /// Measure scheduling strategies by number of workers, and simulate more workers than there are
    Scaling(Box<ScalingArgs>),
}

/// `irt render`.
#[derive(Args, Debug)]
pub(super) struct RenderArgs {
    /// A TOML scene, an OBJ file or the name of a built-in scene
    #[arg(default_value = procedural::DEFAULT)]
    pub(super) scene: String,
    /// Image to write; its extension tells the format: .png, .exr, .hdr or .pfm. With %04d in its name, images of all of
    /// the motion of a scene, numbered from 0000
    #[arg(short, long, value_name = "FILE", default_value = "render.png")]
    pub(super) output: PathBuf,
    /// Exposure in stops, for .png only: the other formats keep linear values
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = number, allow_hyphen_values = true)]
    pub(super) exposure: f32,
    /// Width and height of the image in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,
    /// Render the image this many times, to measure
    #[arg(
        long, value_name = "N", default_value = "1",
        value_parser = whole(1..=1_000_000u32), allow_negative_numbers = true
    )]
    pub(super) frames: u32,
    /// Moment of a moving scene in seconds [default: 0]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub(super) time: Option<f64>,
    /// Numbered images per second of motion [default: the scene's]
    #[arg(long, value_name = "N", value_parser = rate, allow_negative_numbers = true)]
    pub(super) fps: Option<f64>,
    /// Send tiles to the image viewer tev as they are finished; it listens at 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT")]
    pub(super) tev: Option<String>,
    /// Seed of the samplers
    #[arg(
        long, value_name = "N", default_value = "0",
        value_parser = whole(0..=u64::MAX), allow_negative_numbers = true
    )]
    pub(super) seed: u64,
    /// Write the figures of the summary as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(super) export_json: Option<PathBuf>,
    #[command(flatten)]
    pub(super) wish: WishArgs,
    #[command(flatten)]
    pub(super) view: ViewArgs,
    #[command(flatten)]
    pub(super) sampling: SamplingArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
}

/// What the image is to be like, instead of how it is made.
#[derive(Args, Clone, Copy, Debug)]
#[command(
    next_help_heading = "Accuracy and time (modes are chosen by a study, once for a scene and machine)"
)]
pub(super) struct WishArgs {
    /// Choose the cheapest modes whose image is no farther than this RMSE from one of very many samples: of linear values
    /// in [0, 1], such as 0.01
    #[arg(
        long, value_name = "RMSE", value_parser = max_error, allow_negative_numbers = true,
        conflicts_with_all = CHOSEN
    )]
    pub(super) max_error: Option<f64>,
    /// Choose the most accurate modes that build the tree and render all frames in so many seconds; with --max-error, the
    /// cheapest that keep both
    #[arg(
        long, value_name = "SECONDS", value_parser = budget, allow_negative_numbers = true,
        conflicts_with_all = CHOSEN
    )]
    pub(super) time_budget: Option<f64>,
}

/// Flags that would set what wishes choose.
const CHOSEN: [&str; 7] =
    ["samples", "light_samples", "bounces", "max_depth", "cutoff", "visibility", "build"];

/// How far light is followed, and by how many samples.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Sampling")]
pub(super) struct SamplingArgs {
    /// Camera rays per pixel [default: the scene's, or 1]
    #[arg(long, value_name = "N", value_parser = whole(1..=65_536u32), allow_negative_numbers = true)]
    pub(super) samples: Option<u32>,
    /// Take more than one sample only of pixels that differ from a neighbour by more than this share of the range that a
    /// screen shows, 0.03 for instance, and all only where three eighths of them scatter [default: the scene's, or all
    /// pixels]
    #[arg(long, value_name = "SHARE", value_parser = positive_share, allow_negative_numbers = true)]
    pub(super) adaptive: Option<f32>,
    /// Shadow rays per camera ray to each light with an extent [default: the scene's, or 16]
    #[arg(long, value_name = "N", value_parser = whole(1..=65_536u32), allow_negative_numbers = true)]
    pub(super) light_samples: Option<u32>,
    /// Diffuse reflections that indirect light is followed over [default: the scene's, or 0]
    #[arg(long, value_name = "N", value_parser = whole(0..=1024u32), allow_negative_numbers = true)]
    pub(super) bounces: Option<u32>,
    /// Reflections and refractions in a row after which light ends [default: the scene's, or 8]
    #[arg(long, value_name = "N", value_parser = whole(0..=1024u32), allow_negative_numbers = true)]
    pub(super) max_depth: Option<u32>,
    /// Share of a pixel below which light is not followed [default: the scene's, or 1/512]
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub(super) cutoff: Option<f32>,
}

/// `irt view`.
#[derive(Args, Debug)]
pub(super) struct ViewerArgs {
    /// A TOML scene, an OBJ file or the name of a built-in scene
    #[arg(default_value = procedural::DEFAULT)]
    pub(super) scene: String,
    /// Play a script without a window, and tell how it felt: lines of seconds and deeds such as `0.5 press w`
    #[arg(long, value_name = "FILE")]
    pub(super) script: Option<PathBuf>,
    /// Width and height of the picture in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,
    /// How long a frame may take while the camera moves
    #[arg(long, value_name = "MS", default_value = "33", value_parser = milliseconds)]
    pub(super) frame_time: f64,
    /// Draw in the terminal, two pixels to a character, instead of a window; --size does not count then
    #[arg(long, conflicts_with = "script")]
    pub(super) terminal: bool,
    /// Write every frame of the script to this folder as a PNG, with all that lies over it; it slows the frames down
    #[arg(long, value_name = "DIR", requires = "script")]
    pub(super) record: Option<PathBuf>,
    /// Write the figures of every frame of the script as JSON; - is standard output
    #[arg(long, value_name = "FILE", requires = "script")]
    pub(super) export_json: Option<PathBuf>,
    #[command(flatten)]
    pub(super) sampling: SamplingArgs,
    #[command(flatten)]
    pub(super) view: ViewArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
}

/// What replaces the scene's own camera and lights.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Camera and lights")]
pub(super) struct ViewArgs {
    /// Position of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(super) camera_eye: Option<Vec3>,
    /// Point in the middle of the image
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(super) camera_at: Option<Vec3>,
    /// Vector that points up in the image
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(super) camera_up: Option<Vec3>,
    /// Vertical angle of view in degrees
    #[arg(long, value_name = "DEG", value_parser = field_of_view, allow_hyphen_values = true)]
    pub(super) fov: Option<f32>,
    /// A white point light instead of the scene's lights; repeat for more, which share the strength of one
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(super) light: Vec<Vec3>,
}

/// Where threads run.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct PinArgs {
    /// Pin each worker to a core (the default)
    #[arg(long, overrides_with = "no_pin")]
    pin: bool,
    /// Leave the workers to the operating system
    #[arg(long, overrides_with = "pin")]
    no_pin: bool,
}

impl PinArgs {
    /// True unless pinning was declined.
    pub(super) fn pin(self) -> bool {
        !self.no_pin
    }
}

/// What traces, for commands whose findings depend on neither.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct KernelArgs {
    /// Instruction set of the kernels; auto takes the widest of this machine
    #[arg(long, default_value = "auto", value_parser = one_of::<IsaChoice>())]
    isa: IsaChoice,
    /// Time to spend on the tree
    #[arg(long, default_value = BuildPreset::default().name(), value_parser = one_of::<BuildPreset>())]
    pub(super) build: BuildPreset,
}

impl KernelArgs {
    /// Instruction set; `None` for the widest one of this machine.
    pub(super) fn isa(self) -> Option<Isa> {
        self.isa.isa()
    }
}

/// How to compute; of these, only fast visibility changes the image.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Engine (only fast visibility changes the image)")]
pub(super) struct EngineArgs {
    /// Worker threads [default: one per physical core]
    #[arg(long, value_name = "N", value_parser = whole(1..=1024usize), allow_negative_numbers = true)]
    pub(super) threads: Option<usize>,
    #[command(flatten)]
    pub(super) pin: PinArgs,
    /// Instruction set of the kernels; auto takes the widest of this machine
    #[arg(long, default_value = "auto", value_parser = one_of::<IsaChoice>())]
    pub(super) isa: IsaChoice,
    /// How hits are decided: exact, or fast as other ray tracers do, which leaks at edges and vertices
    #[arg(long, default_value = Visibility::default().name(), value_parser = one_of::<Visibility>())]
    pub(super) visibility: Visibility,
    /// Rays with a common origin: 256 at once (tile), one by one (single), or each packet as it is worth (auto)
    #[arg(long, default_value = KernelChoice::default().name(), value_parser = one_of::<KernelChoice>())]
    pub(super) kernel: KernelChoice,
    /// Order of the tiles
    #[arg(long, default_value = Order::default().name(), value_parser = one_of::<Order>())]
    pub(super) order: Order,
    /// Which worker gets which tile when
    #[arg(long, default_value = Strategy::default().name(), value_parser = one_of::<Strategy>())]
    pub(super) schedule: Strategy,
    /// How finished pixels reach the image: written by the workers, or sent to the master
    #[arg(long, default_value = FilmMode::default().name(), value_parser = one_of::<FilmMode>())]
    pub(super) film: FilmMode,
    /// Side of a tile in pixels
    #[arg(
        long, value_name = "N", default_value = "64",
        value_parser = whole(1..=1024u32), allow_negative_numbers = true
    )]
    pub(super) tile: u32,
    /// Time to spend on the tree
    #[arg(long, default_value = BuildPreset::default().name(), value_parser = one_of::<BuildPreset>())]
    pub(super) build: BuildPreset,
    /// Which searches of the tile kernel end early: none, or some of pet-bound, pet-seed, set, occ, area; all but the default
    /// make --kernel auto the tile kernel
    #[arg(long, value_name = "LIST", default_value_t = EarlyTermination::default())]
    pub(super) early_termination: EarlyTermination,
    /// Effects to simulate: auto takes those that the scene calls for, all the same by the kernel for all effects, a list
    /// with commas between only those of the list, and without=LIST the others
    #[arg(long, value_name = "auto|all|LIST|without=LIST", default_value_t = EffectChoice::default())]
    pub(super) effects: EffectChoice,
}

/// `irt inspect`.
#[derive(Args, Debug)]
pub(super) struct InspectArgs {
    /// A TOML scene, an OBJ file or the name of a built-in scene
    pub(super) scene: String,
    /// Time to spend on the tree
    #[arg(long, default_value = BuildPreset::default().name(), value_parser = one_of::<BuildPreset>())]
    pub(super) build: BuildPreset,
    /// Write the same as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(super) export_json: Option<PathBuf>,
    /// Instead, render the scene with and without each of its effects, and tell what each costs and changes
    #[arg(long)]
    pub(super) price: bool,
    /// Width and height of the images of --price in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size, requires = "price")]
    pub(super) size: Option<[u32; 2]>,
    /// How often --price renders each; the median counts [default: 3]
    #[arg(
        long, value_name = "N", value_parser = whole(1..=1000u32), allow_negative_numbers = true, requires = "price"
    )]
    pub(super) rounds: Option<u32>,
    /// Threads that render for --price [default: one per physical core]
    #[arg(
        long, value_name = "N", value_parser = whole(1..=1024usize), allow_negative_numbers = true, requires = "price"
    )]
    pub(super) threads: Option<usize>,
    /// Instruction set of the kernels for --price; auto, the default, takes the widest of this machine
    #[arg(long, value_parser = one_of::<IsaChoice>(), requires = "price")]
    pub(super) isa: Option<IsaChoice>,
}

/// `irt scenes`.
#[derive(Args, Debug)]
pub(super) struct ScenesArgs {
    #[command(flatten)]
    pub(super) export: ExportArgs,
}

/// `irt trace`.
#[derive(Args, Debug)]
pub(super) struct TraceArgs {
    /// A TOML scene, an OBJ file or the name of a built-in scene
    pub(super) scene: String,
    /// Rays: a .npy file, float32 of shape (N, 8): origin x y z, tnear, direction x y z, tfar
    #[arg(long, value_name = "FILE")]
    pub(super) rays: PathBuf,
    /// Hits to write: a .npy file, a structured array of prim u32 (4294967295 = miss), t, u, v f32
    #[arg(long, value_name = "FILE")]
    pub(super) hits: PathBuf,
    /// Ask only whether anything is hit: write one byte per ray, 1 = blocked
    #[arg(long)]
    pub(super) occluded: bool,
    /// Threads that trace [default: one per physical core]
    #[arg(long, value_name = "N", value_parser = whole(1..=1024usize), allow_negative_numbers = true)]
    pub(super) threads: Option<usize>,
    #[command(flatten)]
    pub(super) pin: PinArgs,
    /// Instruction set of the kernels; auto takes the widest of this machine
    #[arg(long, default_value = "auto", value_parser = one_of::<IsaChoice>())]
    pub(super) isa: IsaChoice,
    /// How hits are decided: exact, or fast as other ray tracers do, which leaks at edges and vertices
    #[arg(long, default_value = Visibility::default().name(), value_parser = one_of::<Visibility>())]
    pub(super) visibility: Visibility,
    /// Time to spend on the tree
    #[arg(long, default_value = BuildPreset::default().name(), value_parser = one_of::<BuildPreset>())]
    pub(super) build: BuildPreset,
}

/// Files that a printed table is also written to.
#[derive(Args, Debug)]
pub(super) struct ExportArgs {
    /// Write the table as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(super) export_json: Option<PathBuf>,
    /// Write the table as CSV; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(super) export_csv: Option<PathBuf>,
    /// Write the table as Markdown; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(super) export_markdown: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
