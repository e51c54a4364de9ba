//! The image while it is being made: linear f32 RGB that all workers write at once.

mod hash;

pub use hash::Hash;

use crate::tile::Tile;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// A `width` x `height` image of linear f32 RGB, black at first.
///
/// Workers write disjoint tiles through a shared reference. The pixels are atomics only to make that safe: a relaxed
/// store is an ordinary store on every machine. Whoever reads the film must have waited for the writers, as the
/// scheduler does; then each pixel is what its one writer stored.
///
/// Colours are kept as separate planes, the form in which tiles arrive, so that a row of a tile is copied straight.
#[derive(Debug)]
pub struct Film {
    width: u32,
    height: u32,
    /// Bits of the red, green and blue values, row by row.
    planes: [Vec<AtomicU32>; 3],
    nan_count: AtomicU64,
    /// Index of the first such pixel; `u64::MAX` if there is none.
    nan_first: AtomicU64,
}

/// Pixels whose colour was not a finite number: NaN or infinite. They are black in the film, and somebody has a defect to
/// mend or lights beyond the range of f32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NanPixels {
    /// How many there are.
    pub count: u64,
    /// Column of the first one, in reading order.
    pub x: u32,
    /// Row of the first one, in reading order.
    pub y: u32,
}

impl Film {
    /// A black film.
    pub fn new(width: u32, height: u32) -> Film {
        let len = width as usize * height as usize;
        let plane = || (0..len).map(|_| AtomicU32::new(0)).collect();
        Film {
            width,
            height,
            planes: [plane(), plane(), plane()],
            nan_count: AtomicU64::new(0),
            nan_first: AtomicU64::new(u64::MAX),
        }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Stores the colours of `tile`: element `y * tile.width + x` of each slice belongs to the pixel in column `x` and
    /// row `y` of the tile. A pixel that is NaN or infinite in any channel becomes black and is counted (see
    /// [`Film::nan`]).
    ///
    /// # Panics
    ///
    /// If the tile reaches beyond the film or a slice is shorter than the tile.
    pub fn write_tile(&self, tile: Tile, r: &[f32], g: &[f32], b: &[f32]) {
        assert!(
            tile.x + tile.width <= self.width && tile.y + tile.height <= self.height,
            "tile outside the film"
        );
        let width = tile.width as usize;
        for row in 0..tile.height {
            let from = row as usize * width..(row as usize + 1) * width;
            let to = (tile.y + row) as usize * self.width as usize + tile.x as usize;
            let rows = [&r[from.clone()], &g[from.clone()], &b[from]];
            for (plane, values) in self.planes.iter().zip(rows) {
                store(&plane[to..to + width], values);
            }
            if !rows.iter().all(|values| all_finite(values)) {
                self.blacken(to, rows);
            }
        }
    }

    /// Reads the colours of `tile` into `planes`: red, green and blue, row by row.
    ///
    /// # Panics
    ///
    /// If the tile reaches beyond the film.
    pub fn read_tile(&self, tile: Tile, planes: &mut [Vec<f32>; 3]) {
        for (plane, cells) in planes.iter_mut().zip(&self.planes) {
            plane.clear();
            for row in 0..tile.height {
                let from = (tile.y + row) as usize * self.width as usize + tile.x as usize;
                let row = &cells[from..from + tile.width as usize];
                plane.extend(row.iter().map(|cell| f32::from_bits(cell.load(Ordering::Relaxed))));
            }
        }
    }

    /// Stores colours like [`Film::write_tile`], of pixels apart: the pixel in column `x` and row `y` of `tile` is the
    /// one at `first + spacing * (tile.x + x, tile.y + y)` of the film.
    ///
    /// # Panics
    ///
    /// If one of them lies beyond the film, or a slice is shorter than the tile.
    pub fn write_spaced(&self, tile: Tile, first: [u32; 2], spacing: u32, r: &[f32], g: &[f32], b: &[f32]) {
        for row in 0..tile.height {
            let line = (first[1] + spacing * (tile.y + row)) as usize * self.width as usize;
            for column in 0..tile.width {
                let x = first[0] + spacing * (tile.x + column);
                assert!(x < self.width, "tile outside the film");
                let (from, to) = ((row * tile.width + column) as usize, line + x as usize);
                let color = [r[from], g[from], b[from]];
                for (plane, value) in self.planes.iter().zip(color) {
                    plane[to].store(value.to_bits(), Ordering::Relaxed);
                }
                if !all_finite(&color) {
                    self.blacken(to, [&color[..1], &color[1..2], &color[2..]]);
                }
            }
        }
    }

    #[cold]
    fn blacken(&self, to: usize, rows: [&[f32]; 3]) {
        for i in (0..rows[0].len()).filter(|&i| rows.iter().any(|values| !values[i].is_finite())) {
            for plane in &self.planes {
                plane[to + i].store(0, Ordering::Relaxed);
            }
            self.nan_count.fetch_add(1, Ordering::Relaxed);
            self.nan_first.fetch_min((to + i) as u64, Ordering::Relaxed);
        }
    }

    /// Forgets which pixels were NaN, because all of them are written again.
    pub fn forget_nan(&mut self) {
        self.nan_count = AtomicU64::new(0);
        self.nan_first = AtomicU64::new(u64::MAX);
    }

    /// Takes over that pixels were NaN in a film that this one was made from: at least as many are told here from now on.
    pub fn inherit_nan(&self, other: &Film) {
        self.nan_count.fetch_max(other.nan_count.load(Ordering::Relaxed), Ordering::Relaxed);
        self.nan_first.fetch_min(other.nan_first.load(Ordering::Relaxed), Ordering::Relaxed);
    }

    /// The pixels that were NaN or infinite when they were written; `None` if all is well.
    pub fn nan(&self) -> Option<NanPixels> {
        let count = self.nan_count.load(Ordering::Relaxed);
        let first = self.nan_first.load(Ordering::Relaxed);
        let width = u64::from(self.width);
        (count > 0).then(|| NanPixels { count, x: (first % width) as u32, y: (first / width) as u32 })
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + '_ {
        let [r, g, b] = &self.planes;
        (0..r.len()).map(move |i| [&r[i], &g[i], &b[i]].map(|v| f32::from_bits(v.load(Ordering::Relaxed))))
    }

    /// The pixels of row `y`, from the left.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    pub fn row(&self, y: u32) -> impl ExactSizeIterator<Item = [f32; 3]> + '_ {
        assert!(y < self.height, "no row {y}");
        let start = y as usize * self.width as usize;
        let [r, g, b] = &self.planes;
        (start..start + self.width as usize)
            .map(move |i| [&r[i], &g[i], &b[i]].map(|v| f32::from_bits(v.load(Ordering::Relaxed))))
    }

