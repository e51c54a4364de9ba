//! When every pixel is traced and nothing moves: maps, more samples where they show, files, and that it is so.

use super::{
    maker::{Maker, REST_PASS},
    picture::{Hashes, News},
    publish::Made,
};
use crate::{
    error::Result,
    output::OutputFile,
    render::{Level, RayTally},
};
use std::sync::{Arc, atomic::Ordering};
use std::time::{Duration, Instant};

impl Maker<'_, '_, '_> {
    /// Shows the picture at rest with another overlay; false if an event came first.
    pub(super) fn lay(&mut self) -> Result<bool> {
        let start = Instant::now();
        if self.state.overlay.needs_map() && self.map.is_none() {
            self.map = self.session.map(self.state.options.schedule)?.map(Arc::new);
            if self.map.is_none() {
                return Ok(false);
            }
        }
        self.publish(Made::finer(start, Level::Full, RayTally::default()))?;
        Ok(true)
    }

    /// The picture has all the samples that it is to have, and they are shown.
    pub(super) fn is_finest(&self) -> bool {
        !self.state.antialiasing || self.session.antialiased() && !self.unshown
    }

    /// Pixels that differ get more samples, and are shown unless an event has come.
    pub(super) fn antialias(&mut self) -> Result<()> {
        let start = Instant::now();
        let (schedule, side) = (self.state.options.schedule, self.state.options.tile);
        let deadline = start + Duration::from_secs_f64(REST_PASS);
        let mut rays = RayTally::default();
        if let Some(traced) = self.session.antialias(schedule, side, deadline)? {
            self.kept.image_seconds += traced.stats.seconds;
            (rays, self.unshown) = (traced.rays, true);
        }
        if self.unshown && !self.link.halt.load(Ordering::Relaxed) {
            self.publish(Made::finer(start, Level::Full, rays))?;
            self.unshown = false;
        }
        Ok(())
    }

    /// Nothing is left to do.
    pub(super) fn rest(&mut self) {
        let antialiased = self.session.antialiased_film().filter(|_| self.state.antialiasing);
        let film = self.session.film();
        for path in self.state.screenshots.drain(..) {
            let written = OutputFile::create(&path)
                .and_then(|file| file.write(antialiased.unwrap_or(film), self.state.exposure));
            (self.tell)(News::Note(match written {
                Ok(()) => format!("{} is written", path.display()),
                Err(error) => error.to_string(),
            }));
        }
        let hashes = std::mem::take(&mut self.state.settling).then(|| Hashes {
            image_sha256: film.sha256(),
            antialiased_sha256: antialiased.map(crate::film::Film::sha256),
        });
        (self.tell)(News::Rest { hashes });
    }
}
