//! A scene made ready, and frame after frame on the same workers.

use super::{
    FrameReport, RenderOptions,
    adaptive::{Known, REFINEMENTS, Refining},
    choose_kernels,
    task::{Frame, Pass, RenderTask, TileReport},
};
use crate::{
    bvh::{BuildPreset, Bvh, Update},
    camera::Camera,
    effects::{Effect, EffectChoice, EffectSet, Reasons},
    error::Result,
    film::Film,
    kernels::Kernels,
    scene::Scene,
    schedule::{Control, FilmMode, FrameStats, Master, Placement, Schedule, Source, with_workers},
    shade::{PLAIN, PathTable, RayTally, SurfaceTable},
    tile::{Tile, tiles},
};
use std::{ops::Range, sync::Arc, time::Instant};

/// What a scene is rendered by, as far as it is worth keeping when the scene has moved or is rendered another way.
#[derive(Clone, Debug)]
pub struct Geometry {
    pub(super) bvh: Arc<Bvh>,
    table: SurfaceTable,
    /// The effects that `table` is for.
    set: EffectSet,
}

/// A scene that is ready to be rendered by any number of workers.
pub struct Stage<'a> {
    scene: &'a Scene,
    options: RenderOptions,
    pub(super) kernels: Kernels,
    pub(super) geometry: Geometry,
    /// To follow light further than the first surfaces, where a scene calls for that.
    paths: Option<PathTable<'a>>,
    /// To build the tree and the surface table.
    pub(super) build_seconds: f64,
}

impl<'a> Stage<'a> {
    /// Checks the scene and builds the tree. Threads, frames and schedule of `options` mean nothing here.
    ///
    /// # Errors
    /// [`Error::Flag`](crate::error::Error::Flag) for an instruction set that this machine lacks,
    /// [`Error::Failed`](crate::error::Error::Failed) if the scene breaks a promise (see [`Scene::check`]) or the tree
    /// cannot be built.
    pub fn new(scene: &'a Scene, options: &RenderOptions) -> Result<Stage<'a>> {
        choose_kernels(options.isa)?;
        scene.check()?;
        let start = Instant::now();
        let bvh = Arc::new(Bvh::build(&scene.mesh, options.build)?);
        let set = options.effects.set(&Reasons::new(scene));
        let geometry = Geometry { bvh, table: SurfaceTable::with_effects(scene, set), set };
        let mut stage = Stage::again(scene, options, geometry)?;
        stage.build_seconds = start.elapsed().as_secs_f64();
        Ok(stage)
    }

    /// The same scene, with what an earlier stage has left behind; it has not moved since.
    ///
    /// # Errors
    /// [`Error::Flag`](crate::error::Error::Flag) for an instruction set that this machine lacks.
    pub fn again(scene: &'a Scene, options: &RenderOptions, mut geometry: Geometry) -> Result<Stage<'a>> {
        let kernels = choose_kernels(options.isa)?.with_visibility(options.visibility);
        let set = options.effects.set(&Reasons::new(scene));
        if set != geometry.set {
            (geometry.table, geometry.set) = (SurfaceTable::with_effects(scene, set), set);
        }
        let paths = (!is_plain(scene, set, options.effects)).then(|| PathTable::new(scene, set));
        Ok(Stage { scene, options: *options, kernels, geometry, paths, build_seconds: 0.0 })
    }

    /// Leaves what another stage of this scene can use.
    pub fn leave(self) -> Geometry {
        self.geometry
    }

    /// Another stage with the same tree, for a scene that differs in nothing but settings and pictures. The quality of the
    /// tree in `options` does not count.
    ///
    /// # Errors
    /// As [`Stage::new`].
    ///
    /// # Panics
    /// If the scene has another number of triangles.
    pub fn beside<'b>(&self, scene: &'b Scene, options: &RenderOptions) -> Result<Stage<'b>> {
        assert_eq!(scene.mesh.len(), self.scene.mesh.len(), "the same mesh");
        scene.check()?;
        let set = options.effects.set(&Reasons::new(scene));
        let table = SurfaceTable::with_effects(scene, set);
        Stage::again(scene, options, Geometry { bvh: Arc::clone(&self.geometry.bvh), table, set })
    }

    /// The kernels that trace.
    pub fn kernels(&self) -> Kernels {
        self.kernels
    }

    /// The tree.
    pub fn bvh(&self) -> &Bvh {
        &self.geometry.bvh
    }

    /// How it is rendered.
    pub(super) fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// The effects that are simulated.
    pub fn set(&self) -> EffectSet {
        self.geometry.set
    }

