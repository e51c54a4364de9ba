//! Making pictures: takes events, moves the camera, begins a picture or refines it, and sleeps when nothing is left to do.

use super::{
    clock::Clock,
    link::{Link, Timed},
    overlay::Overlay,
    pacer::{Pacer, regions},
    picture::{News, ShownMoment},
    publish::Made,
    state::{Change, State},
};
use crate::{
    error::Result,
    render::{Level, Limit, Progressive, RayMap, Target, Traced},
    schedule::{Span, WorkerStats},
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Tiles for a base of every n-th pixel are n times as large, so that a worker has as many rays at a time; up to this.
const LARGEST_TILE: u32 = 256;
/// A pass at rest plans this much time before the picture is shown again.
pub(super) const REST_PASS: f64 = 0.1;
/// A frame has no time for another pass in less than this, in seconds.
const SHORTEST_PASS: f64 = 1.0e-3;
/// Between two looks at keys that move nothing.
const SHORTEST_PAUSE: Duration = Duration::from_millis(1);

/// What lasts when the workers are made anew.
pub(super) struct Kept {
    pub(super) pacer: Pacer,
    /// The moment that the scene is at, if it moves.
    pub(super) moment: Option<ShownMoment>,
    /// When work on a picture began before its workers were there.
    pub(super) begun: Option<Instant>,
    /// When the oldest event happened that no picture shows yet.
    unseen: Option<Instant>,
    /// Up to when held keys and the time that passes have been taken in.
    last: Instant,
    /// What the workers did in the first pass of this image.
    pub(super) first: (Vec<WorkerStats>, Vec<Span>),
    /// Seconds spent on tracing this image.
    pub(super) image_seconds: f64,
}

impl Kept {
    pub(super) fn new(state: &State) -> Kept {
        let Clock { time, .. } = state.clock;
        let length = state.clock.length();
        let moment = ShownMoment { time, length, follow_seconds: 0.0, update: None };
        Kept {
            pacer: Pacer::new(state.frame_time),
            moment: (length > 0.0).then_some(moment),
            begun: None,
            unseen: None,
            last: Instant::now(),
            first: Default::default(),
            image_seconds: 0.0,
        }
    }
}

/// Why a maker has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// The viewer ends.
    Quit,
    /// Workers and canvas must be made anew.
    Engine,
    /// The scene is elsewhere by now.
    Moment,
}

/// Makes the pictures of one moment by one set of workers.
pub(super) struct Maker<'r, 'm, 'a> {
    pub(super) session: &'r mut Progressive<'m, 'a>,
    pub(super) state: &'r mut State,
    pub(super) kept: &'r mut Kept,
    pub(super) link: &'r Link,
    pub(super) tell: &'r mut dyn FnMut(News),
    /// What rays do in the image that is shown, if that was asked for.
    pub(super) map: Option<Arc<RayMap>>,
    /// Pixels have got more samples than those that are shown.
    pub(super) unshown: bool,
}

