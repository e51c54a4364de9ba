//! Peano's curve, generalised to rectangles of any size.
//!
//! ```text
//!   3 6-7      a block is walked from corner to opposite corner: its thirds column by column, up and down in turns,
//!   | | |      each mirrored so that it starts where the one before ended
//!   2 5 8
//!   | | |
//!   1 4 9 ...
//! ```
//!
//! On squares of 3^k cells it is Peano's curve. Other sides are cut into thirds as equal as can be whose outer ones are
//! odd, because a block with an odd number of rows or columns can be left at the opposite corner without a diagonal
//! step where the other number is odd as well: a rectangle with two odd sides is walked in unit steps. With an even side,
//! blocks of 2x2 cells, or 2x1, remain here and there, which end one cell beside the corner.
//! Blocks that are more than twice as long as wide are cut along their long side only.

/// A rectangle still to be walked, from the corner that the mirrors tell: (0, 0) without.
#[derive(Clone, Copy, Debug)]
struct Block {
    at: [u32; 2],
    size: [u32; 2],
    /// Per axis: walked from the high end to the low.
    mirrored: [bool; 2],
}

/// Iterator over the cells `(x, y)` of a rectangle along the generalised Peano curve.
#[derive(Clone, Debug)]
pub struct Peano {
    /// Blocks still to be walked, the next one last.
    blocks: Vec<Block>,
}

impl Peano {
    /// Starts at the top left cell of a `width` x `height` rectangle.
    pub fn new(width: u32, height: u32) -> Peano {
        let block = Block { at: [0, 0], size: [width, height], mirrored: [false; 2] };
        Peano { blocks: if width == 0 || height == 0 { vec![] } else { vec![block] } }
    }

    /// Replaces a block by its parts, the first one last.
    fn cut(&mut self, block: Block) {
        let [width, height] = block.size;
        let columns = if is_thin(width, height) { [width, 0, 0] } else { thirds(width) };
        let rows = if is_thin(height, width) { [height, 0, 0] } else { thirds(height) };
        let first = self.blocks.len();
        let mut x = 0;
        for (column, &width) in columns.iter().enumerate().filter(|(_, width)| **width > 0) {
            let mut y = 0;
            let up = column % 2 == 1;
            let start = self.blocks.len();
            for (row, &height) in rows.iter().enumerate().filter(|(_, height)| **height > 0) {
                let mirrored = [block.mirrored[0] ^ (row % 2 == 1), block.mirrored[1] ^ up];
                self.blocks.push(block.part([x, y], [width, height], mirrored));
                y += height;
            }
            if up {
                self.blocks[start..].reverse();
            }
            x += width;
        }
        self.blocks[first..].reverse();
    }
}

impl Block {
    /// The part of this size at an offset that counts from the corner where the walk begins.
    fn part(&self, offset: [u32; 2], size: [u32; 2], mirrored: [bool; 2]) -> Block {
        let at = [0, 1].map(|k| {
            let offset = if self.mirrored[k] { self.size[k] - offset[k] - size[k] } else { offset[k] };
            self.at[k] + offset
        });
        Block { at, size, mirrored }
    }
}

/// True if a block of these sides is cut along `long` only.
fn is_thin(short: u32, long: u32) -> bool {
    long >= 3 && (short == 2 || long / 2 > short)
}

/// Cuts a length of 3 or more into three whose outer ones are odd; cuts 2 into two, and leaves 1.
fn thirds(length: u32) -> [u32; 3] {
    match length {
        1 => [1, 0, 0],
        2 => [1, 1, 0],
        _ => {
            // The better of the two odd numbers about a third.
            let up = (length / 3) | 1;
            let down = up.max(3) - 2;
            let unbalanced = |outer: u32| (3 * outer).abs_diff(length);
            let outer = if 2 * up < length && unbalanced(up) < unbalanced(down) { up } else { down };
            [outer, length - 2 * outer, outer]
        }
    }
}

impl Iterator for Peano {
    type Item = (u32, u32);

    fn next(&mut self) -> Option<(u32, u32)> {
        loop {
            let block = self.blocks.pop()?;
            if block.size == [1, 1] {
                return Some((block.at[0], block.at[1]));
            }
            self.cut(block);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Position `d` on Peano's curve over 3^k x 3^k cells by its digits (Peano 1890): digits of x and y alternate, and
    /// each is replaced by 2 minus itself if the digits of the other coordinate before it have an odd sum.
    fn peano_cell(k: u32, d: u32) -> (u32, u32) {
        let digits: Vec<u32> = (0..2 * k).rev().map(|i| d / 3u32.pow(i) % 3).collect();
        let (mut x, mut y) = (0, 0);
        for i in 0..digits.len() {
            let others: u32 = (0..i).filter(|j| j % 2 != i % 2).map(|j| digits[j]).sum();
            let digit = if others % 2 == 1 { 2 - digits[i] } else { digits[i] };
            if i % 2 == 0 { x = 3 * x + digit } else { y = 3 * y + digit }
        }
        (x, y)
    }

    fn steps(width: u32, height: u32) -> Vec<u32> {
        let cells: Vec<_> = Peano::new(width, height).collect();
        cells.windows(2).map(|w| w[0].0.abs_diff(w[1].0) + w[0].1.abs_diff(w[1].1)).collect()
    }

    #[test]
    fn on_powers_of_three_it_is_the_curve_of_peano() {
        for k in 0..5 {
            let side = 3u32.pow(k);
            let want: Vec<_> = (0..side * side).map(|d| peano_cell(k, d)).collect();
            assert!(Peano::new(side, side).eq(want), "{side}x{side}");
        }
    }

    #[test]
    fn two_odd_sides_are_walked_in_unit_steps() {
        for width in (1..60).step_by(2) {
            for height in (1..60).step_by(2) {
                assert!(steps(width, height).iter().all(|&step| step == 1), "{width}x{height}");
                assert_eq!(Peano::new(width, height).last(), Some((width - 1, height - 1)));
            }
        }
    }

    #[test]
    fn other_sides_are_walked_in_nearly_unit_steps() {
        for (width, height) in [(256, 256), (1024, 1024), (150, 101), (640, 480), (1000, 2)] {
            let steps = steps(width, height);
            let longer = steps.iter().filter(|&&step| step > 1).count();
            assert!(longer * 8 < steps.len(), "{longer} of {} in {width}x{height}", steps.len());
            assert!(steps.iter().all(|&step| step <= width.max(height) / 8), "{width}x{height}");
        }
    }

    #[test]
    fn thirds_are_balanced_and_odd_outside() {
        for length in 3..2000 {
            let [a, b, c] = thirds(length);
            assert!(a == c && a % 2 == 1 && a + b + c == length && b > 0, "{length}");
            assert!(length < 9 || b.abs_diff(a) <= 4, "{length}: {a} {b}");
        }
    }

    #[test]
    fn extreme_sides_are_walked_without_a_deep_stack() {
        assert_eq!(Peano::new(1_000_000, 1).count(), 1_000_000);
        assert_eq!(Peano::new(3, 1_000_000).count(), 3_000_000);
    }
}
