//! What every part of the image took in the last frame.

use crate::tile::Tile;

/// Side of a cell in pixels.
const CELL: u32 = 16;

/// Seconds per cell of 16x16 pixels. A tile's time is spread evenly over its pixels, so that the times of one set of
/// tiles predict those of any other.
#[derive(Clone, Debug, Default)]
pub struct CostMap {
    width: u32,
    height: u32,
    seconds: Vec<f64>,
}

impl CostMap {
    /// A map of zeros that covers all of `tiles`.
    pub fn covering(tiles: &[Tile]) -> CostMap {
        let mut map = CostMap::default();
        map.reset(tiles);
        map
    }

    /// Becomes a map of zeros that covers all of `tiles`; keeps its memory.
    pub(super) fn reset(&mut self, tiles: &[Tile]) {
        self.width = tiles.iter().map(|tile| tile.x + tile.width).max().unwrap_or(0);
        self.height = tiles.iter().map(|tile| tile.y + tile.height).max().unwrap_or(0);
        let cells = self.width.div_ceil(CELL) as usize * self.height.div_ceil(CELL) as usize;
        self.seconds.clear();
        self.seconds.resize(cells, 0.0);
    }

    /// Adds the time of a tile inside the covered area.
    pub fn record(&mut self, tile: Tile, seconds: f64) {
        let per_pixel = seconds / tile.len().max(1) as f64;
        let columns = self.width.div_ceil(CELL);
        for_cells(tile, |column, row, pixels| {
            self.seconds[(row * columns + column) as usize] += per_pixel * f64::from(pixels);
        });
    }

    /// True if every tile can be predicted.
    pub(super) fn covers(&self, tiles: &[Tile]) -> bool {
        tiles.iter().all(|tile| tile.x + tile.width <= self.width && tile.y + tile.height <= self.height)
    }

    /// Seconds of the whole frame, all workers together.
    pub(super) fn total(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// Seconds that `tile` took or would have taken; `None` if it reaches beyond the map.
    pub fn predict(&self, tile: Tile) -> Option<f64> {
        if tile.x + tile.width > self.width || tile.y + tile.height > self.height {
            return None;
        }
        let columns = self.width.div_ceil(CELL);
        let ends_with_cell = |end: u32, all: u32| end.is_multiple_of(CELL) || end == all;
        let whole_cells = tile.x.is_multiple_of(CELL)
            && tile.y.is_multiple_of(CELL)
            && ends_with_cell(tile.x + tile.width, self.width)
            && ends_with_cell(tile.y + tile.height, self.height);
        if whole_cells {
            // The usual case, on the way to the start of every frame.
            let rows = tile.y / CELL..(tile.y + tile.height).div_ceil(CELL);
            let row = |row: u32| {
                let from = (row * columns + tile.x / CELL) as usize;
                &self.seconds[from..from + tile.width.div_ceil(CELL) as usize]
            };
            return Some(rows.flat_map(row).sum());
        }
        let mut sum = 0.0;
        for_cells(tile, |column, row, pixels| {
            // Cells at the right and bottom edge hold fewer pixels.
            let held = |length: u32, cell: u32| (length - cell * CELL).min(CELL);
            let all = held(self.width, column) * held(self.height, row);
            sum += self.seconds[(row * columns + column) as usize] * f64::from(pixels) / f64::from(all);
        });
        Some(sum)
    }
}

/// Calls `visit` with column, row and number of common pixels for every cell that `tile` touches.
fn for_cells(tile: Tile, mut visit: impl FnMut(u32, u32, u32)) {
    let common =
        |from: u32, length: u32, cell: u32| (from + length).min((cell + 1) * CELL) - from.max(cell * CELL);
    for row in tile.y / CELL..(tile.y + tile.height).div_ceil(CELL) {
        for column in tile.x / CELL..(tile.x + tile.width).div_ceil(CELL) {
            visit(column, row, common(tile.x, tile.width, column) * common(tile.y, tile.height, row));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tile::{Order, tiles};

    #[test]
    fn a_frame_predicts_itself_and_its_parts() {
        let all = tiles(100, 70, 32, Order::Hilbert);
        let mut map = CostMap::covering(&all);
        for (i, &tile) in all.iter().enumerate() {
            map.record(tile, i as f64);
        }
        let whole = Tile { x: 0, y: 0, width: 100, height: 70 };
        let sum: f64 = (0..all.len()).map(|i| i as f64).sum();
        assert!((map.predict(whole).unwrap() - sum).abs() < 1e-9);
        for (i, tile) in all.iter().enumerate() {
            assert!((map.predict(*tile).unwrap() - i as f64).abs() < 1e-9);
            let half = Tile { height: tile.height / 2, ..*tile };
            let expected = i as f64 * half.len() as f64 / tile.len() as f64;
            assert!((map.predict(half).unwrap() - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn beyond_the_map_nothing_is_known() {
        let map = CostMap::covering(&tiles(64, 64, 64, Order::Hilbert));
        assert_eq!(map.predict(Tile { x: 60, y: 0, width: 8, height: 8 }), None);
        assert_eq!(CostMap::default().predict(Tile { x: 0, y: 0, width: 1, height: 1 }), None);
        assert_eq!(CostMap::covering(&[]).predict(Tile { x: 0, y: 0, width: 1, height: 1 }), None);
    }
}
