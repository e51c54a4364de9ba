//! The pixels that are not traced yet, from those that are.
//!
//! Lattice by lattice, from coarse to fine: each missing pixel has four known neighbours at the same distance, two
//! and two opposite each other, either diagonal or axial. It becomes the mean of the pair that differs less, so that an
//! edge is continued along its own direction rather than blurred.
//!
//! A pixel depends on others up to [`REACH`] away. A tile computes those around it for itself, so that tiles need not
//! wait for each other, and the picture does not depend on how it is cut.

use super::{
    canvas::{CELL, Canvas},
    level::Level,
};
use crate::tile::Tile;
use std::sync::atomic::{AtomicU32, Ordering};

/// Greatest distance between a pixel and those it is computed from: 1 + 1 + 2 + 2, up to a whole lattice.
const REACH: u32 = 8;

/// A lattice of missing pixels.
#[derive(Clone, Copy)]
struct Step {
    first: [u32; 2],
    spacing: u32,
    /// Where the known neighbours are, else beside and above.
    diagonal: bool,
    /// How far they are away.
    distance: u32,
    /// The level that has these pixels traced.
    level: Level,
}

const fn step(x: u32, y: u32, spacing: u32, diagonal: bool, level: Level) -> Step {
    Step { first: [x, y], spacing, diagonal, distance: spacing / 2, level }
}

const STEPS: [Step; 6] = [
    step(2, 2, 4, true, Level::Quarter),
    step(2, 0, 4, false, Level::Quarter),
    step(0, 2, 4, false, Level::Quarter),
    step(1, 1, 2, true, Level::Half),
    step(1, 0, 2, false, Level::Full),
    step(0, 1, 2, false, Level::Full),
];

/// A tile and what surrounds it.
struct Patch<'a> {
    area: Tile,
    pixels: &'a mut [u32],
}

/// Puts `tile` of the canvas into `picture`, missing pixels filled. Every cell must have some level.
pub(super) fn fill(canvas: &Canvas, tile: Tile, patch: &mut Vec<u32>, picture: &[AtomicU32]) {
    let width = canvas.film.width() as usize;
    let row = |y: u32, x: u32, length: u32| {
        let left = y as usize * width + x as usize;
        left..left + length as usize
    };
    let area = around(tile, canvas);
    let least = canvas.least(area);
    if least == Level::Full {
        for y in tile.y..tile.y + tile.height {
            let range = row(y, tile.x, tile.width);
            for (to, from) in picture[range.clone()].iter().zip(&canvas.samples[range]) {
                to.store(from.load(Ordering::Relaxed), Ordering::Relaxed);
            }
        }
        return;
    }
    patch.clear();
    for y in area.y..area.y + area.height {
        let samples = &canvas.samples[row(y, area.x, area.width)];
        patch.extend(samples.iter().map(|sample| sample.load(Ordering::Relaxed)));
    }
    let mut around = Patch { area, pixels: patch };
    for step in STEPS.into_iter().filter(|step| step.level > least) {
        around.predict(canvas, step);
    }
    for y in tile.y..tile.y + tile.height {
        let from = ((y - area.y) * area.width + tile.x - area.x) as usize;
        for (to, from) in picture[row(y, tile.x, tile.width)].iter().zip(&patch[from..]) {
            to.store(*from, Ordering::Relaxed);
        }
    }
}

fn around(tile: Tile, canvas: &Canvas) -> Tile {
    let (x, y) = (tile.x.saturating_sub(REACH), tile.y.saturating_sub(REACH));
    // Whole lattices, wherever the tile begins.
    let (x, y) = (x - x % 4, y - y % 4);
    let right = (tile.x + tile.width + REACH).min(canvas.film.width());
    let bottom = (tile.y + tile.height + REACH).min(canvas.film.height());
    Tile { x, y, width: right - x, height: bottom - y }
}

