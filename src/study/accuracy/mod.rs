//! `irt accuracy`: what each approximation costs in time and changes in the image.
//!
//! ```text
//!   scene -> modes that it calls for                    one knob each, all others by default
//!     converged image, two halves                       what sampling should come to, and how well that is known
//!     f64 reference                                     what should be hit and lit
//!       mode x rounds, by turns with the default        time, its spread; image, its distance; hits, shadows, leaks
//!         -> Pareto front, a sentence for each mode
//! ```
//!
//! `README.md` beside this file has the definitions and tells what came out.

mod aim;
mod choose;
mod forecast;
mod front;
mod geometry;
mod heat;
pub mod compare;
mod modes;
mod prices;
pub mod reference;
mod study;
mod timing;
mod verdict;

pub use super::patience::Patience;
pub use crate::math::Spread;
pub use aim::Battery;
pub use choose::{CAUTION, Choice, Wish, choose};
pub use front::front;
pub use geometry::Geometry;
pub use heat::{heat, heat_color};
pub use modes::{Knob, Mode, Omission, modes};
pub use prices::{Extra, Prices, Sampling, error_of, price_size, prices, views};
pub use timing::Times;
pub use verdict::{sentence, verdict};

use super::stability::Aimed;
use crate::{
    effects::{Effect, Reasons},
    error::Result,
    render::RenderOptions,
    scene::{RenderSettings, Scene},
    schedule::{Control, Machine, Placement},
};
use compare::{Distance, Picture};
use timing::Bench;

/// How thoroughly.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Longest side of the images in pixels; a quarter of it where light is followed by many rays for each pixel.
    pub side: u32,
    /// Longest side of the view that the reference traces.
    pub reference_side: u32,
    /// Samples per pixel of the converged image.
    pub converged: u32,
    /// Rounds of each mode.
    pub patience: Patience,
    /// Aimed and spawned rays for each way to trace.
    pub aimed: [u64; 2],
    /// Modes that are expected to take more seconds than this in all are left out.
    pub dearest: f64,
    /// A study that is expected to take more seconds than this has smaller images, and fewer modes if need be.
    pub seconds: f64,
}

impl Effort {
    /// Less than ten minutes for a scene on two cores.
    pub const FULL: Effort = Effort {
        side: 512,
        reference_side: 512,
        converged: 256,
        patience: Patience { least: 3, most: 41, seconds: 4.0 },
        aimed: [2_000_000, 600_000],
        dearest: 60.0,
        seconds: 480.0,
    };
    /// Less than a minute.
    pub const QUICK: Effort = Effort {
        side: 192,
        reference_side: 192,
        converged: 256,
        patience: Patience { least: 2, most: 21, seconds: 0.4 },
        aimed: [100_000, 30_000],
        dearest: 5.0,
        seconds: 45.0,
    };

    /// The size of a scene's images: its shape, and no side longer than `side`.
    pub fn size(&self, scene: &Scene) -> [u32; 2] {
        fit_for(scene, scene.size, self.side)
    }
}

/// A size of the same shape with no side longer than `side`, or a quarter of that where light is followed by many rays for
/// each pixel, so that a study of any scene ends in time.
fn fit_for(scene: &Scene, size: [u32; 2], side: u32) -> [u32; 2] {
    let set = Reasons::new(scene).set();
    fit(size, if set.has_any(&MANY_RAYS) { side.div_ceil(4) } else { side })
}

const MANY_RAYS: [Effect; 7] = [
    Effect::SoftShadows,
    Effect::EnvironmentLight,
    Effect::IndirectLight,
    Effect::AmbientOcclusion,
    Effect::Mirror,
    Effect::Glossy,
    Effect::Refraction,
];

/// A size of the same shape with no side longer than `side`.
fn fit(size: [u32; 2], side: u32) -> [u32; 2] {
    let longest = size[0].max(size[1]);
    if longest <= side {
        return size;
    }
    let share = |of: u32| (u64::from(of) * u64::from(side)).div_ceil(u64::from(longest)) as u32;
    size.map(share)
}

