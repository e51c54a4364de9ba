//! Frame after frame on the same workers, for studies that compare schedules.

use super::{
    RenderOptions, choose_kernels,
    task::{Frame, RenderTask, TileReport},
};
use crate::{
    bvh::Bvh,
    camera::Camera,
    error::Result,
    film::Film,
    kernels::Kernels,
    scene::Scene,
    schedule::{Control, FrameStats, Master, Placement, Schedule, with_workers},
    shade::SurfaceTable,
    tile::{Tile, tiles},
};

/// A scene that is ready to be rendered by any number of workers.
pub struct Stage<'a> {
    scene: &'a Scene,
    options: RenderOptions,
    kernels: Kernels,
    bvh: Bvh,
    table: SurfaceTable,
}

impl<'a> Stage<'a> {
    /// Builds the tree. Threads and frames of `options` mean nothing here.
    ///
    /// # Errors
    /// As [`super::render`].
    pub fn new(scene: &'a Scene, options: &RenderOptions) -> Result<Stage<'a>> {
        let kernels = choose_kernels(options.isa)?.with_visibility(options.visibility);
        let (bvh, table) = (Bvh::build(&scene.mesh, options.build)?, SurfaceTable::new(scene));
        Ok(Stage { scene, options: *options, kernels, bvh, table })
    }

    /// The image cut into tiles of `side` pixels, in the stage's order.
    pub fn tiles(&self, side: u32) -> Vec<Tile> {
        let [width, height] = self.options.size;
        tiles(width, height, side, self.options.order)
    }

    /// Instruction set of the kernels.
    pub fn isa(&self) -> &'static str {
        self.kernels.isa().name()
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
        let task = RenderTask::new(self.scene, &self.bvh, &self.table, self.kernels, &self.options);
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
        let (width, height) = (self.film.width(), self.film.height());
        let film = std::mem::replace(&mut self.film, Film::new(0, 0));
        let frame = Frame { camera: self.camera, film, mode: schedule.film };
        let mut sum = TileReport::default();
        let collect = |frame: &Frame, tile, report: &mut TileReport| frame.collect(tile, report, &mut sum);
        match self.master.run_frame(schedule, frame, tiles, control, collect) {
            Ok((frame, stats)) => {
                self.film = frame.film;
                Ok(stats)
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
}
