//! Who did what when in a frame: as a picture, as a trace for trace viewers, and as a map of the image.

use crate::film::Film;
use crate::schedule::{FrameStats, Span};
use serde::Serialize;
use std::fmt::Write;

/// Pixels of the picture: the time axis, the height of a worker's row, the margin for its name.
const WIDTH: f64 = 1200.0;
const ROW: f64 = 22.0;
const MARGIN: f64 = 76.0;
/// With more workers than this, rows get thinner.
const FULL_ROWS: usize = 40;
/// Of a longer stream the last frames are drawn.
const MOST_FRAMES: usize = 4;

/// The frames that are drawn, from which moment on.
fn drawn(stats: &FrameStats) -> (impl Iterator<Item = &Span>, f64) {
    let first = stats.frames.saturating_sub(MOST_FRAMES);
    let spans = stats.spans.iter().filter(move |span| span.frame >= first);
    let start = if first == 0 { 0.0 } else { spans.clone().fold(stats.seconds, |t, span| t.min(span.start)) };
    (spans, start)
}

/// The timeline of a stream of frames as SVG: a row per worker, a bar per tile, time from left to right; what is grey was
/// idle. Every second frame is paler. Of a long stream its end is shown.
pub fn timeline_svg(title: &str, stats: &FrameStats) -> String {
    let workers = stats.workers.len();
    let row = if workers <= FULL_ROWS { ROW } else { (ROW * FULL_ROWS as f64 / workers as f64).max(3.0) };
    let (top, height) = (34.0, row * workers as f64);
    let (spans, from) = drawn(stats);
    let all = (stats.seconds - from).max(1e-12);
    let x = |seconds: f64| MARGIN + (seconds - from) / all * WIDTH;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0} {:.0}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{MARGIN}\" y=\"20\" \
         font-size=\"14\">{}</text>\n",
        MARGIN + WIDTH + 32.0,
        top + height + 36.0,
        escape(title)
    );
    for worker in 0..workers {
        let y = top + row * worker as f64;
        let _ = writeln!(
            svg,
            "<rect x=\"{MARGIN}\" y=\"{y:.1}\" width=\"{WIDTH}\" height=\"{:.1}\" fill=\"#ddd\"/>",
            row * 0.85
        );
        if row >= 11.0 {
            let _ = writeln!(svg, "<text x=\"4\" y=\"{:.1}\">worker {worker}</text>", y + row * 0.65);
        }
    }
    let mut bars = vec![0; workers];
    for span in spans {
        bars[span.worker] += 1;
        let y = top + row * span.worker as f64;
        // Two shades in turn, so that neighbours can be told apart.
        let shade = if bars[span.worker] % 2 == 0 { 1.0 } else { 0.86 };
        let pale = if span.frame % 2 == 0 { 0.0 } else { 0.45 };
        let [r, g, b] = worker_color(span.worker).map(|c| (c * (1.0 - pale) + pale) * shade);
        let _ = writeln!(
            svg,
            "<rect x=\"{:.2}\" y=\"{y:.1}\" width=\"{:.2}\" height=\"{:.1}\" fill=\"rgb({:.0},{:.0},{:.0})\">\
             <title>frame {}, tile {},{} {}x{}: {:.1} us</title></rect>",
            x(span.start),
            (span.end - span.start) / all * WIDTH,
            row * 0.85,
            r * 255.0,
            g * 255.0,
            b * 255.0,
            span.frame,
            span.tile.x,
            span.tile.y,
            span.tile.width,
            span.tile.height,
            (span.end - span.start) * 1e6
        );
    }
    for tick in 0..=10 {
        let seconds = from + all * f64::from(tick) / 10.0;
        let (x, y) = (x(seconds), top + height);
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {top}V{:.1}\" stroke=\"black\" stroke-opacity=\"0.25\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{:.2} ms</text>",
            y + 4.0,
            y + 18.0,
            seconds * 1e3
        );
    }
    svg + "</svg>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// One event of the trace event format that Chrome, Perfetto and Speedscope read; times in microseconds.
#[derive(Debug, Serialize)]
struct TraceEvent {
    name: String,
    /// "idle", or the number of the frame: viewers colour and filter by it.
    cat: String,
    ph: &'static str,
    ts: f64,
    dur: f64,
    pid: usize,
    tid: usize,
}

/// The timeline of a stream in the trace event format: an array of complete events, a thread per worker.
/// Of a long stream it has the end.
pub fn timeline_trace(stats: &FrameStats) -> impl Serialize {
    let event = |name, cat: String, start: f64, end: f64, tid| TraceEvent {
        name,
        cat,
        ph: "X",
        ts: start * 1e6,
        dur: (end - start) * 1e6,
        pid: 1,
        tid,
    };
    let tile = |span: &Span| {
        let name = format!("{},{} {}x{}", span.tile.x, span.tile.y, span.tile.width, span.tile.height);
        event(name, format!("frame {}", span.frame), span.start, span.end, span.worker)
    };
    let mut events: Vec<TraceEvent> = drawn(stats).0.map(tile).collect();
    for (number, worker) in stats.workers.iter().enumerate().filter(|(_, worker)| worker.tiles > 0) {
        events.push(event("start".into(), "idle".into(), 0.0, worker.idle.start, number));
        events.push(event(
            "tail".into(),
            "idle".into(),
            stats.seconds - worker.idle.tail,
            stats.seconds,
            number,
        ));
    }
    events
}

