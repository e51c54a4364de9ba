//! An image that is complete at any time: first some of its pixels, the others filled in, then more and more of them,
//! each traced once, until it is bit by bit the image of [`render`](super::render()).
//!
//! ```text
//!   begin(camera) -> trace(tiles to levels)* -> fill -> picture
//!                          ^ each raises the level of some tiles; who decides which is the caller
//! ```
//!
//! From there on it can become the image of a render with [adaptive](crate::scene::RenderSettings::adaptive) samples.

mod canvas;
mod fill;
mod finer;
mod level;
mod map;
mod task;

pub use canvas::{Canvas, Tone};
pub use finer::Refined;
pub use level::Level;
pub use map::RayMap;

use super::{RayTally, RenderOptions, Stage, task::TileReport};
use crate::{
    camera::Camera,
    error::{Error, Result},
    film::Film,
    scene::CameraDescription,
    schedule::{Control, FrameStats, Master, Placement, Schedule, with_workers},
    tile::{Order, Tile, tiles},
};
use canvas::CELL;
use finer::Finer;
use std::sync::{
    OnceLock,
    atomic::{AtomicBool, AtomicU32},
};
use std::time::Instant;
use task::{Job, Pass, Refinement};

/// Side of the tiles in which missing pixels are filled in, in pixels.
const FILL_TILE: u32 = 128;

/// A tile and the level that it shall reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// Must come from [`Progressive::tiles`].
    pub tile: Tile,
    /// Tiles that have it already stay as they are.
    pub level: Level,
}

/// When a pass begins no further tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// When there is none left.
    Whole,
    /// From this moment on.
    Until(Instant),
    /// While `halt` of [`Stage::with_progressive`] is true.
    Halt,
}

/// What a pass took.
#[derive(Clone, Debug)]
pub struct Traced {
    /// Rays traced.
    pub rays: RayTally,
    /// Seconds the workers spent tracing, all together.
    pub trace_seconds: f64,
    /// Seconds the workers spent on everything else, all together.
    pub shade_seconds: f64,
    /// What the scheduler says.
    pub stats: FrameStats,
    /// All tiles have reached their levels; false if the pass was halted, or late.
    pub complete: bool,
}

impl Traced {
    fn new(sum: &TileReport, stats: FrameStats, complete: bool) -> Traced {
        let (trace_seconds, shade_seconds) = (sum.trace.as_secs_f64(), sum.shade.as_secs_f64());
        Traced { rays: sum.rays, trace_seconds, shade_seconds, stats, complete }
    }
}

/// Workers and an image that is being refined.
pub struct Progressive<'m, 'a> {
    master: &'m mut Master<Refinement<'a>>,
    canvas: Canvas,
    camera: Camera,
    tone: Tone,
    size: [u32; 2],
    order: Order,
    /// By how many samples, and from which difference on, an image becomes adaptive; `None` if none does.
    finer_by: Option<(u32, f32)>,
    /// The scene has adaptive samples.
    adaptive: bool,
    /// Pixels get one sample at first.
    once: bool,
    finer: Option<Finer>,
    /// Films to be written over.
    spare: Vec<Film>,
}

impl Stage<'_> {
    /// Calls `body` with workers that refine images of this scene. While `halt` is true, they begin no further tile of a
    /// pass that is limited by it.
    ///
    /// # Errors
    /// As [`with_workers`].
    pub fn with_progressive<R>(
        &self,
        placement: &Placement,
        halt: &AtomicBool,
        body: impl FnOnce(&mut Progressive<'_, '_>) -> Result<R>,
    ) -> Result<R> {
        self.with_progressive_on(&mut Canvas::default(), placement, halt, body)
    }

    /// The same on the memory of an earlier image, which is kept for a later one.
    ///
    /// # Errors
    /// As [`with_workers`].
    pub fn with_progressive_on<R>(
        &self,
        memory: &mut Canvas,
        placement: &Placement,
        halt: &AtomicBool,
        body: impl FnOnce(&mut Progressive<'_, '_>) -> Result<R>,
    ) -> Result<R> {
        let (render, camera) = (self.task(), self.camera());
        let RenderOptions { size, order, .. } = *self.options();
        let mut canvas = std::mem::take(memory);
        if canvas.size() != size {
            canvas = Canvas::new(size);
        }
        canvas.clear(true);
        let (rays, finer_by) = (OnceLock::new(), self.finer());
        let finer = || finer_by.map(|(samples, _)| self.task_of(samples, &rays));
        let task = Refinement { render, finer: OnceLock::new(), make_finer: &finer, halt };
        with_workers(&task, placement, |master| {
            let tone = Tone::new(0.0);
            let mut session = Progressive {
                master,
                canvas,
                camera,
                tone,
                size,
                order,
                finer_by,
                adaptive: self.adaptive().is_some(),
                once: false,
                finer: None,
                spare: vec![],
            };
            let done = body(&mut session);
            *memory = session.canvas;
            done
        })
    }
}

impl Progressive<'_, '_> {
    /// Begins an image: all pixels of the last one are forgotten.
    pub fn begin(&mut self, camera: &CameraDescription, tone: &Tone) {
        self.camera = Camera::new(camera, self.size[0], self.size[1]);
        self.tone = tone.clone();
        self.end_finer();
        self.canvas.clear(true);
    }

    /// Begins a sketch: an image of which only what is shown is kept, which is quicker. It is never [complete](
    /// Progressive::complete), and [`Progressive::fill`] takes it away once every pixel is traced.
    pub fn begin_sketch(&mut self, camera: &CameraDescription, tone: &Tone) {
        self.begin(camera, tone);
        self.canvas.linear = false;
    }

