//! Frame after frame on the same workers.

use super::{
    FrameReport, Stage,
    passes::{Adaptive, Pass},
    task::{Frame, RenderTask, TileReport},
};
use crate::{
    camera::Camera,
    error::Result,
    film::Film,
    schedule::{
        Control, FilmMode, FrameStats, Load, Master, Placement, Schedule, SharedCoreProbe, Source,
        with_workers,
    },
    shade::RayTally,
    tile::Tile,
};
use std::ops::Range;

impl Stage<'_> {
    /// Calls `body` with workers that render this scene.
    ///
    /// # Errors
    /// As [`with_workers`].
    pub fn with_session<R>(
        &self,
        placement: &Placement,
        body: impl FnOnce(&mut Session<'_, '_>) -> Result<R>,
    ) -> Result<R> {
        let (task, camera) = (self.task(), self.camera());
        let ([width, height], adaptive) = (self.options().size, self.adaptive());
        with_workers(&task, placement, |master| {
            body(&mut Session {
                task: &task,
                master,
                camera,
                adaptive,
                film: Film::new(width, height),
                films: vec![],
                spare: vec![],
            })
        })
    }
}

/// Workers and a film.
pub struct Session<'m, 'a> {
    task: &'m RenderTask<'a>,
    master: &'m mut Master<RenderTask<'a>>,
    camera: Camera,
    /// Only pixels that differ by more than this get all samples.
    adaptive: Option<f32>,
    film: Film,
    /// Of the last stream, in order.
    films: Vec<Film>,
    /// Of earlier ones, to be written over: new memory would cost time in the middle of a stream.
    spare: Vec<Film>,
}

impl Session<'_, '_> {
    /// Renders one frame and tells what it took. `watch` gets each tile with the film that it is on.
    ///
    /// # Errors
    /// As [`Master::run_frame`]; the film is black then.
    pub(super) fn reported_frame(
        &mut self,
        schedule: Schedule,
        tiles: &[Tile],
        control: &Control,
        watch: &mut dyn FnMut(Tile, &Film),
    ) -> Result<FrameReport> {
        let (stats, sum) = self.counted_frame(schedule, tiles, control, watch)?;
        Ok(FrameReport {
            seconds: stats.seconds,
            rays: sum.rays,
            doubts: sum.doubts,
            trace_seconds: sum.trace.as_secs_f64(),
            shade_seconds: sum.shade.as_secs_f64(),
            image_sha256: self.film().sha256(),
            workers: stats.workers,
        })
    }

    fn counted_frame(
        &mut self,
        schedule: Schedule,
        tiles: &[Tile],
        control: &Control,
        watch: &mut dyn FnMut(Tile, &Film),
    ) -> Result<(FrameStats, TileReport)> {
        let Some(least) = self.adaptive else {
            let (_, stats, sum) = self.pass(Pass::All, schedule, tiles, control, watch)?;
            return Ok((stats, sum));
        };
        let mut adaptive = Adaptive::new(least, false);
        let mut step = |adaptive: &mut Adaptive, pass| {
            let (pass, stats, sum) = self.pass(pass, schedule, tiles, control, watch)?;
            adaptive.done(pass, &mut self.film, &mut self.spare, sum.rays.primary);
            Ok((stats, sum))
        };
        let (mut stats, mut sum) = step(&mut adaptive, Pass::Corners)?;
        while let Some(pass) = adaptive.take() {
            let (more, rest) = step(&mut adaptive, pass)?;
            stats = stats.followed_by(more);
            sum.add(&rest);
        }
        self.spare.extend(adaptive.end());
        Ok((stats, sum))
    }

    /// Takes some samples of all pixels, and gives `pass` back.
    fn pass(
        &mut self,
        pass: Pass,
        schedule: Schedule,
        tiles: &[Tile],
        control: &Control,
        watch: &mut dyn FnMut(Tile, &Film),
    ) -> Result<(Pass, FrameStats, TileReport)> {
        let (width, height) = (self.film.width(), self.film.height());
        let mut film = std::mem::replace(&mut self.film, Film::new(0, 0));
        film.forget_nan();
        let frame = Frame { camera: self.camera, film, mode: schedule.film, pass };
        let mut sum = TileReport::default();
        let collect = |frame: &Frame, tile, report: &mut TileReport| {
            frame.collect(tile, report, &mut sum);
            if !matches!(frame.pass, Pass::Corners) {
                watch(tile, &frame.film);
            }
        };
        match self.master.run_frame(schedule, frame, tiles, control, collect) {
            Ok((frame, stats)) => {
                self.film = frame.film;
                Ok((frame.pass, stats, sum))
            }
            Err(error) => {
                self.film = Film::new(width, height);
                Err(error)
            }
        }
    }

