//! Maps over the picture: who rendered what, how finely, how long it took, and what the rays do in the tree.

use super::picture::Picture;
use crate::{
    kernels::MISS,
    render::RayMap,
    tile::{Order, pixels},
};
use std::sync::atomic::{AtomicU32, Ordering};

/// What is laid over the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlay {
    /// Nothing.
    #[default]
    None,
    /// A colour for each worker, on the tiles that it traced in the first pass.
    Workers,
    /// Share of the pixels that are traced, by squares of 16 pixels; then which pixels have more than one sample.
    Samples,
    /// Time per pixel in the first pass, by tiles.
    Time,
    /// Nodes and leaves that the primary ray visits; at rest.
    Steps,
    /// Share of active lanes, if the sixteen rays of a block of 4x4 pixels walked the tree in step; at rest.
    Lanes,
    /// Blue where a pixel hits the same triangle as the one before it in the order of the image; at rest.
    Coherence,
}

/// Colours of workers.
const WORKERS: [u32; 8] =
    [0x00e6_6a2c, 0x002c_8ae6, 0x003c_b35a, 0x00c8_4ac0, 0x00e0_c02c, 0x0030_c0c0, 0x00a0_7050, 0x0080_80ff];

impl Overlay {
    /// All of them.
    pub const ALL: [Overlay; 7] = [
        Overlay::None,
        Overlay::Workers,
        Overlay::Samples,
        Overlay::Time,
        Overlay::Steps,
        Overlay::Lanes,
        Overlay::Coherence,
    ];

    /// The name in scripts and figures.
    pub fn name(self) -> &'static str {
        match self {
            Overlay::None => "none",
            Overlay::Workers => "workers",
            Overlay::Samples => "samples",
            Overlay::Time => "time",
            Overlay::Steps => "steps",
            Overlay::Lanes => "lanes",
            Overlay::Coherence => "coherence",
        }
    }

    /// True if it needs a [`RayMap`].
    pub fn needs_map(self) -> bool {
        matches!(self, Overlay::Steps | Overlay::Lanes | Overlay::Coherence)
    }
}

/// A colour for each pixel of the picture, to be mixed with it, and what the colours mean; `None` if there is nothing to
/// show.
pub(super) fn tint(picture: &Picture, order: Order, tile: u32) -> Option<(Vec<u32>, String)> {
    match (picture.overlay, &picture.map) {
        (Overlay::None, _) => None,
        (Overlay::Workers, _) => Some(workers(picture)),
        (Overlay::Samples, _) => Some(refined(picture).unwrap_or_else(|| samples(picture))),
        (Overlay::Time, _) => Some(time(picture)),
        (Overlay::Steps, Some(map)) => Some(steps(&map.steps)),
        (Overlay::Lanes, Some(map)) => Some(lanes(map, picture.size)),
        (Overlay::Coherence, Some(map)) => Some(coherence(map, picture.size, order, tile)),
        (Overlay::Steps | Overlay::Lanes | Overlay::Coherence, None) => None,
    }
}

/// Paints every span of the first pass.
fn spans(picture: &Picture, color: impl Fn(&crate::schedule::Span) -> u32) -> Vec<u32> {
    let [width, height] = picture.size;
    let mut colors = vec![0; width as usize * height as usize];
    for span in &picture.frame.spans {
        let (tile, color) = (span.tile, color(span));
        for y in tile.y..(tile.y + tile.height).min(height) {
            let left = y as usize * width as usize;
            let right = (tile.x + tile.width).min(width) as usize;
            colors[left + tile.x as usize..left + right].fill(color);
        }
    }
    colors
}

fn workers(picture: &Picture) -> (Vec<u32>, String) {
    let colors = spans(picture, |span| WORKERS[span.worker % WORKERS.len()]);
    (colors, format!("colour: worker, of {}", picture.frame.workers.len()))
}

fn time(picture: &Picture) -> (Vec<u32>, String) {
    let per_pixel = |span: &crate::schedule::Span| (span.end - span.start) / span.tile.len().max(1) as f64;
    // A tile in which a worker was interrupted, or met memory for the first time, shall not leave all others blue.
    let mut times: Vec<f64> = picture.frame.spans.iter().map(per_pixel).collect();
    times.sort_unstable_by(f64::total_cmp);
    let most = times.get(times.len() * 19 / 20).map_or(1e-12, |&most| most.max(1e-12));
    let colors = spans(picture, |span| heat(per_pixel(span) / most));
    (colors, format!("blue to red: time per pixel, up to {:.0} ns or more", most * 1e9))
}

fn samples(picture: &Picture) -> (Vec<u32>, String) {
    let [width, height] = picture.size;
    let columns = width.div_ceil(16) as usize;
    let color = |i: u32| {
        let cell = (i / width / 16) as usize * columns + (i % width / 16) as usize;
        let level = picture.frame.levels.get(cell).copied().unwrap_or_default();
        // By octaves: 1/16 is blue, all is red.
        heat(1.0 + level.share().max(1.0 / 16.0).log2() / 4.0)
    };
    ((0..width * height).map(color).collect(), "blue to red: 1/16, 1/4, 1/2, all of the pixels traced".into())
}

