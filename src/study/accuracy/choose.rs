//! The cheapest combination of modes that keeps a promise, or the best one for a budget.

use super::{
    modes::{Knob, Mode},
    prices::{Extra, Prices, Sampling, extras},
};
use crate::{bvh::BuildPreset, render::RenderOptions, scene::Scene};

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// RMSE from the converged image, at most.
    pub error: Option<f64>,
    /// Seconds to build the tree and to render all frames, at most.
    pub seconds: Option<f64>,
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Frames of one tree.
    pub frames: u32,
}

/// A combination, and what it should come to.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// What differs from the default; nothing if the default is best.
    pub modes: Vec<Mode>,
    /// Seconds expected at most.
    pub seconds: f64,
    /// RMSE expected at most.
    pub error: f64,
    /// The same of the default.
    pub default: [f64; 2],
}

/// Views that were not measured may be worse than those that were: errors count by this factor.
pub const CAUTION: f64 = 1.5;
/// What replaces the default must be quicker by this factor at least.
const WORTH: f64 = 0.97;

/// The cheapest combination whose error is small enough, or the most accurate that is quick enough, or, with both wishes,
/// the cheapest that is both. Errors count with caution ([`CAUTION`]) and the noise of the converged image, times by the
/// upper ends of their spreads, so that the default is not replaced by what may be slower. `Err` has the nearest that there
/// is to an impossible wish.
///
/// # Errors
/// The combination of the least error, or of the least time if only that was wished for.
pub fn choose(
    prices: &Prices,
    scene: &Scene,
    options: &RenderOptions,
    wish: &Wish,
) -> Result<Choice, Box<Choice>> {
    let all = combinations(prices, scene, options, wish);
    let exact = |choice: &&Choice| wish.error.is_none_or(|error| choice.error <= error);
    let quick = |choice: &&Choice| wish.seconds.is_none_or(|seconds| choice.seconds <= seconds);
    let by_time =
        |a: &&Choice, b: &&Choice| a.seconds.total_cmp(&b.seconds).then(a.error.total_cmp(&b.error));
    let by_error =
        |a: &&Choice, b: &&Choice| a.error.total_cmp(&b.error).then(a.seconds.total_cmp(&b.seconds));
    let fitting = || all.iter().filter(exact).filter(quick);
    let best = if wish.error.is_some() { fitting().min_by(by_time) } else { fitting().min_by(by_error) };
    if let Some(best) = best {
        // The default stays unless it is worth replacing.
        let default = fitting().find(|choice| choice.modes.is_empty());
        let stays =
            wish.error.is_some() && default.is_some_and(|default| best.seconds > WORTH * default.seconds);
        return Ok(default.filter(|_| stays).unwrap_or(best).clone());
    }
    let nearest = if wish.error.is_some() { all.iter().min_by(by_error) } else { all.iter().min_by(by_time) };
    Err(Box::new(nearest.cloned().unwrap_or(Choice {
        modes: vec![],
        seconds: f64::INFINITY,
        error: f64::INFINITY,
        default: [f64::INFINITY; 2],
    })))
}

/// All combinations of a sampling and at most one setting of each other knob.
fn combinations(prices: &Prices, scene: &Scene, options: &RenderOptions, wish: &Wish) -> Vec<Choice> {
    let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
    let frames = prices.frame * pixels(wish.size) / pixels(prices.size) * f64::from(wish.frames);
    let build = |preset: BuildPreset| {
        let known = prices.builds.iter().find(|(name, _)| name == preset.name());
        known.map_or(f64::INFINITY, |(_, seconds)| *seconds)
    };
    let caution = |error: f64| CAUTION * error + prices.noise;
    let Some(default) = prices.samplings.first() else { return vec![] };
    let of_default = [build(options.build) + frames, caution(default.error)];
    let mut all = vec![];
    for sets in sets(prices, scene, options) {
        let preset = sets.iter().find_map(|(mode, _)| match mode {
            Mode::Tree(preset) => Some(*preset),
            _ => None,
        });
        let ratio: f64 = sets.iter().map(|(_, extra)| extra.ratio).product();
        let change: f64 = sets.iter().map(|(_, extra)| extra.change).sum();
        for sampling in &prices.samplings {
            let of_sampling = if sampling == default { 1.0 } else { sampling.ratio };
            let mut modes: Vec<Mode> = changes(sampling, default);
            modes.extend(sets.iter().map(|(mode, _)| *mode));
            all.push(Choice {
                modes,
                seconds: build(preset.unwrap_or(options.build)) + frames * of_sampling * ratio,
                error: caution(sampling.error + change),
                default: of_default,
            });
        }
    }
    all
}

fn changes(sampling: &Sampling, default: &Sampling) -> Vec<Mode> {
    let mut modes = vec![];
    if sampling.samples != default.samples {
        modes.push(Mode::Samples(sampling.samples));
    }
    if sampling.light_samples != default.light_samples {
        modes.push(Mode::LightSamples(sampling.light_samples));
    }
    modes
}

