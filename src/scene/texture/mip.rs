//! The chain of ever smaller versions of a picture.
//!
//! A version is half as wide and half as high as the one before, rounded down but at least 1. Each of its texels is
//! the mean of the area that it covers, also where a side is odd, so the mean of the whole stays the same.

/// What 1 is in a texel: half of the range of 16 bits, so that 0, 1/2 and 1 are exact, and all of 8-bit sRGB differs.
pub(super) const ONE: f32 = 32768.0;

/// A value as a channel of a texel, brought into [0, 1] and rounded to nearest; NaN becomes 0.
pub(super) fn encode(value: f32) -> u16 {
    (value.clamp(0.0, 1.0) * ONE + 0.5) as u16
}

/// Linear texels from 0 to [`ONE`]; row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    size: [usize; 2],
    texels: Vec<[u16; 4]>,
}

impl Level {
    /// # Panics
    /// If there is no texel, or not as many as the size says.
    pub(super) fn new(size: [usize; 2], texels: Vec<[u16; 4]>) -> Level {
        assert!(!texels.is_empty() && size[0] * size[1] == texels.len(), "one value per pixel");
        Level { size, texels }
    }

    /// Width and height.
    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// All texels.
    pub(super) fn texels(&self) -> &[[u16; 4]] {
        &self.texels
    }

    /// Half of it, or nothing if it has one texel.
    fn half(&self) -> Option<Level> {
        if self.texels.len() == 1 {
            return None;
        }
        let size = self.size.map(|side| (side / 2).max(1));
        let [across, down] = [0, 1].map(|axis| shares(self.size[axis], size[axis]));
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for rows in &down {
            for columns in &across {
                let mut sum = [0.0f64; 4];
                for &(row, high) in rows {
                    for &(column, wide) in columns {
                        let texel = self.texels[row * self.size[0] + column];
                        for (sum, channel) in sum.iter_mut().zip(texel) {
                            *sum += high * wide * f64::from(channel);
                        }
                    }
                }
                texels.push(sum.map(|channel| (channel + 0.5) as u16));
            }
        }
        Some(Level { size, texels })
    }
}

/// For each of `few` equal parts of a line: which of `many` equal parts it covers, and their shares of its mean.
fn shares(many: usize, few: usize) -> Vec<Vec<(usize, f64)>> {
    let part = |index: usize| {
        // In units of 1 / (many * few) of the line.
        let (begin, end) = (index * many, (index + 1) * many);
        let covered = begin / few..end.div_ceil(few);
        covered
            .map(|source| {
                let overlap = end.min((source + 1) * few) - begin.max(source * few);
                (source, overlap as f64 / many as f64)
            })
            .collect()
    };
    (0..few).map(part).collect()
}

/// The version itself and all smaller ones.
pub(super) fn chain(finest: Level) -> Vec<Level> {
    let mut levels = vec![finest];
    while let Some(half) = levels.last().and_then(Level::half) {
        levels.push(half);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(size: [usize; 2]) -> Level {
        let value = |i: usize| (i.wrapping_mul(2_654_435_761) >> 7) as u16 & 0x7fff;
        Level::new(size, (0..size[0] * size[1]).map(|i| [0, 1, 2, 3].map(|c| value(4 * i + c))).collect())
    }

    fn mean(level: &Level) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for texel in level.texels() {
            for (sum, &c) in sum.iter_mut().zip(texel) {
                *sum += f64::from(c) / level.texels().len() as f64;
            }
        }
        sum
    }

    #[test]
    fn every_version_keeps_the_mean_down_to_one_texel() {
        for size in [[64, 64], [37, 53], [1, 100], [3, 1], [1, 1], [255, 16]] {
            let levels = chain(noise(size));
            let exact = mean(&levels[0]);
            for (n, level) in levels.iter().enumerate() {
                assert_eq!(level.size(), size.map(|side| (side >> n).max(1)));
                for (got, want) in mean(level).into_iter().zip(exact) {
                    assert!((got - want).abs() < 0.51 * n.max(1) as f64, "{size:?} {n}: {got}, not {want}");
                }
            }
            assert_eq!(levels.last().map(|level| level.texels().len()), Some(1));
        }
    }

    #[test]
    fn shares_of_odd_sides_overlap() {
        assert_eq!(shares(4, 2), [[(0, 0.5), (1, 0.5)], [(2, 0.5), (3, 0.5)]]);
        let [third, two_thirds] = [1.0 / 3.0, 2.0 / 3.0];
        assert_eq!(shares(3, 2), [[(0, two_thirds), (1, third)], [(1, third), (2, two_thirds)]]);
        assert_eq!(shares(1, 1), [[(0, 1.0)]]);
    }
}
