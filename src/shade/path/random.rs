//! Stratified samples that are a hash of pixel, sample, dimension and seed: nothing depends on the order in which they are
//! taken.
//!
//! A ray carries a *key*, a hash of the seed, its pixel and the branches of its path. All samples of one purpose at one
//! surface, over all samples of the pixel, form one set that is stratified in two dimensions: A. Kensler, "Correlated
//! Multi-Jittered Sampling", Pixar 13-01 (2013). Sets of different keys and purposes are shuffled apart.

use crate::kernels::SUB;

/// What samples are for; each purpose has its own shuffle.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub(crate) enum Purpose {
    /// Places within the pixel.
    Pixel = 1,
    /// Places on the lens.
    Lens,
    /// Directions of the sky.
    Sky,
    /// Directions of ambient light.
    Ambient,
    /// Micro-normals of a rough surface.
    Gloss,
    /// Directions of diffuse reflection.
    Bounce,
    /// Places on emitting triangles.
    Emitter,
    /// Which emitting triangle.
    Choice,
    /// Places on area light number 0; others follow.
    Light = 64,
}

/// Mixes two numbers into one (the finaliser of MurmurHash3).
#[inline(always)]
pub(crate) fn mix(a: u32, b: u32) -> u32 {
    let mut h = a ^ b.wrapping_mul(0x9e37_79b9).rotate_left(15);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// The key of the camera rays of a pixel.
#[inline(always)]
pub(super) fn pixel_key(x: u32, y: u32, seed: u64) -> u32 {
    mix(mix(mix(mix(0x1234_5678, seed as u32), (seed >> 32) as u32), x), y)
}

/// Sets of `count` samples of the unit square, one for each key, drawn from sixteen keys at a time.
///
/// The loops below run over sixteen lanes without branches, so that inside of a [`Kernel`](crate::kernels::Kernel) the compiler
/// makes them instructions of its instruction set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    count: u32,
    /// Cells per row and column; as many as `count` or a few more.
    cells: [u32; 2],
    purpose: u32,
}

/// A number for each lane.
pub(crate) type Lanes = [u32; SUB];

impl Samples {
    /// Sets of this size for this purpose.
    pub(crate) fn new(count: u32, purpose: u32) -> Samples {
        let columns = (f64::from(count).sqrt() as u32).max(1);
        Samples { count, cells: [columns, count.div_ceil(columns)], purpose }
    }

    /// Of each key's set the sample of that number < `count`: each coordinate in [0, 1).
    #[inline(always)]
    pub(crate) fn squares(&self, keys: &Lanes, numbers: &Lanes) -> [[f32; SUB]; 2] {
        let [m, n] = self.cells;
        let patterns = mix_all(keys, self.purpose);
        let s = permute(*numbers, self.count, &times(&patterns, 0x5163_3e2d));
        let row = quotient(&s, m);
        let mut column = [0; SUB];
        for lane in 0..SUB {
            column[lane] = s[lane] - row[lane] * m;
        }
        let column = permute(column, m, &times(&patterns, 0x68bc_21eb));
        let row = permute(row, n, &times(&patterns, 0x02e5_be93));
        let (mut x, mut y) = ([0.0; SUB], [0.0; SUB]);
        for lane in 0..SUB {
            let jitter = |factor| unit(mix(s[lane], patterns[lane].wrapping_mul(factor)));
            let (jx, jy) = (jitter(0x967a_889b), jitter(0x368c_c8b7));
            let across = (column[lane] as f32 + (row[lane] as f32 + jx) / n as f32) / m as f32;
            // By s, not by cell: no part of the square is left out where there are more cells than samples.
            let down = (s[lane] as f32 + jy) / self.count as f32;
            (x[lane], y[lane]) = (across.min(BELOW_ONE), down.min(BELOW_ONE));
        }
        [x, y]
    }

