//! What a worker does with a tile: trace some of its pixels, or fill in those that are not traced.

use super::{
    Limit,
    canvas::{Canvas, Tone},
    fill::fill,
    level::{Lattice, Level, lattices},
    map::RayMap,
};
use crate::{
    camera::Camera,
    film::Film,
    render::{
        passes as render,
        task::{RenderTask, Scratch, TileReport},
    },
    schedule::{FilmMode, TileTask},
    shade::Meter,
    tile::Tile,
};
use std::sync::{
    OnceLock,
    atomic::{AtomicBool, AtomicU32, Ordering},
};
use std::time::Instant;

/// Everything that stays the same over many passes.
pub(super) struct Refinement<'a> {
    pub(super) render: RenderTask<'a>,
    /// What takes all samples of pixels, once somebody needs that, ...
    pub(super) finer: OnceLock<Option<RenderTask<'a>>>,
    /// ... and what makes it.
    pub(super) make_finer: &'a (dyn Fn() -> Option<RenderTask<'a>> + Sync),
    /// While this is true, no further tile is begun of a pass that obeys it.
    pub(super) halt: &'a AtomicBool,
}

/// One pass over some tiles.
pub(super) struct Pass {
    pub(super) canvas: Canvas,
    pub(super) job: Job,
}

pub(super) enum Job {
    Trace {
        camera: Camera,
        tone: Tone,
        /// What each cell shall reach.
        goals: Vec<Level>,
        /// Pixels get one sample.
        once: bool,
        limit: Limit,
        mode: FilmMode,
    },
    /// A pass of an adaptive image.
    Finer {
        camera: Camera,
        tone: Tone,
        pass: render::Pass,
        /// Where the first pass writes.
        corners: Option<Film>,
        until: Until,
    },
    Fill {
        picture: Vec<AtomicU32>,
    },
    Map {
        camera: Camera,
        map: RayMap,
    },
}

/// How a pass of an adaptive image ends, beside being halted, and how its pixels travel.
pub(super) struct Until {
    /// From this moment on no further tile is begun.
    pub(super) deadline: Instant,
    pub(super) mode: FilmMode,
}

/// What a tile took, and its pixels.
#[derive(Default)]
pub(super) struct Output {
    pub(super) tile: TileReport,
    /// The pixels traced, if they travel as a message, ...
    pieces: Vec<Piece>,
    /// ... and how many of `pieces` are this tile's.
    used: usize,
    /// Was not begun: too late, or not wanted any more.
    pub(super) skipped: bool,
}

struct Piece {
    lattice: Lattice,
    /// In the lattice's own columns and rows.
    part: Tile,
    pixels: [Vec<f32>; 3],
}

/// Buffers of one worker.
pub(super) struct Buffers {
    render: Scratch,
    patch: Vec<u32>,
}

impl TileTask for Refinement<'_> {
    type Frame = Pass;
    type Scratch = Buffers;
    type Output = Output;

    fn scratch(&self, worker: usize) -> Buffers {
        Buffers { render: self.render.scratch(worker), patch: Vec::new() }
    }

    fn run(&self, pass: &Pass, tile: Tile, buffers: &mut Buffers, output: &mut Output) {
        output.used = 0;
        output.tile = TileReport::default();
        match &pass.job {
            Job::Fill { picture } => fill(&pass.canvas, tile, &mut buffers.patch, picture),
            Job::Map { camera, map } => {
                output.skipped = self.halt.load(Ordering::Relaxed);
                if !output.skipped {
                    map.trace(&self.render.traversal, camera, tile, pass.canvas.film.width());
                }
            }
            Job::Finer { until, .. } => {
                output.skipped = self.halt.load(Ordering::Relaxed) || Instant::now() > until.deadline;
                if !output.skipped {
                    self.take_samples(pass, tile, &mut buffers.render, output);
                }
            }
            Job::Trace { limit, .. } => {
                output.skipped = match limit {
                    Limit::Whole => false,
                    Limit::Until(deadline) => Instant::now() > *deadline,
                    Limit::Halt => self.halt.load(Ordering::Relaxed),
                };
                if !output.skipped {
                    self.trace(pass, tile, &mut buffers.render, output);
                }
            }
        }
    }
}

