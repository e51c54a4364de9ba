//! The Hilbert curve, generalised to rectangles of any size.
//!
//! The recursion is the one of Jakub Cerveny, "gilbert: generalized Hilbert space-filling curve for rectangular
//! domains of arbitrary (non-power of two) sizes" (<https://github.com/jakubcerveny/gilbert>), written here with an
//! explicit stack so that it is an iterator. On squares of 2^k cells it is Hilbert's curve.
//!
//! A [`Block`] is walked from its corner `start` to the far end of its `along` side, on the same edge. Elongated
//! blocks are cut in two across `along`; the others in three, which is Hilbert's pattern "up, across, down". Halves
//! are made even where there is a choice, because only even halves can be entered and left without a diagonal step.

/// A length along one axis: `unit` is -1 or 1 in exactly one component.
#[derive(Clone, Copy, Debug)]
struct Side {
    unit: [i64; 2],
    length: i64,
}

impl Side {
    fn reversed(self) -> Side {
        Side { unit: self.unit.map(|u| -u), length: self.length }
    }

    /// Splits off about one half, an even one if the side is longer than two.
    fn halves(self) -> (Side, Side) {
        let half = self.length / 2;
        let half = if half % 2 == 1 && self.length > 2 { half + 1 } else { half };
        (Side { length: half, ..self }, Side { length: self.length - half, ..self })
    }
}

/// A rectangle still to be walked; `across` is perpendicular to `along`.
#[derive(Clone, Copy, Debug)]
struct Block {
    start: [i64; 2],
    along: Side,
    across: Side,
}

impl Block {
    /// Too long for Hilbert's pattern.
    fn is_elongated(&self) -> bool {
        2 * self.along.length > 3 * self.across.length
    }
}

fn step(from: [i64; 2], unit: [i64; 2], count: i64) -> [i64; 2] {
    [from[0] + unit[0] * count, from[1] + unit[1] * count]
}

/// Iterator over the cells `(x, y)` of a rectangle along the generalised Hilbert curve.
///
/// It starts at `(0, 0)`, and each cell is a neighbour of the one before. It ends at the other end of the longer side
/// (the horizontal one of a square), unless that side is odd and the shorter one even: between these two corners no
/// such walk exists (colour the cells like a chessboard). Then it ends elsewhere on the far edges.
#[derive(Clone, Debug)]
pub struct Hilbert {
    /// Blocks still to be walked, the next one last.
    blocks: Vec<Block>,
    /// The line being walked: next cell, unit step, cells left.
    cell: [i64; 2],
    unit: [i64; 2],
    left: i64,
}

impl Hilbert {
    /// Starts at the top left cell of a `width` x `height` rectangle.
    pub fn new(width: u32, height: u32) -> Hilbert {
        let x = Side { unit: [1, 0], length: width.into() };
        let y = Side { unit: [0, 1], length: height.into() };
        let (along, across) = if width >= height { (x, y) } else { (y, x) };
        let blocks =
            if width == 0 || height == 0 { vec![] } else { vec![Block { start: [0, 0], along, across }] };
        Hilbert { blocks, cell: [0, 0], unit: [0, 0], left: 0 }
    }

    /// Either starts a line of cells or replaces `block` by its parts.
    fn descend(&mut self, block: Block) {
        let block = self.free_end(block);
        let Block { start, along, across } = block;
        if across.length == 1 {
            (self.cell, self.unit, self.left) = (start, along.unit, along.length);
        } else if along.length == 1 {
            (self.cell, self.unit, self.left) = (start, across.unit, across.length);
        } else if block.is_elongated() {
            let (near, far) = along.halves();
            let middle = step(start, along.unit, near.length);
            self.blocks.push(Block { start: middle, along: far, across });
            self.blocks.push(Block { start, along: near, across });
        } else {
            self.push_up_across_down(block);
        }
    }

    /// The last block of all may end where it likes: turned, if it cannot be walked along its odd side without a
    /// diagonal step.
    fn free_end(&self, block: Block) -> Block {
        let Block { start, along, across } = block;
        let odd = along.length % 2 == 1 && across.length % 2 == 0 && across.length > 2;
        if odd && self.blocks.is_empty() && !block.is_elongated() {
            return Block { start, along: across, across: along };
        }
        block
    }