/// Every way to change other knobs, each at most once.
fn sets<'p>(prices: &'p Prices, scene: &Scene, options: &RenderOptions) -> Vec<Vec<(Mode, &'p Extra)>> {
    let known = extras(scene, options);
    let mode_of = |extra: &Extra| known.iter().copied().find(|mode| mode.to_string() == extra.mode);
    let mut sets = vec![vec![]];
    for knob in Knob::ALL {
        let of_knob = prices.extras.iter().filter_map(|extra| Some((mode_of(extra)?, extra)));
        let of_knob: Vec<_> = of_knob.filter(|(mode, _)| mode.knob() == Some(knob)).collect();
        let with = |set: &Vec<(Mode, &'p Extra)>| {
            of_knob.iter().map(|&one| set.iter().copied().chain([one]).collect()).collect::<Vec<Vec<_>>>()
        };
        let more: Vec<Vec<_>> = sets.iter().flat_map(with).collect();
        sets.extend(more);
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::Visibility;

    fn prices() -> Prices {
        let sampling = |samples, ratio, error| Sampling { samples, light_samples: 16, ratio, error };
        let extra = |mode: &str, ratio, change| Extra { mode: mode.into(), ratio, change };
        Prices {
            size: [100, 100],
            frame: 0.1,
            noise: 0.0,
            builds: vec![("fast".into(), 0.05), ("medium".into(), 0.2), ("slow".into(), 1.0)],
            samplings: vec![sampling(1, 1.0, 0.04), sampling(4, 4.2, 0.02), sampling(16, 16.4, 0.01)],
            extras: vec![
                extra("visibility fast", 0.9, 0.002),
                extra("tree medium", 0.95, 0.0),
                extra("tree slow", 0.7, 0.0),
                extra("no such mode", 0.01, 0.0),
            ],
        }
    }

    fn chosen(error: Option<f64>, seconds: Option<f64>, frames: u32) -> Result<Choice, Box<Choice>> {
        let scene = Scene::default();
        let options = super::super::options();
        choose(&prices(), &scene, &options, &Wish { error, seconds, size: [100, 200], frames })
    }

    #[test]
    fn the_cheapest_that_keeps_the_promise_is_chosen() {
        // 1.5 * (0.02 + 0.002) = 0.033; a frame takes 0.2 s, and a fast tree is there in 0.05 s.
        let choice = chosen(Some(0.035), None, 1).unwrap();
        assert_eq!(choice.modes, [Mode::Samples(4), Mode::Visibility(Visibility::Fast)]);
        assert!((choice.seconds - (0.05 + 0.2 * 4.2 * 0.9)).abs() < 1e-12, "{choice:?}");
        assert!((choice.error - 0.033).abs() < 1e-12, "{choice:?}");
        assert!((choice.default[0] - 0.25).abs() < 1e-12, "{choice:?}");
        // Without room for the leaks of fast visibility; many frames are worth a better tree.
        let choice = chosen(Some(0.0301), None, 1).unwrap();
        assert_eq!(choice.modes, [Mode::Samples(4)]);
        let choice = chosen(Some(0.0301), None, 100).unwrap();
        assert_eq!(choice.modes, [Mode::Samples(4), Mode::Tree(BuildPreset::Slow)]);
    }

    #[test]
    fn the_default_stays_where_it_keeps_the_promise_and_nothing_is_quicker() {
        let slow = |extra: &Extra| Extra { ratio: extra.ratio.max(0.99), ..extra.clone() };
        let prices = Prices { extras: prices().extras.iter().map(slow).collect(), ..prices() };
        let wish = Wish { error: Some(0.5), seconds: None, size: [100, 100], frames: 1 };
        let choice = choose(&prices, &Scene::default(), &super::super::options(), &wish).unwrap();
        assert_eq!(choice.modes, []);
        assert_eq!([choice.seconds, choice.error], choice.default);
    }

    #[test]
    fn a_budget_takes_the_most_accurate_and_wishes_beyond_all_are_refused() {
        let choice = chosen(None, Some(1.0), 1).unwrap();
        assert_eq!(choice.modes, [Mode::Samples(4)]);
        let both = chosen(Some(0.07), Some(1.0), 1).unwrap();
        assert!(both.seconds <= 0.25 && both.error <= 0.07, "{both:?}");
        // The nearest one has 16 samples, which take 3.28 s on a fast tree, and 2.30 s on a slow one that takes 1 s.
        let nearest = chosen(Some(0.001), None, 1).unwrap_err();
        assert_eq!(nearest.modes, [Mode::Samples(16), Mode::Tree(BuildPreset::Slow)]);
        let nearest = chosen(None, Some(0.001), 1).unwrap_err();
        assert!(nearest.seconds > 0.001 && nearest.modes.contains(&Mode::Visibility(Visibility::Fast)));
        assert!(chosen(Some(0.016), Some(1.0), 1).is_err(), "16 samples take longer");
    }
}