impl Refinement<'_> {
    /// Brings all cells of `tile`, which have a common goal, to it.
    fn trace(&self, pass: &Pass, tile: Tile, scratch: &mut Scratch, output: &mut Output) {
        let Job::Trace { goals, .. } = &pass.job else { return };
        let canvas = &pass.canvas;
        let mut cells = canvas.cells(tile);
        let Some(first) = cells.next() else { return };
        let (from, to) = (canvas.level(first), goals[first]);
        let mut meter = Meter::start();
        if cells.all(|cell| canvas.level(cell) == from) {
            self.raise(pass, tile, [from, to], scratch, &mut meter, output);
        } else {
            // An earlier pass has left some of the cells behind.
            for part in canvas.parts(tile) {
                self.raise(pass, part, [canvas.least(part), to], scratch, &mut meter, output);
            }
        }
        meter.shade();
        output.tile.read(&meter);
    }

    fn raise(
        &self,
        pass: &Pass,
        area: Tile,
        [from, to]: [Level; 2],
        scratch: &mut Scratch,
        meter: &mut Meter,
        output: &mut Output,
    ) {
        let Job::Trace { camera, tone, once, mode, .. } = &pass.job else { return };
        if from >= to {
            return;
        }
        for &lattice in lattices(from, to) {
            let part = lattice.within(area);
            if part.is_empty() {
                continue;
            }
            let camera = camera.every(lattice.first, lattice.spacing);
            match once {
                true => self.render.colour_once(&camera, part, scratch, meter),
                false => self.render.colour(&camera, part, scratch, meter),
            }
            match mode {
                FilmMode::Shared => pass.canvas.write(lattice, part, &scratch.pixels, tone),
                FilmMode::Messages => output.push(lattice, part, &mut scratch.pixels),
            }
        }
        if *mode == FilmMode::Shared {
            pass.canvas.reach(area, to);
            pass.canvas.measure(area, to);
        }
    }
}

impl Refinement<'_> {
    /// The part of a pass of an adaptive image that belongs to a tile.
    fn take_samples(&self, pass: &Pass, tile: Tile, scratch: &mut Scratch, output: &mut Output) {
        let Job::Finer { camera, tone, pass: samples, corners, until } = &pass.job else { return };
        let Some(render) = self.finer.get_or_init(self.make_finer) else { return };
        let mut meter = Meter::start();
        render.run_pass(samples, camera, tile, scratch, &mut meter);
        match until.mode {
            FilmMode::Shared => pass.canvas.write_to(corners.as_ref(), tile, &scratch.pixels, tone),
            FilmMode::Messages => output.push(Lattice::WHOLE, tile, &mut scratch.pixels),
        }
        meter.shade();
        output.tile.read(&meter);
    }
}

impl Output {
    /// The old buffers come back with the next message.
    fn push(&mut self, lattice: Lattice, part: Tile, pixels: &mut [Vec<f32>; 3]) {
        if self.used == self.pieces.len() {
            self.pieces.push(Piece { lattice, part, pixels: Default::default() });
        }
        let piece = &mut self.pieces[self.used];
        (piece.lattice, piece.part) = (lattice, part);
        std::mem::swap(&mut piece.pixels, pixels);
        self.used += 1;
    }

    /// Master: puts the pixels where they belong, if they came as a message.
    pub(super) fn deliver(&self, pass: &Pass, tile: Tile) {
        let canvas = &pass.canvas;
        if self.skipped {
            return;
        }
        if let Job::Finer { corners, tone, until: Until { mode: FilmMode::Messages, .. }, .. } = &pass.job {
            let pieces = &self.pieces[..self.used];
            return pieces
                .iter()
                .for_each(|piece| canvas.write_to(corners.as_ref(), tile, &piece.pixels, tone));
        }
        let Job::Trace { tone, goals, mode: FilmMode::Messages, .. } = &pass.job else { return };
        for Piece { lattice, part, pixels } in &self.pieces[..self.used] {
            canvas.write(*lattice, *part, pixels, tone);
        }
        let Some(first) = canvas.cells(tile).next() else { return };
        let goal = goals[first];
        for part in canvas.parts(tile).filter(|&part| canvas.least(part) < goal) {
            canvas.reach(part, goal);
            canvas.measure(part, goal);
        }
    }
}
