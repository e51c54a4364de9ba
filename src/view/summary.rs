//! What a script has shown, frame by frame and in all.

use super::{picture::Frame, script::Played};
use crate::{
    error::Result,
    math::median,
    render::{Level, Limit, RenderOptions, Stage, Target, Tone},
    scene::Scene,
    schedule::{Machine, Placement},
};
use serde::Serialize;
use std::borrow::Cow;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// One frame.
#[derive(Clone, Debug, Serialize)]
pub struct FrameRow {
    /// Seconds from the start of the script to the start of the frame.
    pub at: f64,
    /// Seconds that it took, from the end of the last frame if that was moving, too.
    pub seconds: f64,
    /// Seconds from the event that it is the first to show until it was finished.
    pub latency: Option<f64>,
    /// The camera or the scene had moved.
    pub moved: bool,
    /// Share of the pixels that are traced.
    pub share: f64,
    /// Rays traced for it.
    pub primary: u64,
    /// The same, to lights.
    pub shadow: u64,
    /// Seconds of filling in the missing pixels.
    pub fill_seconds: f64,
    /// Seconds from the beginning of the motion, if the scene moves.
    pub time: Option<f64>,
    /// Root mean square difference from the whole image, in bytes of sRGB; of some frames only.
    pub rms_error: Option<f64>,
}

/// All frames, and what they have in common.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scene's name.
    pub scene: String,
    /// Width and height at the start.
    pub size: [u32; 2],
    /// Length of a frame that was asked for, in seconds.
    pub frame_time: f64,
    /// Frames made while the camera moved.
    pub moving_frames: usize,
    /// Share of those that took no longer than the frame time.
    pub in_time: f64,
    /// Frames per second while the camera moved, by the median.
    pub fps: f64,
    /// Their median, 95th percentile and greatest time in seconds.
    pub seconds: [f64; 3],
    /// Median and greatest latency in seconds.
    pub latency: [f64; 2],
    /// Least and median share of the pixels that were traced while the camera moved.
    pub share: [f64; 2],
    /// Hash of the linear image at each rest of the script, before anti-aliasing.
    pub image_sha256: Vec<String>,
    /// The same after it; `None` for each rest without.
    pub antialiased_sha256: Vec<Option<String>>,
    /// Every frame.
    pub frames: Vec<FrameRow>,
}

/// Sums up what was played. `errors` are by number of the frame.
pub fn summarise(
    scene: &Scene,
    options: &RenderOptions,
    frame_time: Duration,
    played: &Played,
    errors: &[(usize, f64)],
) -> Summary {
    let start = played.start.or(played.frames.first().map(|frame| frame.start));
    let before = std::iter::once(None).chain(played.frames.iter().map(Some));
    let mut frames: Vec<FrameRow> =
        before.zip(&played.frames).map(|(last, frame)| row(start, last, frame)).collect();
    for &(number, error) in errors {
        frames[number].rms_error = Some(error);
    }
    // The first frame came before the script.
    let moving: Vec<&FrameRow> = frames.iter().skip(1).filter(|frame| frame.moved).collect();
    let mut seconds: Vec<f64> = moving.iter().map(|frame| frame.seconds).collect();
    let latencies: Vec<f64> = moving.iter().filter_map(|frame| frame.latency).collect();
    let shares: Vec<f64> = moving.iter().map(|frame| frame.share).collect();
    let late = seconds.iter().filter(|&&seconds| seconds > frame_time.as_secs_f64()).count();
    let middle = |values: &[f64]| if values.is_empty() { 0.0 } else { median(values) };
    let typical = middle(&seconds);
    seconds.sort_unstable_by(f64::total_cmp);
    let percentile =
        seconds.get((seconds.len() * 95).div_ceil(100).saturating_sub(1)).copied().unwrap_or(0.0);
    let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    Summary {
        scene: scene.name.clone(),
        size: options.size,
        frame_time: frame_time.as_secs_f64(),
        moving_frames: seconds.len(),
        in_time: if seconds.is_empty() { 1.0 } else { 1.0 - late as f64 / seconds.len() as f64 },
        fps: if typical > 0.0 { 1.0 / typical } else { 0.0 },
        seconds: [typical, percentile, greatest(&seconds)],
        latency: [middle(&latencies), greatest(&latencies)],
        share: [shares.iter().copied().fold(1.0, f64::min), middle(&shares)],
        image_sha256: played.hashes.clone(),
        antialiased_sha256: played.antialiased.clone(),
        frames,
    }
}

