//! Antialiasing where it shows (chapter 3.7 of the thesis): a frame is several passes over its tiles.
//!
//! ```text
//!   corners       one sample through the corners of pixels ------> film ---+
//!   centres       one sample through the centre of every pixel --> film ---+-> pixels that differ --> their samples
//!   further ones      film of the pass before ------------------------------+-> the others ----------> as they are
//! ```
//!
//! A pixel differs if its centre differs from one of its four corners or from the centres around it: detail half a
//! pixel wide is seen. Something thinner is hit by some of these and missed by others along it; refined pixels differ from
//! those, which are refined in the next pass.
//!
//! The thesis renders the borders of tiles as tasks of their own, so that neighbouring tiles do not trace them twice. Here
//! a pass finds every neighbour, also those in other tiles, in the film of the pass before, so that no pixel is looked
//! at twice and the image does not depend on tiles. A pixel that is refined has three eighths of its samples, and all of them
//! if those scatter (`scatter.rs`).

use super::task::{RenderTask, Scratch, packet_corners};
use crate::{
    camera::{Camera, pixel_of},
    film::Film,
    kernels::TILE_RAYS,
    shade::Meter,
    tile::Tile,
};
use std::sync::atomic::{AtomicU32, Ordering};

/// Which pixels of an image are refined, row by row. Atomic as a film's pixels are.
type Marks = Vec<AtomicU32>;

/// Bits of a mark below those of the pass: 0, or the samples of a pixel.
const PASS_BITS: u32 = 30;

/// Of a pixel that a pass, from 1 on, has refined to so many samples.
fn mark(pass: u32, samples: u32) -> u32 {
    pass << PASS_BITS | samples
}

/// The samples of a pixel by its mark, beside those that tell whether it differs.
pub(super) fn samples_of(mark: &AtomicU32) -> u32 {
    (mark.load(Ordering::Relaxed) & ((1 << PASS_BITS) - 1)).max(1)
}

/// What is known of an image beside its pixels.
#[derive(Debug)]
pub(super) struct Known {
    /// Pixel (x, y) is the lower right corner of the image's pixel (x, y).
    corners: Film,
    /// Colours that differ by no more are taken for the same.
    least: f32,
    refined: Marks,
    /// Passes that have refined.
    passes: u32,
}

impl Known {
    /// Before any pixel is refined.
    pub(super) fn new(corners: Film, least: f32) -> Known {
        let count = corners.width() as usize * corners.height() as usize;
        let refined = (0..count).map(|_| AtomicU32::new(0)).collect();
        Known { corners, least, refined, passes: 0 }
    }

    /// The film of the corners, which nobody needs any more.
    pub(super) fn end(self) -> Film {
        self.corners
    }

    /// The marks of pixels: see [`samples_of`].
    pub(super) fn marks(&self) -> &[AtomicU32] {
        &self.refined
    }

    fn index(&self, [x, y]: [u32; 2]) -> usize {
        y as usize * self.corners.width() as usize + x as usize
    }
}

/// A pass that refines.
#[derive(Debug)]
pub(super) struct Refining {
    /// The image as the pass before left it.
    before: Film,
    known: Known,
    /// Known afterwards: who is beside a pixel must not see that it has just been refined.
    refined: Marks,
}

impl Refining {
    /// Of pixels that differ in the film `before`.
    pub(super) fn new(before: Film, known: Known) -> Refining {
        let copy = |pixel: &AtomicU32| AtomicU32::new(pixel.load(Ordering::Relaxed));
        let refined = known.refined.iter().map(copy).collect();
        Refining { before, known, refined }
    }

    /// The film of the pass before.
    pub(super) fn before(&self) -> &Film {
        &self.before
    }

    /// The marks of pixels by now: see [`samples_of`].
    pub(super) fn marks(&self) -> &[AtomicU32] {
        &self.refined
    }

    /// The film of the pass before, and what is known now.
    pub(super) fn end(self) -> (Film, Known) {
        (self.before, Known { refined: self.refined, passes: self.known.passes + 1, ..self.known })
    }
}

/// Finds pixels that differ from others; buffers of one worker.
#[derive(Clone, Debug, Default)]
pub(super) struct Differences {
    centres: [Vec<f32>; 3],
    corners: [Vec<f32>; 3],
    /// By pixel of the tile with a border of one pixel.
    differs: Vec<bool>,
    marks: Vec<u32>,
    /// Of a line.
    far: Vec<bool>,
    /// In the order of packets.
    pixels: Vec<[u32; 2]>,
}

impl Differences {
    /// Finds the pixels of `tile` that differ by more than `least`, and reads all into `pixels`.
    fn find(&mut self, [centres, corners]: [&Film; 2], tile: Tile, least: f32, pixels: &mut [Vec<f32>; 3]) {
        let area = with_border(tile, centres);
        self.read(centres, tile, area, pixels);
        corners.read_tile(area, &mut self.corners);
        self.corners.iter_mut().flatten().for_each(|value| *value = seen(*value));
        self.compare(area, least);
        self.list(tile, area);
    }