    /// SHA-256 over the pixels as little-endian f32 red, green, blue, row by row, in lower-case hexadecimal: equal
    /// exactly if the images are equal bit by bit.
    pub fn sha256(&self) -> String {
        let mut hasher = Hash::default();
        let mut bytes = Vec::with_capacity(self.width as usize * 12);
        for y in 0..self.height {
            bytes.clear();
            bytes.extend(self.row(y).flatten().flat_map(f32::to_le_bytes));
            hasher.update(&bytes);
        }
        hasher.hex()
    }
}

fn store(cells: &[AtomicU32], values: &[f32]) {
    for (cell, value) in cells.iter().zip(values) {
        cell.store(value.to_bits(), Ordering::Relaxed);
    }
}

/// Without an early exit, so that it is a few vector instructions.
fn all_finite(values: &[f32]) -> bool {
    values.iter().fold(true, |finite, value| finite & value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tile::{Order, tiles};

    #[test]
    fn tiles_written_by_many_threads_give_the_whole_image() {
        let film = Film::new(50, 31);
        let tiles = tiles(50, 31, 8, Order::Hilbert);
        std::thread::scope(|scope| {
            for part in tiles.chunks(3) {
                let film = &film;
                scope.spawn(move || {
                    for &tile in part {
                        let pixels = (0..tile.len() as u32)
                            .map(|i| (tile.y + i / tile.width) * 50 + tile.x + i % tile.width);
                        let r: Vec<f32> = pixels.map(|i| i as f32).collect();
                        let g: Vec<f32> = r.iter().map(|v| v + 0.25).collect();
                        let b: Vec<f32> = r.iter().map(|v| -v).collect();
                        film.write_tile(tile, &r, &g, &b);
                    }
                });
            }
        });
        assert_eq!(film.pixels().len(), 50 * 31);
        for (i, pixel) in film.pixels().enumerate() {
            assert_eq!(pixel, [i as f32, i as f32 + 0.25, -(i as f32)]);
        }
        assert_eq!(film.row(3).nth(4), Some([154.0, 154.25, -154.0]));
        assert_eq!(film.nan(), None);
    }

    #[test]
    fn nan_and_infinity_become_black_and_are_counted_with_the_first_place() {
        let film = Film::new(4, 4);
        let tile = Tile { x: 1, y: 1, width: 2, height: 2 };
        let nan = f32::NAN;
        film.write_tile(tile, &[1.0, 1.0, 1.0, 1.0], &[1.0, nan, 1.0, 1.0], &[1.0, nan, nan, 3.0e38]);
        assert_eq!(film.nan(), Some(NanPixels { count: 2, x: 2, y: 1 }));
        let pixels: Vec<_> = film.pixels().collect();
        assert_eq!([pixels[5], pixels[6], pixels[9]], [[1.0; 3], [0.0; 3], [0.0; 3]]);
        assert_eq!(pixels[10], [1.0, 1.0, 3.0e38]);
        for (x, infinite) in [(3, f32::INFINITY), (0, -f32::INFINITY)] {
            let one = Tile { x, y: 0, width: 1, height: 1 };
            film.write_tile(one, &[infinite], &[1.0], &[1.0]);
            assert_eq!(film.row(0).nth(x as usize), Some([0.0; 3]));
        }
        assert_eq!(film.nan(), Some(NanPixels { count: 4, x: 0, y: 0 }));
    }

    #[test]
    fn nan_is_forgotten_with_its_image_and_told_of_the_next_one_made_from_it() {
        let (mut film, next) = (Film::new(4, 4), Film::new(4, 4));
        let at = |x, y| Tile { x, y, width: 1, height: 1 };
        film.write_tile(at(2, 1), &[f32::NAN], &[1.0], &[1.0]);
        next.inherit_nan(&film);
        assert_eq!(next.nan(), Some(NanPixels { count: 1, x: 2, y: 1 }));
        // The same pixel again, and one more before it.
        next.write_tile(at(2, 1), &[f32::NAN], &[1.0], &[1.0]);
        next.write_tile(at(3, 0), &[f32::NAN], &[1.0], &[1.0]);
        next.inherit_nan(&film);
        assert_eq!(next.nan(), Some(NanPixels { count: 3, x: 3, y: 0 }));
        film.forget_nan();
        assert_eq!(film.nan(), None);
        film.inherit_nan(&next);
        film.inherit_nan(&Film::new(4, 4));
        assert_eq!(film.nan(), next.nan());
    }

    #[test]
    fn the_hash_is_that_of_the_little_endian_pixels() {
        // sha256 of the 12 bytes 00 00 80 3f, 00 00 00 40, 00 00 00 00, by coreutils.
        let film = Film::new(1, 1);
        film.write_tile(Tile { x: 0, y: 0, width: 1, height: 1 }, &[1.0], &[2.0], &[0.0]);
        assert_eq!(film.sha256(), "a0cfd63f62a31b874a620cdf9932e487469806cacdaa5e7089f33aea12f5b255");
    }

    #[test]
    fn the_hash_tells_positive_from_negative_zero() {
        let film = Film::new(1, 1);
        let before = film.sha256();
        film.write_tile(Tile { x: 0, y: 0, width: 1, height: 1 }, &[-0.0], &[0.0], &[0.0]);
        assert_ne!(film.sha256(), before);
    }

    #[test]
    #[should_panic(expected = "outside the film")]
    fn a_tile_beyond_the_edge_is_refused() {
        Film::new(4, 4).write_tile(Tile { x: 3, y: 0, width: 2, height: 1 }, &[0.0; 2], &[0.0; 2], &[0.0; 2]);
    }
}
