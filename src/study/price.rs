//! What each effect costs in time and changes in the image, found out by leaving it out.

use crate::{
    effects::{Effect, EffectChoice, EffectSet, Reasons},
    error::Result,
    render::{RenderOptions, render},
    scene::Scene,
    schedule::Control,
};

/// How one image differs from another, in linear values.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Root of the mean square over all channels.
    pub rmse: f64,
    /// Greatest of all channels.
    pub max: f64,
    /// Share of the pixels that differ at all.
    pub changed: f64,
}

impl Difference {
    /// The images are the same.
    pub const NONE: Difference = Difference { rmse: 0.0, max: 0.0, changed: 0.0 };
}

/// What leaving out one effect saves and changes.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Price {
    /// The effect.
    #[serde(serialize_with = "as_text")]
    pub effect: Effect,
    /// Seconds of the frame without it, round by round.
    pub seconds: Vec<f64>,
    /// Of the image without it to the one with it.
    pub difference: Difference,
}

/// Prices of all effects that a scene calls for.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Prices {
    /// Name of the scene.
    pub scene: String,
    /// Seconds of the frame with all that the scene calls for, round by round.
    pub seconds: Vec<f64>,
    /// The same image by the kernel for all effects.
    pub general_seconds: Vec<f64>,
    /// Its difference, which must be none.
    pub general: Difference,
    /// One for each effect that is called for.
    pub prices: Vec<Price>,
}

fn as_text<S: serde::Serializer>(effect: &Effect, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_str(effect)
}

/// Renders `scene` with all effects that it calls for, by the kernel for all effects, and without each of them, one after
/// the other, `rounds` times. The effects that `options` choose do not matter.
///
/// # Errors
/// As [`render`].
pub fn prices(scene: &Scene, options: &RenderOptions, rounds: u32, control: &Control) -> Result<Prices> {
    let set = Reasons::new(scene).set();
    let without = |effect: Effect| EffectChoice::Only(set.without(EffectSet::of(&[effect])));
    let mut choices = vec![EffectChoice::Auto, EffectChoice::All];
    choices.extend(set.iter().map(without));
    let mut seconds = vec![Vec::new(); choices.len()];
    let mut differences = Vec::new();
    for round in 0..rounds.max(1) {
        let mut whole: Option<Pixels> = None;
        for (&effects, seconds) in choices.iter().zip(&mut seconds) {
            // The first frame of a stage warms up memory and caches.
            let rendered = render(scene, &RenderOptions { effects, frames: 2, ..*options }, control)?;
            seconds.push(rendered.frames[1].seconds);
            // The image is the same in every round.
            if round == 0 {
                let pixels: Pixels = rendered.film.pixels().collect();
                differences.push(whole.as_ref().map_or(Difference::NONE, |whole| difference(whole, &pixels)));
                whole.get_or_insert(pixels);
            }
        }
    }
    let mut seconds = seconds.into_iter();
    let mut next = || seconds.next().unwrap_or_default();
    let (auto, general_seconds) = (next(), next());
    let prices = set.iter().zip(&differences[2..]).map(|(effect, &difference)| Price {
        effect,
        seconds: next(),
        difference,
    });
    let prices = prices.collect();
    Ok(Prices { scene: scene.name.clone(), seconds: auto, general_seconds, general: differences[1], prices })
}

type Pixels = Vec<[f32; 3]>;

fn difference(a: &Pixels, b: &Pixels) -> Difference {
    let (mut squares, mut max, mut changed) = (0.0f64, 0.0f64, 0u64);
    for (a, b) in a.iter().zip(b) {
        let off: [f64; 3] = std::array::from_fn(|c| (f64::from(a[c]) - f64::from(b[c])).abs());
        squares += off.iter().map(|d| d * d).sum::<f64>();
        max = off.into_iter().fold(max, f64::max);
        changed += u64::from(a != b);
    }
    let pixels = a.len().max(1) as f64;
    Difference { rmse: (squares / (3.0 * pixels)).sqrt(), max, changed: changed as f64 / pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_counted_over_channels_and_pixels() {
        let a = vec![[0.0, 0.5, 1.0], [0.25; 3], [0.0; 3], [1.0; 3]];
        let mut b = a.clone();
        assert_eq!(difference(&a, &b), Difference::NONE);
        b[0] = [0.0, 0.0, 1.0];
        b[3] = [1.0, 1.0, 0.0];
        let Difference { rmse, max, changed } = difference(&a, &b);
        assert_eq!((max, changed), (1.0, 0.5));
        assert!((rmse - (1.25f64 / 12.0).sqrt()).abs() < 1e-12, "{rmse}");
    }
}
