//! FLIP: what people notice who flip between two images (Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild,
//! "FLIP: A Difference Evaluator for Alternating Images", 2020), for images on a screen 0.7 m wide with 3840 pixels across,
//! seen from 0.7 m.
//!
//! ```text
//!   sRGB -> opponent colours -> blurred as the eye does -> L*a*b*, Hunt's effect -> distance of colours --+
//!             |                                                                                           +-> error
//!             +-> brightness -> edges and points ------------------------------> difference of features --+
//! ```

use super::{
    Picture,
    filter::{Plane, Weights, bell, normalised, weights},
};
use std::f64::consts::PI;

/// Pixels per degree of what the eye sees: 0.7 m * 3840 / 0.7 m * pi / 180.
const DENSITY: f64 = 3840.0 * PI / 180.0;

/// The mean of [`flip_map`]: 0 for equal images, at most 1.
///
/// # Panics
/// If their sizes differ.
pub fn flip(right: &Picture, image: &Picture) -> f64 {
    let map = flip_map(right, image);
    map.iter().map(|&error| f64::from(error)).sum::<f64>() / map.len().max(1) as f64
}

/// The error of each pixel of `image` against `right`, the one that it should be, from 0 to 1.
///
/// # Panics
/// If their sizes differ.
pub fn flip_map(right: &Picture, image: &Picture) -> Vec<f32> {
    assert_eq!(right.size, image.size, "images of one size");
    let (right, image) = (opponents(right), opponents(image));
    let colours = colour_errors(&seen(&right), &seen(&image));
    let features = feature_errors(&right[0], &image[0]);
    let error = |(colour, feature): (f64, f64)| colour.powf(1.0 - feature) as f32;
    colours.into_iter().zip(features).map(error).collect()
}

type V = [f64; 3];

/// XYZ of linear red, green and blue (sRGB primaries), as the authors' program has them.
const XYZ: [V; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

fn xyz(rgb: V) -> V {
    XYZ.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2])
}

/// The inverse of [`xyz`].
fn rgb(xyz: V) -> V {
    let matrix = glam::DMat3::from_cols_array_2d(&XYZ).transpose().inverse();
    (matrix * glam::DVec3::from(xyz)).to_array()
}

/// XYZ of white.
fn white() -> V {
    xyz([1.0; 3])
}

/// Brightness, red against green, and blue against yellow (YyCxCz).
fn opponents(picture: &Picture) -> [Plane; 3] {
    let white = white();
    let colours = picture.pixels.iter().map(|pixel| {
        let xyz = xyz(pixel.map(f64::from));
        let [x, y, z] = [0, 1, 2].map(|i| xyz[i] / white[i]);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    });
    let colours: Vec<V> = colours.collect();
    [0, 1, 2].map(|c| Plane::new(picture.size, colours.iter().map(|colour| colour[c] as f32)))
}

/// What the eye resolves of a channel: a sum of bells in the frequencies (its contrast sensitivity), by weight and width.
const SENSITIVITY: [[(f64, f64); 2]; 3] =
    [[(1.0, 0.0047), (0.0, 1.0e-5)], [(1.0, 0.0053), (0.0, 1.0e-5)], [(34.1, 0.04), (13.5, 0.025)]];

fn blurred(plane: &Plane, sensitivity: [(f64, f64); 2]) -> Plane {
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * DENSITY).ceil() as usize;
    let bells = sensitivity.map(|(weight, width)| {
        let along = weights(radius, |d| (-(PI * d / DENSITY).powi(2) / width).exp());
        (weight * (PI / width).sqrt(), along)
    });
    let total: f64 = bells.iter().map(|(weight, along)| weight * along.iter().sum::<f64>().powi(2)).sum();
    let parts = bells.iter().filter(|(weight, _)| *weight > 0.0).map(|(weight, along)| {
        let scaled: Weights = along.iter().map(|value| value * weight / total).collect();
        plane.filtered(&scaled, along)
    });
    parts.reduce(|sum, part| sum.with(&part, |a, b| a + b)).unwrap_or_else(|| plane.clone())
}

/// Colours as the eye gets them, in L*a*b* with less colour where it is dark (Hunt's effect).
fn seen(opponents: &[Plane; 3]) -> Vec<V> {
    let white = white();
    let [y, cx, cz] = [0, 1, 2].map(|c| blurred(&opponents[c], SENSITIVITY[c]));
    let colour = |i: usize| {
        let y_share = (f64::from(y.values[i]) + 16.0) / 116.0;
        let x_share = f64::from(cx.values[i]) / 500.0 + y_share;
        let z_share = y_share - f64::from(cz.values[i]) / 200.0;
        let xyz = [x_share * white[0], y_share * white[1], z_share * white[2]];
        hunt_lab(rgb(xyz).map(|value| value.clamp(0.0, 1.0)))
    };
    (0..y.values.len()).map(colour).collect()
}

