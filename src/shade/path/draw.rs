//! Samples for all rays of a generation.

use super::{queue::State, random::Samples, source::Squares};
use crate::kernels::{Kernel, SUB, Simd};

/// Which sample each ray takes: number `index` of `count`, for each sample of its pixel.
#[derive(Clone, Copy)]
pub(super) struct Draw<'a> {
    pub(super) states: &'a [State],
    pub(super) samples: Samples,
    pub(super) index: u32,
    pub(super) count: u32,
}

impl Draw<'_> {
    /// Calls `put` with the place of every sixteenth ray, keys and numbers of it and those behind it.
    #[inline(always)]
    fn each(self, mut put: impl FnMut(usize, usize, [u32; SUB], [u32; SUB])) {
        for (block, states) in self.states.chunks(SUB).enumerate() {
            let (mut keys, mut numbers) = ([0; SUB], [0; SUB]);
            for (lane, state) in states.iter().enumerate() {
                keys[lane] = state.key;
                numbers[lane] = state.number * self.count + self.index;
            }
            put(block * SUB, states.len(), keys, numbers);
        }
    }
}

/// Two numbers for each ray.
pub(super) struct DrawSquares<'a>(pub(super) Draw<'a>, pub(super) &'a mut Squares);

impl Kernel for DrawSquares<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let DrawSquares(draw, to) = self;
        draw.each(|first, len, keys, numbers| {
            let squares = draw.samples.squares(&keys, &numbers);
            for (to, from) in to.iter_mut().zip(squares) {
                to[first..first + len].copy_from_slice(&from[..len]);
            }
        });
    }
}

/// One number for each ray.
pub(super) struct DrawLines<'a>(pub(super) Draw<'a>, pub(super) &'a mut [f32]);

impl Kernel for DrawLines<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let DrawLines(draw, to) = self;
        draw.each(|first, len, keys, numbers| {
            to[first..first + len].copy_from_slice(&draw.samples.lines(&keys, &numbers)[..len]);
        });
    }
}
