//! What was typed for the commands that study several scenes or a battery of tests.

use super::args::{ExportArgs, KernelArgs, PinArgs};
use super::value::{IsaChoice, factor, network, one_of, size, whole};
use crate::{
    bvh::BuildPreset,
    kernels::Visibility,
    schedule::{FilmMode, Strategy},
    study::{
        bench::{Engine, Kind},
        coherence::ShadowRays,
        stability::Kernel,
    },
    tile::Order,
};
use clap::Args;
use std::path::PathBuf;

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

/// `irt accuracy`.
#[derive(Args, Debug)]
pub(super) struct AccuracyArgs {
    /// Scenes as for render [default: atrium, gallery]
    #[arg(value_name = "SCENE")]
    pub(super) scenes: Vec<String>,
    /// Smaller images and fewer rounds: less than a minute for a scene on two cores
    #[arg(long)]
    pub(super) quick: bool,
    /// Longest side of the images in pixels; a quarter of it for scenes whose light takes many rays [default: 512, quick 192; halved
    /// where a study would take more than eight minutes, quick 45 s]
    #[arg(
        long, value_name = "N", value_parser = whole(16..=4096u32), allow_negative_numbers = true
    )]
    pub(super) side: Option<u32>,
    /// Samples per pixel of the image that all are compared with
    #[arg(
        long, value_name = "N", default_value = "256", value_parser = whole(2..=65_536u32), allow_negative_numbers = true
    )]
    pub(super) converged: u32,
    /// Rounds at least of each mode and the default by turns [default: 3, quick 2]
    #[arg(
        long, value_name = "N", value_parser = whole(1..=1000usize), allow_negative_numbers = true
    )]
    pub(super) rounds: Option<usize>,
    /// Threads that render [default: one per physical core]
    #[arg(long, value_name = "N", value_parser = whole(1..=1024usize), allow_negative_numbers = true)]
    pub(super) threads: Option<usize>,
    #[command(flatten)]
    pub(super) pin: PinArgs,
    #[command(flatten)]
    pub(super) kernels: KernelArgs,
    /// Rays aimed at closed meshes by each way to trace [default: 2000000, quick 100000]
    #[arg(
        long, value_name = "N", value_parser = whole(1000..=1_000_000_000u64), allow_negative_numbers = true
    )]
    pub(super) rays: Option<u64>,
    /// Write everything as one HTML page, with plots and maps
    #[arg(long, value_name = "FILE")]
    pub(super) report: Option<PathBuf>,
    /// Write a map of where each mode differs as a PNG to this folder
    #[arg(long, value_name = "DIR")]
    pub(super) maps: Option<PathBuf>,
    #[command(flatten)]
    pub(super) export: ExportArgs,
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
    #[command(flatten)]
    pub(super) kernels: KernelArgs,
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
    /// Numbers of workers; more than there are cores are simulated
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', default_value = "1,2,4,16,32,256",
        value_parser = whole(1..=1024usize), allow_negative_numbers = true
    )]
    pub(super) workers: Vec<usize>,
    /// Rounds of which the median counts
    #[arg(
        long, value_name = "N", default_value = "10",
        value_parser = whole(1..=100_000u32), allow_negative_numbers = true
    )]
    pub(super) rounds: u32,
    /// Frames of a round for each worker, so that any number of workers has about as long to do
    #[arg(
        long, value_name = "N", default_value = "4",
        value_parser = whole(1..=16usize), allow_negative_numbers = true
    )]
    pub(super) frames: usize,
    /// Frames in flight: with 2, who finds nothing to do in one goes on with the next; with 1, that begins when all have ended
    #[arg(
        long, value_name = "N", default_value = "2",
        value_parser = whole(1..=16usize), allow_negative_numbers = true
    )]
    pub(super) in_flight: usize,
    /// Where more workers than cores are simulated: by which factor their tiles take longer than one worker's
    #[arg(
        long, value_name = "FACTOR", default_value = "1", value_parser = factor, allow_negative_numbers = true
    )]
    pub(super) inflation: f64,
    /// Instead of strategies, compare sizes of tiles
    #[arg(long, conflicts_with_all = ["pictures", "network", "inflation"])]
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
    #[command(flatten)]
    pub(super) kernels: KernelArgs,
    #[command(flatten)]
    pub(super) export: ExportArgs,
}
