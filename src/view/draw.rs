//! Text and boxes over a picture.

use embedded_graphics::{
    Drawable, Pixel,
    geometry::{OriginDimensions, Point, Size},
    mono_font::{MonoFont, MonoTextStyle, ascii},
    pixelcolor::{Rgb888, RgbColor},
    prelude::DrawTarget,
    text::{Baseline, Text},
};
use std::convert::Infallible;

/// Pixels that can be drawn on: row by row, 0x00rrggbb.
pub struct Surface<'a> {
    /// Width and height.
    pub size: [u32; 2],
    /// Row by row.
    pub pixels: &'a mut [u32],
}

/// Sizes of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// For ordinary screens.
    Small,
    /// For screens with many pixels to the inch.
    Large,
}

impl Scale {
    fn font(self) -> &'static MonoFont<'static> {
        match self {
            Scale::Small => &ascii::FONT_7X14,
            Scale::Large => &ascii::FONT_10X20,
        }
    }

    /// Width and height of a character in pixels.
    pub fn cell(self) -> [u32; 2] {
        let Size { width, height } = self.font().character_size;
        [width, height]
    }
}

impl Surface<'_> {
    /// Darkens a rectangle, so that text on it can be read.
    pub fn shade(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2]) {
        self.change([x, y], [width, height], |pixel| pixel >> 2 & 0x003f_3f3f);
    }

    /// Fills a rectangle with one colour.
    pub fn block(&mut self, at: [u32; 2], size: [u32; 2], color: u32) {
        self.change(at, size, |_| color);
    }

    fn change(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], new: impl Fn(u32) -> u32) {
        let right = x.saturating_add(width).min(self.size[0]);
        for row in y..y.saturating_add(height).min(self.size[1]) {
            let line = row as usize * self.size[0] as usize;
            for pixel in self.pixels.get_mut(line + x as usize..line + right as usize).into_iter().flatten() {
                *pixel = new(*pixel);
            }
        }
    }

    /// Writes lines on a shaded box; (x, y) is its corner. Returns its size.
    pub fn lines(&mut self, [x, y]: [u32; 2], scale: Scale, lines: &[String]) -> [u32; 2] {
        let [w, h] = scale.cell();
        let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0) as u32;
        let size = [(longest + 2) * w, (lines.len() as u32 + 1) * h];
        self.shade([x, y], size);
        for (i, line) in lines.iter().enumerate() {
            let at = [x + w, y + h / 2 + i as u32 * h];
            self.text(at, scale, line);
        }
        size
    }

    /// Writes one line; (x, y) is its upper left corner.
    pub fn text(&mut self, [x, y]: [u32; 2], scale: Scale, text: &str) {
        let style = MonoTextStyle::new(scale.font(), Rgb888::new(235, 235, 225));
        let at = Point::new(x as i32, y as i32);
        match Text::with_baseline(text, at, style, Baseline::Top).draw(self) {
            Ok(_) => {}
            Err(never) => match never {},
        }
    }
}

impl OriginDimensions for Surface<'_> {
    fn size(&self) -> Size {
        Size::new(self.size[0], self.size[1])
    }
}

impl DrawTarget for Surface<'_> {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(Point { x, y }, color) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
                && x < self.size[0]
                && y < self.size[1]
            {
                let rgb = u32::from(color.r()) << 16 | u32::from(color.g()) << 8 | u32::from(color.b());
                self.pixels[(y * self.size[0] + x) as usize] = rgb;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_stays_on_the_picture_wherever_it_is_put() {
        for size in [[1, 1], [40, 20], [300, 5]] {
            let mut pixels = vec![0x0080_8080; (size[0] * size[1]) as usize];
            let mut surface = Surface { size, pixels: &mut pixels };
            for at in [[0, 0], [size[0] - 1, size[1] - 1], [1000, 1000]] {
                surface.lines(at, Scale::Large, &["A line of text".into(), String::new()]);
                surface.block(at, [u32::MAX, u32::MAX], 7);
            }
        }
    }

    #[test]
    fn text_is_light_on_a_darkened_box() {
        let mut pixels = vec![0x0080_8080; 100 * 60];
        let mut surface = Surface { size: [100, 60], pixels: &mut pixels };
        let [width, height] = surface.lines([0, 0], Scale::Small, &["Ii".into()]);
        let inside = |i: usize| (i as u32 % 100) < width && (i as u32 / 100) < height;
        for (i, &pixel) in pixels.iter().enumerate() {
            match pixel {
                0x0080_8080 => assert!(!inside(i), "{i}"),
                0x0020_2020 | 0x00eb_ebe1 => assert!(inside(i), "{i}"),
                other => panic!("{other:x} at {i}"),
            }
        }
        assert!(pixels.contains(&0x00eb_ebe1));
    }
}
