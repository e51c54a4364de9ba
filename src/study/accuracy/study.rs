//! The study of one scene, step by step.

use super::{
    Battery, Effort, Mode, Omission, Row, SceneAccuracy, Step,
    compare::Picture,
    converged_scene, fit,
    forecast::Forecast,
    front::front,
    geometry::View,
    modes::{Knob, modes},
    timing::{Bench, Image, Times},
};
use crate::{
    error::{Error, Result},
    kernels::Isa,
    render::{RenderOptions, Stage},
    scene::Scene,
};
use std::{cell::Cell, fmt::Display, time::Instant};

/// Seeds of the two halves of a converged image: none that people use.
pub(super) const HALVES: [u64; 2] = [0x5eed_0001, 0x5eed_0002];

pub(super) struct Study<'a> {
    scene: &'a Scene,
    effort: &'a Effort,
    bench: Bench<'a>,
    modes: Vec<Mode>,
    omissions: Vec<Omission>,
    /// With the tree and the settings of the default.
    stage: Stage<'a>,
    forecast: Forecast<'a>,
    done: Cell<f64>,
}

impl<'a> Study<'a> {
    pub(super) fn new(scene: &'a Scene, effort: &'a Effort, bench: Bench<'a>) -> Result<Study<'a>> {
        let (mut modes, mut omissions) = modes(scene, &bench.options);
        let stage = Stage::new(scene, &bench.options)?;
        let tiles = stage.tiles(bench.options.tile);
        let frame = stage.with_session(&bench.placement, |session| {
            session.frame(bench.options.schedule, &tiles, bench.control)?;
            Ok(session.frame(bench.options.schedule, &tiles, bench.control)?.0)
        })?;
        let forecast = Forecast {
            scene,
            effort,
            threads: bench.placement.slots().len(),
            isa: bench.options.isa.unwrap_or_else(Isa::detect),
            size: bench.options.size,
            frame,
            build: stage.bvh().build_time().as_secs_f64(),
        };
        let forecast = forecast.cut(&mut modes, &mut omissions);
        let options = RenderOptions { size: forecast.size, ..bench.options };
        let (stage, bench) = (stage.beside(scene, &options)?, Bench { options, ..bench });
        Ok(Study { scene, effort, bench, modes, omissions, stage, forecast, done: Cell::new(0.0) })
    }

    pub(super) fn run(&self, battery: &mut Battery, tell: &dyn Fn(Step)) -> Result<SceneAccuracy> {
        let of = self.forecast.total(&self.modes);
        let since = Cell::new(Instant::now());
        let step = |name: &dyn Display, seconds: f64| {
            self.done.set(self.done.get() + seconds);
            tell(Step { done: self.done.get(), of });
            let taken = since.replace(Instant::now()).elapsed().as_secs_f64();
            log::debug!("{}: {name}: {taken:.2} s, expected {seconds:.2}", self.scene.name);
        };
        step(&"start", 0.0);
        let (right, noise) = self.converged()?;
        step(&"converged image", self.forecast.converged());
        let view = self.view();
        step(&"f64 reference", self.forecast.reference());
        let mut rows = vec![];
        let mut default: Option<Image> = None;
        for &mode in &self.modes {
            let (row, image) = self.row(mode, &right, &view, default.as_ref(), battery)?;
            rows.push(row);
            default.get_or_insert(image);
            step(&mode, self.forecast.mode(mode));
        }
        let points: Vec<(f64, f64)> =
            rows.iter().map(|row| (row.times.ratio.median, row.error.rmse)).collect();
        rows.iter_mut().zip(front(&points)).for_each(|(row, on_front)| row.front = on_front);
        let Some(default) = default else {
            return Err(Error::Failed("there is no default mode; please report this".into()));
        };
        Ok(SceneAccuracy {
            scene: self.scene.name.clone(),
            triangles: self.scene.mesh.len(),
            size: self.bench.options.size,
            threads: self.bench.placement.slots().len(),
            isa: self.bench.options.isa.unwrap_or_else(Isa::detect).name(),
            converged: self.effort.converged,
            noise,
            rows,
            omissions: self.omissions.clone(),
            picture: default.picture,
        })
    }

    /// The mean of two halves with seeds of their own, and the RMSE of its noise: half of that between the halves.
    fn converged(&self) -> Result<(Picture, f64)> {
        converged(self.scene, &self.stage, &self.bench, self.effort.converged)
    }

    fn view(&self) -> View {
        let size = fit(self.bench.options.size, self.effort.reference_side);
        let threads = self.bench.placement.slots().len();
        View::new(self.scene, self.stage.bvh(), self.stage.kernels(), size, threads)
    }

    /// What a mode costs and changes, and its image. Without a `default` image, it is that itself.
    fn row(
        &self,
        mode: Mode,
        right: &Picture,
        view: &View,
        default: Option<&Image>,
        battery: &mut Battery,
    ) -> Result<(Row, Image)> {
        let options = mode.options(&self.bench.options);
        let scene = mode.scene(self.scene);
        let stage = self.stage(&scene, &options)?;
        let (image, times) = self.bench.measure(&self.stage, &stage, &scene, mode, self.effort.patience)?;
        let geometric = mode.knob().is_none_or(Knob::is_geometric);
        let geometry = geometric
            .then(|| view.measure(&stage, self.scene, mode, &self.bench.options, self.bench.control))
            .transpose()?;
        let threads = self.bench.placement.slots().len();
        let aimed = battery.aim(mode, &self.bench.options, self.effort.aimed, threads)?;
        let beside = default.unwrap_or(&image);
        let row = Row { geometry, aimed, ..judge(mode, times, &image, right, beside) };
        Ok((row, image))
    }

    /// The stage of a mode: with the tree of the default, unless it asks for another.
    fn stage<'s>(&self, scene: &'s Scene, options: &RenderOptions) -> Result<Stage<'s>> {
        if options.build == self.bench.options.build {
            self.stage.beside(scene, options)
        } else {
            Stage::new(scene, options)
        }
    }
}

