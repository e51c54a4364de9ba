//! What was typed. Values are checked one by one here; what they mean together is settled in `options`.

use super::value::{IsaChoice, field_of_view, network, number, one_of, size, vector, whole};
use crate::{
    bvh::BuildPreset,
    kernels::Visibility,
    scene::procedural,
    schedule::{FilmMode, Strategy},
    study::{
        bench::{Engine, Kind},
        coherence::ShadowRays,
        stability::Kernel,
    },
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
    /// Image to write; its extension tells the format: .png, .exr, .hdr or .pfm
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
    /// Kernel for rays with a common origin
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
    /// Which searches of the tile kernel end early: none, or some of pet-bound, pet-seed, set, occ, area
    #[arg(long, value_name = "LIST", default_value_t = EarlyTermination::default())]
    pub(super) early_termination: EarlyTermination,
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
}

/// `irt scenes`.
#[derive(Args, Debug)]
pub(super) struct ScenesArgs {
    #[command(flatten)]
    pub(super) export: ExportArgs,
}

/// `irt bench`.
#[derive(Args, Debug)]
pub(super) struct BenchArgs {
    /// Scenes as for render [default: atrium, nave, office, hall, statue; of --micro atrium]
    #[arg(value_name = "SCENE")]
    pub(super) scenes: Vec<String>,
    /// Kinds of rays
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', default_value = "primary,shadow,mirror,diffuse",
        value_parser = one_of::<Kind>()
    )]
    pub(super) kinds: Vec<Kind>,
    /// What traces them; embree needs a build with that feature
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', default_value = "irt,obvhs",
        value_parser = one_of::<Engine>()
    )]
    pub(super) engines: Vec<Engine>,
    /// Instruction set of irt and Embree; auto takes the widest of this machine
    #[arg(long, default_value = "auto", value_parser = one_of::<IsaChoice>())]
    pub(super) isa: IsaChoice,
    /// How irt decides hits: exact, or fast as other ray tracers do, which leaks at edges and vertices; both are compared
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', default_value = Visibility::default().name(),
        value_parser = one_of::<Visibility>()
    )]
    pub(super) visibility: Vec<Visibility>,
    /// Timed rounds, of which the median is told
    #[arg(
        long, value_name = "N", default_value = "7",
        value_parser = whole(1..=100_000u32), allow_negative_numbers = true
    )]
    pub(super) rounds: u32,
    /// Threads that trace
    #[arg(
        long, value_name = "N", default_value = "1",
        value_parser = whole(1..=1024usize), allow_negative_numbers = true
    )]
    pub(super) threads: usize,
    #[command(flatten)]
    pub(super) pin: PinArgs,
    /// Width and height of the image whose rays are traced [default: 1024x1024; of --micro 256x256]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,
    /// Time to spend on irt's tree
    #[arg(long, default_value = BuildPreset::default().name(), value_parser = one_of::<BuildPreset>())]
    pub(super) build: BuildPreset,
    /// Compare builds instead: every preset's time, size, and rays per second; of obvhs, there is none
    #[arg(long, conflicts_with_all = ["build", "all_modes", "visibility"])]
    pub(super) builds: bool,
    /// Time the steps of a frame one by one instead, in ns per ray, box or triangle, for every instruction set
    #[arg(long, conflicts_with_all = ["builds", "all_modes", "kinds", "engines", "threads", "visibility"])]
    pub(super) micro: bool,
    /// Show and export every kernel of every engine, not only its fastest; --verbose does so too
    #[arg(long)]
    pub(super) all_modes: bool,
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

/// `irt stability`.
#[derive(Args, Debug)]
pub(super) struct StabilityArgs {
    /// The small battery, for every change: less than a minute on two cores
    #[arg(long)]
    pub(super) quick: bool,
    /// Rays aimed at vertices and edges, over all cells; the other parts grow with it [default: 100000000, quick 2000000]
    #[arg(
        long, value_name = "N",
        value_parser = whole(1..=1_000_000_000_000u64), allow_negative_numbers = true
    )]
    pub(super) rays: Option<u64>,
    /// Instruction set to test; auto tests all of this machine
    #[arg(long, default_value = "auto", value_parser = one_of::<IsaChoice>())]
    pub(super) isa: IsaChoice,
    /// Kernels to test, beside single rays, which all are compared with [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = one_of::<Kernel>())]
    pub(super) kernel: Option<Vec<Kernel>>,
    /// Engines at the closed meshes; embree needs a build with that feature
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "irt", value_parser = one_of::<Engine>())]
    pub(super) engines: Vec<Engine>,
    /// How hits are decided: exact, or fast, which shows that the battery finds leaks
    #[arg(long, default_value = Visibility::default().name(), value_parser = one_of::<Visibility>())]
    pub(super) visibility: Visibility,
    /// Threads that test [default: one per physical core]
    #[arg(long, value_name = "N", value_parser = whole(1..=1024usize), allow_negative_numbers = true)]
    pub(super) threads: Option<usize>,
    /// Seed of everything that is random
    #[arg(
        long, value_name = "N", default_value = "0",
        value_parser = whole(0..=u64::MAX), allow_negative_numbers = true
    )]
    pub(super) seed: u64,
    #[command(flatten)]
    pub(super) export: ExportArgs,
}