    /// What workers need to render this scene.
    pub(super) fn task(&self) -> RenderTask<'_> {
        let Stage { scene, options, kernels, geometry: Geometry { bvh, table, .. }, paths, .. } = self;
        let once = self.set().without(EffectSet::of(&[Effect::Antialiasing]));
        let plain_once = is_plain(scene, once, options.effects);
        RenderTask::new(scene, bvh, table, paths.as_ref(), plain_once, *kernels, options)
    }

    /// The camera of the scene.
    pub(super) fn camera(&self) -> Camera {
        let [width, height] = self.options.size;
        Camera::new(&self.scene.camera, width, height)
    }

    /// The image cut into tiles of `side` pixels, in the stage's order.
    pub fn tiles(&self, side: u32) -> Vec<Tile> {
        let [width, height] = self.options.size;
        tiles(width, height, side, self.options.order)
    }

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
        let [width, height] = self.options.size;
        let settings = &self.scene.settings;
        let adaptive = settings.adaptive.filter(|_| self.set().has(Effect::Antialiasing));
        with_workers(&task, placement, |master| {
            body(&mut Session {
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

impl Geometry {
    /// Follows the scene, which has moved: the tree is refitted or built anew (see [`Bvh::follow`]).
    ///
    /// # Errors
    /// As [`Bvh::build`].
    pub fn follow(&mut self, scene: &Scene, build: BuildPreset) -> Result<Update> {
        let update = Arc::make_mut(&mut self.bvh).follow(&scene.mesh, build)?;
        self.table.pose(&scene.mesh);
        Ok(update)
    }
}

/// Workers and a film.
pub struct Session<'m, 'a> {
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
        let centres = self.camera;
        self.camera = centres.of_corners();
        let corners = self.pass(Pass::Once, schedule, tiles, control, &mut |_, _| {});
        self.camera = centres;
        let (_, stats, mut sum) = corners?;
        let corners = self.next_film();
        let (_, more, rest) = self.pass(Pass::Once, schedule, tiles, control, watch)?;
        self.film.inherit_nan(&corners);
        sum.add(&rest);
        let mut stats = stats.followed_by(more);
        let mut known = Known::new(corners, least);
        for _ in 0..REFINEMENTS {
            let refining = Pass::Refine(Box::new(Refining::new(self.next_film(), known)));
            let (refining, more, rest) = self.pass(refining, schedule, tiles, control, watch)?;
            let Pass::Refine(refining) = refining else { return Ok((stats, sum)) };
            let (before, now) = refining.end();
            self.film.inherit_nan(&before);
            self.spare.push(before);
            known = now;
            sum.add(&rest);
            stats = stats.followed_by(more);
            if rest.rays.primary == 0 {
                break;
            }
        }
        self.spare.push(known.end());
        Ok((stats, sum))
    }

    /// Takes the film, and puts another in its place.
    fn next_film(&mut self) -> Film {
        let [width, height] = [self.film.width(), self.film.height()];
        let blank = self.spare.pop().unwrap_or_else(|| Film::new(width, height));
        std::mem::replace(&mut self.film, blank)
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
            watch(tile, &frame.film);
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

/// Whether light need not be followed further than to the first surfaces.
fn is_plain(scene: &Scene, set: EffectSet, choice: EffectChoice) -> bool {
    let shadowless = !scene.lights.is_empty() && !set.has(Effect::HardShadows);
    let smooth = set.has(Effect::SmoothNormals) && scene.settings.smooth_terminator;
    PLAIN.includes(set) && choice != EffectChoice::All && !shadowless && !smooth
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
    use super::super::adaptive::tests::differing;
    use super::*;
    use crate::{
        kernels::Visibility,
        schedule::{Machine, Strategy},
        tile::Order,
        trace::{EarlyTermination, KernelChoice},
    };
    use std::collections::BTreeSet;

    const LEAST: f32 = 0.2;

    fn scene(samples: u32, adaptive: Option<f32>) -> Scene {
        let mut scene = crate::scene::load("atrium@0.1").unwrap();
        (scene.settings.samples, scene.settings.adaptive) = (samples, adaptive);
        scene
    }

    /// The image of a frame, seen through corners instead of centres if so.
    fn film(scene: &Scene, of_corners: bool) -> Film {
        let options = RenderOptions {
            isa: None,
            kernel: KernelChoice::Tile,
            visibility: Visibility::Exact,
            threads: Some(1),
            pin: false,
            order: Order::Hilbert,
            schedule: Schedule { strategy: Strategy::Stealing, film: FilmMode::Shared },
            tile: 32,
            size: [97, 61],
            frames: 1,
            build: BuildPreset::Fast,
            seed: 0,
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
        let (one, corners) = (film(&scene(1, None), false), film(&scene(1, None), true));
        let (all, adaptive) = (film(&scene(6, None), false), film(&scene(6, Some(LEAST)), false));
        let (expected, mut refined, mut passes) = (one, BTreeSet::new(), vec![]);
        for _ in 0..REFINEMENTS {
            let more: Vec<_> = differing([&expected, &corners], LEAST)
                .into_iter()
                .filter(|&[x, y]| refined.insert([x, y]))
                .collect();
            for &[x, y] in &more {
                let [r, g, b] = all.row(y).nth(x as usize).unwrap();
                expected.write_tile(Tile { x, y, width: 1, height: 1 }, &[r], &[g], &[b]);
            }
            passes.push(more.len());
        }
        assert!(passes[0] > 300 && passes[1] > 10 && refined.len() < 97 * 61 * 3 / 4, "{passes:?}");
        assert_eq!(adaptive.sha256(), expected.sha256(), "{passes:?}");
    }
}
