//! Frames of a mode and of the default, by turns, on the same workers' cores.

use super::{Patience, compare::Picture, modes::Mode};
use crate::{
    error::Result,
    math::{Spread, SrgbTable, srgb8_to_linear},
    render::{Level, Limit, RenderOptions, Stage, Target, Tone},
    scene::Scene,
    schedule::{Control, Placement},
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// One frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) seconds: f64,
    pub(super) rays: u64,
}

/// What a mode takes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Times {
    /// Seconds of a frame.
    pub seconds: Spread,
    /// The same over those of the default frame beside it, round by round.
    pub ratio: Spread,
    /// Rays of a frame.
    pub rays: u64,
}

/// An image of a mode.
pub(super) struct Image {
    pub(super) picture: Picture,
    /// Hash of the linear pixels; `None` for pictures of bytes.
    pub(super) hash: Option<String>,
    /// Pixels that came out as NaN or infinite.
    pub(super) nan: u64,
}

/// Where and how frames are made.
pub(super) struct Bench<'a> {
    pub(super) placement: Placement,
    pub(super) options: RenderOptions,
    pub(super) control: &'a Control<'a>,
}

/// Makes a frame, and its image if that is wanted.
type Make<'m> = &'m mut dyn FnMut(bool) -> Result<(Frame, Option<Image>)>;
type Body<'b> = &'b mut dyn FnMut(Make) -> Result<()>;

impl Bench<'_> {
    /// Renders `mode` of a stage and the default by turns; the first frames of both are not counted.
    ///
    /// # Errors
    /// As [`crate::render::render`].
    pub(super) fn measure(
        &self,
        default: &Stage,
        stage: &Stage,
        scene: &Scene,
        mode: Mode,
        patience: Patience,
    ) -> Result<(Image, Times)> {
        let mut shown = None;
        let tiles = default.tiles(self.options.tile);
        default.with_session(&self.placement, |session| {
            let mut plain = || {
                let (seconds, rays) = session.frame(self.options.schedule, &tiles, self.control)?;
                Ok(Frame { seconds, rays: rays.total() })
            };
            self.with_frames(stage, scene, mode, &mut |frame| {
                plain()?;
                let (first, image) = frame(true)?;
                let times = rounds(patience, first, &mut plain, &mut || Ok(frame(false)?.0))?;
                shown = image.map(|image| (image, times));
                Ok(())
            })
        })?;
        shown.ok_or_else(|| crate::error::Error::Failed(format!("{mode} made no image; please report this")))
    }

    /// Calls `body` with what makes a frame and its picture.
    fn with_frames(&self, stage: &Stage, scene: &Scene, mode: Mode, body: Body) -> Result<()> {
        match mode {
            Mode::Fill(level) => self.with_filled(stage, scene, level, body),
            _ => self.with_films(stage, mode == Mode::EightBits, body),
        }
    }

    fn with_films(&self, stage: &Stage, bytes: bool, body: Body) -> Result<()> {
        let (tiles, table, linear) = (stage.tiles(self.options.tile), SrgbTable::new(), srgb8_to_linear());
        stage.with_session(&self.placement, |session| {
            body(&mut |wanted| {
                let (mut seconds, rays) = session.frame(self.options.schedule, &tiles, self.control)?;
                let film = session.film();
                let mut encoded: Vec<[u8; 3]> = vec![];
                if bytes {
                    let start = Instant::now();
                    encoded.extend(film.pixels().map(|pixel| pixel.map(|value| table.encode(value))));
                    seconds += start.elapsed().as_secs_f64();
                }
                let image = wanted.then(|| {
                    let shown = encoded.iter().map(|pixel| pixel.map(|byte| linear[usize::from(byte)]));
                    let (picture, hash) = match bytes {
                        true => (Picture::new([film.width(), film.height()], shown), None),
                        false => (Picture::of(film), Some(film.sha256())),
                    };
                    Image { picture, hash, nan: film.nan().map_or(0, |nan| nan.count) }
                });
                Ok((Frame { seconds, rays: rays.total() }, image))
            })
        })
    }

    fn with_filled(&self, stage: &Stage, scene: &Scene, level: Level, body: Body) -> Result<()> {
        let linear = srgb8_to_linear();
        let halt = AtomicBool::new(false);
        let (schedule, tone) = (self.options.schedule, Tone::new(0.0));
        stage.with_progressive(&self.placement, &halt, |progressive| {
            let tiles = progressive.tiles(self.options.tile);
            let targets: Vec<Target> = tiles.into_iter().map(|tile| Target { tile, level }).collect();
            let mut filled = vec![];
            body(&mut |wanted| {
                let start = Instant::now();
                progressive.begin(&scene.camera, &tone);
                let traced = progressive.trace(schedule, &targets, Limit::Whole)?;
                progressive.fill(schedule, &mut filled)?;
                let seconds = start.elapsed().as_secs_f64();
                let pixel = |i: usize| {
                    let [_, bytes @ ..] = filled[i].load(Ordering::Relaxed).to_be_bytes();
                    bytes.map(|byte| linear[usize::from(byte)])
                };
                let image = wanted.then(|| Image {
                    picture: Picture::new(self.options.size, (0..filled.len()).map(pixel)),
                    hash: None,
                    nan: progressive.film().nan().map_or(0, |nan| nan.count),
                });
                Ok((Frame { seconds, rays: traced.rays.total() }, image))
            })
        })
    }
}

/// Rounds of a default frame and one of the mode, the first of which alternates.
fn rounds(
    patience: Patience,
    first: Frame,
    plain: &mut dyn FnMut() -> Result<Frame>,
    frame: &mut dyn FnMut() -> Result<Frame>,
) -> Result<Times> {
    let start = Instant::now();
    let (mut seconds, mut ratios) = (vec![], vec![]);
    while patience.lasts(seconds.len(), start) {
        let (own, usual) = if seconds.len() % 2 == 0 {
            let usual = plain()?;
            (frame()?, usual)
        } else {
            let own = frame()?;
            (own, plain()?)
        };
        seconds.push(own.seconds);
        ratios.push(own.seconds / usual.seconds);
    }
    Ok(Times { seconds: Spread::of(&seconds), ratio: Spread::of(&ratios), rays: first.rays })
}
