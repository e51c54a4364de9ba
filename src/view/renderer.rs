//! The renderer's thread: what lasts from picture to picture, and when the scene, the tree or the workers are made anew.
//!
//! ```text
//!   events, held keys --> camera has moved?  yes: a whole new picture, as fine as the frame time allows
//!                                            no:  the picture is refined, unless every pixel is traced
//!                         scene has moved?   the tree follows, the workers begin anew, and so does the picture
//!   picture --> whoever shows it; meanwhile the next one is made
//! ```
//!
//! A picture holds pixels of one camera and one moment only: what was seen of older ones is dropped at once.

use super::{
    link::Link,
    maker::{End, Kept, Maker},
    pacer::Pacer,
    picture::{News, ShownMoment},
    state::State,
};
use crate::{
    error::{Error, Result},
    render::{Canvas, Geometry, RenderOptions, Stage},
    scene::Scene,
    schedule::{Machine, Placement},
};
use std::borrow::Cow;
use std::time::{Duration, Instant};

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
    let mut scene = Cow::Borrowed(scene);
    let mut geometry = Stage::new(&scene, options)?.leave();
    let mut state = State::new(&scene, options, frame_time);
    let (mut kept, mut canvas) = (Kept::new(&state), Canvas::default());
    loop {
        follow(&mut scene, &mut geometry, &state, &mut kept)?;
        let stage = Stage::again(&scene, &state.options, geometry)?;
        let placement = Placement::new(Machine::get(), state.options.threads, state.options.pin);
        let end = stage.with_progressive_on(&mut canvas, &placement, &link.halt, |session| {
            Maker::new(session, &mut state, &mut kept, link, &mut *tell).run()
        })?;
        geometry = stage.leave();
        match end {
            End::Quit => return Ok(()),
            End::Engine => kept.pacer = Pacer::new(state.frame_time),
            End::Moment => {}
        }
    }
}

/// Puts a moving scene where it is at the time of the clock, and lets the tree follow.
fn follow(scene: &mut Cow<'_, Scene>, geometry: &mut Geometry, state: &State, kept: &mut Kept) -> Result<()> {
    let Some(moment) = kept.moment else { return Ok(()) };
    kept.moment = Some(ShownMoment { follow_seconds: 0.0, update: None, ..moment });
    if moment.time != state.clock.time {
        let (start, time) = (Instant::now(), state.clock.time);
        scene.to_mut().pose(time);
        let update = Some(geometry.follow(scene, state.options.build)?);
        let follow_seconds = start.elapsed().as_secs_f64();
        kept.moment = Some(ShownMoment { time, follow_seconds, update, ..moment });
        kept.begun = Some(start);
    }
    Ok(())
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
