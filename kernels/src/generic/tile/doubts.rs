//! Rays that the tile kernel's filters leave in doubt, decided for all rays of a sub-packet and one triangle at once.
//!
//! ```text
//!   doubtful --edge functions and depth in f64, lane = ray--> misses | hits, if nearer beyond doubt | still in doubt
//!      still in doubt: by expansions, and against the plane of the triangle hit so far (see `doubt`)
//! ```
//!
//! With relative corners p and q as f64, the coefficients of det(p, q, d) are differences of exact products, rounded
//! once; for |u|, |v| <= 1 and d = (u, v, 1), two products and two sums are rounded after that. Each is off by at most
//! 2^-53 of what it is computed from, so all together by less than 4 * 2^-53 times the sum of the magnitudes of the six
//! products. Twice that is allowed. No product of floats leaves the range of f64.

use super::{State, rays as rays_of};
use crate::{
    exact::{Canonical, passes, wide},
    generic::{
        Frame,
        doubt::{NO_SLOT, block_of, inverse_interval},
        leaf::triangle,
    },
    node::BvhView,
    packet::{MISS, SUB, TilePacket},
    simd::{Kernel, Simd},
};

/// Triangles remembered.
const ENTRIES: usize = 32;
/// 8 * 2^-53.
const BOUND: f64 = 4.0 * f64::EPSILON;

/// Decides rays of sub-packet `sub` about which the test of the triangle in `slot` is not sure; true if one hits.
pub(super) struct Settle<'a, 'b, const ANY: bool> {
    pub(super) bvh: &'a BvhView<'b>,
    pub(super) packet: &'a TilePacket,
    pub(super) state: &'a mut State,
    pub(super) slot: u32,
    pub(super) sub: usize,
    /// Bit = ray in doubt.
    pub(super) rays: u32,
    /// Bit = ray known to pass through the triangle, at whatever depth.
    pub(super) pierced: u32,
}

/// A triangle in f64.
#[derive(Clone, Copy, Debug)]
struct Contender {
    plane: Canonical,
    /// Coefficients of the edge functions, and how far those may be off.
    normals: [[f64; 3]; 3],
    bound: f64,
    prim: u32,
}

impl Contender {
    #[inline(always)]
    fn new([a, b, c]: [[f32; 3]; 3], prim: u32) -> Contender {
        let mut new = Contender { plane: Canonical::new(a, b, c), normals: [[0.0; 3]; 3], bound: 0.0, prim };
        for (normal, [p, q]) in new.normals.iter_mut().zip([[b, c], [c, a], [a, b]]) {
            let (p, q) = (wide(p), wide(q));
            let mut size = 0.0;
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let (plus, minus) = (p[i] * q[j], p[j] * q[i]);
                normal[k] = plus - minus;
                size += plus.abs() + minus.abs();
            }
            new.bound = new.bound.max(BOUND * size);
        }
        new
    }

    /// Least and greatest edge function along (u, v, 1).
    #[inline(always)]
    fn edges(&self, u: f64, v: f64) -> [f64; 2] {
        let [a, b, c] = self.normals.map(|[x, y, z]| x * u + y * v + z);
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        [if c < low { c } else { low }, if c > high { c } else { high }]
    }
}

/// The triangles in doubt last, by slot.
#[derive(Clone, Debug)]
pub(super) struct Contenders {
    /// Epoch (see `scratch`) and slot.
    tags: [u64; ENTRIES],
    entries: [Contender; ENTRIES],
}

impl Contenders {
    pub(super) fn new() -> Contenders {
        Contenders { tags: [0; ENTRIES], entries: [Contender::new([[0.0; 3]; 3], MISS); ENTRIES] }
    }

    #[inline(always)]
    fn get(&mut self, bvh: &BvhView, frame: &Frame, epoch: u32, slot: u32) -> &Contender {
        let at = slot as usize % ENTRIES;
        let tag = u64::from(epoch) << 32 | u64::from(slot);
        if self.tags[at] != tag {
            self.tags[at] = tag;
            let (block, lane) = block_of(bvh, slot);
            self.entries[at] = Contender::new(triangle(block, lane, frame), block.prim[lane]);
        }
        &self.entries[at]
    }
}

/// Depths of the plane of a contender along the rays of a sub-packet.
#[inline(always)]
fn depths(plane: &Canonical, u: &[f32; SUB], v: &[f32; SUB]) -> [f64; SUB] {
    let mut t = [0.0; SUB];
    for i in 0..SUB {
        t[i] = plane.depth([f64::from(u[i]), f64::from(v[i]), 1.0]);
    }
    t
}

