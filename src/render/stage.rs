//! A scene made ready: its tree and its tables, and what workers need of them.

use super::{RenderOptions, choose_kernels, task::RenderTask};
use crate::{
    bvh::{BuildPreset, Bvh, Update},
    camera::Camera,
    effects::{Effect, EffectChoice, EffectSet, Reasons},
    error::Result,
    kernels::Kernels,
    scene::{RenderSettings, Scene},
    shade::{PLAIN, PathTable, SurfaceTable},
    tile::{Tile, tiles},
};
use std::{
    sync::{Arc, OnceLock},
    time::Instant,
};

/// What a scene is rendered by, as far as it is worth keeping when the scene has moved or is rendered another way.
#[derive(Clone, Debug)]
pub struct Geometry {
    pub(super) bvh: Arc<Bvh>,
    table: SurfaceTable,
    /// The effects that `table` is for.
    set: EffectSet,
}

/// Samples of pixels that differ, for images that become adaptive though their scene does not say how.
const FINER_SAMPLES: u32 = 16;
/// The same: what counts as different.
const FINER_LEAST: f32 = 0.03;

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
        let samples = if self.set().has(Effect::Antialiasing) { scene.settings.samples } else { 1 };
        let paths = paths.as_ref().map(|paths| (paths, samples));
        RenderTask::new(scene, bvh, table, paths, self.is_plain_once(), *kernels, options)
    }

    /// What workers need to take `samples` samples of some pixels, also if the scene calls for only one: `rays` is made
    /// unless there is such a table already.
    pub(super) fn task_of<'t>(&'t self, samples: u32, rays: &'t OnceLock<PathTable<'a>>) -> RenderTask<'t> {
        let Stage { scene, options, kernels, geometry: Geometry { bvh, table, set }, paths, .. } = self;
        let paths = match paths {
            Some(paths) => paths,
            None => rays.get_or_init(|| PathTable::new(scene, *set)),
        };
        RenderTask::new(scene, bvh, table, Some((paths, samples)), self.is_plain_once(), *kernels, options)
    }

    /// One sample of a pixel needs no path table.
    fn is_plain_once(&self) -> bool {
        let once = self.set().without(EffectSet::of(&[Effect::Antialiasing]));
        is_plain(self.scene, once, self.options.effects)
    }

    /// From which difference on pixels get all samples, if that is not for all of them.
    pub(super) fn adaptive(&self) -> Option<f32> {
        self.scene.settings.adaptive.filter(|_| self.set().has(Effect::Antialiasing))
    }

    /// The samples per pixel, and the threshold, by which an image with one sample per pixel becomes an adaptive one: those
    /// of the scene, as far as it has some. `None` if effects leave antialiasing out, or the scene has all pixels take many
    /// samples anyway.
    pub(super) fn finer(&self) -> Option<(u32, f32)> {
        let RenderSettings { samples, adaptive, without, .. } = &self.scene.settings;
        let allowed = self.options.effects.allows(Effect::Antialiasing) && !without.has(Effect::Antialiasing);
        match (*samples, *adaptive) {
            _ if !allowed => None,
            (1, least) => Some((FINER_SAMPLES, least.unwrap_or(FINER_LEAST))),
            (samples, least) => Some((samples, least?)),
        }
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

/// Whether light need not be followed further than to the first surfaces.
fn is_plain(scene: &Scene, set: EffectSet, choice: EffectChoice) -> bool {
    let shadowless = !scene.lights.is_empty() && !set.has(Effect::HardShadows);
    let smooth = set.has(Effect::SmoothNormals) && scene.settings.smooth_terminator;
    PLAIN.includes(set) && choice != EffectChoice::All && !shadowless && !smooth
}
