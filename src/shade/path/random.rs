//! Stratified samples that are a hash of pixel, sample, dimension and seed: nothing depends on the order in which they are
//! taken.
//!
//! A ray carries a *key*, a hash of the seed, its pixel and the branches of its path. All samples of one purpose at one
//! surface, over all samples of the pixel, form one set that is stratified in two dimensions: A. Kensler, "Correlated
//! Multi-Jittered Sampling", Pixar 13-01 (2013). Sets of different keys and purposes are shuffled apart.

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
pub(crate) fn mix(a: u32, b: u32) -> u32 {
    let mut h = a ^ b.wrapping_mul(0x9e37_79b9).rotate_left(15);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// The key of the camera rays of a pixel.
pub(crate) fn pixel_key(x: u32, y: u32, seed: u64) -> u32 {
    mix(mix(mix(mix(0x1234_5678, seed as u32), (seed >> 32) as u32), x), y)
}

/// A set of `count` samples of the unit square.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    count: u32,
    /// Cells per row and column; as many as `count` or a few more.
    cells: [u32; 2],
    pattern: u32,
}

impl Samples {
    /// The set for a key and purpose.
    pub(crate) fn new(count: u32, key: u32, purpose: u32) -> Samples {
        let columns = (f64::from(count).sqrt() as u32).max(1);
        Samples { count, cells: [columns, count.div_ceil(columns)], pattern: mix(key, purpose) }
    }

    /// Sample number `index` < `count`: each coordinate in [0, 1).
    pub(crate) fn get(&self, index: u32) -> [f32; 2] {
        let [m, n] = self.cells;
        let pattern = self.pattern;
        let s = permute(index, self.count, pattern.wrapping_mul(0x5163_3e2d));
        let column = permute(s % m, m, pattern.wrapping_mul(0x68bc_21eb));
        let row = permute(s / m, n, pattern.wrapping_mul(0x02e5_be93));
        let jx = unit(mix(s, pattern.wrapping_mul(0x967a_889b)));
        let jy = unit(mix(s, pattern.wrapping_mul(0x368c_c8b7)));
        let x = (column as f32 + (row as f32 + jx) / n as f32) / m as f32;
        // By s, not by cell: no part of the square is left out where there are more cells than samples.
        let y = (s as f32 + jy) / self.count as f32;
        [x.min(BELOW_ONE), y.min(BELOW_ONE)]
    }

    /// One coordinate in [0, 1) of sample number `index`, stratified over all of them.
    pub(crate) fn line(&self, index: u32) -> f32 {
        let s = permute(index, self.count, self.pattern.wrapping_mul(0x5163_3e2d));
        let jitter = unit(mix(s, self.pattern.wrapping_mul(0x967a_889b)));
        ((s as f32 + jitter) / self.count as f32).min(BELOW_ONE)
    }
}

const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// In [0, 1).
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1u32 << 24) as f32
}

/// A permutation of 0..`len` that depends on `p` (Kensler, section 3).
fn permute(mut i: u32, len: u32, p: u32) -> u32 {
    if len <= 1 {
        return 0;
    }
    let mut w = len - 1;
    for shift in [1, 2, 4, 8, 16] {
        w |= w >> shift;
    }
    loop {
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
        i ^= i >> 5;
        if i < len {
            return ((u64::from(i) + u64::from(p)) % u64::from(len)) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permutations_are_permutations() {
        for len in [1, 2, 3, 7, 16, 60, 257] {
            for p in [0, 1, 0x9e37_79b9, u32::MAX] {
                let mut seen: Vec<u32> = (0..len).map(|i| permute(i, len, p)).collect();
                seen.sort_unstable();
                assert!(seen.into_iter().eq(0..len), "{len}, {p}");
            }
        }
    }

    #[test]
    fn samples_are_stratified_in_two_dimensions() {
        for (count, key) in [(16u32, 1), (36, 2), (144, 3)] {
            let samples = Samples::new(count, key, 5);
            let all: Vec<[f32; 2]> = (0..count).map(|i| samples.get(i)).collect();
            let side = (count as f32).sqrt() as usize;
            let cell = |x: f32, cells: usize| (x * cells as f32) as usize;
            let mut cells: Vec<usize> =
                all.iter().map(|[x, y]| cell(*x, side) + side * cell(*y, side)).collect();
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..count as usize), "one in each cell");
            for axis in 0..2 {
                // Kensler's rows are jittered, so that a rounding may lead to the next one.
                let mut rows: Vec<usize> = all.iter().map(|of| cell(of[axis], count as usize)).collect();
                rows.sort_unstable();
                rows.dedup();
                assert!(rows.len() * 10 >= count as usize * 9, "about one in each row: {}", rows.len());
            }
            let mut line: Vec<usize> = (0..count).map(|i| cell(samples.line(i), count as usize)).collect();
            line.sort_unstable();
            assert!(line.into_iter().eq(0..count as usize));
        }
    }

    #[test]
    fn sets_of_two_purposes_have_nothing_to_do_with_each_other() {
        let (a, b) = (Samples::new(4096, 9, 1), Samples::new(4096, 9, 2));
        let mean: f64 = (0..4096).map(|i| f64::from(a.get(i)[0] * b.get(i)[0])).sum::<f64>() / 4096.0;
        assert!((mean - 0.25).abs() < 0.01, "{mean}");
    }
}