    /// Renders one frame; returns its seconds and rays.
    ///
    /// # Errors
    /// As [`Master::run_frame`]; the film is black then.
    pub fn frame(
        &mut self,
        schedule: Schedule,
        tiles: &[Tile],
        control: &Control,
    ) -> Result<(f64, RayTally)> {
        let (stats, sum) = self.counted_frame(schedule, tiles, control, &mut |_, _| {})?;
        Ok((stats.seconds, sum.rays))
    }

    /// See [`Master::employ`].
    pub fn employ(&mut self, workers: Range<usize>) {
        self.master.employ(workers);
    }

    /// Renders the image `frames` times, with all samples of every pixel, and up to `in_flight` frames at once. Each has a
    /// film of its own, kept until the next stream; those of the longest stream so far are made once.
    ///
    /// # Errors
    /// As [`Master::run_stream`]; the films are gone then.
    pub fn stream(
        &mut self,
        schedule: Schedule,
        tiles: &[Tile],
        frames: usize,
        in_flight: usize,
        control: &Control,
    ) -> Result<FrameStats> {
        let size = [self.film.width(), self.film.height()];
        let mut blank = std::mem::take(&mut self.spare);
        blank.append(&mut self.films);
        let (camera, mode) = (self.camera, schedule.film);
        let mut source = Again { left: frames, size, camera, mode, blank, films: vec![] };
        let stats = self.master.run_stream(schedule, in_flight, tiles, control, &mut source)?;
        (self.films, self.spare) = (source.films, source.blank);
        Ok(stats)
    }

    /// A round of the probe with tiles of this scene, rendered onto the films of all streams so far, which are gone then; see
    /// [`SharedCoreProbe::measure`]. The workers stay parked.
    ///
    /// # Panics
    /// If there are no tiles.
    pub fn probe(
        &mut self,
        probe: &mut SharedCoreProbe,
        mode: FilmMode,
        tiles: &[Tile],
        messages: usize,
        cpus: [usize; 2],
    ) {
        let mut films = std::mem::take(&mut self.spare);
        films.append(&mut self.films);
        if films.is_empty() {
            films.push(Film::new(self.film.width(), self.film.height()));
        }
        let frame = |film| Frame { camera: self.camera, film, mode, pass: Pass::All };
        let frames: Vec<Frame> = films.into_iter().map(frame).collect();
        let collect = |frame: &Frame, tile, report: &mut TileReport| {
            frame.collect(tile, report, &mut TileReport::default());
        };
        probe.measure(&Load { task: self.task, frames: &frames, tiles, collect: &collect }, messages, cpus);
        self.spare = frames.into_iter().map(|frame| frame.film).collect();
    }

    /// The images of the last stream.
    pub fn films(&self) -> &[Film] {
        &self.films
    }

    /// The last frame's image.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Takes the film away; only for after the last frame.
    pub(super) fn take_film(&mut self) -> Film {
        std::mem::replace(&mut self.film, Film::new(0, 0))
    }
}

/// The same frame again and again.
struct Again {
    left: usize,
    size: [u32; 2],
    camera: Camera,
    mode: FilmMode,
    /// Films to be written over.
    blank: Vec<Film>,
    films: Vec<Film>,
}

