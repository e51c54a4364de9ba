//! The figures over the picture: how fast, how fine, and what the workers do.

use super::picture::{Frame, ShownMoment};
use crate::render::Update;
use std::collections::VecDeque;
use std::time::Duration;

/// Frames older than this do not count.
const WINDOW: Duration = Duration::from_secs(1);

/// The last frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Figures {
    frames: VecDeque<Frame>,
}

/// What time it is, and what it took to get there.
fn moment_line(moment: &ShownMoment) -> String {
    let ShownMoment { time, length, follow_seconds, update } = moment;
    let tree = match update {
        None => String::new(),
        Some(update) => {
            let done = if *update == Update::Refitted { "refitted" } else { "built anew" };
            format!(", tree {done}: {:.1} ms", follow_seconds * 1e3)
        }
    };
    format!("{time:5.2} of {length:.2} s{tree}")
}

impl Figures {
    /// One more frame was finished.
    pub(super) fn note(&mut self, frame: &Frame) {
        self.frames.push_back(frame.clone());
        while self.frames.front().is_some_and(|old| frame.end.duration_since(old.end) > WINDOW) {
            self.frames.pop_front();
        }
    }

    /// What to show, a line for each.
    pub(super) fn lines(&self) -> Vec<String> {
        let Some(last) = self.frames.back() else { return vec![] };
        let moving: Vec<&Frame> = self.frames.iter().filter(|frame| frame.moved).collect();
        let mut times: Vec<f64> =
            moving.windows(2).map(|pair| (pair[1].end - pair[0].end).as_secs_f64()).collect();
        times.sort_unstable_by(f64::total_cmp);
        let mut lines = vec![];
        if let (Some(least), Some(most)) = (times.first(), times.last()) {
            let typical = times[times.len() / 2];
            lines.push(format!(
                "{:5.1} frames/s   {:.1} ms ({:.1} to {:.1})",
                1.0 / typical.max(1e-9),
                typical * 1e3,
                least * 1e3,
                most * 1e3
            ));
        }
        let seconds = (last.end - last.start).as_secs_f64().max(1e-9);
        let [primary, shadow] =
            [last.rays.primary, last.rays.shadow].map(|rays| rays as f64 / seconds * 1e-6);
        lines.push(format!("{primary:5.1} Mrays/s primary, {shadow:.1} shadow"));
        lines.push(format!(
            "{:5.1} % traced{}",
            last.share * 100.0,
            if last.moved { "" } else { ", at rest" }
        ));
        lines.extend(last.refined.map(|refined| {
            let done = if refined.complete { "anti-aliased" } else { "anti-aliasing" };
            format!("{:5.1} % {done} by up to {} samples", refined.share * 100.0, refined.samples)
        }));
        if let Some(latency) = last.latency.or(moving.last().and_then(|frame| frame.latency)) {
            lines.push(format!("{:5.1} ms from hand to eye", latency.as_secs_f64() * 1e3));
        }
        lines.extend(last.moment.map(|moment| moment_line(&moment)));
        lines.push(last.modes.clone());
        lines
    }

    /// Each worker's time in the last first pass: busy, and idle at the start, for work, to deliver, at the end; as
    /// shares of the pass.
    pub(super) fn loads(&self) -> Vec<[f64; 5]> {
        let Some(last) = self.frames.iter().rev().find(|frame| !frame.workers.is_empty()) else {
            return vec![];
        };
        let load = |worker: &crate::schedule::WorkerStats| {
            let idle = worker.idle;
            let parts = [worker.busy_seconds, idle.start, idle.work, idle.deliver, idle.tail];
            let sum = parts.iter().sum::<f64>().max(1e-9);
            parts.map(|part| part / sum)
        };
        last.workers.iter().map(load).collect()
    }
}