impl<const ANY: bool> Kernel for Settle<'_, '_, ANY> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> bool {
        let Settle { bvh, packet, state, slot, sub, rays: mut left, pierced } = self;
        let State { frame, epoch, contenders, .. } = state;
        state.doubts += u64::from(left.count_ones());
        let this = contenders.get(bvh, frame, *epoch, slot);
        let (bound, prim) = (this.bound, this.prim);
        if prim == MISS {
            return false;
        }
        let (u, v) = (&rays_of(&packet.u)[sub], &rays_of(&packet.v)[sub]);
        let t = depths(&this.plane, u, v);
        let (mut low, mut high) = ([0.0; SUB], [0.0; SUB]);
        for i in 0..SUB {
            [low[i], high[i]] = this.edges(f64::from(u[i]), f64::from(v[i]));
        }
        // The slot and the depths of the triangle that rays hit so far; mostly it is the same one.
        let (mut other, mut other_prim, mut other_t) = (NO_SLOT, MISS, t);
        let mut decided = false;
        while left != 0 {
            let i = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            let (low, high, t) = (low[i], high[i], t[i]);
            // What is cheaper decides first.
            let astride = high > bound && low < -bound;
            if astride || !(t >= 0.0 && t <= f64::from(packet.tfar(sub * SUB + i))) {
                continue;
            }
            let best = state.slot[sub][i];
            let interval = inverse_interval(t);
            if best != NO_SLOT && interval.0 <= state.hi[sub][i] {
                if best != other {
                    let contender = contenders.get(bvh, frame, *epoch, best);
                    (other, other_prim) = (best, contender.prim);
                    other_t = depths(&contender.plane, u, v);
                }
                if (other_t[i], other_prim) <= (t, prim) {
                    continue;
                }
            }
            let inside = pierced >> i & 1 != 0 || low > bound || high < -bound;
            if !(inside || is_exactly_inside(bvh, frame, slot, [u[i], v[i], 1.0])) {
                continue;
            }
            decided = true;
            if ANY {
                state.live[sub] &= !(1 << i);
            } else {
                (state.lo[sub][i], state.hi[sub][i]) = interval;
                state.slot[sub][i] = slot;
            }
        }
        decided
    }
}

/// What expansions say of the ray along `d` and the triangle in `slot`.
#[cold]
#[inline(never)]
fn is_exactly_inside(bvh: &BvhView, frame: &Frame, slot: u32, d: [f32; 3]) -> bool {
    let (block, lane) = block_of(bvh, slot);
    let [a, b, c] = triangle(block, lane, frame);
    passes(a, b, c, d)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles from a lattice, and directions at them, near their edges, through their corners and along their edges.
    fn hard_cases() -> impl Iterator<Item = ([[f32; 3]; 3], [f32; 2])> {
        let mut random = 0x9e37_79b9_7f4a_7c15u64;
        let mut next = move || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random >> 40) as f32 / (1u64 << 24) as f32
        };
        (0..200_000).map(move |case| {
            let corner = |next: &mut dyn FnMut() -> f32| {
                let z = 1.0 + next();
                let lattice = |x: f32| if case % 3 == 0 { (x * 8.0).floor() / 8.0 } else { x };
                [lattice(next() - 0.5), lattice(next() - 0.5), lattice(z)]
            };
            let [a, b, c] = std::array::from_fn(|_| corner(&mut next));
            let s = if case % 2 == 0 { 0.0 } else { next() };
            let nudge = if case % 5 == 0 { 0.0 } else { (next() - 0.5) * 1.0e-7 };
            let at: [f32; 3] = std::array::from_fn(|k| a[k] + (b[k] - a[k]) * s);
            ([a, b, c], [at[0] / at[2] + nudge, at[1] / at[2]])
        })
    }

    /// Full mantissas, so that every product of three numbers is rounded; integers, so that i128 knows the truth.
    #[test]
    fn edge_functions_are_off_by_no_more_than_their_bound() {
        const ONE: i128 = 1 << 24;
        let mut random = 0x2545_f491_4f6c_dd1du64;
        let mut next = move || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random >> 40) as i128 * 2 - (ONE - 1)
        };
        let mut worst = 0.0f64;
        for _ in 0..20_000 {
            let corners: [[i128; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| next() / 2));
            let (i, j) = (next() / 2, next() / 2);
            let det = |p: [i128; 3], q: [i128; 3]| {
                let n: [i128; 3] = std::array::from_fn(|k| {
                    let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                    p[l] * q[m] - p[m] * q[l]
                });
                n[0] * i + n[1] * j + n[2] * ONE
            };
            let [a, b, c] = corners;
            let mut truth = [det(b, c), det(c, a), det(a, b)];
            truth.sort_unstable();
            let contender = Contender::new(corners.map(|v| v.map(|x| x as f32)), 0);
            let found = contender.edges(i as f64 / ONE as f64, j as f64 / ONE as f64);
            for (found, truth) in found.into_iter().zip([truth[0], truth[2]]) {
                // Scaling by a power of two is exact, and so is the difference of numbers that close.
                let off = ((found * ONE as f64) as i128 - truth).abs() as f64 / ONE as f64;
                worst = worst.max(off / contender.bound);
            }
        }
        // The bound holds and is not far too wide.
        assert!(worst > 0.05 && worst <= 1.0, "{worst}");
    }

    #[test]
    fn what_f64_is_sure_of_is_what_exact_arithmetic_says() {
        let (mut sure, mut unsure) = (0, 0);
        for ([a, b, c], [u, v]) in hard_cases() {
            let contender = Contender::new([a, b, c], 0);
            let [low, high] = contender.edges(f64::from(u), f64::from(v));
            let astride = low < -contender.bound && high > contender.bound;
            let inside = low > contender.bound || high < -contender.bound;
            if astride || inside {
                sure += 1;
                assert_eq!(inside, passes(a, b, c, [u, v, 1.0]), "{a:?} {b:?} {c:?} {u} {v}");
            } else {
                unsure += 1;
            }
        }
        // Both happen, or nothing was tested.
        assert!(sure > 100_000 && unsure > 1_000, "{sure} {unsure}");
    }
}
