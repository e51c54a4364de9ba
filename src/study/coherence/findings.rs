//! What the points of a sweep say: lines through the gains of one order, cache or technique over another.

use super::{
    cache::Shape,
    fit::Line,
    sweep::{Point, SHAPES, Tests},
    tally::gain,
};
use crate::tile::Order;

/// What many points say about one comparison.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What is compared: its gain is y.
    pub what: String,
    /// What x is.
    pub against: &'static str,
    /// The points (x, y).
    pub points: Vec<(f64, f64)>,
    /// The line through them.
    pub line: Option<Line>,
}

impl Finding {
    fn new(what: String, against: &'static str, points: Vec<(f64, f64)>) -> Finding {
        let points: Vec<_> = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let line = Line::fit(&points);
        Finding { what, against, points, line }
    }

    /// The mean gain.
    pub fn mean(&self) -> f64 {
        self.points.iter().map(|(_, y)| y).sum::<f64>() / self.points.len().max(1) as f64
    }

    /// The share of points with a gain above zero, in percent.
    pub fn wins(&self) -> f64 {
        let wins = self.points.iter().filter(|(_, y)| *y > 0.0).count();
        100.0 * wins as f64 / self.points.len().max(1) as f64
    }
}

/// What x of a finding about the size of triangles is.
pub const TRIANGLE_SIZE: &str = "log2 of pixels per triangle seen";
/// What x of a finding about neighbours is.
pub const LIKENESS: &str = "half of: like the pixel above, over like the pixel to the left, in %";
/// What x of a finding about shadows is.
pub const OCCLUDED: &str = "occluded share of a light's rays in %";
/// What x of a finding about lights is.
pub const LIGHTS: &str = "lights";

/// Compares orders with the scanline order, caches with the thesis', and techniques with base.
pub fn findings(points: &[Point]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let others = || Order::ALL.into_iter().filter(|&order| order != Order::Scanline);
    let pairs = |order, shape| pairs(points, order, Order::Scanline, shape, shape);
    for order in others() {
        let y = |(a, b): (&Point, &Point)| (size_of(a), percent(a.same as f64, b.same as f64));
        let points = pairs(order, Shape::THESIS).map(y).collect();
        findings.push(Finding::new(
            format!("same triangle as before: {order} over scanline"),
            TRIANGLE_SIZE,
            points,
        ));
    }
    for order in others() {
        let y = |(a, b): (&Point, &Point)| {
            (0.5 * percent(a.likeness[1], a.likeness[0]), percent(a.same as f64, b.same as f64))
        };
        let points = pairs(order, Shape::THESIS).map(y).collect();
        findings.push(Finding::new(
            format!("same triangle as before: {order} over scanline"),
            LIKENESS,
            points,
        ));
    }
    for order in others() {
        let each = pairs(order, Shape::THESIS).flat_map(|(a, b)| a.lights.iter().zip(&b.lights));
        let y = |(a, b): (&[Tests; 4], &[Tests; 4])| {
            let occluded = 100.0 * a[0].hit as f64 / a[0].rays as f64;
            (occluded, percent(a[0].seeded as f64, b[0].seeded as f64))
        };
        findings.push(Finding::new(
            format!("successes of OCC: {order} over scanline"),
            OCCLUDED,
            each.map(y).collect(),
        ));
    }
    for shape in SHAPES.map(|(area, entries)| Shape { area, entries }) {
        for order in others() {
            let y = |(a, b): (&Point, &Point)| (size_of(a), percent(b.tests(), a.tests()));
            let points = pairs(order, shape).map(y).collect();
            findings.push(Finding::new(
                format!("work with cache {shape}: {order} over scanline"),
                TRIANGLE_SIZE,
                points,
            ));
        }
    }
    for order in Order::ALL {
        for shape in SHAPES[1..].iter().map(|&(area, entries)| Shape { area, entries }) {
            let y = |(a, b): (&Point, &Point)| (size_of(a), percent(b.tests(), a.tests()));
            let points = self::pairs(points, order, order, shape, Shape::THESIS).map(y).collect();
            let what = format!("work in {order} order: cache {shape} over ray x1");
            findings.push(Finding::new(what, TRIANGLE_SIZE, points));
        }
    }
    findings.extend(techniques(points));
    findings
}

/// Techniques over base by the number of lights.
fn techniques(points: &[Point]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let base = super::TECHNIQUES[0];
    for order in [Order::Scanline, Order::Hilbert] {
        for technique in &super::TECHNIQUES[1..] {
            let chosen = points.iter().filter(|point| point.order == order && point.shape == Shape::THESIS);
            let each = chosen.flat_map(|point| {
                (1..=point.lights.len()).map(move |count| {
                    let y = percent(point.tests_of(base, count), point.tests_of(*technique, count));
                    (count as f64, y)
                })
            });
            let what = format!("work in {order} order: {} over base", technique.name);
            findings.push(Finding::new(what, LIGHTS, each.collect()));
        }
    }
    findings
}

/// Points that differ in order or cache only.
fn pairs(
    points: &[Point],
    order: Order,
    than: Order,
    shape: Shape,
    than_shape: Shape,
) -> impl Iterator<Item = (&Point, &Point)> {
    points.iter().filter(move |point| point.order == order && point.shape == shape).filter_map(move |point| {
        let same = |other: &&Point| {
            (other.order, other.shape) == (than, than_shape)
                && (&other.scene, other.size) == (&point.scene, point.size)
        };
        Some((point, points.iter().find(same)?))
    })
}

fn size_of(point: &Point) -> f64 {
    point.pixels_per_triangle.log2()
}

/// The gain, not a number over nothing.
fn percent(with: f64, without: f64) -> f64 {
    gain(with, without).unwrap_or(f64::NAN)
}
