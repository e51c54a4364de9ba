//! Lines through points.

/// A least-squares line y = intercept + slope * x, and how well it fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Value at x = 0.
    pub intercept: f64,
    /// Change of y per unit of x.
    pub slope: f64,
    /// Share of the variance of y that the line explains, 0 to 1.
    pub r2: f64,
    /// Number of points.
    pub points: usize,
}

impl Line {
    /// The line through points (x, y); `None` if there are fewer than three, or all at one x.
    pub fn fit(points: &[(f64, f64)]) -> Option<Line> {
        let n = points.len() as f64;
        let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), &(x, y)| (a + x / n, b + y / n));
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for &(x, y) in points {
            xx += (x - mx) * (x - mx);
            xy += (x - mx) * (y - my);
            yy += (y - my) * (y - my);
        }
        if points.len() < 3 || xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        let r2 = if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 };
        Some(Line { intercept: my - slope * mx, slope, r2, points: points.len() })
    }

    /// Value at x.
    pub fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }

    /// Where the line crosses zero; `None` if it is level.
    pub fn zero(&self) -> Option<f64> {
        (self.slope != 0.0).then(|| -self.intercept / self.slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_give_that_line() {
        let line = Line::fit(&[(0.0, -4.0), (1.0, -2.0), (5.0, 6.0)]).unwrap();
        assert!((line.intercept + 4.0).abs() < 1e-12 && (line.slope - 2.0).abs() < 1e-12);
        assert!((line.r2 - 1.0).abs() < 1e-12 && (line.zero().unwrap() - 2.0).abs() < 1e-12);
        assert!((line.at(3.0) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn scattered_points_are_explained_in_part() {
        // By hand: means 1.5 and 2.25, slope 3.5 / 5, r2 = 3.5^2 / (5 * 2.75).
        let line = Line::fit(&[(0.0, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 3.0)]).unwrap();
        assert!((line.slope - 0.7).abs() < 1e-12 && (line.intercept - 1.2).abs() < 1e-12);
        assert!((line.r2 - 12.25 / (5.0 * 2.75)).abs() < 1e-12, "{}", line.r2);
    }

    #[test]
    fn too_few_points_have_no_line() {
        assert_eq!(Line::fit(&[(0.0, 1.0), (1.0, 2.0)]), None);
        assert_eq!(Line::fit(&[(1.0, 1.0), (1.0, 2.0), (1.0, 5.0)]), None);
    }
}
