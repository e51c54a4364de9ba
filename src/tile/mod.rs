//! Rectangles of the image plane and the orders in which they are visited.
//!
//! A [`Tile`] is the unit of work of a frame. An [`Order`] walks every cell of a grid once; walking the grid of
//! tiles in Hilbert order keeps consecutive tiles next to each other, so that the rays traced one after another
//! touch the same part of the tree.

mod hilbert;
mod morton;
mod peano;
mod scanline;
mod serpentine;

pub use hilbert::Hilbert;
pub use morton::Morton;
pub use peano::Peano;
pub use scanline::Scanline;
pub use serpentine::Serpentine;

use crate::error::Error;
use std::fmt;
use std::str::FromStr;

/// A rectangle of pixels; `(0, 0)` is the top left pixel of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Tile {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// True if the tile has no pixel.
    pub fn is_empty(&self) -> bool {
        self.width == 0 || self.height == 0
    }
}

/// The order in which the cells of a rectangle are visited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// Row by row, each from left to right.
    Scanline,
    /// Row by row, to the right and to the left in turns.
    Serpentine,
    /// Along a Hilbert curve, generalised to any rectangle.
    #[default]
    Hilbert,
    /// By the interleaved bits of row and column (Z order).
    Morton,
    /// Along a Peano curve, generalised to any rectangle.
    Peano,
}

impl Order {
    /// Every order there is, for studies that sweep them and messages that list them.
    pub const ALL: [Order; 5] =
        [Order::Scanline, Order::Serpentine, Order::Hilbert, Order::Morton, Order::Peano];

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Order::Scanline => "scanline",
            Order::Serpentine => "serpentine",
            Order::Hilbert => "hilbert",
            Order::Morton => "morton",
            Order::Peano => "peano",
        }
    }

    /// Visits every cell `(x, y)` of a `width` x `height` rectangle exactly once. An empty rectangle has no cells.
    pub fn cells(self, width: u32, height: u32) -> Cells {
        match self {
            Order::Scanline => Cells::Scanline(Scanline::new(width, height)),
            Order::Serpentine => Cells::Serpentine(Serpentine::new(width, height)),
            Order::Hilbert => Cells::Hilbert(Hilbert::new(width, height)),
            Order::Morton => Cells::Morton(Morton::new(width, height)),
            Order::Peano => Cells::Peano(Peano::new(width, height)),
        }
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Order {
    type Err = Error;

    /// Parses the name on the command line; the error lists the orders there are.
    fn from_str(name: &str) -> Result<Order, Error> {
        Order::ALL.into_iter().find(|order| order.name() == name).ok_or_else(|| {
            let available = Order::ALL.map(Order::name).join(", ");
            Error::flag("--order", format!("'{name}' is not available"), format!("use one of: {available}"))
        })
    }
}

/// Iterator over the cells of a rectangle, made by [`Order::cells`].
#[derive(Clone, Debug)]
pub enum Cells {
    /// See [`Order::Scanline`].
    Scanline(Scanline),
    /// See [`Order::Serpentine`].
    Serpentine(Serpentine),
    /// See [`Order::Hilbert`].
    Hilbert(Hilbert),
    /// See [`Order::Morton`].
    Morton(Morton),
    /// See [`Order::Peano`].
    Peano(Peano),
}

impl Iterator for Cells {
    type Item = (u32, u32);

    fn next(&mut self) -> Option<(u32, u32)> {
        match self {
            Cells::Scanline(cells) => cells.next(),
            Cells::Serpentine(cells) => cells.next(),
            Cells::Hilbert(cells) => cells.next(),
            Cells::Morton(cells) => cells.next(),
            Cells::Peano(cells) => cells.next(),
        }
    }
}

/// Every pixel of a `width` x `height` image once: in `order`, or tile by tile, tiles of `tile` pixels in `order` and the
/// pixels of each tile in `order` as well.
///
/// # Panics
///
/// If `tile` is 0.
pub fn pixels(width: u32, height: u32, order: Order, tile: Option<u32>) -> Vec<(u32, u32)> {
    match tile {
        None => order.cells(width, height).collect(),
        Some(size) => tiles(width, height, size, order)
            .into_iter()
            .flat_map(|tile| order.cells(tile.width, tile.height).map(move |(x, y)| (tile.x + x, tile.y + y)))
            .collect(),
    }
}

/// Cuts a `width` x `height` image into squares of `tile_size` pixels and lists them in `order`. Tiles at the right
/// and bottom edge are clipped to the image, so together they cover every pixel exactly once.
///
/// # Panics
///
/// If `tile_size` is 0.
pub fn tiles(width: u32, height: u32, tile_size: u32, order: Order) -> Vec<Tile> {
    assert!(tile_size > 0, "a tile needs at least one pixel");
    order
        .cells(width.div_ceil(tile_size), height.div_ceil(tile_size))
        .map(|(column, row)| {
            let (x, y) = (column * tile_size, row * tile_size);
            Tile { x, y, width: tile_size.min(width - x), height: tile_size.min(height - y) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once_in_every_order() {
        for order in Order::ALL {
            for (width, height, size) in
                [(1, 1, 64), (64, 64, 64), (65, 127, 64), (30, 7, 4), (3, 200, 16), (9, 9, 1)]
            {
                let mut count = vec![0; (width * height) as usize];
                for tile in tiles(width, height, size, order) {
                    assert!(!tile.is_empty());
                    for y in tile.y..tile.y + tile.height {
                        for x in tile.x..tile.x + tile.width {
                            count[(y * width + x) as usize] += 1;
                        }
                    }
                }
                assert!(count.iter().all(|&c| c == 1), "{order} {width}x{height} by {size}");
                for tile in [None, Some(size)] {
                    let mut cells = pixels(width, height, order, tile);
                    cells.sort_unstable_by_key(|&(x, y)| (y, x));
                    assert!(cells.into_iter().eq(Scanline::new(width, height)), "{order} {width}x{height}");
                }
            }
        }
    }

    #[test]
    fn an_empty_image_has_no_tiles() {
        for order in Order::ALL {
            assert_eq!(tiles(0, 10, 8, order), []);
            assert_eq!(tiles(10, 0, 8, order), []);
        }
    }

    #[test]
    fn the_largest_tile_size_does_not_overflow() {
        assert_eq!(tiles(7, 5, u32::MAX, Order::Hilbert), [Tile { x: 0, y: 0, width: 7, height: 5 }]);
    }

    #[test]
    fn names_parse_back_to_their_order() {
        for order in Order::ALL {
            assert_eq!(order.to_string().parse::<Order>().unwrap(), order);
        }
    }

    #[test]
    fn an_unknown_order_is_answered_with_the_available_ones() {
        let message = "spiral".parse::<Order>().unwrap_err().to_string();
        let available = "scanline, serpentine, hilbert, morton, peano";
        assert_eq!(message, format!("--order: 'spiral' is not available; use one of: {available}"));
    }
}