    /// Whether this is a sketch.
    pub fn is_sketch(&self) -> bool {
        !self.canvas.linear
    }

    /// The image cut into tiles of about `side` pixels, in the order of the options.
    pub fn tiles(&self, side: u32) -> Vec<Tile> {
        tiles(self.size[0], self.size[1], side.max(1).next_multiple_of(CELL), self.order)
    }

    /// Raises disjoint tiles to their levels. Tiles that are not begun because of `limit` stay as they are.
    ///
    /// # Errors
    /// As [`Master::run_frame`]; the image is lost then, and must be begun again.
    pub fn trace(&mut self, schedule: Schedule, targets: &[Target], limit: Limit) -> Result<Traced> {
        let tiles: Vec<Tile> = targets.iter().map(|target| target.tile).collect();
        let cells = self.size.map(|side| side.div_ceil(CELL) as usize);
        let mut goals = vec![Level::Nothing; cells[0] * cells[1]];
        for target in targets {
            self.canvas.cells(target.tile).for_each(|cell| goals[cell] = target.level);
        }
        let (camera, tone, mode) = (self.camera, self.tone.clone(), schedule.film);
        let job = Job::Trace { camera, tone, goals, once: self.once, limit, mode };
        let (mut sum, mut complete) = (TileReport::default(), true);
        let (_, stats) = self.run(schedule, job, &tiles, |pass, tile, output| {
            output.deliver(pass, tile);
            sum.add(&output.tile);
            complete &= !output.skipped;
        })?;
        Ok(Traced::new(&sum, stats, complete))
    }

    /// Puts the image into `picture`, row by row as 0x00rrggbb; pixels that are not traced are filled in.
    ///
    /// # Errors
    /// [`Error::Failed`] if some tile has no level at all. As [`Master::run_frame`].
    pub fn fill(&mut self, schedule: Schedule, picture: &mut Vec<AtomicU32>) -> Result<()> {
        if self.canvas.least(self.whole()) == Level::Nothing {
            return Err(Error::Failed(
                "a part of the picture has no pixels at all; please report this".into(),
            ));
        }
        if self.is_sketch() && self.traced() {
            picture.resize_with(self.canvas.samples.len(), || AtomicU32::new(0));
            std::mem::swap(picture, &mut self.canvas.samples);
            return Ok(());
        }
        let mut pixels = std::mem::take(picture);
        pixels.resize_with(self.canvas.samples.len(), || AtomicU32::new(0));
        let tiles = tiles(self.size[0], self.size[1], FILL_TILE, self.order);
        if let (Job::Fill { picture: filled }, _) =
            self.run(schedule, Job::Fill { picture: pixels }, &tiles, |_, _, _| {})?
        {
            *picture = filled;
        }
        Ok(())
    }

    /// Counts what every primary ray of the image does; `None` if that was halted.
    ///
    /// # Errors
    /// As [`Master::run_frame`].
    pub fn map(&mut self, schedule: Schedule) -> Result<Option<RayMap>> {
        let map = RayMap::new(self.canvas.samples.len());
        let (tiles, mut complete) = (self.tiles(64), true);
        let job = Job::Map { camera: self.camera, map };
        let (job, _) = self.run(schedule, job, &tiles, |_, _, output| complete &= !output.skipped)?;
        Ok(match job {
            Job::Map { map, .. } if complete => Some(map),
            _ => None,
        })
    }

    /// The level of each square of 16 pixels, row by row.
    pub fn levels(&self) -> Vec<Level> {
        self.canvas.cells(self.whole()).map(|cell| self.canvas.level(cell)).collect()
    }

    fn run(
        &mut self,
        schedule: Schedule,
        job: Job,
        tiles: &[Tile],
        collect: impl FnMut(&Pass, Tile, &mut task::Output),
    ) -> Result<(Job, FrameStats)> {
        let canvas = std::mem::replace(&mut self.canvas, Canvas::new([0, 0]));
        match self.master.run_frame(schedule, Pass { canvas, job }, tiles, &Control::unattended(), collect) {
            Ok((pass, stats)) => {
                self.canvas = pass.canvas;
                Ok((pass.job, stats))
            }
            Err(error) => {
                self.canvas = Canvas::new(self.size);
                Err(error)
            }
        }
    }

    /// All of the image.
    pub fn whole(&self) -> Tile {
        Tile { x: 0, y: 0, width: self.size[0], height: self.size[1] }
    }

    /// The lowest level in a tile.
    pub fn level(&self, tile: Tile) -> Level {
        self.canvas.least(tile)
    }

    /// How different neighbouring pixels of a tile are, in bytes of sRGB, summed over the channels.
    pub fn variation(&self, tile: Tile) -> f64 {
        self.canvas.variation(tile)
    }

    /// Share of the pixels that are traced.
    pub fn share(&self) -> f64 {
        self.canvas.share()
    }

    /// Every pixel is traced.
    pub fn traced(&self) -> bool {
        self.canvas.least(self.whole()) == Level::Full
    }

    /// Every pixel is traced, and [`Progressive::film`] has it.
    pub fn complete(&self) -> bool {
        self.traced() && !self.is_sketch()
    }

    /// The traced pixels, as they were before the image became adaptive; others have values of no meaning.
    pub fn film(&self) -> &Film {
        let kept = self.finer.as_ref().and_then(Finer::centres);
        kept.unwrap_or(&self.canvas.film)
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.master.workers()
    }
}