/// What is wrong with an image, beside the right one and that of the default.
fn judge(mode: Mode, times: Times, image: &Image, right: &Picture, default: &Image) -> Row {
    let against = if mode.knob().is_none_or(Knob::converges) { right } else { &default.picture };
    Row {
        mode,
        times,
        error: image.picture.distance(right),
        change: image.picture.distance(&default.picture),
        same: image.hash.as_ref().map(|hash| Some(hash) == default.hash.as_ref()),
        nan: image.nan,
        geometry: None,
        aimed: None,
        map: image.picture.differences(against),
        front: false,
    }
}

/// The image that sampling should come to, and the RMSE of its noise.
///
/// # Errors
/// As [`crate::render::render`].
pub(super) fn converged(scene: &Scene, stage: &Stage, bench: &Bench, samples: u32) -> Result<(Picture, f64)> {
    let many = converged_scene(scene, samples.div_ceil(2));
    let half = |seed| {
        let options = RenderOptions { seed, ..bench.options };
        let stage = stage.beside(&many, &options)?;
        let tiles = stage.tiles(options.tile);
        stage.with_session(&bench.placement, |session| {
            session.frame(options.schedule, &tiles, bench.control)?;
            Ok(Picture::of(session.film()))
        })
    };
    let [first, second] = [half(HALVES[0])?, half(HALVES[1])?];
    Ok((first.mean(&second), 0.5 * first.rmse(&second)))
}

#[cfg(test)]
mod tests {
    use super::super::{Patience, Spread, options};
    use super::*;
    use crate::kernels::Visibility;
    use crate::schedule::{Control, Machine, Placement};
    use std::sync::atomic::AtomicBool;

    const EFFORT: Effort = Effort {
        side: 48,
        reference_side: 48,
        converged: 32,
        patience: Patience { least: 1, most: 1, seconds: 0.0 },
        aimed: [1000, 300],
        dearest: 3600.0,
        seconds: 36000.0,
    };

    fn with_study<R>(name: &str, body: impl FnOnce(&Study) -> R) -> R {
        let scene = crate::scene::load(name).unwrap();
        let control = Control::unattended();
        let options = RenderOptions { size: EFFORT.size(&scene), ..options() };
        let placement = Placement::new(Machine::get(), options.threads, false);
        let bench = Bench { placement, options, control: &control };
        body(&Study::new(&scene, &EFFORT, bench).unwrap())
    }

    #[test]
    fn an_injected_error_is_found_with_its_size() {
        with_study("atrium@0.1", |study| {
            let (right, _) = study.converged().unwrap();
            let (_, default) = study
                .row(Mode::Default, &right, &study.view(), None, &mut Battery::new(&AtomicBool::new(false)))
                .unwrap();
            // A quarter more or less in every fifth pixel.
            let tampered = default.picture.pixels().iter().enumerate().map(|(i, pixel)| match i % 5 {
                0 => pixel.map(|value| if value < 0.5 { value + 0.25 } else { value - 0.25 }),
                _ => *pixel,
            });
            let picture = Picture::new(default.picture.size(), tampered);
            let image = Image { picture, hash: Some("another".into()), nan: 3 };
            let times = Times { seconds: Spread::exactly(1.0), ratio: Spread::exactly(0.5), rays: 1 };
            let row = judge(Mode::Visibility(Visibility::Fast), times, &image, &right, &default);
            let share =
                default.picture.pixels().len().div_ceil(5) as f64 / default.picture.pixels().len() as f64;
            assert!((row.change.changed - share).abs() < 1e-12, "{:?}", row.change);
            assert!((row.change.rmse - 0.25 * share.sqrt()).abs() < 1e-6, "{:?}", row.change);
            assert!((row.change.max - 0.25).abs() < 1e-6 && row.same == Some(false) && row.nan == 3);
            assert!((0..row.map.len()).all(|i| (row.map[i] > 0.2) == (i % 5 == 0)), "the map shows where");
        });
    }

    #[test]
    fn scenes_of_many_rays_have_smaller_images_and_converge_by_more_light() {
        let [plain, many] = ["atrium@0.1", "gallery@0.1"].map(|name| crate::scene::load(name).unwrap());
        let longest = |scene: &Scene| Effort::QUICK.size(scene).into_iter().max();
        assert_eq!([longest(&plain), longest(&many)], [Some(192), Some(48)]);
        let (usual, converged) = (&many.settings, converged_scene(&many, 100).settings);
        assert_eq!((converged.samples, converged.max_depth), (100, 2 * usual.max_depth));
        // Nothing cut off at all would be every path among glass: two to the power of the depth.
        assert!(converged.cutoff > 0.0 && converged.cutoff * 50.0 < usual.cutoff, "{}", converged.cutoff);
    }

    #[test]
    fn two_halves_tell_the_noise_of_their_mean() {
        // Against an image of far more samples, the mean is off by about what the halves say.
        with_study("atrium@0.1", |study| {
            let converged = |samples| converged(study.scene, &study.stage, &study.bench, samples).unwrap();
            let ((few, noise), (many, _)) = (converged(16), converged(1024));
            let off = few.rmse(&many);
            assert!(noise > 0.0 && off < 2.0 * noise && off > 0.4 * noise, "{off} against {noise}");
        });
    }
}
