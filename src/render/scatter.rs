//! How many samples a pixel needs: some, and if these scatter, all.
//!
//! The mean of n stratified samples is off by about their standard deviation / n^0.7, so that samples are best spent where
//! they scatter. Three eighths of them tell where. Taking these at pixels whose samples agree, and all of them elsewhere, is a
//! two-stage form of adaptive sampling by variance (D. P. Mitchell, "Generating Antialiased Images at Low Sampling
//! Densities", SIGGRAPH 1987, has two levels, too).

/// Samples scatter if their standard deviation is more than this many times what pixels beside each other may differ by.
const SCATTER: f32 = 6.0;

/// Fewer samples than this do not tell how they scatter.
const FEW: u32 = 4;

/// Samples of pixels that are stratified together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Series {
    /// Of each pixel.
    pub(super) samples: u32,
    pub(super) seed: u64,
}

impl Series {
    /// The first of `samples` samples, and the rest unless these are all: each stratified on its own.
    pub(super) fn parts(samples: u32, seed: u64) -> (Series, Option<Series>) {
        let first = (u64::from(samples) * 3 / 8) as u32;
        let first = first.max(FEW).min(samples);
        let rest = Series { samples: samples - first, seed: seed ^ 0x5bd1_e995_9e37_79b9 };
        (Series { samples: first, seed }, Some(rest).filter(|rest| rest.samples > 0))
    }
}

/// Sums over samples of pixels.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    pixels: Vec<Sum>,
}

/// Over samples of one pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    samples: u32,
    color: [f32; 3],
    /// Of square roots of colours, which is about how they are seen, and of the squares of those.
    seen: [[f32; 2]; 3],
}

impl Sums {
    /// Nothing is added up yet for `len` pixels.
    pub(super) fn begin(&mut self, len: usize) {
        self.pixels.clear();
        self.pixels.resize(len, Sum::default());
    }

    /// Adds samples of pixel number `at`, by channel.
    pub(super) fn add(&mut self, at: u32, samples: [&[f32]; 3]) {
        let sum = &mut self.pixels[at as usize];
        sum.samples += samples[0].len() as u32;
        for (k, channel) in samples.into_iter().enumerate() {
            let (mut color, [mut seen, mut squares]) = (sum.color[k], sum.seen[k]);
            for &value in channel {
                let visible = value.clamp(0.0, 1.0);
                color += value;
                seen += visible.sqrt();
                squares += visible;
            }
            (sum.color[k], sum.seen[k]) = (color, [seen, squares]);
        }
    }

    /// Whether the samples of a pixel scatter, in a picture where `least` is a difference that is seen.
    pub(super) fn scatters(&self, at: u32, least: f32) -> bool {
        let Sum { samples, seen, .. } = self.pixels[at as usize];
        let [count, degrees] = [samples, samples - 1].map(|n| n as f32);
        let most = (SCATTER * least).powi(2) * degrees;
        // A pixel without a colour (NaN) has none with more samples.
        seen.iter().any(|[sum, squares]| squares - sum * sum / count > most)
    }

    /// Of each pixel how many samples it has, and their mean colour.
    pub(super) fn means(&self) -> impl Iterator<Item = (u32, [f32; 3])> {
        self.pixels.iter().map(|sum| {
            let share = 1.0 / sum.samples as f32;
            (sum.samples, sum.color.map(|color| color * share))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_samples_and_the_rest_are_all_of_them() {
        for samples in [1, 2, 3, 4, 5, 8, 16, 20, 32, 1000, u32::MAX] {
            let (first, rest) = Series::parts(samples, 3);
            assert_eq!(first.samples + rest.map_or(0, |rest| rest.samples), samples);
            assert_eq!(first.seed, 3, "{samples} are taken as in an image of so many everywhere");
            assert_ne!(rest.map(|rest| rest.seed), Some(3), "the same places again tell nothing new");
            assert!(first.samples >= samples.min(FEW));
        }
        assert_eq!(Series::parts(32, 0).0.samples, 12);
    }

    #[test]
    fn samples_scatter_by_their_standard_deviation_as_it_is_seen() {
        // By two passes, in f64; only what a screen shows.
        let deviation = |colors: &[f32]| {
            let seen: Vec<f64> = colors.iter().map(|&v| f64::from(v.clamp(0.0, 1.0)).sqrt()).collect();
            let mean = seen.iter().sum::<f64>() / seen.len() as f64;
            (seen.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (seen.len() - 1) as f64).sqrt()
        };
        let sets: [&[f32]; 5] = [
            &[0.25, 0.36, 0.3, 0.5],
            &[0.0, 0.0, 0.0, 0.0, 0.001],
            &[1.0, 7.0, 3.0, 0.98],
            &[0.9, 0.1, 0.9, 0.1, 0.5, 0.4],
            &[-0.5, 0.0, 0.002, 0.01],
        ];
        for (channel, colors) in (0..3).cycle().zip(sets) {
            let mut sums = Sums::default();
            sums.begin(2);
            for &color in colors {
                let mut rgb = [0.5; 3];
                rgb[channel] = color;
                sums.add(1, rgb.each_ref().map(std::slice::from_ref));
                sums.add(0, [&[0.75]; 3]);
            }
            let limit = (deviation(colors) / f64::from(SCATTER)) as f32;
            assert!(sums.scatters(1, limit * 0.99) && !sums.scatters(1, limit * 1.01), "{colors:?}");
            assert!(!sums.scatters(0, 1e-4));
            let mean = colors.iter().sum::<f32>() / colors.len() as f32;
            let means: Vec<_> = sums.means().collect();
            assert!((means[1].1[channel] - mean).abs() < 1e-6 && means[0].1 == [0.75; 3], "{means:?}");
            assert!(means.iter().all(|(samples, _)| *samples as usize == colors.len()));
        }
    }

    #[test]
    fn a_pixel_without_a_colour_is_left_so() {
        let mut sums = Sums::default();
        sums.begin(1);
        sums.add(0, [&[f32::NAN; 4], &[0.0, 0.1, 0.2, 0.3], &[0.0; 4]]);
        assert!(sums.means().next().unwrap().1[0].is_nan());
    }
}