impl<'r, 'm, 'a> Maker<'r, 'm, 'a> {
    pub(super) fn new(
        session: &'r mut Progressive<'m, 'a>,
        state: &'r mut State,
        kept: &'r mut Kept,
        link: &'r Link,
        tell: &'r mut dyn FnMut(News),
    ) -> Maker<'r, 'm, 'a> {
        Maker { session, state, kept, link, tell, map: None, unshown: false }
    }

    /// Makes pictures until there is a reason to end.
    pub(super) fn run(mut self) -> Result<End> {
        let (mut stale, mut told, mut laid) = (true, false, Overlay::None);
        // A moment gets its picture before anything else is listened to: else time would have passed again.
        if self.kept.begun.is_some() {
            self.frame()?;
            (stale, laid) = (false, self.state.laid());
        }
        loop {
            let whole = !stale && !self.state.moving() && self.session.complete();
            if whole && laid != self.state.overlay && self.lay()? {
                laid = self.state.overlay;
            }
            let idle = whole && laid == self.state.overlay && self.is_finest();
            if self.state.settling || !self.state.screenshots.is_empty() {
                told = false;
            }
            if idle && !std::mem::replace(&mut told, true) {
                self.rest();
            }
            let change = self.listen(idle);
            if let Some(end) = self.end(change) {
                return Ok(end);
            }
            stale |= change.picture || !self.session.suits_antialiasing(self.state.antialiasing);
            if stale {
                self.frame()?;
                (stale, told, laid) = (false, false, self.state.laid());
            } else if !self.session.complete() {
                self.refine()?;
            } else if !self.state.moving() && !self.is_finest() {
                self.antialias()?;
                told = false;
            } else if self.state.moving() {
                // By keys that hold each other: nobody has to look again at once.
                std::thread::sleep(SHORTEST_PAUSE);
            }
        }
    }

    fn end(&self, change: Change) -> Option<End> {
        let moved = self.kept.moment.is_some_and(|moment| moment.time != self.state.clock.time);
        [(change.quit, End::Quit), (change.engine, End::Engine), (moved, End::Moment)]
            .into_iter()
            .find(|(so, _)| *so)
            .map(|(_, end)| end)
    }

    /// Takes events in, and moves the camera up to now.
    fn listen(&mut self, wait: bool) -> Change {
        let (events, frame_time) = (self.link.take(wait), self.state.frame_time);
        let mut change = Change::default();
        if wait {
            self.kept.last = Instant::now();
        }
        for Timed { at, event } in events {
            // Keys that were held until then have moved the camera until then.
            change.picture |= self.step(at);
            let mut own = Change::default();
            self.state.apply(&event, &mut own);
            if own != Change::default() || self.state.moving() {
                self.kept.unseen.get_or_insert(at);
            }
            change.picture |= own.picture;
            change.engine |= own.engine;
            change.quit |= own.quit;
        }
        change.picture |= self.step(Instant::now());
        if self.state.frame_time != frame_time {
            self.kept.pacer = Pacer::new(self.state.frame_time);
        }
        change
    }

    fn step(&mut self, now: Instant) -> bool {
        let seconds = now.saturating_duration_since(self.kept.last).as_secs_f32();
        self.kept.last = self.kept.last.max(now);
        self.state.advance(seconds)
    }

    /// A whole new picture.
    fn frame(&mut self) -> Result<()> {
        let begin = Instant::now();
        let start = self.kept.begun.take().unwrap_or(begin);
        let [width, height] = self.state.options.size;
        let (pixels, workers) = (f64::from(width) * f64::from(height), self.session.workers());
        let left = self.kept.pacer.left(begin - start);
        let base = self.kept.pacer.base(left, pixels, workers);
        self.session.set_antialiasing(self.state.antialiasing);
        (self.map, self.unshown) = (None, false);
        // With time for every pixel, the image need not be there before the camera rests.
        match base {
            Level::Full => self.session.begin_sketch(&self.state.rig.camera, &self.state.tone),
            _ => self.session.begin(&self.state.rig.camera, &self.state.tone),
        }
        let side = (self.state.options.tile * base.spacing()).min(LARGEST_TILE.max(self.state.options.tile));
        let targets: Vec<Target> =
            self.session.tiles(side).into_iter().map(|tile| Target { tile, level: base }).collect();
        let first = self.session.trace(self.state.options.schedule, &targets, Limit::Whole)?;
        self.kept.image_seconds = first.stats.seconds;
        self.kept.first = (first.stats.workers, first.stats.spans);
        self.kept.pacer.learn_base(base, pixels, workers, begin.elapsed().as_secs_f64());
        let mut rays = first.rays;
        let deadline = begin + Duration::from_secs_f64(self.kept.pacer.left(begin - start));
        loop {
            let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
            if left < SHORTEST_PASS || self.session.traced() {
                break;
            }
            rays.add(&self.pass(left, Limit::Until(deadline))?.rays);
        }
        let latency = self.kept.unseen.take();
        self.publish(Made { start, latency, moved: true, base, rays })
    }

    /// The picture becomes finer, or the sketch an image.
    fn refine(&mut self) -> Result<()> {
        let start = Instant::now();
        if self.session.is_sketch() {
            self.session.begin(&self.state.rig.camera, &self.state.tone);
            self.kept.image_seconds = 0.0;
        }
        if self.session.level(self.session.whole()) == Level::Nothing {
            return self.whole(start);
        }
        let Traced { complete, rays, .. } = self.pass(REST_PASS, Limit::Halt)?;
        if complete {
            let base = self.session.level(self.session.whole());
            self.publish(Made::finer(start, base, rays))?;
        }
        Ok(())
    }

    /// Traces all pixels, which takes no longer than a frame did, and shows them unless an event comes first.
    fn whole(&mut self, start: Instant) -> Result<()> {
        let tiles = self.session.tiles(self.state.options.tile);
        let targets: Vec<Target> =
            tiles.into_iter().map(|tile| Target { tile, level: Level::Full }).collect();
        let traced = self.session.trace(self.state.options.schedule, &targets, Limit::Halt)?;
        self.kept.image_seconds += traced.stats.seconds;
        if traced.complete {
            self.publish(Made::finer(start, Level::Full, traced.rays))?;
        }
        Ok(())
    }

    /// Refines what helps most in these seconds.
    fn pass(&mut self, seconds: f64, limit: Limit) -> Result<Traced> {
        let regions = regions(self.session, self.state.options.tile);
        let (targets, planned) = self.kept.pacer.refine(&regions, seconds, self.session.workers());
        let traced = self.session.trace(self.state.options.schedule, &targets, limit)?;
        self.kept.image_seconds += traced.stats.seconds;
        if traced.complete {
            self.kept.pacer.learn_refine(planned, traced.stats.seconds);
        }
        Ok(traced)
    }
}