    /// Hilbert's pattern. The parts are pushed last to first.
    fn push_up_across_down(&mut self, block: Block) {
        let Block { start, along, across } = block;
        let (low, high) = across.halves();
        // Here only the cut across is made even: evening both would unbalance small blocks for no gain.
        let near = Side { length: along.length / 2, ..along };
        let far = Side { length: along.length - near.length, ..along };
        let down = step(step(start, along.unit, along.length - 1), across.unit, low.length - 1);
        self.blocks.push(Block { start: down, along: low.reversed(), across: far.reversed() });
        self.blocks.push(Block { start: step(start, across.unit, low.length), along, across: high });
        self.blocks.push(Block { start, along: low, across: near });
    }
}

impl Iterator for Hilbert {
    type Item = (u32, u32);

    fn next(&mut self) -> Option<(u32, u32)> {
        while self.left == 0 {
            let block = self.blocks.pop()?;
            self.descend(block);
        }
        let [x, y] = self.cell;
        self.left -= 1;
        self.cell = step(self.cell, self.unit, 1);
        Some((x as u32, y as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_of_every_rectangle_up_to_70_is_visited_exactly_once() {
        for width in 1..=70 {
            for height in 1..=70 {
                let mut seen = vec![false; (width * height) as usize];
                for (x, y) in Hilbert::new(width, height) {
                    assert!(x < width && y < height, "({x}, {y}) is outside {width}x{height}");
                    let cell = &mut seen[(y * width + x) as usize];
                    assert!(!*cell, "({x}, {y}) of {width}x{height} is visited twice");
                    *cell = true;
                }
                assert!(seen.iter().all(|&s| s), "{width}x{height} is incomplete");
            }
        }
    }

    #[test]
    fn every_step_goes_to_a_neighbour_in_every_rectangle() {
        for width in 1u32..=70 {
            for height in 1u32..=70 {
                let cells: Vec<_> = Hilbert::new(width, height).collect();
                let steps = cells.windows(2).map(|w| (w[0].0.abs_diff(w[1].0), w[0].1.abs_diff(w[1].1)));
                let other: Vec<_> = steps.filter(|&s| s != (0, 1) && s != (1, 0)).collect();
                assert_eq!(other, [], "{width}x{height}");
            }
        }
    }

    #[test]
    fn the_walk_ends_at_the_other_end_of_the_longer_side_where_it_can() {
        for (width, height, end) in [
            (8, 8, (7, 0)),
            (12, 5, (11, 0)),
            (5, 12, (0, 11)),
            (5, 5, (4, 0)),
            (1, 9, (0, 8)),
            (7, 6, (0, 5)),
        ] {
            assert_eq!(Hilbert::new(width, height).next(), Some((0, 0)));
            assert_eq!(Hilbert::new(width, height).last(), Some(end), "{width}x{height}");
        }
    }

    #[test]
    fn on_powers_of_two_it_is_the_curve_of_hilbert() {
        for n in [2, 4, 8, 16, 32, 64, 128] {
            let ours: Vec<_> = Hilbert::new(n, n).collect();
            let theirs: Vec<(u32, u32)> =
                (0..n * n).map(|d| fast_hilbert::h2xy(d.into(), n.ilog2() as u8)).collect();
            let mirrored: Vec<_> = theirs.iter().map(|&(x, y)| (y, x)).collect();
            assert!(ours == theirs || ours == mirrored, "{n}x{n}");
        }
    }

    #[test]
    fn an_empty_rectangle_has_no_cells() {
        assert_eq!(Hilbert::new(0, 5).next(), None);
        assert_eq!(Hilbert::new(5, 0).next(), None);
    }

    #[test]
    fn extreme_sides_are_walked_without_a_deep_stack() {
        assert_eq!(Hilbert::new(1_000_000, 1).count(), 1_000_000);
        assert_eq!(Hilbert::new(3, 1_000_000).count(), 3_000_000);
    }
}