    /// One coordinate in [0, 1) of each key's sample of that number, stratified over all of them.
    #[inline(always)]
    pub(crate) fn lines(&self, keys: &Lanes, numbers: &Lanes) -> [f32; SUB] {
        let patterns = mix_all(keys, self.purpose);
        let s = permute(*numbers, self.count, &times(&patterns, 0x5163_3e2d));
        let mut line = [0.0; SUB];
        for lane in 0..SUB {
            let jitter = unit(mix(s[lane], patterns[lane].wrapping_mul(0x967a_889b)));
            line[lane] = ((s[lane] as f32 + jitter) / self.count as f32).min(BELOW_ONE);
        }
        line
    }
}

/// The keys of the camera rays of pixels; see [`pixel_key`].
#[inline(always)]
pub(crate) fn pixel_keys(x: &Lanes, y: &Lanes, seed: u64) -> Lanes {
    let mut keys = [0; SUB];
    for lane in 0..SUB {
        keys[lane] = pixel_key(x[lane], y[lane], seed);
    }
    keys
}

#[inline(always)]
fn mix_all(a: &Lanes, b: u32) -> Lanes {
    let mut mixed = [0; SUB];
    for lane in 0..SUB {
        mixed[lane] = mix(a[lane], b);
    }
    mixed
}

#[inline(always)]
fn times(a: &Lanes, factor: u32) -> Lanes {
    let mut product = [0; SUB];
    for lane in 0..SUB {
        product[lane] = a[lane].wrapping_mul(factor);
    }
    product
}

const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// In [0, 1).
#[inline(always)]
fn unit(bits: u32) -> f32 {
    // Below 2^24: exact, also as a signed number, which more instruction sets convert.
    (bits >> 8) as i32 as f32 / (1u32 << 24) as f32
}

/// Each lane's place in a permutation of 0..`len` that depends on `p` (Kensler, section 3). Who begins out of range may never come
/// back into it.
#[inline(always)]
fn permute(mut i: Lanes, len: u32, p: &Lanes) -> Lanes {
    debug_assert!(len <= 1 || i.iter().all(|&i| i < len), "{i:?} of {len}");
    if len <= 1 {
        return [0; SUB];
    }
    let w = u32::MAX >> (len - 1).leading_zeros();
    for lane in 0..SUB {
        i[lane] = scramble(i[lane], w, p[lane]);
    }
    // Those that have left the range go on until they come back.
    while i.iter().fold(0, |most, &i| if i > most { i } else { most }) >= len {
        for lane in 0..SUB {
            let next = scramble(i[lane], w, p[lane]);
            i[lane] = if i[lane] < len { i[lane] } else { next };
        }
    }
    if len.is_power_of_two() {
        for lane in 0..SUB {
            i[lane] = i[lane].wrapping_add(p[lane]) & (len - 1);
        }
    } else {
        let whole = quotient(p, len);
        for lane in 0..SUB {
            let sum = u64::from(i[lane]) + u64::from(p[lane] - whole[lane] * len);
            i[lane] = (if sum < u64::from(len) { sum } else { sum - u64::from(len) }) as u32;
        }
    }
    i
}

/// Each lane divided by `by`, rounded down. (a + 1/2) / by is at least 1 / (2 by) from any whole number, and the product with the rounded
/// reciprocal is off by at most 2^-52 of itself, which is less than 2^-20 / by.
#[inline(always)]
fn quotient(a: &Lanes, by: u32) -> Lanes {
    let inverse = 1.0 / f64::from(by);
    let mut quotients = [0; SUB];
    for lane in 0..SUB {
        quotients[lane] = ((f64::from(a[lane]) + 0.5) * inverse) as u32;
    }
    quotients
}