impl Source<RenderTask<'_>> for Again {
    fn next(&mut self) -> Option<Frame> {
        self.left = self.left.checked_sub(1)?;
        let [width, height] = self.size;
        let film = self.blank.pop().unwrap_or_else(|| Film::new(width, height));
        Some(Frame { camera: self.camera, film, mode: self.mode, pass: Pass::All })
    }

    fn more(&self) -> bool {
        self.left > 0
    }

    fn collect(&mut self, frame: &Frame, tile: Tile, report: &mut TileReport) {
        frame.collect(tile, report, &mut TileReport::default());
    }

    fn done(&mut self, frame: Frame) {
        self.films.push(frame.film);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{adaptive::tests::differing, passes::REFINEMENTS, scatter::Series};
    use super::*;
    use crate::{
        bvh::BuildPreset,
        effects::EffectChoice,
        kernels::Visibility,
        render::RenderOptions,
        scene::Scene,
        schedule::{Machine, Strategy},
        tile::Order,
        trace::{EarlyTermination, KernelChoice},
    };
    use std::collections::BTreeSet;

    const LEAST: f32 = 0.05;

    fn scene(samples: u32, adaptive: Option<f32>) -> Scene {
        let mut scene = crate::scene::load("atrium@0.1").unwrap();
        (scene.settings.samples, scene.settings.adaptive) = (samples, adaptive);
        scene
    }

    /// The image of a frame, seen through corners instead of centres if so.
    fn film(scene: &Scene, of_corners: bool, seed: u64) -> Film {
        let options = RenderOptions {
            isa: None,
            kernel: KernelChoice::Auto,
            visibility: Visibility::Exact,
            threads: Some(1),
            pin: false,
            order: Order::Hilbert,
            schedule: Schedule { strategy: Strategy::Stealing, film: FilmMode::Shared },
            tile: 32,
            size: [97, 61],
            frames: 1,
            build: BuildPreset::Fast,
            seed,
            early: EarlyTermination::FASTEST,
            effects: EffectChoice::Auto,
        };
        let stage = Stage::new(scene, &options).unwrap();
        let placement = Placement::new(Machine::get(), Some(1), false);
        let render = |session: &mut Session| {
            if of_corners {
                session.camera = session.camera.of_corners();
            }
            session.frame(options.schedule, &stage.tiles(32), &Control::unattended())?;
            Ok(session.take_film())
        };
        stage.with_session(&placement, render).unwrap()
    }

    #[test]
    fn an_adaptive_image_is_what_its_definition_says_pass_by_pass() {
        let (first, rest) = Series::parts(16, 7);
        let rest = rest.unwrap();
        assert_eq!((first.samples, rest.samples), (6, 10));
        let part = |Series { samples, seed }| film(&scene(samples, None), false, seed);
        let (some_film, more_film) = (part(first), part(rest));
        let (one, corners) = (film(&scene(1, None), false, 7), film(&scene(1, None), true, 7));
        let adaptive = film(&scene(16, Some(LEAST)), false, 7);
        let at = |film: &Film, [x, y]: [u32; 2]| film.row(y).nth(x as usize).unwrap();
        // How far the parts of pixels are apart that have the first, and both: about what their samples scatter by.
        let (mut few, mut whole) = (vec![], vec![]);
        let seen = |color: [f32; 3]| color.map(|value| value.clamp(0.0, 1.0).sqrt());
        let (expected, mut refined, mut passes) = (one, BTreeSet::new(), vec![]);
        for _ in 0..REFINEMENTS {
            let more: Vec<_> = differing([&expected, &corners], LEAST)
                .into_iter()
                .filter(|&[x, y]| refined.insert([x, y]))
                .collect();
            for &[x, y] in &more {
                let ([r, g, b], some, more) =
                    (at(&adaptive, [x, y]), at(&some_film, [x, y]), at(&more_film, [x, y]));
                let apart = seen(some).iter().zip(seen(more)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                if [r, g, b] == some {
                    few.push(apart);
                } else {
                    let all = [0, 1, 2].map(|k| (6.0 * some[k] + 10.0 * more[k]) / 16.0);
                    assert!([r, g, b].iter().zip(all).all(|(a, b)| (a - b).abs() < 1e-6), "{x}, {y}");
                    whole.push(apart);
                }
                expected.write_tile(Tile { x, y, width: 1, height: 1 }, &[r], &[g], &[b]);
            }
            passes.push(more.len());
        }
        assert!(passes[0] > 300 && passes[1] > 10 && refined.len() < 97 * 61 * 9 / 10, "{passes:?}");
        assert!(whole.len() > 100 && few.len() > 100, "{} and {}", whole.len(), few.len());
        let [few, whole] = [few, whole].map(|apart| apart.iter().sum::<f32>() / apart.len() as f32);
        assert!(whole > 2.0 * few, "{whole} {few}: all samples are not where the first ones scatter");
        assert_eq!(adaptive.sha256(), expected.sha256(), "{passes:?}");
    }
}