/// Which worker rendered what of the last frame: a flat colour per worker, the borders of its tiles darker.
///
/// # Panics
/// If a tile reaches beyond `size`.
pub fn worker_map(stats: &FrameStats, [width, height]: [u32; 2]) -> Film {
    let film = Film::new(width, height);
    for span in stats.spans.iter().filter(|span| span.frame + 1 == stats.frames) {
        let tile = span.tile;
        let color = worker_color(span.worker);
        let plane = |channel: usize| -> Vec<f32> {
            (0..tile.len() as u32)
                .map(|i| {
                    let border = i % tile.width == 0 || i < tile.width;
                    (color[channel] * if border { 0.55 } else { 1.0 }).powf(2.2) as f32
                })
                .collect()
        };
        film.write_tile(tile, &plane(0), &plane(1), &plane(2));
    }
    film
}

/// Well separated hues, by the golden ratio; red, green and blue in 0..1 as they are shown.
fn worker_color(worker: usize) -> [f64; 3] {
    let hue = (worker as f64 * 0.618_033_988_75 + 0.58).fract() * 6.0;
    // Lightness varies as well: hues of many workers come close.
    let value = [0.92, 0.78, 0.64][worker / 8 % 3];
    [0.0, 4.0, 2.0].map(|shift: f64| {
        let distance = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        value * (0.35 + 0.65 * distance.clamp(0.0, 1.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{CostMap, FilmMode, Plan, Schedule, SharedCore, Strategy};
    use crate::study::scaling::{Costs, Flow, Replay, simulate};
    use crate::tile::{Order, tiles};

    fn stats(workers: usize) -> FrameStats {
        let costs = Costs {
            prepare: 1e-6,
            send: 1e-6,
            reply: 1e-6,
            to_master: 1e-5,
            late: 0.0,
            delay: 0.0,
            to_worker: 1e-5,
            collect: 1e-6,
            collect_tile: 1e-7,
            tile: 1e-7,
            steal: 1e-6,
            shared: SharedCore::punctual(1e-6, 1e-6, 1e-6, 1e-6),
            copying: SharedCore::punctual(1e-6, 1e-6, 1e-6, 1e-6),
            per_byte: 1e-9,
            copied: None,
            cores: 2,
        };
        let schedule = Schedule { strategy: Strategy::Stealing, film: FilmMode::Shared };
        let replay = |end| {
            let tiles = tiles(64, 48, 16, Order::Hilbert);
            let plan = Plan::new(schedule.strategy, workers, end, &tiles, &CostMap::default());
            let seconds = vec![1e-3; plan.tiles.len()];
            Replay { plan, seconds }
        };
        simulate(schedule, &vec![1.0; workers], Flow::ONE, replay, &costs)
    }

    #[test]
    fn the_picture_has_a_bar_for_every_tile_and_escapes_its_title() {
        for workers in [1, 3, 64] {
            let svg = timeline_svg("a < b & c", &stats(workers));
            assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
            assert!(svg.contains("a &lt; b &amp; c"));
            assert_eq!(svg.matches("<title>").count(), 12);
            assert_eq!(svg.matches("#ddd").count(), workers);
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
        }
    }

    #[test]
    fn of_a_long_stream_the_last_frames_are_drawn() {
        let span =
            |frame: usize| Span { frame, start: frame as f64, end: frame as f64 + 1.0, ..stats(1).spans[0] };
        let long = FrameStats { frames: 9, seconds: 9.0, spans: (0..9).map(span).collect(), ..stats(1) };
        let (spans, from) = drawn(&long);
        assert_eq!((spans.count(), from), (4, 5.0));
        assert!(timeline_svg("", &long).contains("<title>frame 8"));
        assert_eq!(drawn(&stats(1)).1, 0.0);
    }

    #[test]
    fn the_trace_has_a_complete_event_for_every_tile() {
        let json = serde_json::to_value(timeline_trace(&stats(2))).unwrap();
        let events = json.as_array().unwrap();
        let tiles: Vec<_> = events.iter().filter(|event| event["cat"] == "frame 0").collect();
        assert_eq!(tiles.len(), 12);
        for event in events {
            assert!(
                event["ph"] == "X" && event["ts"].as_f64() >= Some(0.0) && event["dur"].as_f64() >= Some(0.0)
            );
        }
        assert!(tiles.iter().all(|event| event["dur"].as_f64().is_some_and(|us| (us - 1000.0).abs() < 0.01)));
    }

    #[test]
    fn the_map_shows_each_worker_where_it_was() {
        let stats = stats(3);
        let film = worker_map(&stats, [64, 48]);
        let inside = |span: &Span| film.row(span.tile.y + 8).nth(span.tile.x as usize + 8).unwrap();
        for a in &stats.spans {
            for b in &stats.spans {
                assert_eq!(inside(a) == inside(b), a.worker == b.worker);
            }
        }
        assert!(film.pixels().all(|pixel| pixel != [0.0; 3]), "every pixel is somebody's");
    }
}
