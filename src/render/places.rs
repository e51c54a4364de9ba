//! Where the samples of pixels go through the image.

use super::scatter::Series;
use crate::{
    kernels::{Kernel, SUB, Simd, TILE_RAYS},
    shade::{Purpose, Samples, Shot, pixel_keys},
};

/// Places of a packet's rays, in pixels from the centre of the image's first one: rounded alike in every packet, so that the
/// image has one hash.
pub(super) struct Places<'a> {
    pub(super) shots: &'a [Shot],
    pub(super) series: Series,
    pub(super) to: &'a mut [[f32; TILE_RAYS]; 2],
}

impl Kernel for Places<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let [x, y] = self.to;
        let to = x.as_chunks_mut::<SUB>().0.iter_mut().zip(y.as_chunks_mut::<SUB>().0);
        for (shots, (x, y)) in self.shots.as_chunks::<SUB>().0.iter().zip(to) {
            [*x, *y] = Block::new(shots, self.series.seed).places(self.series.samples);
        }
    }
}

/// Places of sixteen rays as [`Places`] has them, and squares for their way through the lens.
pub(super) struct LensPlaces<'a> {
    pub(super) shots: &'a [Shot; SUB],
    pub(super) series: Series,
}

impl Kernel for LensPlaces<'_> {
    type Output = [[[f32; SUB]; 2]; 2];

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> [[[f32; SUB]; 2]; 2] {
        let Series { samples, seed } = self.series;
        let block = Block::new(self.shots, seed);
        let lens = Samples::new(samples, Purpose::Lens as u32).squares(&block.keys, &block.numbers);
        [block.places(samples), lens]
    }
}

/// Sixteen rays.
struct Block {
    pixels: [[u32; SUB]; 2],
    numbers: [u32; SUB],
    keys: [u32; SUB],
}

impl Block {
    #[inline(always)]
    fn new(shots: &[Shot; SUB], seed: u64) -> Block {
        let (mut x, mut y, mut numbers) = ([0; SUB], [0; SUB], [0; SUB]);
        for lane in 0..SUB {
            [x[lane], y[lane]] = shots[lane].pixel;
            numbers[lane] = shots[lane].number;
        }
        Block { pixels: [x, y], numbers, keys: pixel_keys(&x, &y, seed) }
    }

    #[inline(always)]
    fn places(&self, samples: u32) -> [[f32; SUB]; 2] {
        let mut places = [[0.0; SUB]; 2];
        let moved = match samples {
            // A single one goes through the centre.
            1 => [[0.5; SUB]; 2],
            _ => Samples::new(samples, Purpose::Pixel as u32).squares(&self.keys, &self.numbers),
        };
        for axis in 0..2 {
            for lane in 0..SUB {
                places[axis][lane] = self.pixels[axis][lane] as f32 + (moved[axis][lane] - 0.5);
            }
        }
        places
    }
}