    /// Finds those that differ from a pixel beside them which the last of the passes has refined, and are not refined: what
    /// else differs has been refined before.
    fn find_beside(&mut self, before: &Film, known: &Known, tile: Tile, pixels: &mut [Vec<f32>; 3]) {
        let area = with_border(tile, before);
        let (width, height) = (area.width as usize, area.height as usize);
        self.marks.clear();
        for y in area.y..area.y + area.height {
            let line = &known.refined[known.index([area.x, y])..][..width];
            self.marks.extend(line.iter().map(|mark| mark.load(Ordering::Relaxed)));
        }
        self.differs.clear();
        self.differs.resize(area.len(), false);
        self.pixels.clear();
        if !self.marks.iter().any(|mark| mark >> PASS_BITS == known.passes) {
            return before.read_tile(tile, pixels);
        }
        self.read(before, tile, area, pixels);
        let Differences { centres, differs, marks, .. } = self;
        for at in (0..area.len()).filter(|&at| marks[at] >> PASS_BITS == known.passes) {
            let (x, y) = (at % width, at / width);
            for y in y.saturating_sub(1)..(y + 2).min(height) {
                for beside in y * width + x.saturating_sub(1)..y * width + (x + 2).min(width) {
                    let far = || centres.iter().any(|plane| (plane[at] - plane[beside]).abs() > known.least);
                    differs[beside] |= marks[beside] == 0 && far();
                }
            }
        }
        self.list(tile, area);
    }

    /// Reads an area of the film of centres, and leaves the colours of the tile within it in `pixels`.
    fn read(&mut self, centres: &Film, tile: Tile, area: Tile, pixels: &mut [Vec<f32>; 3]) {
        centres.read_tile(area, &mut self.centres);
        let [left, top, width] = [tile.x - area.x, tile.y - area.y, tile.width].map(|v| v as usize);
        for (plane, pixels) in self.centres.iter_mut().zip(pixels) {
            pixels.clear();
            for row in plane.chunks(area.width as usize).skip(top).take(tile.height as usize) {
                pixels.extend_from_slice(&row[left..left + width]);
            }
            plane.iter_mut().for_each(|value| *value = seen(*value));
        }
    }

    /// Lists the pixels of `tile` that differ.
    fn list(&mut self, tile: Tile, area: Tile) {
        let (marks, width) = (&self.differs, area.width as usize);
        let differs = |[x, y]: [u32; 2]| marks[(y - area.y) as usize * width + (x - area.x) as usize];
        self.pixels.clear();
        for [x, y] in packet_corners(tile) {
            let pixels = (0..TILE_RAYS).map(pixel_of).map(|(dx, dy)| [x + dx, y + dy]);
            let inside = pixels.filter(|&[x, y]| x < tile.width && y < tile.height);
            self.pixels.extend(inside.map(|[x, y]| [tile.x + x, tile.y + y]).filter(|&at| differs(at)));
        }
    }

    /// Compares every pixel of the area with its corners, and with those to the right, below, and below to either side.
    fn compare(&mut self, area: Tile, least: f32) {
        let (width, height) = (area.width as usize, area.height as usize);
        let Differences { centres, corners, differs, far, .. } = self;
        differs.clear();
        differs.resize(area.len(), false);
        // Pixels against those `right - left` columns to the right and `down` rows below; corners the other way.
        let mut pairs = |[left, right]: [usize; 2], down: usize, others: &[Vec<f32>; 3], both: bool| {
            for row in down..height {
                let ends = |row: usize, shift: usize| {
                    row * width + shift..row * width + width - (left + right) + shift
                };
                let (one, other) = (ends(row - down, left), ends(row, right));
                let (one, other) = if both { (one, other) } else { (other, one) };
                compare_lines(
                    [0, 1, 2].map(|k| (&centres[k][one.clone()], &others[k][other.clone()])),
                    least,
                    far,
                );
                differs[one].iter_mut().zip(&*far).for_each(|(differs, far)| *differs |= far);
                if both {
                    differs[other].iter_mut().zip(&*far).for_each(|(differs, far)| *differs |= far);
                }
            }
        };
        for (columns, down) in [([0, 1], 0), ([0, 0], 1), ([0, 1], 1), ([1, 0], 1)] {
            pairs(columns, down, centres, true);
        }
        for (columns, down) in [([0, 0], 0), ([0, 1], 0), ([0, 0], 1), ([0, 1], 1)] {
            pairs(columns, down, corners, false);
        }
    }
}

