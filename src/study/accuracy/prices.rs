//! What combinations of modes cost and how far off they are, over several views of a scene: what `--max-error` and
//! `--time-budget` choose from.
//!
//! Sampling is measured in steps of its own: each of them is compared with a converged image of each view, and the worst
//! view counts. All other knobs are measured one at a time against the default image of each view. An image that differs by
//! several knobs is then off by at most the sum (RMSE is a distance), and takes the product of their ratios.

use super::{
    Patience, Spread,
    compare::Picture,
    fit_for,
    modes::{Knob, Mode, modes},
    study::converged,
    timing::{Bench, Image, Times},
};
use crate::{
    bvh::{BuildPreset, Bvh},
    error::Result,
    render::{RenderOptions, Stage},
    scene::{CameraDescription, Effect, Scene},
    schedule::{Control, Machine, Placement},
};
use glam::Quat;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A setting of sampling, measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampling {
    /// Camera rays per pixel.
    pub samples: u32,
    /// Shadow rays to lights with an extent.
    pub light_samples: u32,
    /// Time of a frame over the default's: the upper end of its spread in the worst view.
    pub ratio: f64,
    /// RMSE from the converged image in the worst view.
    pub error: f64,
}

/// Another knob's setting, measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Extra {
    /// The knob and its setting: `visibility fast`.
    pub mode: String,
    /// Time of a frame over the default's: the upper end of its spread in the worst view.
    pub ratio: f64,
    /// RMSE from the default image in the worst view.
    pub change: f64,
}

/// Everything that a choice needs to know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prices {
    /// Width and height of the images measured.
    pub size: [u32; 2],
    /// Seconds of a default frame of that size: the upper end of its spread in the slowest view.
    pub frame: f64,
    /// RMSE of the noise of the converged images, of the noisiest.
    pub noise: f64,
    /// Seconds to build a tree, by the name of its quality.
    pub builds: Vec<(String, f64)>,
    /// Settings of sampling, the default first.
    pub samplings: Vec<Sampling>,
    /// Settings of other knobs.
    pub extras: Vec<Extra>,
}

/// Longest side of the images.
const SIDE: u32 = 256;
/// Samples per pixel of converged images.
const CONVERGED: u32 = 128;
const PATIENCE: Patience = Patience { least: 3, most: 15, seconds: 0.25 };

/// The size of the images of a scene that are measured for one of `size`.
pub fn price_size(scene: &Scene, size: [u32; 2]) -> [u32; 2] {
    fit_for(scene, size, SIDE)
}

/// The camera and two others: one that has gone around a little and nearer, one that has turned.
pub fn views(camera: &CameraDescription) -> [CameraDescription; 3] {
    let CameraDescription { eye, at, up, .. } = *camera;
    let turn = |degrees: f32| Quat::from_axis_angle(up.normalize(), degrees.to_radians());
    let around = CameraDescription { eye: at + turn(20.0) * ((eye - at) * 0.9), ..*camera };
    let turned = CameraDescription { at: eye + turn(-25.0) * (at - eye), ..*camera };
    [*camera, around, turned]
}

/// Measures a scene from [`views`] of its camera, for images of `options.size` or less; `tell` hears which share is done.
///
/// # Errors
/// As [`crate::render::render`].
pub fn prices(
    scene: &Scene,
    options: &RenderOptions,
    control: &Control,
    tell: &dyn Fn(f64),
) -> Result<Prices> {
    let options = RenderOptions { size: price_size(scene, options.size), frames: 1, ..*options };
    let placement = Placement::new(Machine::get(), options.threads, options.pin);
    let bench = Bench { placement, options, control };
    let mut all: Option<Prices> = None;
    let views = views(&scene.camera);
    for (index, camera) in views.into_iter().enumerate() {
        let view = Scene { camera, ..scene.clone() };
        let share = |within: f64| tell((index as f64 + within) / 3.0);
        let measured = of_view(&view, &bench, &share)?;
        all = Some(match all {
            None => measured,
            Some(before) => before.worse_of(&measured),
        });
    }
    let mut prices = all.unwrap_or_default();
    prices.builds = builds(scene)?;
    Ok(prices)
}

impl Default for Prices {
    /// Nothing measured.
    fn default() -> Prices {
        let (builds, samplings, extras) = (vec![], vec![], vec![]);
        Prices { size: [1, 1], frame: 0.0, noise: 0.0, builds, samplings, extras }
    }
}

impl Prices {
    /// The worse of two views of one scene.
    fn worse_of(mut self, other: &Prices) -> Prices {
        self.frame = self.frame.max(other.frame);
        self.noise = self.noise.max(other.noise);
        for (own, other) in self.samplings.iter_mut().zip(&other.samplings) {
            (own.ratio, own.error) = (own.ratio.max(other.ratio), own.error.max(other.error));
        }
        for (own, other) in self.extras.iter_mut().zip(&other.extras) {
            (own.ratio, own.change) = (own.ratio.max(other.ratio), own.change.max(other.change));
        }
        self
    }
}

