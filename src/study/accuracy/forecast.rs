//! What a study is expected to take, and how it is cut to the time that it has.
//!
//! ```text
//!   seconds of a default frame and of building its tree
//!     -> of each mode            modes beyond `Effort::dearest` are left out
//!     -> of the whole study      beyond `Effort::seconds`: sides of the images halve, then the dearest modes go
//! ```
//!
//! Sides halve, because errors depend on the size of an image: what a study measures should not hang on a few percent of
//! this machine's mood.

use super::{Effort, Knob, Mode, Omission, fit};
use crate::{bvh::BuildPreset, kernels::Isa, scene::Scene, trace::KernelChoice};

/// Images are not made smaller than this along their longest side, unless they were wanted so.
const SMALLEST: u32 = 32;
/// Seconds of a thread for an aimed ray with what is spawned from it: packets, and rays one by one.
const AIMED: [f64; 2] = [2.4e-5, 5.6e-5];
/// Seconds of a thread for a ray of the f64 reference, and for a triangle of its tree.
const REFERENCE: [f64; 2] = [4.0e-6, 6.0e-7];

/// What steps of a study take.
#[derive(Clone, Copy)]
pub(super) struct Forecast<'a> {
    pub(super) scene: &'a Scene,
    pub(super) effort: &'a Effort,
    /// Threads that render.
    pub(super) threads: usize,
    /// Instruction set of the default.
    pub(super) isa: Isa,
    /// Width and height of the images.
    pub(super) size: [u32; 2],
    /// Seconds of a default frame of that size.
    pub(super) frame: f64,
    /// Seconds that the default tree took.
    pub(super) build: f64,
}

