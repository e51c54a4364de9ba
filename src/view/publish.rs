//! From an image to a picture for whoever shows it.

use super::{
    maker::Maker,
    overlay::Overlay,
    picture::{Frame, News, Picture},
    setting::described,
};
use crate::{
    error::Result,
    render::{Level, RayTally},
};
use std::time::Instant;

impl Maker<'_, '_, '_> {
    /// Fills in what is not traced, and gives the picture away.
    pub(super) fn publish(&mut self, made: Made) -> Result<()> {
        let Made { start, latency, moved, base, rays } = made;
        let (workers, spans) = self.kept.first.clone();
        let begin = Instant::now();
        let mut pixels = self.link.spare();
        self.session.fill(self.state.options.schedule, &mut pixels)?;
        let end = Instant::now();
        let fill_seconds = (end - begin).as_secs_f64();
        self.kept.pacer.learn_fill(fill_seconds);
        let frame = Frame {
            start,
            end,
            latency: latency.map(|at| end.saturating_duration_since(at)),
            moved,
            share: self.session.share(),
            base,
            refined: self.session.refined(),
            rays,
            fill_seconds,
            moment: self.kept.moment,
            camera: self.state.rig.camera,
            exposure: self.state.exposure,
            options: self.state.options,
            modes: described(&self.state.options),
            workers,
            spans,
            levels: self.session.levels(),
            image_seconds: self.kept.image_seconds,
        };
        let (size, overlay) = (self.state.options.size, self.state.overlay);
        let map = self.map.clone().filter(|_| overlay.needs_map());
        let tells = overlay == Overlay::Samples;
        let refined = tells.then(|| self.session.pixel_samples()).flatten();
        (self.tell)(News::Picture(Box::new(Picture { size, pixels, frame, overlay, map, refined })));
        Ok(())
    }
}

/// What a picture is published with.
pub(super) struct Made {
    pub(super) start: Instant,
    /// When the oldest event happened that it is the first to show.
    pub(super) latency: Option<Instant>,
    pub(super) moved: bool,
    pub(super) base: Level,
    pub(super) rays: RayTally,
}

impl Made {
    /// The same image as before, finer.
    pub(super) fn finer(start: Instant, base: Level, rays: RayTally) -> Made {
        Made { start, latency: None, moved: false, base, rays }
    }
}
