//! Antialiasing where it shows (chapter 3.7 of the thesis): a frame is two passes over its tiles.
//!
//! ```text
//!   first pass    one sample through the centre of every pixel --> film
//!   second pass   film --> pixels that differ from one of their eight neighbours --> all their samples --> another film
//!                      --> the others --------------------------------------------> as they are
//! ```
//!
//! The thesis renders the borders of tiles as tasks of their own, so that neighbouring tiles do not trace them twice. Here
//! the second pass finds every neighbour, also those in other tiles, in the film of the first one, so that no pixel is looked
//! at twice and the image does not depend on tiles. A pixel that is refined has the samples that it would have in an image of that
//! many samples everywhere.

use super::task::{RenderTask, Scratch, packet_corners};
use crate::{
    camera::{Camera, pixel_of},
    film::Film,
    kernels::TILE_RAYS,
    shade::Meter,
    tile::Tile,
};

/// Finds pixels that differ from others; buffers of one worker.
#[derive(Clone, Debug, Default)]
pub(super) struct Differences {
    planes: [Vec<f32>; 3],
    /// By pixel of the tile with a border of one pixel.
    differs: Vec<bool>,
    /// In the order of packets.
    pixels: Vec<[u32; 2]>,
}

impl Differences {
    /// Finds the pixels of `tile` that differ from a neighbour by more than `least`.
    fn find(&mut self, film: &Film, tile: Tile, least: f32) {
        let [left, top] = [tile.x.saturating_sub(1), tile.y.saturating_sub(1)];
        let right = (tile.x + tile.width + 1).min(film.width());
        let bottom = (tile.y + tile.height + 1).min(film.height());
        let area = Tile { x: left, y: top, width: right - left, height: bottom - top };
        film.read_tile(area, &mut self.planes);
        self.planes.iter_mut().flatten().for_each(|value| *value = value.clamp(0.0, 1.0).sqrt());
        self.compare(area, least);
        let (planes, width) = (&self.differs, area.width as usize);
        let differs = |[x, y]: [u32; 2]| planes[(y - top) as usize * width + (x - left) as usize];
        self.pixels.clear();
        for [x, y] in packet_corners(tile) {
            let pixels = (0..TILE_RAYS).map(pixel_of).map(|(dx, dy)| [x + dx, y + dy]);
            let inside = pixels.filter(|&[x, y]| x < tile.width && y < tile.height);
            self.pixels.extend(inside.map(|[x, y]| [tile.x + x, tile.y + y]).filter(|&at| differs(at)));
        }
    }

    /// Compares every pixel of the area with those to the right, below, and below to either side.
    fn compare(&mut self, area: Tile, least: f32) {
        let width = area.width as usize;
        let Differences { planes, differs, .. } = self;
        differs.clear();
        differs.resize(area.len(), false);
        for at in 0..area.len() {
            let (column, below) = (at % width, at + width < area.len());
            let neighbours = [
                (column + 1 < width, 1),
                (below, width),
                (below && column + 1 < width, width + 1),
                (below && column > 0, width - 1),
            ];
            for (_, step) in neighbours.into_iter().filter(|(there, _)| *there) {
                if planes.iter().any(|plane| (plane[at] - plane[at + step]).abs() > least) {
                    differs[at] = true;
                    differs[at + step] = true;
                }
            }
        }
    }
}

impl RenderTask<'_> {
    /// The second pass: leaves the colours of the tile's pixels in `scratch.pixels`, row by row.
    pub(super) fn refine(
        &self,
        camera: &Camera,
        tile: Tile,
        first: &Film,
        least: f32,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        first.read_tile(tile, &mut scratch.pixels);
        let Some(follow) = &self.follow else { return };
        let mut differences = std::mem::take(&mut scratch.differences);
        differences.find(first, tile, least);
        if !differences.pixels.is_empty() {
            follow.refine(self, camera, &differences.pixels, scratch, meter);
            let colors = scratch.path.finish(follow.samples());
            for (plane, colors) in scratch.pixels.iter_mut().zip(colors) {
                for (&[x, y], &color) in differences.pixels.iter().zip(colors) {
                    plane[((y - tile.y) * tile.width + x - tile.x) as usize] = color;
                }
            }
        }
        scratch.differences = differences;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tile::{Order, tiles};

    /// Straight from the definition.
    fn differing(film: &Film, least: f32) -> Vec<[u32; 2]> {
        let at = |[x, y]: [u32; 2]| film.row(y).nth(x as usize).unwrap().map(|v| v.clamp(0.0, 1.0).sqrt());
        let range = |at: u32, end: u32| at.saturating_sub(1)..(at + 2).min(end);
        let all = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| [x, y]));
        let far = |a: [f32; 3], b: [f32; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > least);
        all.filter(|&[x, y]| {
            range(y, film.height()).any(|ny| range(x, film.width()).any(|nx| far(at([x, y]), at([nx, ny]))))
        })
        .collect()
    }

    #[test]
    fn pixels_that_differ_are_found_whatever_the_tiles() {
        let film = Film::new(50, 37);
        let whole = Tile { x: 0, y: 0, width: 50, height: 37 };
        let mut bits = 1u32;
        let mut plane = |rare: u32| -> Vec<f32> {
            let value = |_| {
                bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if bits >> 8 & 0xff < rare { (bits >> 16) as f32 / 30_000.0 - 0.5 } else { 0.25 }
            };
            (0..whole.len()).map(value).collect()
        };
        film.write_tile(whole, &plane(3), &plane(2), &plane(1));
        let mut expected = differing(&film, 0.1);
        assert!(expected.len() > 50 && expected.len() < 1000, "{}", expected.len());
        expected.sort_unstable();
        for side in [1, 5, 16, 33, 64] {
            let mut differences = Differences::default();
            let mut found: Vec<[u32; 2]> = vec![];
            for tile in tiles(50, 37, side, Order::Hilbert) {
                differences.find(&film, tile, 0.1);
                found.extend(&differences.pixels);
            }
            found.sort_unstable();
            assert_eq!(found, expected, "tiles of {side}");
        }
    }
}