fn of_view(view: &Scene, bench: &Bench, tell: &dyn Fn(f64)) -> Result<Prices> {
    let stage = Stage::new(view, &bench.options)?;
    let (right, noise) = converged(view, &stage, bench, CONVERGED)?;
    tell(0.3);
    let samplings = settings(view, stage.set().has_any(&[Effect::SoftShadows, Effect::EnvironmentLight]));
    let extras = extras(view, &bench.options);
    let work = |samples: u32| f64::from(samples) + 8.0;
    let all: f64 =
        samplings.iter().map(|&[samples, _]| work(samples)).sum::<f64>() + 9.0 * extras.len() as f64;
    let mut done = 0.0;
    let mut step = |work: f64| {
        done += work;
        tell(0.3 + 0.7 * done / all);
    };
    let mut prices = Prices { size: bench.options.size, noise, ..Prices::default() };
    let mut default: Option<Image> = None;
    for [samples, light_samples] in samplings {
        let mut scene = view.clone();
        (scene.settings.samples, scene.settings.light_samples) = (samples, light_samples);
        // As `Mode::Samples`: other numbers of samples are meant for all pixels.
        scene.settings.adaptive = view.settings.adaptive.filter(|_| samples == view.settings.samples);
        let (image, times) = measured(bench, &stage, &scene, &bench.options, Mode::Samples(samples))?;
        let (ratio, error) = (times.ratio.high, image.picture.rmse(&right));
        prices.frame = if default.is_none() { times.seconds.high } else { prices.frame };
        prices.samplings.push(Sampling { samples, light_samples, ratio, error });
        default.get_or_insert(image);
        step(work(samples));
    }
    for mode in extras {
        let (scene, options) = (mode.scene(view), mode.options(&bench.options));
        let (image, times) = measured(bench, &stage, &scene, &options, mode)?;
        let change = default.as_ref().map_or(0.0, |default| image.picture.rmse(&default.picture));
        prices.extras.push(Extra { mode: mode.to_string(), ratio: times.ratio.high, change });
        step(9.0);
    }
    Ok(prices)
}

fn measured(
    bench: &Bench,
    default: &Stage,
    scene: &Scene,
    options: &RenderOptions,
    mode: Mode,
) -> Result<(Image, Times)> {
    let stage = match mode {
        Mode::Tree(_) => Stage::new(scene, options)?,
        _ => default.beside(scene, options)?,
    };
    bench.measure(default, &stage, scene, mode, PATIENCE)
}

/// Settings of sampling, those of the scene first.
fn settings(scene: &Scene, lights: bool) -> Vec<[u32; 2]> {
    let now = [scene.settings.samples, scene.settings.light_samples];
    let mut all = vec![now];
    all.extend([1, 2, 4, 8, 16, 32, 64].map(|samples| [samples, now[1]]));
    if lights {
        all.extend([1, 4].into_iter().flat_map(|light| [4, 16, 64].map(|samples| [samples, light])));
    }
    let mut once: Vec<[u32; 2]> = vec![];
    for setting in all {
        if !once.contains(&setting) {
            once.push(setting);
        }
    }
    once
}

/// The modes of other knobs that `irt render` has flags for and that may save time.
pub(super) fn extras(scene: &Scene, options: &RenderOptions) -> Vec<Mode> {
    let knobs = [Knob::Visibility, Knob::Tree, Knob::Bounces, Knob::Depth, Knob::Cutoff];
    let (modes, _) = modes(scene, options);
    modes.into_iter().filter(|mode| mode.knob().is_some_and(|knob| knobs.contains(&knob))).collect()
}

/// Median seconds of three builds of each quality.
fn builds(scene: &Scene) -> Result<Vec<(String, f64)>> {
    let timed = |preset: BuildPreset| {
        let once = |_| {
            let start = Instant::now();
            Bvh::build(&scene.mesh, preset)?;
            Ok(start.elapsed().as_secs_f64())
        };
        let seconds = (0..3).map(once).collect::<Result<Vec<f64>>>()?;
        Ok((preset.to_string(), Spread::of(&seconds).median))
    };
    BuildPreset::ALL.into_iter().map(timed).collect()
}

/// How far an image of a view is from its converged image, and that one's noise: to see whether a promise was kept.
///
/// # Errors
/// As [`crate::render::render`].
pub fn error_of(
    picture: &Picture,
    scene: &Scene,
    options: &RenderOptions,
    samples: u32,
) -> Result<(f64, f64)> {
    let control = Control::unattended();
    let placement = Placement::new(Machine::get(), options.threads, options.pin);
    let bench = Bench { placement, options: *options, control: &control };
    let stage = Stage::new(scene, options)?;
    let (right, noise) = converged(scene, &stage, &bench, samples)?;
    Ok((picture.rmse(&right), noise))
}
