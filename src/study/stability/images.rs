//! The equality matrix: one image, whatever computes it.

use super::{Setup, random::Random, tally::First};
use crate::{
    bvh::BuildPreset,
    effects::EffectChoice,
    error::{Error, Result},
    kernels::Isa,
    render::{RenderOptions, render},
    scene::procedural,
    schedule::{Control, FilmMode, Schedule, Strategy},
    tile::Order,
    trace::{EarlyTermination, KernelChoice},
};
use std::collections::BTreeMap;

/// Not a multiple of packets or tiles.
const SIZE: [u32; 2] = [150, 101];
const THREADS: [usize; 4] = [1, 2, 3, 7];
const TILES: [u32; 6] = [5, 16, 24, 33, 64, 1024];

/// Images with one value of one dimension.
#[derive(Clone, Debug)]
pub struct ImageCell {
    /// What was varied.
    pub dimension: &'static str,
    /// Its value.
    pub value: String,
    /// Images rendered with it.
    pub images: u64,
    /// Those that differ from the first one.
    pub differ: u64,
}

/// What became of all images.
#[derive(Clone, Debug, Default)]
pub struct Images {
    /// By dimension and value.
    pub cells: Vec<ImageCell>,
    /// Images rendered.
    pub images: u64,
    /// Those that differ from the first one of their scene.
    pub differ: u64,
    /// Pixels that came out as NaN.
    pub nan: u64,
    /// The first image that broke a promise.
    pub first: First,
}

/// Renders `count` images of each scene: every value of every dimension on its own, then any combinations.
///
/// # Errors
/// [`Error::Interrupted`], and as [`render`].
pub(super) fn run(setup: &Setup, count: u64, tell: &dyn Fn(u64)) -> Result<Images> {
    let mut images = Images::default();
    let mut cells: BTreeMap<(usize, String), (u64, u64)> = BTreeMap::new();
    for (number, name) in ["atrium", "hall"].into_iter().enumerate() {
        let scene = procedural::build(name, 0.15)?;
        let mut want: Option<String> = None;
        let mut random = Random::new(setup.seed, 1 << 43 | number as u64);
        for (i, options) in
            singles(setup).into_iter().chain((0..).map_while(|_| any(setup, &mut random))).enumerate()
        {
            if i as u64 >= count {
                break;
            }
            let rendered = render(&scene, &options, &Control::unattended())?;
            let hash = rendered.frames.last().map(|frame| frame.image_sha256.clone()).unwrap_or_default();
            let want = want.get_or_insert_with(|| hash.clone());
            let differs = hash != *want;
            images.images += 1;
            images.differ += u64::from(differs);
            images.nan += rendered.nan.map_or(0, |nan| nan.count);
            let values = values(&options);
            for (dimension, value) in values.iter().enumerate() {
                let cell = cells.entry((dimension, value.clone())).or_default();
                *cell = (cell.0 + 1, cell.1 + u64::from(differs));
            }
            if differs {
                images.first.note(i as u64, || format!("the image of {name} with {}", values.join(", ")));
            }
            tell(number as u64 * count + i as u64 + 1);
            if (setup.stopped)() {
                return Err(Error::Interrupted);
            }
        }
    }
    images.cells = cells
        .into_iter()
        .map(|((dimension, value), (images, differ))| ImageCell {
            dimension: DIMENSIONS[dimension],
            value,
            images,
            differ,
        })
        .collect();
    Ok(images)
}

const DIMENSIONS: [&str; 8] =
    ["isa", "kernel", "threads", "order", "schedule", "tile", "tree", "early termination"];

fn values(options: &RenderOptions) -> [String; 8] {
    [
        options.isa.map_or("auto", Isa::name).to_string(),
        options.kernel.to_string(),
        format!("{} threads", options.threads.unwrap_or(0)),
        options.order.to_string(),
        format!("{}, film {}", options.schedule.strategy, options.schedule.film),
        format!("tiles of {:4}", options.tile),
        format!("{} tree", options.build),
        if options.early == EarlyTermination::FASTEST { "as by default".into() } else { "another".into() },
    ]
}

fn base(setup: &Setup) -> RenderOptions {
    RenderOptions {
        isa: Some(setup.kernels[0].isa()),
        visibility: setup.kernels[0].visibility(),
        kernel: KernelChoice::Single,
        threads: Some(1),
        pin: false,
        order: Order::Scanline,
        schedule: Schedule::default(),
        tile: 64,
        size: SIZE,
        frames: 1,
        build: BuildPreset::Medium,
        early: EarlyTermination::FASTEST,
        effects: EffectChoice::Auto,
        seed: 0,
    }
}

/// The base, and whatever differs from it in one dimension.
fn singles(setup: &Setup) -> Vec<RenderOptions> {
    let base = base(setup);
    let mut all = vec![base];
    for kernels in &setup.kernels {
        all.extend(KernelChoice::ALL.map(|kernel| RenderOptions {
            isa: Some(kernels.isa()),
            kernel,
            ..base
        }));
    }
    all.extend(THREADS.map(|threads| RenderOptions { threads: Some(threads), ..base }));
    all.extend(Order::ALL.map(|order| RenderOptions { order, ..base }));
    all.extend(Schedule::all().map(|schedule| RenderOptions { schedule, threads: Some(2), ..base }));
    all.extend(TILES.map(|tile| RenderOptions { tile, ..base }));
    all.extend(BuildPreset::ALL.map(|build| RenderOptions { build, ..base }));
    all.push(RenderOptions { early: EarlyTermination::NONE, kernel: KernelChoice::Tile, ..base });
    all
}

/// Any combination.
fn any(setup: &Setup, random: &mut Random) -> Option<RenderOptions> {
    let early: Vec<EarlyTermination> = EarlyTermination::all().collect();
    Some(RenderOptions {
        isa: Some(setup.kernels[random.below(setup.kernels.len())].isa()),
        kernel: random.of(&KernelChoice::ALL),
        threads: Some(random.of(&THREADS)),
        order: random.of(&Order::ALL),
        schedule: Schedule { strategy: random.of(&Strategy::ALL), film: random.of(&FilmMode::ALL) },
        tile: random.of(&TILES),
        build: random.of(&BuildPreset::ALL),
        early: random.of(&early),
        ..base(setup)
    })
}