/// How many samples pixels have, once anti-aliasing has begun.
fn refined(picture: &Picture) -> Option<(Vec<u32>, String)> {
    let (pixels, refined) = (picture.refined.as_ref()?, picture.frame.refined?);
    let most = f64::from(refined.samples).ln().max(f64::MIN_POSITIVE);
    let colors = pixels.iter().map(|&samples| heat(f64::from(samples).ln() / most)).collect();
    let share = refined.share * 100.0;
    let text =
        format!("blue to red: 1 to {} samples per pixel, more than one at {share:.1} %", refined.samples);
    Some((colors, text))
}

fn steps(steps: &[AtomicU32]) -> (Vec<u32>, String) {
    let most = steps.iter().map(|steps| steps.load(Ordering::Relaxed)).max().unwrap_or(1).max(1);
    let color = |steps: &AtomicU32| heat(f64::from(steps.load(Ordering::Relaxed)) / f64::from(most));
    (steps.iter().map(color).collect(), format!("blue to red: nodes and leaves visited, up to {most}"))
}

fn lanes(map: &RayMap, [width, height]: [u32; 2]) -> (Vec<u32>, String) {
    let mut colors = vec![0; width as usize * height as usize];
    let (mut active, mut lanes) = (0.0, 0.0);
    for top in (0..height).step_by(4) {
        for left in (0..width).step_by(4) {
            let block = || {
                (top..(top + 4).min(height))
                    .flat_map(move |y| (left..(left + 4).min(width)).map(move |x| (y * width + x) as usize))
            };
            let steps = || block().map(|i| f64::from(map.steps[i].load(Ordering::Relaxed)));
            let (sum, most) = (steps().sum::<f64>(), steps().fold(0.0, f64::max) * 16.0);
            let share = if most > 0.0 { sum / most } else { 1.0 };
            (active, lanes) = (active + sum, lanes + most);
            block().for_each(|i| colors[i] = heat(1.0 - share));
        }
    }
    let mean = if lanes > 0.0 { active / lanes * 100.0 } else { 100.0 };
    (colors, format!("blue to red: all to none of 16 lanes active, {mean:.0} % in all"))
}

fn coherence(map: &RayMap, size: [u32; 2], order: Order, tile: u32) -> (Vec<u32>, String) {
    let mut colors = vec![0; map.prims.len()];
    let (mut last, mut same) = (MISS, 0usize);
    for (x, y) in pixels(size[0], size[1], order, Some(tile.max(1))) {
        let at = (y * size[0] + x) as usize;
        let prim = map.prims[at].load(Ordering::Relaxed);
        if prim == last && prim != MISS {
            (colors[at], same) = (0x0000_00ff, same + 1);
        }
        last = prim;
    }
    let share = same as f64 / colors.len().max(1) as f64 * 100.0;
    (colors, format!("blue: hits the triangle of the pixel before, in {order} order: {share:.1} %"))
}

/// From blue (0) over green to red (1).
fn heat(value: f64) -> u32 {
    let value = value.clamp(0.0, 1.0) * 4.0;
    let rise = |from: f64| ((value - from).clamp(0.0, 1.0) * 255.0) as u32;
    let (red, green, blue) = (rise(2.0), rise(0.0).min(255 - rise(3.0)), 255 - rise(1.0));
    red << 16 | green << 8 | blue
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_goes_from_blue_over_green_to_red() {
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(heat), [0xff, 0xffff, 0xff00, 0x00ff_ff00, 0x00ff_0000]);
        assert_eq!([heat(-1.0), heat(2.0), heat(f64::NAN)], [0xff, 0x00ff_0000, heat(f64::NAN)]);
    }

    fn map(steps: &[u32], prims: &[u32]) -> RayMap {
        let plane = |values: &[u32]| values.iter().map(|&value| AtomicU32::new(value)).collect();
        RayMap { steps: plane(steps), prims: plane(prims) }
    }

    #[test]
    fn lanes_that_wait_for_the_longest_ray_are_not_active() {
        // 4x4 pixels, of which one takes ten steps and the others five.
        let mut steps = [5; 16];
        steps[3] = 10;
        let (colors, text) = lanes(&map(&steps, &[0; 16]), [4, 4]);
        assert!(text.ends_with("53 % in all"), "{text}");
        assert!(colors.iter().all(|&color| color == heat(1.0 - 85.0 / 160.0)));
    }

    #[test]
    fn coherence_follows_the_order_and_misses_are_none() {
        let (colors, text) = coherence(&map(&[0; 4], &[7, 7, MISS, MISS]), [2, 2], Order::Scanline, 64);
        assert_eq!(colors, [0, 0xff, 0, 0]);
        assert!(text.ends_with("scanline order: 25.0 %"), "{text}");
    }
}