/// A tile and the pixels around it.
fn with_border(tile: Tile, film: &Film) -> Tile {
    let [x, y] = [tile.x.saturating_sub(1), tile.y.saturating_sub(1)];
    let right = (tile.x + tile.width + 1).min(film.width());
    let bottom = (tile.y + tile.height + 1).min(film.height());
    Tile { x, y, width: right - x, height: bottom - y }
}

/// About how bright a linear value looks.
fn seen(value: f32) -> f32 {
    value.clamp(0.0, 1.0).sqrt()
}

/// Whether colours differ by more than `least`: red, green and blue of both.
fn compare_lines(lines: [(&[f32], &[f32]); 3], least: f32, far: &mut Vec<bool>) {
    far.clear();
    far.resize(lines[0].0.len(), false);
    for (one, other) in lines {
        for ((far, one), other) in far.iter_mut().zip(one).zip(other) {
            *far |= (one - other).abs() > least;
        }
    }
}

impl RenderTask<'_> {
    /// A pass after the first two: leaves the colours of the tile's pixels in `scratch.pixels`, row by row.
    pub(super) fn refine(
        &self,
        camera: &Camera,
        tile: Tile,
        refining: &Refining,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        let Refining { before, known, refined } = refining;
        let Some(follow) = &self.follow else { return before.read_tile(tile, &mut scratch.pixels) };
        let mut differences = std::mem::take(&mut scratch.differences);
        if known.passes == 0 {
            differences.find([before, &known.corners], tile, known.least, &mut scratch.pixels);
        } else {
            differences.find_beside(before, known, tile, &mut scratch.pixels);
        }
        if !differences.pixels.is_empty() {
            follow.refine(self, camera, &differences.pixels, known.least, scratch, meter);
            for (&[x, y], (samples, color)) in differences.pixels.iter().zip(scratch.sums.means()) {
                refined[known.index([x, y])].store(mark(known.passes + 1, samples), Ordering::Relaxed);
                let at = ((y - tile.y) * tile.width + x - tile.x) as usize;
                scratch.pixels.iter_mut().zip(color).for_each(|(plane, color)| plane[at] = color);
            }
        }
        scratch.differences = differences;
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::tile::{Order, tiles};

    /// Straight from the definition: centres, and corners.
    pub(in crate::render) fn differing([centres, corners]: [&Film; 2], least: f32) -> Vec<[u32; 2]> {
        let (width, height) = (centres.width() as i32, centres.height() as i32);
        let of = |film: &Film, [x, y]: [i32; 2]| {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            let seen = |pixel: [f32; 3]| pixel.map(|v| v.clamp(0.0, 1.0).sqrt());
            inside.then(|| seen(film.row(y as u32).nth(x as usize).unwrap()))
        };
        let all = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let differs = |&[x, y]: &[i32; 2]| {
            let own = of(centres, [x, y]).unwrap();
            let far = |other: Option<[f32; 3]>| {
                other.is_some_and(|other| (0..3).any(|k| (own[k] - other[k]).abs() > least))
            };
            (-1..=1).any(|dy| (-1..=1).any(|dx| far(of(centres, [x + dx, y + dy]))))
                || (-1..=0).any(|dy| (-1..=0).any(|dx| far(of(corners, [x + dx, y + dy]))))
        };
        all.filter(differs).map(|at| at.map(|v| v as u32)).collect()
    }

    #[test]
    fn pixels_that_differ_are_found_whatever_the_tiles() {
        let whole = Tile { x: 0, y: 0, width: 50, height: 37 };
        let mut bits = 1u32;
        let mut film = || {
            let film = Film::new(50, 37);
            let mut plane = |rare: u32| -> Vec<f32> {
                let value = |_| {
                    bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    if bits >> 8 & 0xff < rare { (bits >> 16) as f32 / 30_000.0 - 0.5 } else { 0.25 }
                };
                (0..whole.len()).map(value).collect()
            };
            film.write_tile(whole, &plane(2), &plane(2), &plane(1));
            film
        };
        let (flat, [centres, corners]) = (Film::new(50, 37), [film(), film()]);
        flat.write_tile(whole, &vec![0.25; 1850], &vec![0.25; 1850], &vec![0.25; 1850]);
        for films in [[&centres, &corners], [&flat, &corners], [&centres, &flat]] {
            let mut expected = differing(films, 0.1);
            assert!(expected.len() > 50 && expected.len() < 1000, "{}", expected.len());
            expected.sort_unstable();
            for side in [1, 5, 16, 33, 64] {
                let (mut differences, mut pixels) = (Differences::default(), <[Vec<f32>; 3]>::default());
                let mut found: Vec<[u32; 2]> = vec![];
                for tile in tiles(50, 37, side, Order::Hilbert) {
                    differences.find(films, tile, 0.1, &mut pixels);
                    found.extend(&differences.pixels);
                }
                found.sort_unstable();
                assert_eq!(found, expected, "tiles of {side}");
            }
        }
    }
}