/// `irt coherence`.
#[derive(Args, Debug)]
pub(super) struct CoherenceArgs {
    /// Scenes as for render [default: statue, office, nave, atrium, hall]
    #[arg(value_name = "SCENE")]
    pub(super) scenes: Vec<String>,
    /// Width and height of the image in pixels [default: 256x256]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,
    /// Orders in which pixels are visited
    #[arg(
        long, value_name = "LIST", value_delimiter = ',',
        default_value = "scanline,serpentine,hilbert,morton,peano", value_parser = one_of::<Order>()
    )]
    pub(super) orders: Vec<Order>,
    /// Walk the image tile by tile, so many pixels square; the order is that of the tiles and of the pixels in each
    #[arg(long, value_name = "N", value_parser = whole(1..=1024u32), allow_negative_numbers = true)]
    pub(super) tile: Option<u32>,
    /// Timed rounds, of which the median is told; 0 counts only
    #[arg(
        long, value_name = "N", default_value = "3",
        value_parser = whole(0..=1000u32), allow_negative_numbers = true
    )]
    pub(super) rounds: u32,
    /// Shadow rays: from each surface to every light, as in the thesis, or to those that it is facing, as render does
    #[arg(long, default_value = ShadowRays::default().name(), value_parser = one_of::<ShadowRays>())]
    pub(super) shadow_rays: ShadowRays,
    /// End shadow rays at the light; the thesis' search the whole line beyond it, and ask afterwards
    #[arg(long)]
    pub(super) end_at_light: bool,
    /// Do not compare caches for areas
    #[arg(long)]
    pub(super) no_caches: bool,
    /// Write the maps of figures 15 to 30 as PNG into this folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "sweep")]
    pub(super) maps: Option<PathBuf>,
    /// Find out instead under which conditions each order and each cache wins: the scenes in several details (built-in
    /// ones) and sizes, each light by itself, all orders and caches, counted
    #[arg(long, conflicts_with_all = ["size", "orders", "tile", "rounds", "shadow_rays", "end_at_light", "no_caches"])]
    pub(super) sweep: bool,
    /// Write the plots of --sweep as SVG into this folder
    #[arg(long, value_name = "FOLDER", requires = "sweep")]
    pub(super) plots: Option<PathBuf>,
    /// Instruction set of the kernel; auto takes the widest of this machine
    #[arg(long, default_value = "auto", value_parser = one_of::<IsaChoice>())]
    pub(super) isa: IsaChoice,
    /// Time to spend on the tree
    #[arg(long, default_value = BuildPreset::default().name(), value_parser = one_of::<BuildPreset>())]
    pub(super) build: BuildPreset,
    #[command(flatten)]
    pub(super) export: ExportArgs,
}

/// `irt scaling`.
#[derive(Args, Debug)]
pub(super) struct ScalingArgs {
    /// Scenes as for render [default: statue, office, nave, atrium]
    #[arg(value_name = "SCENE")]
    pub(super) scenes: Vec<String>,
    /// Scheduling strategies [default: all; of --tiles stealing]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = one_of::<Strategy>())]
    pub(super) strategies: Vec<Strategy>,
    /// How finished pixels reach the image [default: both; of --tiles shared]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = one_of::<FilmMode>())]
    pub(super) films: Vec<FilmMode>,
    /// Numbers of workers; more than there are cores are simulated, as are all those of a cluster but one
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', default_value = "1,2,4,16,32,256",
        value_parser = whole(1..=1024usize), allow_negative_numbers = true
    )]
    pub(super) workers: Vec<usize>,
    /// Frames of which the median counts
    #[arg(
        long, value_name = "N", default_value = "10",
        value_parser = whole(1..=100_000u32), allow_negative_numbers = true
    )]
    pub(super) rounds: u32,
    /// Instead of strategies, compare sizes of tiles
    #[arg(long, conflicts_with = "pictures")]
    pub(super) tiles: bool,
    /// Simulated workers are nodes of a cluster: latency of its network in microseconds, its speed in Gb/s
    #[arg(long, value_name = "US,GBIT", value_parser = network, allow_hyphen_values = true)]
    pub(super) network: Option<(f64, f64)>,
    /// Write each frame's timeline (.svg, .trace.json) and map of workers (.png) to this folder
    #[arg(long, value_name = "DIR")]
    pub(super) pictures: Option<PathBuf>,
    /// Width and height of the image in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,
    /// Side of a tile in pixels
    #[arg(
        long, value_name = "N", default_value = "64",
        value_parser = whole(1..=1024u32), allow_negative_numbers = true
    )]
    pub(super) tile: u32,
    /// Order of the tiles
    #[arg(long, default_value = Order::default().name(), value_parser = one_of::<Order>())]
    pub(super) order: Order,
    #[command(flatten)]
    pub(super) pin: PinArgs,
    /// Instruction set of the kernels; auto takes the widest of this machine
    #[arg(long, default_value = "auto", value_parser = one_of::<IsaChoice>())]
    pub(super) isa: IsaChoice,
    /// Time to spend on the tree
    #[arg(long, default_value = BuildPreset::default().name(), value_parser = one_of::<BuildPreset>())]
    pub(super) build: BuildPreset,
    #[command(flatten)]
    pub(super) export: ExportArgs,
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
