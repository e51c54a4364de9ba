//! Antialiasing where it shows, of an image whose every pixel is traced: the passes of an adaptive image (`../passes.rs`),
//! each in as many parts as there is time for.

use super::{
    Progressive, Traced,
    task::{Job, Until},
};
use crate::{
    error::Result,
    film::Film,
    render::{
        passes::{Adaptive, Pass},
        task::TileReport,
    },
    schedule::Schedule,
    tile::Tile,
};
use std::time::Instant;

/// An image that becomes adaptive.
pub(super) struct Finer {
    adaptive: Adaptive,
    /// Tiles that the pass that is due has not rendered.
    left: Vec<Tile>,
    /// Primary rays of that pass so far.
    primary: u64,
    /// What that pass writes on if it is the first.
    corners: Option<Film>,
}

impl Finer {
    /// One sample of each pixel, unless the canvas still has it.
    pub(super) fn centres(&self) -> Option<&Film> {
        self.adaptive.centres()
    }
}

/// How far an image has become adaptive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refined {
    /// The most samples of a pixel that differs from those beside it.
    pub samples: u32,
    /// Share of the pixels that have more than one by now.
    pub share: f64,
    /// Nothing is left to do.
    pub complete: bool,
}

impl Progressive<'_, '_> {
    /// Whether images from the next one on are going to be [antialiased](Progressive::antialias). Those of scenes with
    /// [adaptive](crate::scene::RenderSettings::adaptive) samples have one sample per pixel until then, instead of all.
    pub fn set_antialiasing(&mut self, on: bool) {
        self.once = on && self.adaptive;
    }

    /// Whether this image may go on as it is with antialiasing, or without it.
    pub fn suits_antialiasing(&self, on: bool) -> bool {
        self.once == (on && self.adaptive) && (on || self.finer.is_none())
    }

    /// Takes all samples of pixels that differ, until `deadline` or until `halt` of
    /// [`with_progressive`](crate::render::Stage::with_progressive) is true: `complete` of the result says that neither
    /// came before the end of a pass over the image. Does nothing unless the image is [complete](Progressive::complete)
    /// and not [antialiased](Progressive::antialiased) yet.
    ///
    /// # Errors
    /// As [`Master::run_frame`](crate::schedule::Master::run_frame); the image is lost then, and must be begun again.
    pub fn antialias(&mut self, schedule: Schedule, side: u32, deadline: Instant) -> Result<Option<Traced>> {
        let Some((_, least)) = self.finer_by.filter(|_| self.complete() && !self.antialiased()) else {
            return Ok(None);
        };
        let mut finer = self.finer.take().unwrap_or_else(|| self.begin_finer(side, least));
        let Some(pass) = finer.adaptive.take() else { return Ok(None) };
        let until = Until { deadline, mode: schedule.film };
        let (camera, tone, corners) = (self.camera, self.tone.clone(), finer.corners.take());
        let job = Job::Finer { camera, tone, pass, corners, until };
        let (mut sum, mut left) = (TileReport::default(), vec![]);
        let (job, stats) = self.run(schedule, job, &finer.left, |pass, tile, output| {
            output.deliver(pass, tile);
            sum.add(&output.tile);
            left.extend(output.skipped.then_some(tile));
        })?;
        let complete = left.is_empty();
        finer.left = left;
        finer.primary += sum.rays.primary;
        if let Job::Finer { pass, corners, .. } = job {
            finer.corners = corners;
            if complete { self.pass_is_done(&mut finer, pass, side) } else { finer.adaptive.put(pass) }
        }
        self.finer = Some(finer);
        Ok(Some(Traced::new(&sum, stats, complete)))
    }

    fn begin_finer(&mut self, side: u32, least: f32) -> Finer {
        let mut adaptive = Adaptive::new(least, true);
        adaptive.put(Pass::Corners);
        let corners = self.spare.pop().unwrap_or_else(|| Film::new(self.size[0], self.size[1]));
        Finer { adaptive, left: self.tiles(side), primary: 0, corners: Some(corners) }
    }

    fn pass_is_done(&mut self, finer: &mut Finer, pass: Pass, side: u32) {
        let Finer { adaptive, primary, .. } = finer;
        let (image, spare) = (&mut self.canvas.film, &mut self.spare);
        match finer.corners.take() {
            None => adaptive.done(pass, image, spare, *primary),
            Some(mut corners) => {
                adaptive.done(pass, &mut corners, spare, *primary);
                spare.push(corners);
                // One sample of every pixel is there already.
                if let Some(centres) = adaptive.take() {
                    adaptive.done(centres, image, spare, 0);
                }
            }
        }
        // Tiles with as many rays as others have pixels, so that an event waits no longer for one.
        let along = self.finer_by.map_or(1, |(samples, _)| samples.isqrt().max(1));
        (finer.left, finer.primary) = (self.tiles(side / along), 0);
    }

    /// Forgets what makes the image adaptive, and keeps the memory.
    pub(super) fn end_finer(&mut self) {
        if let Some(Finer { adaptive, corners, .. }) = self.finer.take() {
            self.spare.extend(adaptive.end().chain(corners));
        }
    }

    /// The image is complete, and has all samples where they show.
    pub fn antialiased(&self) -> bool {
        let done = |finer: &Finer| finer.adaptive.complete();
        self.complete() && (self.finer_by.is_none() || self.finer.as_ref().is_some_and(done))
    }

    /// The image with all samples where they show, bit by bit that of a render with adaptive samples. `None` unless it is
    /// [antialiased](Progressive::antialiased).
    pub fn antialiased_film(&self) -> Option<&Film> {
        self.antialiased().then_some(&self.canvas.film)
    }

    /// How far the image has become adaptive; `None` before that was begun.
    pub fn refined(&self) -> Option<Refined> {
        let (samples, pixels) = (self.finer_by?.0, self.finer.as_ref()?.adaptive.samples()?);
        let count = pixels.len().max(1);
        let share = pixels.filter(|&samples| samples > 1).count() as f64 / count as f64;
        Some(Refined { samples, share, complete: self.antialiased() })
    }

    /// The samples of each pixel, row by row; `None` before the first that has more than one.
    pub fn pixel_samples(&self) -> Option<Vec<u32>> {
        Some(self.finer.as_ref()?.adaptive.samples()?.collect())
    }
}