/// What a mode costs and changes.
#[derive(Clone, Debug)]
pub struct Row {
    /// The mode.
    pub mode: Mode,
    /// Time.
    pub times: Times,
    /// From the converged image.
    pub error: Distance,
    /// From the default image.
    pub change: Distance,
    /// The linear image is the default one, bit by bit; `None` for pictures of bytes.
    pub same: Option<bool>,
    /// Pixels that came out as NaN or infinite.
    pub nan: u64,
    /// Hits and shadows; of the default and of what can change them.
    pub geometry: Option<Geometry>,
    /// Leaks and self-hits; of the default and of what can change them.
    pub aimed: Option<Aimed>,
    /// By pixel, how far it is from the converged image, or from the default one (see [`Knob::converges`]).
    pub map: Vec<f32>,
    /// No other mode is both quicker and nearer to the converged image.
    pub front: bool,
}

/// One scene.
#[derive(Clone, Debug)]
pub struct SceneAccuracy {
    /// Its name.
    pub scene: String,
    /// Triangles in it.
    pub triangles: usize,
    /// Width and height of the images in pixels.
    pub size: [u32; 2],
    /// Threads that rendered.
    pub threads: usize,
    /// Instruction set of the default.
    pub isa: &'static str,
    /// Samples per pixel of the converged image.
    pub converged: u32,
    /// How well that is known: RMSE of its noise, from the difference of its halves.
    pub noise: f64,
    /// One for each mode, the default first.
    pub rows: Vec<Row>,
    /// Knobs left out.
    pub omissions: Vec<Omission>,
    /// The default image, for people to look at.
    pub picture: Picture,
}

/// How far a study is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Seconds of work done, as estimated before it began.
    pub done: f64,
    /// Those of all.
    pub of: f64,
}

/// Measures a scene; `tell` hears after each step how far it is.
///
/// # Errors
/// As [`crate::render::render`].
pub fn accuracy(
    scene: &Scene,
    options: &RenderOptions,
    effort: &Effort,
    battery: &mut Battery,
    control: &Control,
    tell: &dyn Fn(Step),
) -> Result<SceneAccuracy> {
    let options = RenderOptions { size: effort.size(scene), frames: 1, ..*options };
    let placement = Placement::new(Machine::get(), options.threads, options.pin);
    study::Study::new(scene, effort, Bench { placement, options, control })?.run(battery, tell)
}

/// The scene that sampling should converge to: many samples, twice the depth, and light followed to a 64th of the share.
/// Not to nothing: where each surface both reflects and refracts, paths of twice the depth are the square of as many.
fn converged_scene(scene: &Scene, samples: u32) -> Scene {
    let max_depth = scene.settings.max_depth.saturating_mul(2);
    let cutoff = scene.settings.cutoff / 64.0;
    let settings = RenderSettings { samples, adaptive: None, max_depth, cutoff, ..scene.settings.clone() };
    Scene { settings, ..scene.clone() }
}

/// The options of tests.
#[cfg(test)]
pub(crate) fn options() -> RenderOptions {
    use crate::{
        bvh::BuildPreset,
        effects::EffectChoice,
        kernels::Visibility,
        schedule::{FilmMode, Schedule, Strategy},
        tile::Order,
        trace::{EarlyTermination, KernelChoice},
    };
    RenderOptions {
        isa: None,
        kernel: KernelChoice::default(),
        visibility: Visibility::default(),
        threads: Some(1),
        pin: false,
        order: Order::default(),
        schedule: Schedule { strategy: Strategy::default(), film: FilmMode::default() },
        tile: 32,
        size: [60, 40],
        frames: 1,
        build: BuildPreset::Fast,
        seed: 0,
        early: EarlyTermination::default(),
        effects: EffectChoice::Auto,
    }
}
