//! The Morton or Z order: cells by the interleaved bits of y and x.
//!
//! Quadrants of the enclosing square of 2^k cells are walked with an explicit stack; those outside the rectangle are
//! dropped whole, so that a long thin rectangle costs no more than its own cells.

/// Iterator over the cells `(x, y)` of a rectangle in Morton order.
#[derive(Clone, Debug)]
pub struct Morton {
    width: u32,
    height: u32,
    /// Squares still to be walked, the next one last: corner and logarithm of the side.
    squares: Vec<(u32, u32, u32)>,
}

impl Morton {
    /// Starts at the top left cell of a `width` x `height` rectangle.
    pub fn new(width: u32, height: u32) -> Morton {
        let side = width.max(height);
        let log = if side == 0 { 0 } else { 32 - (side - 1).leading_zeros() };
        let empty = width == 0 || height == 0;
        Morton { width, height, squares: if empty { vec![] } else { vec![(0, 0, log)] } }
    }
}

impl Iterator for Morton {
    type Item = (u32, u32);

    fn next(&mut self) -> Option<(u32, u32)> {
        loop {
            let (x, y, log) = self.squares.pop()?;
            if x >= self.width || y >= self.height {
                continue;
            }
            if log == 0 {
                return Some((x, y));
            }
            let half = 1 << (log - 1);
            // Sums beyond the largest number lie outside anyway.
            let (right, below) = (x.saturating_add(half), y.saturating_add(half));
            let quadrants = [(right, below), (x, below), (right, y), (x, y)];
            self.squares.extend(quadrants.map(|(x, y)| (x, y, log - 1)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Morton;

    /// Every second bit of `code`, starting at bit `first`.
    fn every_second_bit(code: u32, first: u32) -> u32 {
        (0..16).map(|bit| (code >> (2 * bit + first) & 1) << bit).sum()
    }

    #[test]
    fn cells_come_by_their_interleaved_bits() {
        let ours: Vec<_> = Morton::new(13, 6).collect();
        let codes = (0..256).map(|code| (every_second_bit(code, 0), every_second_bit(code, 1)));
        assert_eq!(ours, codes.filter(|&(x, y)| x < 13 && y < 6).collect::<Vec<_>>());
    }

    #[test]
    fn a_thin_rectangle_is_no_more_work_than_its_cells() {
        assert_eq!(Morton::new(1_000_000, 1).count(), 1_000_000);
        assert_eq!(Morton::new(u32::MAX, 1).next(), Some((0, 0)));
    }
}
