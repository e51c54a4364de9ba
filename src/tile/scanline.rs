//! Row by row, each row from left to right.

/// Iterator over the cells `(x, y)` of a rectangle in reading order.
#[derive(Clone, Debug)]
pub struct Scanline {
    width: u32,
    height: u32,
    x: u32,
    y: u32,
}

impl Scanline {
    /// Starts at the top left cell of a `width` x `height` rectangle.
    pub fn new(width: u32, height: u32) -> Scanline {
        // A rectangle without columns has no rows to walk either.
        Scanline { width, height: if width == 0 { 0 } else { height }, x: 0, y: 0 }
    }
}

impl Iterator for Scanline {
    type Item = (u32, u32);

    fn next(&mut self) -> Option<(u32, u32)> {
        if self.y == self.height {
            return None;
        }
        let cell = (self.x, self.y);
        self.x += 1;
        if self.x == self.width {
            self.x = 0;
            self.y += 1;
        }
        Some(cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_each_other_from_the_top() {
        let cells: Vec<_> = Scanline::new(3, 2).collect();
        assert_eq!(cells, [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]);
    }
}
