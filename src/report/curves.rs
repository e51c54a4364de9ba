//! Curves over two logarithmic axes, as SVG.

use super::{
    number::significant,
    plot::{Area, COLORS, svg},
};
use crate::error::Result;
use plotters::prelude::*;

/// Points with names.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// x and y, and what stands beside the point. What is not greater than zero is drawn at the edge.
    pub points: Vec<(f64, f64, String)>,
    /// How they are drawn.
    pub mark: Mark,
}

/// How a curve's points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Dots joined by a line in the order of x.
    Line,
    /// Dots.
    Dots,
    /// Black rings, around the dots of other curves.
    Rings,
}

/// A plot of curves.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Above it.
    pub title: String,
    /// Below the axis.
    pub x: String,
    /// Beside the axis.
    pub y: String,
    /// What is plotted.
    pub curves: Vec<Curve>,
    /// A level line with its name.
    pub level: Option<(f64, String)>,
}

const SIZE: (u32, u32) = (920, 560);

impl Curves {
    /// The plot as SVG.
    ///
    /// # Errors
    /// [`Error::Failed`] if it cannot be drawn.
    pub fn to_svg(&self) -> Result<String> {
        svg(&self.title, SIZE, |area| self.draw(area))
    }

    fn draw(&self, area: &Area) -> std::result::Result<(), Box<dyn std::error::Error>> {
        let [x, y] = self.ranges();
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(72)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        let label = |log: &f64| significant(10.0f64.powf(*log), 2);
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .light_line_style(WHITE)
            .draw()?;
        if let Some((level, name)) = &self.level {
            let at = logarithm(*level, y.0);
            chart.draw_series(DashedLineSeries::new([(x.0, at), (x.1, at)], 6, 4, BLACK.mix(0.5).into()))?;
            let style = ("sans-serif", 12).into_font().color(&BLACK.mix(0.6));
            chart.draw_series([Text::new(name.clone(), (x.0 + 0.01 * (x.1 - x.0), at), style)])?;
        }
        // Black is the rings' own.
        let mut colors = COLORS.iter().filter(|&&color| color != BLACK).cycle();
        for curve in &self.curves {
            let color = if curve.mark == Mark::Rings { &BLACK } else { colors.next().unwrap_or(&BLACK) };
            let (radius, fill) = curve.mark.dot(*color);
            let mut places: Vec<(f64, f64)> =
                curve.points.iter().map(|(px, py, _)| (logarithm(*px, x.0), logarithm(*py, y.0))).collect();
            let dots = places.iter().zip(&curve.points).map(|(&place, (_, _, name))| {
                let style = ("sans-serif", 12).into_font().color(color);
                EmptyElement::at(place)
                    + Circle::new((0, 0), radius, fill)
                    + Text::new(name.clone(), (6, -12), style)
            });
            let dots = chart.draw_series(dots)?;
            dots.label(&curve.name).legend(move |(x, y)| Circle::new((x + 8, y), radius, fill));
            if curve.mark == Mark::Line {
                places.sort_by(|a, b| a.0.total_cmp(&b.0));
                chart.draw_series(LineSeries::new(places, color.stroke_width(2)))?;
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        Ok(())
    }

    /// Least and greatest logarithm of x and y, with some room.
    fn ranges(&self) -> [(f64, f64); 2] {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let levels = self.level.iter().map(|(level, _)| *level);
        let x = span(points().map(|point| point.0));
        let y = span(points().map(|point| point.1).chain(levels));
        let room = |(least, most): (f64, f64), after: f64| {
            let length = (most - least).max(0.3);
            (least - 0.06 * length, most + after * length)
        };
        // Names stand on the right of their points, and the legend in the corner.
        [room(x, 0.24), room(y, 0.1)]
    }
}

impl Mark {
    /// Radius in pixels and style of a point.
    fn dot(self, color: RGBColor) -> (i32, ShapeStyle) {
        match self {
            Mark::Line | Mark::Dots => (4, color.filled()),
            Mark::Rings => (7, color.stroke_width(1)),
        }
    }
}

/// The logarithm, or `edge` if there is none.
fn logarithm(value: f64, edge: f64) -> f64 {
    if value > 0.0 && value.is_finite() { value.log10().max(edge) } else { edge }
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let logs = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
    let (least, most) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    if least <= most { (least, most) } else { (0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_have_their_points_and_names_even_where_there_is_no_logarithm() {
        let points = vec![(1.0, 0.1, "one".into()), (10.0, 0.0, "none".into()), (100.0, 1e-3, "far".into())];
        let rings = Curve { name: "rings".into(), points: points[..1].to_vec(), mark: Mark::Rings };
        let curve = Curve { name: "curve".into(), points, mark: Mark::Line };
        let plot = Curves {
            title: "Error".into(),
            x: "ms".into(),
            y: "RMSE".into(),
            curves: vec![curve, rings],
            level: Some((1e-4, "noise".into())),
        };
        let svg = plot.to_svg().unwrap();
        for word in ["Error", "ms", "RMSE", "curve", "one", "none", "far", "noise"] {
            assert!(svg.contains(word), "{word} in {svg}");
        }
        // Three and one; two in the legend.
        assert_eq!(svg.matches("<circle").count(), 6);
        let hollow = r##"r="7" opacity="1" fill="none" stroke="#000000""##;
        assert_eq!(svg.matches(hollow).count(), 2, "{svg}");
        assert_eq!([logarithm(100.0, -3.0), logarithm(0.0, -3.0), logarithm(1e-9, -3.0)], [2.0, -3.0, -3.0]);
        let nothing = Curves { curves: vec![], level: None, ..plot };
        assert!(nothing.to_svg().unwrap().contains("Error"));
    }
}