fn row(start: Option<Instant>, last: Option<&Frame>, frame: &Frame) -> FrameRow {
    let since = |from: Instant| frame.end.saturating_duration_since(from).as_secs_f64();
    // Between two frames on the move there is no pause that is not theirs.
    let last_end = last.filter(|last| last.moved && frame.start.saturating_duration_since(last.end) < PAUSE);
    FrameRow {
        at: start.map_or(0.0, |start| frame.start.saturating_duration_since(start).as_secs_f64()),
        seconds: last_end.map_or(since(frame.start), |last| since(last.end)),
        latency: frame.latency.map(|latency| latency.as_secs_f64()),
        moved: frame.moved,
        share: frame.share,
        primary: frame.rays.primary,
        shadow: frame.rays.shadow,
        fill_seconds: frame.fill_seconds,
        time: frame.moment.map(|moment| moment.time),
        rms_error: None,
    }
}

/// Whoever waits longer than this between two frames waits for the user.
const PAUSE: Duration = Duration::from_millis(5);

/// Root mean square differences of the kept pictures from the whole images, in bytes of sRGB, by number of the frame.
///
/// # Errors
/// As [`Stage::new`] and [`Stage::with_progressive`].
pub fn errors(scene: &Scene, options: &RenderOptions, played: &Played) -> Result<Vec<(usize, f64)>> {
    let mut scene = Cow::Borrowed(scene);
    let mut geometry = Stage::new(&scene, options)?.leave();
    let placement = Placement::new(Machine::get(), options.threads, options.pin);
    let mut errors = vec![];
    for (number, picture) in &played.kept {
        if let Some(moment) = picture.frame.moment {
            scene.to_mut().pose(moment.time);
            geometry.follow(&scene, options.build)?;
        }
        let effects = picture.frame.options.effects;
        let here = RenderOptions { size: picture.size, effects, ..*options };
        let stage = Stage::again(&scene, &here, geometry)?;
        let whole = stage.with_progressive(&placement, &AtomicBool::new(false), |session| {
            session.begin(&picture.frame.camera, &Tone::new(picture.frame.exposure));
            let targets: Vec<Target> = session
                .tiles(options.tile)
                .into_iter()
                .map(|tile| Target { tile, level: Level::Full })
                .collect();
            session.trace(options.schedule, &targets, Limit::Whole)?;
            let mut whole = vec![];
            session.fill(options.schedule, &mut whole)?;
            Ok(whole)
        })?;
        errors.push((*number, rms(&picture.pixels, &whole)));
        geometry = stage.leave();
    }
    Ok(errors)
}

fn rms(a: &[AtomicU32], b: &[AtomicU32]) -> f64 {
    let bytes = |pixel: &AtomicU32| pixel.load(Ordering::Relaxed).to_be_bytes();
    let square = |(a, b): (u8, u8)| f64::from(a.abs_diff(b)).powi(2);
    let sum: f64 =
        a.iter().zip(b).map(|(a, b)| bytes(a).into_iter().zip(bytes(b)).map(square).sum::<f64>()).sum();
    (sum / (3 * a.len().max(1)) as f64).sqrt()
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |seconds: f64| seconds * 1e3;
        let [width, height] = self.size;
        let [typical, percentile, greatest] = self.seconds.map(ms);
        let [latency, longest] = self.latency.map(ms);
        let [least, share] = self.share.map(|share| share * 100.0);
        writeln!(f, "{} at {width}x{height}, {} frames", self.scene, self.frames.len())?;
        writeln!(f, "  moving     {} frames, {:.1} per second", self.moving_frames, self.fps)?;
        writeln!(
            f,
            "  time       {typical:.1} ms median, {percentile:.1} ms 95th percentile, {greatest:.1} ms at most"
        )?;
        writeln!(f, "  in time    {:.1} % within {:.1} ms", self.in_time * 100.0, ms(self.frame_time))?;
        writeln!(f, "  latency    {latency:.1} ms median, {longest:.1} ms at most")?;
        writeln!(f, "  traced     {share:.1} % of the pixels, {least:.1} % at least")?;
        let errors: Vec<f64> =
            self.frames.iter().filter(|frame| frame.moved).filter_map(|frame| frame.rms_error).collect();
        if let Some(most) = errors.iter().copied().reduce(f64::max) {
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            writeln!(
                f,
                "  error      {mean:.1} of 255 (root mean square), {most:.1} at most, of {} frames",
                errors.len()
            )?;
        }
        for (index, hash) in self.image_sha256.iter().enumerate() {
            writeln!(f, "  rest {}     image {hash}", index + 1)?;
            if let Some(Some(hash)) = self.antialiased_sha256.get(index) {
                writeln!(f, "  rest {}     anti-aliased {hash}", index + 1)?;
            }
        }
        Ok(())
    }
}
