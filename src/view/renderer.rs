//! The renderer's thread: takes events, moves the camera, makes pictures, and sleeps when there is nothing left to do.
//!
//! ```text
//!   events, held keys --> camera has moved?  yes: a whole new picture, as fine as the frame time allows
//!                                            no:  the picture is refined, unless every pixel is traced
//!   picture --> whoever shows it; meanwhile the next one is made
//! ```
//!
//! A picture holds pixels of one camera only: what an older camera saw is dropped at once.

use super::{
    link::{Link, Timed},
    overlay::Overlay,
    pacer::{Pacer, regions},
    picture::{Frame, News, Picture},
    setting::described,
    state::{Change, State},
};
use crate::{
    error::{Error, Result},
    output::OutputFile,
    render::{Level, Limit, Progressive, RayMap, RayTally, RenderOptions, Stage, Target, Traced},
    scene::Scene,
    schedule::{Machine, Placement, Span, WorkerStats},
};
use std::time::{Duration, Instant};

/// Tiles for a base of every n-th pixel are n times as large, so that a worker has as many rays at a time; up to this.
const LARGEST_TILE: u32 = 256;
/// A pass at rest plans this much time before the picture is shown again.
const REST_PASS: f64 = 0.1;
/// A frame has no time for another pass in less than this, in seconds.
const SHORTEST_PASS: f64 = 1.0e-3;

/// Renders until an event ends it. `tell` gets all news, on this thread.
///
/// # Errors
/// As [`Stage::new`] and [`Stage::with_progressive`].
pub fn run(
    scene: &Scene,
    options: &RenderOptions,
    frame_time: Duration,
    link: &Link,
    tell: &mut dyn FnMut(News),
) -> Result<()> {
    let mut geometry = Stage::new(scene, options)?.leave();
    let mut state = State::new(scene, options, frame_time);
    // When the oldest event happened that no picture shows yet.
    let mut unseen = None;
    loop {
        let stage = Stage::again(scene, &state.options, geometry)?;
        let placement = Placement::new(Machine::get(), state.options.threads, state.options.pin);
        let quit = stage.with_progressive(&placement, &link.halt, |session| {
            let pacer = Pacer::new(state.frame_time);
            let last = Instant::now();
            let renderer = Renderer {
                session,
                state: &mut state,
                pacer,
                link,
                tell: &mut *tell,
                last,
                first: Default::default(),
                image_seconds: 0.0,
            };
            renderer.run(&mut unseen)
        })?;
        if quit {
            return Ok(());
        }
        geometry = stage.leave();
    }
}

struct Renderer<'r, 'm, 'a> {
    session: &'r mut Progressive<'m, 'a>,
    state: &'r mut State,
    pacer: Pacer,
    link: &'r Link,
    tell: &'r mut dyn FnMut(News),
    /// What the workers did in the first pass of this image.
    first: (Vec<WorkerStats>, Vec<Span>),
    /// Seconds spent on tracing this image.
    image_seconds: f64,
    /// Up to when held keys have moved the camera.
    last: Instant,
}

