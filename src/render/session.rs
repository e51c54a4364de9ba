//! A scene made ready, and frame after frame on the same workers.

use super::{
    RenderOptions, choose_kernels,
    task::{Frame, RenderTask, TileReport},
};
use crate::{
    bvh::Bvh,
    camera::Camera,
    effects::{Effect, EffectChoice, EffectSet, Reasons},
    error::Result,
    film::Film,
    kernels::Kernels,
    scene::Scene,
    schedule::{Control, FrameStats, Master, Placement, Schedule, with_workers},
    shade::{PLAIN, PathTable, SurfaceTable},
    tile::{Tile, tiles},
};
use std::time::Instant;

/// A scene that is ready to be rendered by any number of workers.
pub struct Stage<'a> {
    scene: &'a Scene,
    options: RenderOptions,
    pub(super) kernels: Kernels,
    pub(super) bvh: Bvh,
    table: SurfaceTable,
    /// The effects that are simulated.
    pub(super) set: EffectSet,
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
        let kernels = choose_kernels(options.isa)?.with_visibility(options.visibility);
        scene.check()?;
        let start = Instant::now();
        let set = options.effects.set(&Reasons::new(scene));
        let (bvh, table) = (Bvh::build(&scene.mesh, options.build)?, SurfaceTable::with_effects(scene, set));
        let paths = (!is_plain(scene, set, options.effects)).then(|| PathTable::new(scene, set));
        let build_seconds = start.elapsed().as_secs_f64();
        Ok(Stage { scene, options: *options, kernels, bvh, table, set, paths, build_seconds })
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
        let task = RenderTask::new(
            self.scene,
            &self.bvh,
            &self.table,
            self.paths.as_ref(),
            self.kernels,
            &self.options,
        );
        let [width, height] = self.options.size;
        let camera = Camera::new(&self.scene.camera, width, height);
        with_workers(&task, placement, |master| {
            body(&mut Session { master, camera, film: Film::new(width, height) })
        })
    }
}

/// Workers and a film.
pub struct Session<'m, 'a> {
    master: &'m mut Master<RenderTask<'a>>,
    camera: Camera,
    film: Film,
}

impl Session<'_, '_> {
    /// Renders one frame.
    ///
    /// # Errors
    /// As [`Master::run_frame`]; the film is black then.
    pub fn frame(&mut self, schedule: Schedule, tiles: &[Tile], control: &Control) -> Result<FrameStats> {
        self.counted_frame(schedule, tiles, control).map(|(stats, _)| stats)
    }

    /// The same, with the sum of what the tiles report.
    pub(super) fn counted_frame(
        &mut self,
        schedule: Schedule,
        tiles: &[Tile],
        control: &Control,
    ) -> Result<(FrameStats, TileReport)> {
        let (width, height) = (self.film.width(), self.film.height());
        let film = std::mem::replace(&mut self.film, Film::new(0, 0));
        let frame = Frame { camera: self.camera, film, mode: schedule.film };
        let mut sum = TileReport::default();
        let collect = |frame: &Frame, tile, report: &mut TileReport| frame.collect(tile, report, &mut sum);
        match self.master.run_frame(schedule, frame, tiles, control, collect) {
            Ok((frame, stats)) => {
                self.film = frame.film;
                Ok((stats, sum))
            }
            Err(error) => {
                self.film = Film::new(width, height);
                Err(error)
            }
        }
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
