//! Row by row like an ox that ploughs: to the right, then to the left. Every step goes to a neighbour.

/// Iterator over the cells `(x, y)` of a rectangle in boustrophedon order.
#[derive(Clone, Debug)]
pub struct Serpentine {
    width: u32,
    height: u32,
    x: u32,
    y: u32,
}

impl Serpentine {
    /// Starts at the top left cell of a `width` x `height` rectangle.
    pub fn new(width: u32, height: u32) -> Serpentine {
        // A rectangle without columns has no rows to walk either.
        Serpentine { width, height: if width == 0 { 0 } else { height }, x: 0, y: 0 }
    }
}

impl Iterator for Serpentine {
    type Item = (u32, u32);

    fn next(&mut self) -> Option<(u32, u32)> {
        if self.y == self.height {
            return None;
        }
        let cell = (if self.y.is_multiple_of(2) { self.x } else { self.width - 1 - self.x }, self.y);
        self.x += 1;
        if self.x == self.width {
            (self.x, self.y) = (0, self.y + 1);
        }
        Some(cell)
    }
}

#[cfg(test)]
mod tests {
    use super::Serpentine;

    #[test]
    fn rows_alternate() {
        let cells: Vec<_> = Serpentine::new(3, 3).collect();
        assert_eq!(cells, [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1), (0, 2), (1, 2), (2, 2)]);
    }
}
