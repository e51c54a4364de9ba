//! Differences as colours.

use crate::film::Film;
use crate::math::srgb8_to_linear;
use crate::tile::Tile;

/// From nothing to the greatest difference, as 8-bit sRGB: black, violet, red, orange, yellow, white.
const COLORS: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [70.0, 20.0, 110.0],
    [180.0, 40.0, 80.0],
    [240.0, 115.0, 30.0],
    [250.0, 205.0, 60.0],
    [255.0, 255.0, 255.0],
];
/// The least difference that is not black, as a power of two: a difference of eight bits cannot show less.
const LEAST: f32 = -10.0;

/// The colour of a difference in linear values, by its logarithm: black below 1/1024, white at 1.
pub fn heat_color(difference: f32) -> [u8; 3] {
    if difference.is_nan() || difference <= LEAST.exp2() {
        return [0; 3];
    }
    let place = (1.0 - difference.log2() / LEAST).clamp(0.0, 1.0) * (COLORS.len() - 1) as f32;
    let first = (place as usize).min(COLORS.len() - 2);
    let share = place - first as f32;
    [0, 1, 2].map(|c| (COLORS[first][c] + share * (COLORS[first + 1][c] - COLORS[first][c])).round() as u8)
}

/// A map of differences.
///
/// # Panics
/// If there is not one for each pixel.
pub fn heat(differences: &[f32], [width, height]: [u32; 2]) -> Film {
    assert_eq!(differences.len(), width as usize * height as usize, "a difference for each pixel");
    let linear = srgb8_to_linear();
    let plane = |c: usize| -> Vec<f32> {
        differences.iter().map(|&difference| linear[usize::from(heat_color(difference)[c])]).collect()
    };
    let film = Film::new(width, height);
    film.write_tile(Tile { x: 0, y: 0, width, height }, &plane(0), &plane(1), &plane(2));
    film
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greater_differences_are_brighter() {
        let all = [0.0, 0.0009, 0.002, 0.01, 0.05, 0.25, 0.6, 1.0].map(heat_color);
        assert_eq!((all[0], all[1], all[7]), ([0; 3], [0; 3], [255; 3]));
        let sum = |color: &[u8; 3]| color.iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!(all[1..].is_sorted_by(|a, b| sum(a) < sum(b)), "{all:?}");
        assert_eq!(heat_color(f32::NAN), [0; 3]);
        let film = heat(&[0.0, 1.0], [2, 1]);
        assert_eq!(film.pixels().collect::<Vec<_>>(), [[0.0; 3], [1.0; 3]]);
    }
}
