//! Which pixels of an image are traced first, and which are left for later.
//!
//! ```text
//!   1 . 2 . 1      level 1: every fourth pixel of every fourth row         1/16 of the pixels
//!   . 3 . 3 .      level 2: every second pixel of every second row         1/4
//!   2 . 2 . 2      level 3: their centres, too                             1/2
//!   . 3 . 3 .      level 4: all
//!   1 . 2 . 1
//! ```
//!
//! The pixels of a level are lattices, and the rays of a lattice are a packet with a common origin like those of
//! adjacent pixels: only wider.

use crate::tile::Tile;

/// How far a part of the image is: each level has all pixels of those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Level {
    /// Nothing is traced.
    #[default]
    Nothing,
    /// One pixel of sixteen.
    Sixteenth,
    /// One pixel of four.
    Quarter,
    /// Every other pixel, like the white squares of a chess board.
    Half,
    /// Every pixel.
    Full,
}

impl Level {
    /// All of them, in order.
    pub const ALL: [Level; 5] = [Level::Nothing, Level::Sixteenth, Level::Quarter, Level::Half, Level::Full];

    /// Share of the pixels that are traced.
    pub fn share(self) -> f64 {
        [0.0, 1.0 / 16.0, 0.25, 0.5, 1.0][self as usize]
    }

    /// Distance of neighbours in the finest whole lattice of this level, in pixels.
    pub fn spacing(self) -> u32 {
        [4, 4, 2, 2, 1][self as usize]
    }

    /// The level with this number.
    pub(super) fn of(number: u8) -> Level {
        Level::ALL[usize::from(number).min(4)]
    }
}

/// Every `spacing`-th pixel in both directions, from `first` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lattice {
    pub(super) first: [u32; 2],
    pub(super) spacing: u32,
}

const fn lattice(x: u32, y: u32, spacing: u32) -> Lattice {
    Lattice { first: [x, y], spacing }
}

impl Lattice {
    /// Every pixel.
    pub(super) const WHOLE: Lattice = lattice(0, 0, 1);

    /// The lattice's pixels within `area`, counted in the lattice's own columns and rows.
    pub(super) fn within(self, area: Tile) -> Tile {
        let count = |from: u32, first: u32| from.saturating_sub(first).div_ceil(self.spacing);
        let [x, y] = [count(area.x, self.first[0]), count(area.y, self.first[1])];
        let [right, bottom] =
            [count(area.x + area.width, self.first[0]), count(area.y + area.height, self.first[1])];
        Tile { x, y, width: right - x, height: bottom - y }
    }
}

const FOURTHS: Lattice = lattice(0, 0, 4);
const SECONDS: Lattice = lattice(0, 0, 2);
const CENTRES: Lattice = lattice(1, 1, 2);
/// What every second pixel has and every fourth has not.
const BETWEEN: [Lattice; 3] = [lattice(2, 2, 4), lattice(2, 0, 4), lattice(0, 2, 4)];
/// From a sixteenth to all; parts of it are the shorter ways.
const UPWARDS: [Lattice; 6] =
    [BETWEEN[0], BETWEEN[1], BETWEEN[2], CENTRES, lattice(1, 0, 2), lattice(0, 1, 2)];

/// The fewest lattices that lead from one level to another: disjoint, and each as dense as can be.
pub(super) fn lattices(from: Level, to: Level) -> &'static [Lattice] {
    use Level::{Full, Half, Nothing, Quarter, Sixteenth};
    match (from, to) {
        (Nothing, Sixteenth) => const { &[FOURTHS] },
        (Nothing, Quarter) => const { &[SECONDS] },
        (Nothing, Half) => const { &[SECONDS, CENTRES] },
        (Nothing, Full) => const { &[Lattice::WHOLE] },
        (Sixteenth, Quarter) => const { &BETWEEN },
        (Sixteenth, Half) => const { UPWARDS.split_at(4).0 },
        (Sixteenth, Full) => const { &UPWARDS },
        (Quarter, Half) => const { &[CENTRES] },
        (Quarter, Full) => const { UPWARDS.split_at(3).1 },
        (Half, Full) => const { UPWARDS.split_at(4).1 },
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(area: Tile, lattices: &[Lattice], counts: &mut [u32], width: u32) {
        for lattice in lattices {
            let part = lattice.within(area);
            for y in part.y..part.y + part.height {
                for x in part.x..part.x + part.width {
                    let [x, y] =
                        [lattice.first[0] + lattice.spacing * x, lattice.first[1] + lattice.spacing * y];
                    assert!(
                        x >= area.x && x < area.x + area.width && y >= area.y && y < area.y + area.height
                    );
                    counts[(y * width + x) as usize] += 1;
                }
            }
        }
    }

    #[test]
    fn every_way_to_a_level_has_each_of_its_pixels_once_in_any_cut() {
        for (width, height) in [(16, 16), (37, 21), (1, 1), (3, 2), (5, 64)] {
            for to in Level::ALL {
                let mut direct = vec![0; (width * height) as usize];
                let whole = Tile { x: 0, y: 0, width, height };
                count(whole, lattices(Level::Nothing, to), &mut direct, width);
                let traced = |x: u32, y: u32| match to {
                    Level::Nothing => false,
                    Level::Sixteenth => (x | y) & 3 == 0,
                    Level::Quarter => (x | y) & 1 == 0,
                    Level::Half => (x + y) & 1 == 0,
                    Level::Full => true,
                };
                let expected = (0..width * height).map(|i| u32::from(traced(i % width, i / width)));
                assert!(expected.eq(direct.iter().copied()), "{to:?} of {width}x{height}");
                for middle in Level::ALL.into_iter().filter(|&middle| middle <= to) {
                    let mut steps = vec![0; (width * height) as usize];
                    for y in 0..height {
                        // In cuts of any size.
                        for (x, part) in [(0, width / 3), (width / 3, width - width / 3)] {
                            let area = Tile { x, y, width: part, height: 1 };
                            count(area, lattices(Level::Nothing, middle), &mut steps, width);
                            count(area, lattices(middle, to), &mut steps, width);
                        }
                    }
                    assert_eq!(steps, direct, "{middle:?} to {to:?} of {width}x{height}");
                }
            }
        }
    }
}