/// L*a*b* of linear red, green and blue; a and b weighted by L.
fn hunt_lab(linear: V) -> V {
    const DELTA: f64 = 6.0 / 29.0;
    let (xyz, white) = (xyz(linear), white());
    let root = |t: f64| {
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = [0, 1, 2].map(|i| root(xyz[i] / white[i]));
    let light = 116.0 * y - 16.0;
    [light, 0.01 * light * 500.0 * (x - y), 0.01 * light * 200.0 * (y - z)]
}

/// Distance for large differences of colour (HyAB: Abasi, Tehran, Fairchild 2019).
fn hyab(a: V, b: V) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Distances between 0 and 1; those up to two fifths of the greatest take 95 % of that range.
fn colour_errors(right: &[V], image: &[V]) -> Vec<f64> {
    const POWER: f64 = 0.7;
    const BEND: f64 = 0.4;
    const AT_BEND: f64 = 0.95;
    let most = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(POWER);
    let error = |(&a, &b): (&V, &V)| {
        let distance = hyab(a, b).powf(POWER);
        let bend = BEND * most;
        if distance < bend {
            AT_BEND / bend * distance
        } else {
            AT_BEND + (distance - bend) / (most - bend) * (1.0 - AT_BEND)
        }
    };
    right.iter().zip(image).map(error).collect()
}

/// How different edges and points are, from 0 to 1.
fn feature_errors(right: &Plane, image: &Plane) -> Vec<f64> {
    let deviation = 0.5 * 0.082 * DENSITY;
    let radius = (3.0 * deviation).ceil() as usize;
    let smooth = normalised(weights(radius, bell(deviation)));
    let edge = balanced(weights(radius, |d| -d * bell(deviation)(d)));
    let point = balanced(weights(radius, |d| (d * d / (deviation * deviation) - 1.0) * bell(deviation)(d)));
    let strength = |plane: &Plane, derivative: &Weights| {
        let scaled = Plane::new(plane.size, plane.values.iter().map(|value| (value + 16.0) / 116.0));
        scaled.filtered(derivative, &smooth).with(&scaled.filtered(&smooth, derivative), f32::hypot)
    };
    let change = |derivative: &Weights| {
        strength(right, derivative).with(&strength(image, derivative), |a, b| (a - b).abs())
    };
    let most = change(&edge).with(&change(&point), f32::max);
    most.values.iter().map(|&change| (f64::from(change) / 2.0f64.sqrt()).sqrt()).collect()
}

/// Positive weights that sum to 1, and negative ones that sum to -1.
fn balanced(weights: Weights) -> Weights {
    let sum = |sign: f64| weights.iter().filter(|&&w| w * sign > 0.0).sum::<f64>().abs();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    weights.iter().map(|&w| if w > 0.0 { w / positive } else { w / negative }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::srgb8_to_linear;

    const SIZE: [u32; 2] = [48, 36];

    fn picture(size: [u32; 2], of: impl Fn(u32, u32) -> [u32; 3]) -> Picture {
        let linear = srgb8_to_linear();
        let pixel = |i: u32| of(i % size[0], i / size[0]).map(|value| linear[value as usize]);
        Picture::new(size, (0..size[0] * size[1]).map(pixel))
    }

    fn board(x: u32, y: u32) -> [u32; 3] {
        [if (x / 12 + y / 9).is_multiple_of(2) { 40 } else { 200 }, 5 * x, 7 * y]
    }

    fn noise(i: u32) -> u32 {
        let mut x = i.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
        x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
        x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
        x ^ x >> 16
    }

    // Expected: the authors' C++ program, as crate nv-flip 0.1.2 calls it.
    #[test]
    fn patterns_get_the_error_that_the_authors_program_tells() {
        let right = picture(SIZE, board);
        let noisy = picture(SIZE, |x, y| {
            let place = 3 * (y * SIZE[0] + x);
            let of = board(x, y);
            [0, 1, 2].map(|c| (of[c as usize] + noise(place + c) % 41).saturating_sub(20).min(255))
        });
        let shifted = picture(SIZE, |x, y| board(x.saturating_sub(1), y));
        let grey = picture(SIZE, |x, y| [board(x, y).iter().sum::<u32>() / 3; 3]);
        let dot = picture(SIZE, |x, y| if (x, y) == (24, 18) { [255; 3] } else { board(x, y) });
        for (image, expected) in
            [(noisy, 0.106_904), (shifted, 0.176_119), (grey, 0.706_776), (dot, 0.003_039)]
        {
            let got = flip(&right, &image);
            assert!((got - expected).abs() < 2e-4, "{got}, not {expected}");
        }
        assert_eq!(flip(&right, &right), 0.0);
    }

    #[test]
    fn flat_colours_get_the_error_that_the_authors_program_tells() {
        let flat = |colour: [u32; 3]| picture([8, 8], |_, _| colour);
        for (a, b, expected) in [
            ([255, 0, 0], [0, 255, 0], 0.986_665),
            ([0, 255, 0], [0, 0, 255], 1.0),
            ([100, 100, 100], [110, 100, 100], 0.116_359),
            ([0, 0, 0], [255, 255, 255], 0.967_388),
        ] {
            let got = flip(&flat(a), &flat(b));
            assert!((got - expected).abs() < 2e-4, "{got}, not {expected}");
        }
    }
}
