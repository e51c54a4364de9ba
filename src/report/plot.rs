//! Scatter plots with lines, as SVG. This file and `curves.rs` alone name `plotters`.

use crate::error::{Error, Result};
use plotters::prelude::*;

/// Points and the line through them.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// The points (x, y).
    pub points: Vec<(f64, f64)>,
    /// Intercept and slope of the line through them.
    pub line: Option<(f64, f64)>,
}

/// A plot of several series.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Above it.
    pub title: String,
    /// Below the axis.
    pub x: String,
    /// Beside the axis.
    pub y: String,
    /// What is plotted, the first one first.
    pub series: Vec<Series>,
}

/// Width and height in pixels.
const SIZE: (u32, u32) = (900, 560);

/// Colours that stay apart for most eyes (Okabe and Ito 2008).
pub(super) const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(150, 150, 0),
];

/// Where a plot is drawn.
pub(super) type Area<'s> = DrawingArea<SVGBackend<'s>, plotters::coord::Shift>;

/// A white picture of so many pixels, with what `draw` draws.
///
/// # Errors
/// [`Error::Failed`] if it cannot be drawn.
pub(super) fn svg(
    title: &str,
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> std::result::Result<(), Box<dyn std::error::Error>>,
) -> Result<String> {
    let mut svg = String::new();
    let failed =
        |error: &dyn std::fmt::Display| Error::Failed(format!("{title}: the plot cannot be drawn ({error})"));
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        area.fill(&WHITE).map_err(|error| failed(&error))?;
        draw(&area).map_err(|error| failed(&error))?;
        area.present().map_err(|error| failed(&error))?;
    }
    Ok(svg)
}

impl Plot {
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
            .y_label_area_size(56)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        chart.configure_mesh().x_desc(&self.x).y_desc(&self.y).light_line_style(WHITE).draw()?;
        chart.draw_series(LineSeries::new([(x.0, 0.0), (x.1, 0.0)], BLACK.mix(0.5)))?;
        for (series, color) in self.series.iter().zip(COLORS.iter().cycle()) {
            let dot = |&point: &(f64, f64)| Circle::new(point, 3, color.mix(0.55).filled());
            let dots = chart.draw_series(series.points.iter().map(dot))?;
            dots.label(&series.name).legend(|(x, y)| Circle::new((x + 8, y), 4, color.filled()));
            if let Some((intercept, slope)) = series.line {
                let ends = span(series.points.iter().map(|point| point.0));
                let line = [ends.0, ends.1].map(|x| (x, intercept + slope * x));
                chart.draw_series(LineSeries::new(line, color.stroke_width(2)))?;
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

    /// Least and greatest x and y, with some room, zero among the latter.
    fn ranges(&self) -> [(f64, f64); 2] {
        let points = || self.series.iter().flat_map(|series| &series.points);
        let (x, y) = (span(points().map(|point| point.0)), span(points().map(|point| point.1).chain([0.0])));
        let room = |(least, most): (f64, f64), after: f64| {
            let length = (most - least).max(1e-6);
            (least - 0.04 * length, most + after * length)
        };
        // The legend stands on the right.
        [room(x, 0.34), room(y, 0.04)]
    }
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    if least <= most { (least, most) } else { (0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_has_its_names_and_a_dot_for_each_point() {
        let series =
            Series { name: "curve".into(), points: vec![(1.0, 2.0), (2.0, -3.0)], line: Some((0.0, 1.0)) };
        let plot = Plot { title: "Gains".into(), x: "size".into(), y: "gain".into(), series: vec![series] };
        let svg = plot.to_svg().unwrap();
        for word in ["Gains", "size", "gain", "curve"] {
            assert!(svg.contains(word), "{word} in {svg}");
        }
        // Two, and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 3);
    }

    #[test]
    fn a_plot_of_nothing_can_be_drawn() {
        let plot = Plot { title: "None".into(), x: "x".into(), y: "y".into(), series: vec![] };
        assert!(plot.to_svg().unwrap().contains("None"));
    }
}