impl Patch<'_> {
    /// Fills the pixels of one lattice where they are not traced.
    fn predict(&mut self, canvas: &Canvas, step: Step) {
        let Tile { x: left, y: top, width, height } = self.area;
        let Step { first: [x0, y0], spacing, distance, level, .. } = step;
        for y in (y0..height).step_by(spacing as usize) {
            let mut rows = Rows::new(self.pixels, [width, height], y, distance);
            let mut x = x0;
            while x < width {
                // To the end of the cell, in steps of the lattice.
                let cell = (top + y) / CELL * canvas.columns + (left + x) / CELL;
                let end = (((left + x) / CELL + 1) * CELL - left).min(width);
                let beyond = x + (end - x).next_multiple_of(spacing);
                if canvas.level(cell as usize) < level {
                    rows.predict(step, x as usize, end as usize);
                }
                x = beyond;
            }
        }
    }
}

/// The row that is filled, and those at a distance above and below it, as far as they exist.
struct Rows<'a> {
    above: Option<&'a [u32]>,
    here: &'a mut [u32],
    below: Option<&'a [u32]>,
}

impl<'a> Rows<'a> {
    fn new(pixels: &'a mut [u32], [width, height]: [u32; 2], y: u32, distance: u32) -> Rows<'a> {
        let row = |y: u32| (y * width) as usize..((y + 1) * width) as usize;
        let (before, rest) = pixels.split_at_mut(row(y).start);
        let (here, after) = rest.split_at_mut(width as usize);
        let above = y.checked_sub(distance).map(|y| &before[row(y)]);
        let below = (y + distance < height).then(|| &after[row(distance - 1)]);
        Rows { above, here, below }
    }

    /// Fills the lattice's pixels from column `from` to before `to`.
    fn predict(&mut self, step: Step, from: usize, to: usize) {
        let (width, distance, spacing) = (self.here.len(), step.distance as usize, step.spacing as usize);
        // Away from the edges everything exists.
        let safe = from >= distance && to + distance <= width;
        match (self.above, self.below) {
            (Some(above), Some(below)) if safe && step.diagonal => {
                for x in (from..to).step_by(spacing) {
                    let (l, r) = (x - distance, x + distance);
                    self.here[x] = better([above[l], below[r]], [above[r], below[l]]);
                }
            }
            (Some(above), Some(below)) if safe => {
                for x in (from..to).step_by(spacing) {
                    let beside = [self.here[x - distance], self.here[x + distance]];
                    self.here[x] = better(beside, [above[x], below[x]]);
                }
            }
            _ => (from..to).step_by(spacing).for_each(|x| self.at_edge(step.diagonal, x, distance)),
        }
    }

    fn at_edge(&mut self, diagonal: bool, x: usize, distance: usize) {
        let right = (x + distance < self.here.len()).then_some(x + distance);
        let left = x.checked_sub(distance);
        // What exists on one side only says nothing about a difference: a whole pair goes before it.
        let (beside, upright) = (left.zip(right), self.above.zip(self.below));
        let (column, row) = (left.or(right), self.above.or(self.below));
        self.here[x] = match (beside, upright) {
            (Some((l, r)), Some((above, below))) if diagonal => {
                better([above[l], below[r]], [above[r], below[l]])
            }
            (Some((l, r)), None) if diagonal => row.map_or(0, |row| mean(row[l], row[r])),
            (None, Some((above, below))) if diagonal => column.map_or(0, |x| mean(above[x], below[x])),
            (None, None) if diagonal => column.zip(row).map_or(0, |(x, row)| row[x]),
            (Some((l, r)), Some((above, below))) => {
                better([self.here[l], self.here[r]], [above[x], below[x]])
            }
            (Some((l, r)), None) => mean(self.here[l], self.here[r]),
            (None, Some((above, below))) => mean(above[x], below[x]),
            (None, None) => column.map_or_else(|| row.map_or(self.here[x], |row| row[x]), |x| self.here[x]),
        };
    }
}

/// The mean of the pair that differs less in green, the brightest of the channels.
#[inline(always)]
fn better([a, b]: [u32; 2], [c, d]: [u32; 2]) -> u32 {
    let green = |pixel: u32| pixel & 0xff00;
    let first = green(a).abs_diff(green(b)) <= green(c).abs_diff(green(d));
    let (a, b) = if first { (a, b) } else { (c, d) };
    mean(a, b)
}

/// Mean of each channel, rounded down.
#[inline(always)]
fn mean(a: u32, b: u32) -> u32 {
    (a & b) + ((a ^ b) >> 1 & 0x007f_7f7f)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A canvas of this size whose pixels are `color`, traced to `level`; what is not traced is white.
    fn canvas(size: [u32; 2], level: Level, color: impl Fn(u32, u32) -> u32) -> Canvas {
        let canvas = Canvas::new(size);
        let whole = Tile { x: 0, y: 0, width: size[0], height: size[1] };
        canvas.reach(whole, level);
        for (i, sample) in canvas.samples.iter().enumerate() {
            let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
            let traced = match level {
                Level::Nothing => false,
                Level::Sixteenth => x % 4 == 0 && y % 4 == 0,
                Level::Quarter => x % 2 == 0 && y % 2 == 0,
                Level::Half => (x + y) % 2 == 0,
                Level::Full => true,
            };
            sample.store(if traced { color(x, y) } else { 0x00ff_ffff }, Ordering::Relaxed);
        }
        canvas
    }

    fn filled(canvas: &Canvas, size: [u32; 2], cut: u32) -> Vec<u32> {
        let picture: Vec<AtomicU32> = (0..size[0] * size[1]).map(|_| AtomicU32::new(0)).collect();
        for tile in crate::tile::tiles(size[0], size[1], cut, crate::tile::Order::Scanline) {
            fill(canvas, tile, &mut Vec::new(), &picture);
        }
        picture.iter().map(|pixel| pixel.load(Ordering::Relaxed)).collect()
    }

    const LEVELS: [Level; 4] = [Level::Sixteenth, Level::Quarter, Level::Half, Level::Full];

    #[test]
    fn an_even_picture_stays_even_at_any_size() {
        for level in LEVELS {
            for size in [[1, 1], [2, 1], [1, 7], [3, 3], [5, 4], [40, 33], [17, 64]] {
                let canvas = canvas(size, level, |_, _| 0x0012_3456);
                let picture = filled(&canvas, size, 16);
                assert!(picture.iter().all(|&pixel| pixel == 0x0012_3456), "{level:?} {size:?} {picture:x?}");
            }
        }
    }

    #[test]
    fn a_ramp_is_continued_exactly_inside() {
        for level in LEVELS {
            for along in [|x: u32, _: u32| x << 8, |_: u32, y: u32| y << 8] {
                let canvas = canvas([81, 65], level, along);
                let picture = filled(&canvas, [81, 65], 32);
                for (i, &pixel) in picture.iter().enumerate() {
                    let (x, y) = (i as u32 % 81, i as u32 / 81);
                    if x > 76 || y > 60 {
                        continue;
                    }
                    assert_eq!(pixel, along(x, y), "{level:?} at ({x}, {y})");
                }
            }
        }
    }

    #[test]
    fn edges_are_continued_and_not_blurred() {
        // Black to the left of an upright edge, white to the right: nothing between.
        for level in LEVELS {
            let canvas = canvas([64, 64], level, |x, _| if x < 32 { 0 } else { 0x00ff_ffff });
            let picture = filled(&canvas, [64, 64], 64);
            // Away from the edges of the image, where only one pair is whole.
            let inner = &picture[4 * 64..60 * 64];
            let grey = inner.iter().filter(|&&pixel| pixel != 0 && pixel != 0x00ff_ffff).count();
            // Where both pairs straddle it, a mean is all there is.
            assert!(grey <= 64 * 3, "{level:?}: {grey}");
        }
    }

    #[test]
    fn the_cut_does_not_matter_even_between_cells_of_different_levels() {
        let size = [100, 70];
        let noise = |x: u32, y: u32| (x * 7919 + y * 104_729).wrapping_mul(2_654_435) & 0x00ff_ffff;
        let canvas = canvas(size, Level::Full, noise);
        let whole = Tile { x: 0, y: 0, width: 100, height: 70 };
        for (i, cell) in canvas.parts(whole).enumerate() {
            canvas.reach(cell, LEVELS[i * i % 4]);
        }
        let once = filled(&canvas, size, 128);
        for cut in [1, 7, 16, 33, 64] {
            assert_eq!(filled(&canvas, size, cut), once, "{cut}");
        }
    }
}