/// A permutation of 0..=`w`, which is a power of two minus 1.
#[inline(always)]
fn scramble(mut i: u32, w: u32, p: u32) -> u32 {
    i ^= p;
    i = i.wrapping_mul(0xe170_893d);
    i ^= p >> 16;
    i ^= (i & w) >> 4;
    i ^= p >> 8;
    i = i.wrapping_mul(0x0929_eb3f);
    i ^= p >> 23;
    i ^= (i & w) >> 1;
    i = i.wrapping_mul(1 | p >> 27);
    i = i.wrapping_mul(0x6935_fa69);
    i ^= (i & w) >> 11;
    i = i.wrapping_mul(0x74dc_b303);
    i ^= (i & w) >> 2;
    i = i.wrapping_mul(0x9e50_1cc3);
    i ^= (i & w) >> 2;
    i = i.wrapping_mul(0xc860_a3df);
    i &= w;
    i ^ (i >> 5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{Isa, Kernel, Kernels, Simd};

    /// The definition, for one key: a set of `count` samples of the unit square.
    #[derive(Clone, Copy, Debug)]
    struct One {
        count: u32,
        /// Cells per row and column; as many as `count` or a few more.
        cells: [u32; 2],
        pattern: u32,
    }

    impl One {
        fn new(count: u32, key: u32, purpose: u32) -> One {
            let columns = (f64::from(count).sqrt() as u32).max(1);
            One { count, cells: [columns, count.div_ceil(columns)], pattern: mix(key, purpose) }
        }

        /// Sample number `index` < `count`: each coordinate in [0, 1).
        fn get(&self, index: u32) -> [f32; 2] {
            let [m, n] = self.cells;
            let pattern = self.pattern;
            let s = permute_one(index, self.count, pattern.wrapping_mul(0x5163_3e2d));
            let column = permute_one(s % m, m, pattern.wrapping_mul(0x68bc_21eb));
            let row = permute_one(s / m, n, pattern.wrapping_mul(0x02e5_be93));
            let jx = unit(mix(s, pattern.wrapping_mul(0x967a_889b)));
            let jy = unit(mix(s, pattern.wrapping_mul(0x368c_c8b7)));
            let x = (column as f32 + (row as f32 + jx) / n as f32) / m as f32;
            // By s, not by cell: no part of the square is left out where there are more cells than samples.
            let y = (s as f32 + jy) / self.count as f32;
            [x.min(BELOW_ONE), y.min(BELOW_ONE)]
        }

        /// One coordinate in [0, 1) of sample number `index`, stratified over all of them.
        fn line(&self, index: u32) -> f32 {
            let s = permute_one(index, self.count, self.pattern.wrapping_mul(0x5163_3e2d));
            let jitter = unit(mix(s, self.pattern.wrapping_mul(0x967a_889b)));
            ((s as f32 + jitter) / self.count as f32).min(BELOW_ONE)
        }
    }

    /// One lane of a permutation.
    fn permute_one(mut i: u32, len: u32, p: u32) -> u32 {
        if len <= 1 {
            return 0;
        }
        loop {
            i = scramble(i, len.next_power_of_two() - 1, p);
            if i < len {
                return ((u64::from(i) + u64::from(p)) % u64::from(len)) as u32;
            }
        }
    }

    /// Sixteen samples by an instruction set.
    struct Draw(Samples, Lanes, Lanes);

    impl Kernel for Draw {
        type Output = ([[f32; SUB]; 2], [f32; SUB]);

        #[inline(always)]
        fn run<S: Simd>(self, _: S) -> ([[f32; SUB]; 2], [f32; SUB]) {
            (self.0.squares(&self.1, &self.2), self.0.lines(&self.1, &self.2))
        }
    }

    #[test]
    fn sixteen_at_a_time_are_those_of_the_definition_to_the_bit() {
        for count in [1u32, 2, 3, 4, 5, 7, 8, 12, 16, 20, 31, 36, 60, 64, 100, 144, 257, 4096] {
            for round in 0..20 {
                let keys: Lanes = std::array::from_fn(|lane| mix(lane as u32, round));
                let numbers: Lanes = std::array::from_fn(|lane| mix(round, lane as u32) % count);
                for isa in Isa::available() {
                    let kernels = Kernels::for_isa(isa).unwrap();
                    let ([x, y], line) = kernels.run(Draw(Samples::new(count, 5 + round), keys, numbers));
                    for lane in 0..SUB {
                        let one = One::new(count, keys[lane], 5 + round);
                        let want = one.get(numbers[lane]).map(f32::to_bits);
                        assert_eq!([x[lane], y[lane]].map(f32::to_bits), want, "{isa} {count} {lane}");
                        assert_eq!(line[lane].to_bits(), one.line(numbers[lane]).to_bits(), "{isa} {count}");
                    }
                }
            }
        }
    }

    /// What all samples of one set have, sixteen at a time.
    fn all<T>(count: u32, draw: impl Fn(&Lanes) -> [T; SUB]) -> Vec<T> {
        let firsts = (0..count).step_by(SUB);
        let lanes = firsts.map(|first| std::array::from_fn(|lane| (first + lane as u32).min(count - 1)));
        lanes.flat_map(|numbers| draw(&numbers)).take(count as usize).collect()
    }

    /// All samples of the set of a key.
    fn squares(count: u32, key: u32, purpose: u32) -> Vec<[f32; 2]> {
        let samples = Samples::new(count, purpose);
        all(count, |numbers| {
            let [x, y] = samples.squares(&[key; SUB], numbers);
            std::array::from_fn(|lane| [x[lane], y[lane]])
        })
    }

    #[test]
    fn permutations_are_permutations() {
        for len in [1, 2, 3, 7, 16, 60, 257] {
            for p in [0, 1, 0x9e37_79b9, u32::MAX] {
                let mut seen = all(len, |numbers| permute(*numbers, len, &[p; SUB]));
                seen.sort_unstable();
                assert!(seen.into_iter().eq(0..len), "{len}, {p}");
            }
        }
    }

    #[test]
    fn quotients_are_whole_ones() {
        for by in [1u32, 2, 3, 5, 12, 20, 49, 98, 257, 65_537, u32::MAX - 1, u32::MAX] {
            for near in [0, by, by.wrapping_mul(2), u32::MAX / by * by, u32::MAX] {
                let a = std::array::from_fn(|lane| near.wrapping_add(lane as u32).wrapping_sub(8));
                assert_eq!(quotient(&a, by), a.map(|a| a / by), "{a:?} by {by}");
            }
        }
    }

    #[test]
    fn samples_are_stratified_in_two_dimensions() {
        for (count, key) in [(16u32, 1), (36, 2), (144, 3)] {
            let all_of_them = squares(count, key, 5);
            let side = (count as f32).sqrt() as usize;
            let cell = |x: f32, cells: usize| (x * cells as f32) as usize;
            let mut cells: Vec<usize> =
                all_of_them.iter().map(|[x, y]| cell(*x, side) + side * cell(*y, side)).collect();
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..count as usize), "one in each cell");
            for axis in 0..2 {
                // Kensler's rows are jittered, so that a rounding may lead to the next one.
                let mut rows: Vec<usize> =
                    all_of_them.iter().map(|of| cell(of[axis], count as usize)).collect();
                rows.sort_unstable();
                rows.dedup();
                assert!(rows.len() * 10 >= count as usize * 9, "about one in each row: {}", rows.len());
            }
            let samples = Samples::new(count, 5);
            let line = all(count, |numbers| samples.lines(&[key; SUB], numbers));
            let mut line: Vec<usize> = line.into_iter().map(|x| cell(x, count as usize)).collect();
            line.sort_unstable();
            assert!(line.into_iter().eq(0..count as usize));
        }
    }

    #[test]
    fn sets_of_two_purposes_have_nothing_to_do_with_each_other() {
        let pairs = squares(4096, 9, 1).into_iter().zip(squares(4096, 9, 2));
        let mean: f64 = pairs.map(|(a, b)| f64::from(a[0] * b[0])).sum::<f64>() / 4096.0;
        assert!((mean - 0.25).abs() < 0.01, "{mean}");
    }
}