impl Renderer<'_, '_, '_> {
    /// Makes pictures until the viewer ends (true) or the workers must be made anew (false).
    fn run(mut self, unseen: &mut Option<Instant>) -> Result<bool> {
        let (mut stale, mut told, mut laid) = (true, false, Overlay::None);
        loop {
            let idle = !stale && !self.state.moving() && self.session.complete();
            if self.state.settling || !self.state.screenshots.is_empty() {
                told = false;
            }
            if idle && laid != self.state.overlay && self.lay()? {
                laid = self.state.overlay;
            }
            let halted = idle && laid != self.state.overlay;
            if idle && !halted && !std::mem::replace(&mut told, true) {
                self.rest();
            }
            let change = self.listen(idle && !halted, unseen);
            if change.quit || change.engine {
                return Ok(change.quit);
            }
            stale |= change.picture;
            if stale {
                self.frame(unseen)?;
                (stale, told, laid) = (
                    false,
                    false,
                    if self.state.overlay.needs_map() { Overlay::None } else { self.state.overlay },
                );
            } else if !self.session.complete() {
                self.refine()?;
            }
        }
    }

    /// Shows the picture at rest with another overlay; false if an event came first.
    fn lay(&mut self) -> Result<bool> {
        if self.state.overlay.needs_map() {
            return self.map();
        }
        let (start, rays) = (Instant::now(), RayTally::default());
        self.publish(Made { start, latency: None, moved: false, base: Level::Full, rays, map: None })?;
        Ok(true)
    }

    /// Nothing is left to do.
    fn rest(&mut self) {
        let film = self.session.film();
        for path in self.state.screenshots.drain(..) {
            let written = OutputFile::create(&path).and_then(|file| file.write(film, self.state.exposure));
            (self.tell)(News::Note(match written {
                Ok(()) => format!("{} is written", path.display()),
                Err(error) => error.to_string(),
            }));
        }
        let image_sha256 = std::mem::take(&mut self.state.settling).then(|| film.sha256());
        (self.tell)(News::Rest { image_sha256 });
    }

    /// Takes events in, and moves the camera up to now.
    fn listen(&mut self, wait: bool, unseen: &mut Option<Instant>) -> Change {
        let (events, frame_time) = (self.link.take(wait), self.state.frame_time);
        let mut change = Change::default();
        if wait {
            self.last = Instant::now();
        }
        for Timed { at, event } in events {
            // Keys that were held until then have moved the camera until then.
            change.picture |= self.step(at);
            let mut own = Change::default();
            self.state.apply(&event, &mut own);
            if own != Change::default() || self.state.moving() {
                unseen.get_or_insert(at);
            }
            change.picture |= own.picture;
            change.engine |= own.engine;
            change.quit |= own.quit;
        }
        change.picture |= self.step(Instant::now());
        if self.state.frame_time != frame_time {
            self.pacer = Pacer::new(self.state.frame_time);
        }
        change
    }

    fn step(&mut self, now: Instant) -> bool {
        let seconds = now.saturating_duration_since(self.last).as_secs_f32();
        self.last = self.last.max(now);
        self.state.advance(seconds)
    }

    /// A whole new picture.
    fn frame(&mut self, unseen: &mut Option<Instant>) -> Result<()> {
        let start = Instant::now();
        self.session.begin(&self.state.rig.camera, &self.state.tone);
        let [width, height] = self.state.options.size;
        let (pixels, workers) = (f64::from(width) * f64::from(height), self.session.workers());
        let base = self.pacer.base(pixels, workers);
        let side = (self.state.options.tile * base.spacing()).min(LARGEST_TILE.max(self.state.options.tile));
        let targets: Vec<Target> =
            self.session.tiles(side).into_iter().map(|tile| Target { tile, level: base }).collect();
        let first = self.session.trace(self.state.options.schedule, &targets, Limit::Whole)?;
        self.image_seconds = first.stats.seconds;
        self.first = (first.stats.workers, first.stats.spans);
        self.pacer.learn_base(base, pixels, workers, start.elapsed().as_secs_f64());
        let mut rays = first.rays;
        let deadline = start + Duration::from_secs_f64(self.pacer.tracing());
        loop {
            let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
            if left < SHORTEST_PASS || self.session.complete() {
                break;
            }
            rays.add(&self.pass(left, Limit::Until(deadline))?.rays);
        }
        let latency = unseen.take();
        let map = None;
        self.publish(Made { start, latency, moved: true, base, rays, map })
    }

    /// The picture becomes finer.
    fn refine(&mut self) -> Result<()> {
        let start = Instant::now();
        let Traced { complete, rays, .. } = self.pass(REST_PASS, Limit::Halt)?;
        if complete {
            let base = self.session.level(self.session.whole());
            self.publish(Made { start, latency: None, moved: false, base, rays, map: None })?;
        }
        Ok(())
    }

    /// The picture is shown again, with a map of what the rays of the whole image do; unless an event comes first.
    fn map(&mut self) -> Result<bool> {
        let start = Instant::now();
        let map = self.session.map(self.state.options.schedule)?;
        let mapped = map.is_some();
        if mapped {
            let rays = RayTally::default();
            self.publish(Made { start, latency: None, moved: false, base: Level::Full, rays, map })?;
        }
        Ok(mapped)
    }

    /// Refines what helps most in these seconds.
    fn pass(&mut self, seconds: f64, limit: Limit) -> Result<Traced> {
        let regions = regions(self.session, self.state.options.tile);
        let (targets, planned) = self.pacer.refine(&regions, seconds, self.session.workers());
        let traced = self.session.trace(self.state.options.schedule, &targets, limit)?;
        self.image_seconds += traced.stats.seconds;
        if traced.complete {
            self.pacer.learn_refine(planned, traced.stats.seconds);
        }
        Ok(traced)
    }

    fn publish(&mut self, made: Made) -> Result<()> {
        let Made { start, latency, moved, base, rays, map } = made;
        let (workers, spans) = self.first.clone();
        let begin = Instant::now();
        let mut pixels = self.link.spare();
        self.session.fill(self.state.options.schedule, &mut pixels)?;
        let end = Instant::now();
        let fill_seconds = (end - begin).as_secs_f64();
        self.pacer.learn_fill(fill_seconds);
        let frame = Frame {
            start,
            end,
            latency: latency.map(|at| end.saturating_duration_since(at)),
            moved,
            share: self.session.share(),
            base,
            rays,
            fill_seconds,
            camera: self.state.rig.camera,
            exposure: self.state.exposure,
            options: self.state.options,
            modes: described(&self.state.options),
            workers,
            spans,
            levels: self.session.levels(),
            image_seconds: self.image_seconds,
        };
        let (size, overlay) = (self.state.options.size, self.state.overlay);
        (self.tell)(News::Picture(Box::new(Picture { size, pixels, frame, overlay, map })));
        Ok(())
    }
}

/// What a picture is published with.
struct Made {
    start: Instant,
    /// When the oldest event happened that it is the first to show.
    latency: Option<Instant>,
    moved: bool,
    base: Level,
    rays: RayTally,
    map: Option<RayMap>,
}

/// Calls [`run`] on a thread of its own, which ends before `user` has returned, and `user` meanwhile on this one. The
/// renderer ends when `user` returns.
///
/// # Errors
/// As [`run`], or what `user` returns; [`Error::Failed`] if the thread cannot be started.
pub fn beside<R>(
    scene: &Scene,
    options: &RenderOptions,
    frame_time: Duration,
    link: &Link,
    mut tell: impl FnMut(News) + Send,
    user: impl FnOnce() -> Result<R>,
) -> Result<R> {
    std::thread::scope(|scope| {
        let renderer = std::thread::Builder::new()
            .name("renderer".into())
            .spawn_scoped(scope, move || run(scene, options, frame_time, link, &mut tell))
            .map_err(|error| {
                Error::Failed(format!("the renderer's thread cannot be started ({error}); try again"))
            })?;
        let outcome = user();
        link.send(super::Event::Quit);
        match renderer.join() {
            Ok(done) => done.and(outcome),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