impl Forecast<'_> {
    /// Seconds of a mode.
    pub(super) fn mode(&self, mode: Mode) -> f64 {
        let patience = self.effort.patience;
        let own = self.frame * self.share(mode);
        let round = self.frame + own;
        let least = patience.least as f64 * round;
        let most = patience.most as f64 * round;
        let shadows = if mode.knob().is_none_or(Knob::is_geometric) { self.scene.lights.len() } else { 0 };
        let build = self.build
            * match mode {
                Mode::Tree(BuildPreset::Slow) => 7.0,
                Mode::Tree(_) => 1.0,
                _ => 0.0,
            };
        let shown = 0.1 + 0.5 * own * shadows as f64;
        least.max(patience.seconds.min(most)) + round + shown + build + self.aimed(mode)
    }

    /// A frame of a mode over one of the default.
    fn share(&self, mode: Mode) -> f64 {
        let settings = &self.scene.settings;
        let samples = |count: u32| f64::from(count) / f64::from(settings.samples);
        match mode {
            Mode::Samples(count) => samples(count),
            // Three eighths of them, and the others where these scatter.
            Mode::Adaptive(count, _) => 0.5 * samples(count),
            Mode::LightSamples(count) => 0.2 + 0.8 * f64::from(count) / f64::from(settings.light_samples),
            Mode::Isa(isa) => (self.isa.lanes() as f64 / isa.lanes() as f64).powf(0.6),
            // Either may suit a scene, or not.
            Mode::Kernel(_) => 3.0,
            _ => 1.0,
        }
    }

    fn aimed(&self, mode: Mode) -> f64 {
        let ray = match mode {
            Mode::Kernel(KernelChoice::Single) => AIMED[1],
            Mode::Default | Mode::Visibility(_) | Mode::Isa(_) => AIMED[0],
            // Not again, or none at all.
            _ => return 0.0,
        };
        self.effort.aimed[0] as f64 * ray / self.threads as f64
    }

    /// Seconds of the converged image.
    pub(super) fn converged(&self) -> f64 {
        self.frame * f64::from(self.effort.converged) / f64::from(self.scene.settings.samples)
    }

    /// Seconds of the f64 reference.
    pub(super) fn reference(&self) -> f64 {
        let size = fit(self.size, self.effort.reference_side).map(f64::from);
        let rays = size[0] * size[1] * (1.0 + self.scene.lights.len() as f64);
        REFERENCE[0] * rays / self.threads as f64 + REFERENCE[1] * self.scene.mesh.len() as f64
    }

    /// Seconds of everything.
    pub(super) fn total(&self, modes: &[Mode]) -> f64 {
        self.converged() + self.reference() + modes.iter().map(|&mode| self.mode(mode)).sum::<f64>()
    }

    /// The same for images of another longest side.
    fn with_side(&self, side: u32) -> Self {
        let pixels = |size: [u32; 2]| size.map(f64::from).iter().product::<f64>();
        let size = fit(self.size, side);
        // Neighbouring rays of smaller images have less in common: each takes longer.
        Forecast { size, frame: self.frame * (pixels(size) / pixels(self.size)).powf(0.75), ..*self }
    }

    fn dear(&self, mode: Mode) -> bool {
        // Aimed rays take as long with images of any size.
        mode != Mode::Default && self.mode(mode) - self.aimed(mode) > self.effort.dearest
    }

    /// Cuts a study to [`Effort::dearest`] and [`Effort::seconds`]: images become smaller, modes are left out, and both are
    /// told.
    pub(super) fn cut(self, modes: &mut Vec<Mode>, omissions: &mut Vec<Omission>) -> Self {
        let wanted = self.size[0].max(self.size[1]);
        let total = |of: &Self| {
            let kept: Vec<Mode> = modes.iter().copied().filter(|&mode| !of.dear(mode)).collect();
            of.total(&kept)
        };
        let (mut cut, mut side) = (self, wanted);
        while total(&cut) > self.effort.seconds && side / 2 >= SMALLEST {
            side /= 2;
            cut = self.with_side(side);
        }
        if side != wanted {
            let why = format!(
                "{wanted} pixels along the longest side would take {:.0} seconds in all; --side {} takes that time",
                total(&self),
                self.effort.side
            );
            omissions.push(Omission { knob: "size", why });
        }
        let mut dear: Vec<Mode> = modes.iter().copied().filter(|&mode| cut.dear(mode)).collect();
        modes.retain(|mode| !dear.contains(mode));
        while cut.total(modes) > self.effort.seconds && modes.len() > 1 {
            let dearest = (1..modes.len()).max_by(|&a, &b| cut.mode(modes[a]).total_cmp(&cut.mode(modes[b])));
            dear.extend(dearest.map(|index| modes.remove(index)));
        }
        omissions.extend(dear.into_iter().map(|mode| Omission {
            knob: mode.knob().map_or("default", Knob::name),
            why: format!(
                "{mode} would take {:.0} seconds; a smaller --side makes all modes quicker",
                cut.mode(mode)
            ),
        }));
        cut
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Patience, modes, options};
    use super::*;

    /// Of the atrium in 64 by 32 pixels, one sample each: two threads, a second for a frame.
    fn with_forecast(effort: Effort, body: impl FnOnce(Forecast, Vec<Mode>)) {
        let scene = crate::scene::load("atrium@0.1").unwrap();
        assert_eq!(scene.settings.samples, 1);
        let (modes, _) = modes(&scene, &options());
        body(
            Forecast {
                scene: &scene,
                effort: &effort,
                threads: 2,
                isa: Isa::Scalar,
                size: [64, 32],
                frame: 1.0,
                build: 3.0,
            },
            modes,
        );
    }

    const EFFORT: Effort = Effort {
        side: 64,
        reference_side: 64,
        converged: 100,
        patience: Patience { least: 2, most: 4, seconds: 5.0 },
        aimed: [1_000_000, 1],
        dearest: f64::INFINITY,
        seconds: f64::INFINITY,
    };

    #[test]
    fn seconds_are_those_of_rounds_trees_and_rays() {
        with_forecast(EFFORT, |forecast, _| {
            let near = |mode: Mode, seconds: f64| {
                assert!((forecast.mode(mode) - seconds).abs() < 1e-9, "{mode}: {}", forecast.mode(mode));
            };
            // Five seconds are more than two rounds of two frames and less than four; one round to warm up.
            near(Mode::EightBits, 5.0 + 2.0 + 0.1);
            // Two rounds of 65 frames, and one.
            near(Mode::Samples(64), 3.0 * 65.0 + 0.1);
            let shadows = 0.5 * forecast.scene.lights.len() as f64;
            near(Mode::Tree(BuildPreset::Slow), 7.1 + shadows + 21.0);
            near(Mode::Default, 7.1 + shadows + 12.0);
            near(Mode::Kernel(KernelChoice::Single), 3.0 * 4.0 + 0.1 + 3.0 * shadows + 28.0);
            assert_eq!(forecast.converged(), 100.0);
            let half = forecast.with_side(32);
            assert_eq!(
                (half.size, half.frame, half.converged()),
                ([32, 16], 0.25f64.powf(0.75), 100.0 * 0.25f64.powf(0.75))
            );
        });
    }

    #[test]
    fn a_study_that_fits_is_not_cut() {
        with_forecast(EFFORT, |forecast, mut modes| {
            let all = modes.clone();
            let mut omissions = vec![];
            let cut = forecast.cut(&mut modes, &mut omissions);
            assert_eq!((cut.size, modes, omissions), ([64, 32], all, vec![]));
        });
    }

    #[test]
    fn modes_that_take_too_long_are_left_out_and_told() {
        with_forecast(Effort { dearest: 190.0, ..EFFORT }, |forecast, mut modes| {
            let (all, mut omissions) = (modes.clone(), vec![]);
            let cut = forecast.cut(&mut modes, &mut omissions);
            assert_eq!(cut.size, [64, 32]);
            let left: Vec<Mode> = all.into_iter().filter(|mode| !modes.contains(mode)).collect();
            assert_eq!(left, [Mode::Samples(64)]);
            assert_eq!((omissions.len(), omissions[0].knob), (1, "samples"));
            let why = "samples 64 would take 195 seconds; a smaller --side makes all modes quicker";
            assert_eq!(omissions[0].why, why);
        });
    }

    #[test]
    fn aimed_rays_make_no_mode_dear() {
        let mut seconds = 0.0;
        let fast = Mode::Visibility(crate::kernels::Visibility::Fast);
        with_forecast(EFFORT, |forecast, _| seconds = forecast.mode(fast));
        // Twelve of them are aimed.
        with_forecast(Effort { dearest: seconds - 11.0, ..EFFORT }, |forecast, mut modes| {
            forecast.cut(&mut modes, &mut vec![]);
            assert!(modes.contains(&fast) && !modes.contains(&Mode::Samples(64)));
        });
        with_forecast(Effort { dearest: seconds - 13.0, ..EFFORT }, |forecast, mut modes| {
            forecast.cut(&mut modes, &mut vec![]);
            assert!(!modes.contains(&fast));
        });
    }

    #[test]
    fn images_become_smaller_until_a_study_fits() {
        let mut whole = 0.0;
        with_forecast(EFFORT, |forecast, modes| whole = forecast.total(&modes));
        with_forecast(Effort { seconds: 0.99 * whole, ..EFFORT }, |forecast, mut modes| {
            let (all, mut omissions) = (modes.clone(), vec![]);
            let cut = forecast.cut(&mut modes, &mut omissions);
            assert_eq!((cut.size, modes.len()), ([32, 16], all.len()));
            assert!(cut.total(&modes) <= 0.99 * whole);
            assert_eq!((omissions.len(), omissions[0].knob), (1, "size"));
            let why =
                format!("64 pixels along the longest side would take {whole:.0} seconds in all; --side 64");
            assert!(omissions[0].why.starts_with(&why), "{}", omissions[0].why);
        });
    }

    #[test]
    fn what_still_does_not_fit_loses_its_dearest_modes() {
        let seconds = 60.0;
        with_forecast(Effort { seconds, ..EFFORT }, |forecast, mut modes| {
            let (all, mut omissions) = (modes.clone(), vec![]);
            let cut = forecast.cut(&mut modes, &mut omissions);
            assert_eq!(cut.size, [32, 16], "no side is shorter than 32");
            assert!(cut.total(&modes) <= seconds && modes.len() > 1);
            assert_eq!((modes[0], modes.len() + omissions.len()), (Mode::Default, all.len() + 1));
            let left = all.iter().filter(|mode| !modes.contains(mode)).map(|&mode| cut.mode(mode));
            let least = left.fold(f64::INFINITY, f64::min);
            assert!(modes[1..].iter().all(|&mode| cut.mode(mode) <= least), "the dearest ones go");
        });
        with_forecast(Effort { seconds: 0.0, ..EFFORT }, |forecast, mut modes| {
            forecast.cut(&mut modes, &mut vec![]);
            assert_eq!(modes, [Mode::Default], "the default stays");
        });
    }
}
