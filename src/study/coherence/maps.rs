//! Figures 15 to 30 of the thesis as images.

use crate::film::Film;
use crate::tile::Tile;

/// Colours of the map of lights, by their number, as 8-bit sRGB: 0 black, then from blue over green to red, 8 and more
/// white.
const COLORS: [[u8; 3]; 9] = [
    [0, 0, 0],
    [0, 0, 255],
    [0, 128, 255],
    [0, 200, 120],
    [0, 220, 0],
    [220, 220, 0],
    [255, 128, 0],
    [255, 0, 0],
    [255, 255, 255],
];

/// Pixels of the legend's height and of each of its fields' width.
const LEGEND: [u32; 2] = [16, 28];

/// Digits 0 to 8 and the sign +, three columns by five rows, a row per octal digit from the top.
const GLYPHS: [u32; 10] =
    [0o75557, 0o26227, 0o71747, 0o71717, 0o55711, 0o74717, 0o74757, 0o71111, 0o75757, 0o02720];

/// Blue where a pixel hits the same triangle as the one before it, black elsewhere (figures 15 to 22).
///
/// # Panics
/// If there are not as many values as pixels.
pub fn primary_map(same: &[bool], size: [u32; 2]) -> Film {
    let blue = |&same: &bool| if same { [0, 0, 255] } else { [0, 0, 0] };
    film(size, &same.iter().map(blue).collect::<Vec<_>>())
}

/// The number of lights occluded by the same triangle as for the pixel before, as colours, with a legend below (figures
/// 23 to 30).
///
/// # Panics
/// If there are not as many values as pixels.
pub fn shadow_map(lights: &[u16], [width, height]: [u32; 2]) -> Film {
    let color = |number: usize| COLORS[number.min(COLORS.len() - 1)];
    assert_eq!(lights.len(), width as usize * height as usize, "a number for each pixel");
    let wide = width.max(LEGEND[1] * COLORS.len() as u32);
    let mut pixels = vec![[40; 3]; wide as usize * (height + LEGEND[0]) as usize];
    for (row, lights) in lights.chunks_exact(width as usize).enumerate() {
        for (pixel, &lights) in pixels[row * wide as usize..].iter_mut().zip(lights) {
            *pixel = color(lights as usize);
        }
    }
    for number in 0..COLORS.len() {
        let left = number as u32 * LEGEND[1];
        for y in 2..LEGEND[0] - 2 {
            for x in 1..12 {
                pixels[((height + y) * wide + left + x) as usize] = color(number);
            }
        }
        let mut text = vec![number];
        text.extend((number == COLORS.len() - 1).then_some(9));
        for (place, glyph) in text.into_iter().enumerate() {
            let at = [left + 14 + 7 * place as u32, height + 3];
            write(&mut pixels, wide, at, GLYPHS[glyph]);
        }
    }
    film([wide, height + LEGEND[0]], &pixels)
}

/// Writes a glyph, each of its dots two pixels wide and high.
fn write(pixels: &mut [[u8; 3]], width: u32, [left, top]: [u32; 2], glyph: u32) {
    for y in 0..10 {
        for x in 0..6 {
            if glyph >> (3 * (4 - y / 2) + 2 - x / 2) & 1 != 0 {
                pixels[((top + y) * width + left + x) as usize] = [230; 3];
            }
        }
    }
}

fn film([width, height]: [u32; 2], pixels: &[[u8; 3]]) -> Film {
    let film = Film::new(width, height);
    let plane = |k: usize| pixels.iter().map(|pixel| linear(pixel[k])).collect::<Vec<f32>>();
    film.write_tile(Tile { x: 0, y: 0, width, height }, &plane(0), &plane(1), &plane(2));
    film
}

/// The linear value of 8-bit sRGB (IEC 61966-2-1).
fn linear(srgb: u8) -> f32 {
    let s = f32::from(srgb) / 255.0;
    if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::linear_to_srgb8;

    fn bytes(film: &Film, x: u32, y: u32) -> [u8; 3] {
        film.row(y).nth(x as usize).unwrap().map(linear_to_srgb8)
    }

    #[test]
    fn colours_survive_the_film() {
        for byte in 0..=255 {
            assert_eq!(linear_to_srgb8(linear(byte)), byte);
        }
    }

    #[test]
    fn pixels_have_the_colour_of_their_number_and_the_legend_says_which() {
        let film = shadow_map(&[0, 1, 7, 11], [2, 2]);
        let pixels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| bytes(&film, x, y));
        assert_eq!(pixels, [COLORS[0], COLORS[1], COLORS[7], COLORS[8]]);
        for (number, color) in COLORS.into_iter().enumerate() {
            assert_eq!(bytes(&film, number as u32 * LEGEND[1] + 4, 2 + 8), color);
        }
        let blue = primary_map(&[true, false], [2, 1]);
        assert_eq!([bytes(&blue, 0, 0), bytes(&blue, 1, 0)], [[0, 0, 255], [0, 0, 0]]);
    }
}
