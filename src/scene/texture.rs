//! Images on surfaces: pixels with smaller and smaller copies of themselves, so that far away a mean is seen, not a sample.

use glam::Vec2;

/// What lies beyond the edges of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The pixels at its edge.
    Clamp,
}

/// An image to be looked up by texture coordinates: linear red, green, blue and opacity.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name for messages, mostly that of its file.
    pub name: String,
    wrap: Wrap,
    /// From the full image down to one pixel, each half as wide and high as the one before (rounded down, at least 1).
    levels: Vec<Level>,
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: [usize; 2],
    pixels: Vec<[f32; 4]>,
}

impl Texture {
    /// An image of `size` columns and rows, row by row from the top.
    ///
    /// # Panics
    /// If it has no pixel, or not as many as `size` says.
    pub fn new(name: impl Into<String>, size: [u32; 2], pixels: Vec<[f32; 4]>, wrap: Wrap) -> Texture {
        let size = size.map(|side| side as usize);
        assert!(!pixels.is_empty() && pixels.len() == size[0] * size[1], "one value per pixel");
        let mut levels = vec![Level { size, pixels }];
        while let Some(last) = levels.last().filter(|level| level.size != [1, 1]) {
            let half = last.half();
            levels.push(half);
        }
        Texture { name: name.into(), wrap, levels }
    }

    /// Columns and rows of the full image.
    pub fn size(&self) -> [u32; 2] {
        self.levels[0].size.map(|side| side as u32)
    }

    /// The mean around `uv` over about a square with sides of `footprint`, in units of the image's width and height:
    /// linear between pixels and between levels. (0, 0) is the lower left corner. Coordinates that are not finite count as 0.
    ///
    /// Only `+`, `-`, `*` and rounding, so that it is the same on every machine.
    pub fn sample(&self, uv: Vec2, footprint: f32) -> [f32; 4] {
        let [width, height] = self.size();
        let level = log2(footprint * width.max(height) as f32).min((self.levels.len() - 1) as f32);
        let (low, high) = (level as usize, (level as usize + 1).min(self.levels.len() - 1));
        let fine = self.levels[low].sample(uv, self.wrap);
        let share = level - low as f32;
        if share <= 0.0 {
            return fine;
        }
        mix(fine, self.levels[high].sample(uv, self.wrap), share)
    }
}

/// Continuous, rising, and right at powers of two; 0 below 1 and for NaN.
fn log2(x: f32) -> f32 {
    if x.is_nan() || x <= 1.0 {
        return 0.0;
    }
    let exponent = (x.to_bits() >> 23) as f32 - 127.0;
    let mantissa = f32::from_bits(x.to_bits() & 0x007f_ffff | 0x3f80_0000);
    exponent + (mantissa - 1.0)
}

fn mix(a: [f32; 4], b: [f32; 4], share: f32) -> [f32; 4] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * share)
}

impl Level {
    /// Each pixel is the mean of the two to three by two to three that it stands for.
    fn half(&self) -> Level {
        let size = self.size.map(|side| (side / 2).max(1));
        let span =
            |i: usize, axis: usize| i * self.size[axis] / size[axis]..(i + 1) * self.size[axis] / size[axis];
        let mut pixels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let (mut sum, mut count) = ([0.0f32; 4], 0.0f32);
                for row in span(y, 1) {
                    for column in span(x, 0) {
                        let pixel = self.pixels[row * self.size[0] + column];
                        sum = std::array::from_fn(|k| sum[k] + pixel[k]);
                        count += 1.0;
                    }
                }
                pixels.push(sum.map(|sum| sum / count));
            }
        }
        Level { size, pixels }
    }

    fn sample(&self, uv: Vec2, wrap: Wrap) -> [f32; 4] {
        let (x0, x1, fx) = neighbours(uv.x, self.size[0], wrap);
        let (y0, y1, fy) = neighbours(1.0 - uv.y, self.size[1], wrap);
        let pixel = |x: usize, y: usize| self.pixels[y * self.size[0] + x];
        mix(mix(pixel(x0, y0), pixel(x1, y0), fx), mix(pixel(x0, y1), pixel(x1, y1), fx), fy)
    }
}

/// The two pixels of a row whose centres are on either side of `at`, and how far it is from the first to the second.
fn neighbours(at: f32, side: usize, wrap: Wrap) -> (usize, usize, f32) {
    let at = if at.is_finite() { at } else { 0.0 };
    let at = match wrap {
        Wrap::Repeat => at - at.floor(),
        Wrap::Clamp => at.clamp(0.0, 1.0),
    };
    let at = at * side as f32 - 0.5;
    let first = at.floor();
    let inside = |i: isize| match wrap {
        Wrap::Repeat => i.rem_euclid(side as isize) as usize,
        Wrap::Clamp => i.clamp(0, side as isize - 1) as usize,
    };
    (inside(first as isize), inside(first as isize + 1), at - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks(wrap: Wrap) -> Texture {
        let pixel = |i: usize| if (i + i / 2).is_multiple_of(2) { [1.0; 4] } else { [0.0, 0.5, 0.0, 1.0] };
        Texture::new("checks", [2, 2], (0..4).map(pixel).collect(), wrap)
    }

    #[test]
    fn pixels_lie_at_their_centres_and_far_away_the_mean_is_seen() {
        let texture = checks(Wrap::Repeat);
        assert_eq!(texture.sample(Vec2::new(0.25, 0.75), 0.0), [1.0; 4]);
        assert_eq!(texture.sample(Vec2::new(0.25, 0.25), 0.0), [0.0, 0.5, 0.0, 1.0]);
        assert_eq!(texture.sample(Vec2::new(-0.75, 5.75), 0.5), [1.0; 4]);
        let mean = [0.5, 0.75, 0.5, 1.0];
        assert_eq!(texture.sample(Vec2::new(0.5, 0.5), 0.0), mean);
        assert_eq!(texture.sample(Vec2::new(0.1, 0.9), 1.0), mean);
        assert_eq!(texture.sample(Vec2::new(f32::NAN, 0.9), f32::NAN)[3], 1.0);
        assert_eq!(checks(Wrap::Clamp).sample(Vec2::new(-3.0, 9.0), 0.0), [1.0; 4]);
    }
}
