//! From rays to lines, and to the intervals that enclose them.
//!
//! # Error bounds
//!
//! Let e = 2^-24, c the reference point, and O = `extent` the greatest |o - c| along any axis, o an origin. With o' =
//! fl(o - c) the line has u = fl(dx / dz), off by e, and a = fl(ox' - u oz'), off by 8 e O.
//!
//! *Boxes.* An exact hit at depth t from the ray's own origin satisfies fl(x0 - ox) <= U t <= fl(x1 - ox) for any box
//! [x0, x1] around its triangle, with the exact slope U, because rounding is monotonic; the same for y, and for z with
//! t in place of U t. Hence x1 - ox >= U t - 1.1 e t, and with z = t + oz' the depth from the reference point,
//! fl(x1 - cx) >= a + u z - (4 e z + 10 e O). z itself lies in [fl(z0 - cz) (1 - 3 e), fl(z1 - cz) (1 + 3 e)], which
//! moves u z by 3 e z. Evaluating a + u z adds 2 e z + 2 e O. Slopes widened by 16 e and crossings widened by 16 e O
//! cover all of it: all depths are positive.

use super::{Bounds, E, Rays, State, triangles::Coefficients, walk::Planes};
use crate::{
    generic::{F16, Frame, doubt::NO_SLOT, leaf::TINY},
    packet::{Face, Pick, RayBlock, SUB, SUBS},
    simd::Simd,
    vector::{I32, Mask},
};

/// Sub-packets whose slopes differ by more than this are traced ray by ray.
const APART: f32 = 1.0;
/// Origins farther apart than this are traced ray by ray, lest anything overflow.
const FAR: f32 = 1.0e15;

impl Bounds<[f32; SUBS]> {
    const NOTHING: Self = {
        let none = [[f32::INFINITY; SUBS], [f32::NEG_INFINITY; SUBS]];
        Bounds { u: none, v: none, a: none, b: none, start: [f32::INFINITY; SUBS], reach: [-1.0; SUBS] }
    };
}

impl State {
    #[inline(always)]
    pub(super) fn new<S: Simd>(s: S, blocks: &[RayBlock], picks: &[Pick]) -> State {
        const ZERO: Rays = [[0.0; SUB]; SUBS];
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let mut state = State {
            lines: [[[0.0; SUB]; 5]; SUBS],
            start: [ZERO; 2],
            lo: [[-1.0; SUB]; SUBS],
            hi: [[-1.0; SUB]; SUBS],
            slot: [[NO_SLOT; SUB]; SUBS],
            bounds: Bounds::NOTHING,
            middle: [[0.0; SUBS]; 5],
            radius: [[0.0; SUBS]; 5],
            beam: Bounds { u: none, v: none, a: none, b: none, start: f32::INFINITY, reach: -1.0 },
            beam_middle: [0.0; 5],
            beam_radius: [0.0; 5],
            planes: Planes::EMPTY,
            triangles: Coefficients::EMPTY,
            pairs: [0; 9 * SUBS],
            live: [0; SUBS],
            live_subs: 0,
            alone: [0; SUBS],
            doubts: 0,
            extent: 0.0,
            frame: Frame::new([0.0; 3], Face::ALL[0]),
        };
        if !state.place(s, blocks, picks) {
            return state;
        }
        for (sub, &pick) in picks.iter().enumerate().take(SUBS) {
            if state.live[sub] != 0 {
                state.sub_packet(s, &blocks[pick.block as usize], sub);
            }
        }
        state.whole_beam(s);
        state
    }

    /// Chooses face and reference point, and which rays fly together; false if none does.
    #[inline(always)]
    fn place<S: Simd>(&mut self, s: S, blocks: &[RayBlock], picks: &[Pick]) -> bool {
        let infinity = F16::splat(s, f32::INFINITY);
        let mut face = None;
        let mut least = [infinity; 3];
        let mut most = [-infinity; 3];
        for (sub, &pick) in picks.iter().enumerate().take(SUBS) {
            let block = &blocks[pick.block as usize];
            let valid = valid(s, block) & u32::from(pick.active);
            if valid == 0 {
                continue;
            }
            let lane = (valid.trailing_zeros() & 15) as usize;
            let face = *face.get_or_insert(Face::of(block.ray(lane).dir));
            let together = valid & of_face(s, block, face);
            self.live[sub] = together as u16;
            self.alone[sub] = (valid & !together) as u16;
            let mask = Mask::from_bits(s, together);
            for axis in 0..3 {
                let org = F16::load(s, &block.org[axis]);
                least[axis] = least[axis].min(mask.select(org, infinity));
                most[axis] = most[axis].max(mask.select(org, -infinity));
            }
        }
        let Some(face) = face else { return false };
        let mut org = [0.0; 3];
        for axis in 0..3 {
            let (least, most) = (least[axis].reduce_min(), most[axis].reduce_max());
            self.extent = self.extent.max(most - least);
            org[axis] = 0.5 * least + 0.5 * most;
            if axis == face.axis {
                // Behind all origins.
                org[axis] = if face.negative { most } else { least };
            }
        }
        self.frame = Frame::new(org, face);
        if self.extent < FAR {
            return true;
        }
        for (alone, live) in self.alone.iter_mut().zip(&mut self.live) {
            *alone |= std::mem::take(live);
        }
        false
    }

    /// Lines and bounds of one sub-packet.
    #[inline(always)]
    fn sub_packet<S: Simd>(&mut self, s: S, block: &RayBlock, sub: usize) {
        let [iu, iv, iz] = self.frame.axes;
        let flip = I32::splat(s, self.frame.flip);
        let active = Mask::from_bits(s, u32::from(self.live[sub]));
        let (infinity, nothing) = (F16::splat(s, f32::INFINITY), F16::splat(s, -1.0));
        let x = F16::load(s, &block.org[iu]) - F16::splat(s, self.frame.org[0]);
        let y = F16::load(s, &block.org[iv]) - F16::splat(s, self.frame.org[1]);
        let z = (F16::load(s, &block.org[iz]) - F16::splat(s, self.frame.org[2])).flip(flip);
        let dz = F16::load(s, &block.dir[iz]).abs();
        let u = F16::load(s, &block.dir[iu]) / dz;
        let v = F16::load(s, &block.dir[iv]) / dz;
        let (a, b) = (x - u * z, y - v * z);
        let lines = [u, v, a, b, a * v - b * u];
        let mut ends = [infinity; 10];
        for i in 0..5 {
            lines[i].store(&mut self.lines[sub][i]);
            ends[2 * i] = active.select(lines[i], infinity);
            ends[2 * i + 1] = active.select(-lines[i], infinity);
        }
        let [u0, u1, v0, v1] = F16::reduce_min4(s, [ends[0], ends[1], ends[2], ends[3]]);
        let [a0, a1, b0, b1] = F16::reduce_min4(s, [ends[4], ends[5], ends[6], ends[7]]);
        let bounds = &mut self.bounds;
        (bounds.u[0][sub], bounds.u[1][sub]) = (u0, -u1);
        (bounds.v[0][sub], bounds.v[1][sub]) = (v0, -v1);
        (bounds.a[0][sub], bounds.a[1][sub]) = (a0, -a1);
        (bounds.b[0][sub], bounds.b[1][sub]) = (b0, -b1);
        // Depths are off by a few units of each term.
        let slack = F16::splat(s, 8.0 * E);
        let near = F16::splat(s, 0.0).max(F16::load(s, &block.tnear)) * dz;
        let far = F16::load(s, &block.tfar) * dz;
        let (tiny, huge) = (F16::splat(s, TINY), F16::splat(s, f32::MAX));
        let (first, last) = (z + near, z + far);
        let start = [first.min(huge) - slack * first.min(huge), first + slack * first + tiny];
        let lo = active.select(last - slack * last.min(huge) - tiny, nothing);
        let hi = active.select(last + slack * last + tiny, nothing);
        for (to, start) in self.start.iter_mut().zip(start) {
            active.select(start, infinity).store(&mut to[sub]);
        }
        lo.store(&mut self.lo[sub]);
        hi.store(&mut self.hi[sub]);
        let first = active.select(start[0], infinity);
        let [w0, w1, first, last] = F16::reduce_min4(s, [ends[8], ends[9], first, -hi]);
        self.bounds.start[sub] = first;
        self.bounds.reach[sub] = -last;
        let least = [u0, v0, a0, b0, w0];
        let most = [-u1, -v1, -a1, -b1, -w1];
        for i in 0..5 {
            self.middle[i][sub] = 0.5 * (least[i] + most[i]);
            self.radius[i][sub] = 0.5 * (most[i] - least[i]);
        }
    }

    /// Bounds of the beam; widens those of the sub-packets, and gives up those that fly apart.
    #[inline(always)]
    fn whole_beam<S: Simd>(&mut self, s: S) {
        let apart = F16::splat(s, APART);
        let width = F16::load(s, &self.radius[0]).max(F16::load(s, &self.radius[1]));
        let apart = apart.lt(width + width).bits();
        for sub in 0..SUBS {
            if apart >> sub & 1 != 0 {
                self.alone[sub] |= std::mem::take(&mut self.live[sub]);
            }
            self.live_subs |= u32::from(self.live[sub] != 0) << sub;
        }
        let subs = Mask::from_bits(s, self.live_subs);
        let slope = 16.0 * E;
        let crossing = 16.0 * E * self.extent;
        let infinity = F16::splat(s, f32::INFINITY);
        let (bounds, beam) = (&mut self.bounds, &mut self.beam);
        let pairs = [
            (&mut bounds.u, &mut beam.u, slope),
            (&mut bounds.v, &mut beam.v, slope),
            (&mut bounds.a, &mut beam.a, crossing),
            (&mut bounds.b, &mut beam.b, crossing),
        ];
        for (i, (of_subs, of_beam, wider)) in pairs.into_iter().enumerate() {
            let (least, most) = (F16::load(s, &of_subs[0]), F16::load(s, &of_subs[1]));
            (least - F16::splat(s, wider)).store(&mut of_subs[0]);
            (most + F16::splat(s, wider)).store(&mut of_subs[1]);
            let least = subs.select(least, infinity).reduce_min();
            let most = subs.select(most, -infinity).reduce_max();
            *of_beam = [least - wider, most + wider];
            self.beam_middle[i] = 0.5 * (least + most);
            self.beam_radius[i] = 0.5 * (most - least);
        }
        let (middle, radius) = (F16::load(s, &self.middle[4]), F16::load(s, &self.radius[4]));
        let least = subs.select(middle - radius, infinity).reduce_min();
        let most = subs.select(middle + radius, -infinity).reduce_max();
        self.beam_middle[4] = 0.5 * (least + most);
        self.beam_radius[4] = 0.5 * (most - least);
        self.beam.start = subs.select(F16::load(s, &self.bounds.start), infinity).reduce_min();
        self.pull_in(s);
    }

    /// Works out the reach of the beam anew.
    #[inline(always)]
    pub(super) fn pull_in<S: Simd>(&mut self, s: S) {
        let subs = Mask::from_bits(s, self.live_subs);
        self.beam.reach = subs.select(F16::load(s, &self.bounds.reach), F16::splat(s, -1.0)).reduce_max();
    }
}

/// Active rays that do not miss by definition: the rule of the single-ray kernel.
#[inline(always)]
fn valid<S: Simd>(s: S, block: &RayBlock) -> u32 {
    let zero = F16::splat(s, 0.0);
    let infinity = F16::splat(s, f32::INFINITY);
    let tnear = F16::load(s, &block.tnear);
    // NaN fails every comparison.
    let mut valid = tnear.le(tnear) & zero.max(tnear).le(F16::load(s, &block.tfar));
    let mut greatest = zero;
    for axis in 0..3 {
        let size = F16::load(s, &block.dir[axis]).abs();
        valid = valid & F16::load(s, &block.org[axis]).abs().lt(infinity) & size.lt(infinity);
        greatest = greatest.max(size);
    }
    (valid & zero.lt(greatest)).bits() & u32::from(block.active)
}

/// Rays of this face: the rule of [`Face::of`].
#[inline(always)]
fn of_face<S: Simd>(s: S, block: &RayBlock, face: Face) -> u32 {
    let [x, y, z] = &block.dir;
    let (x, y, z) = (F16::load(s, x).abs(), F16::load(s, y).abs(), F16::load(s, z).abs());
    let is_x = (y.le(x) & z.le(x)).bits();
    let is_y = !is_x & z.le(y).bits();
    let of_axis = [is_x, is_y, !is_x & !is_y][face.axis];
    let negative = F16::load(s, &block.dir[face.axis]).lt(F16::splat(s, 0.0)).bits();
    of_axis & if face.negative { negative } else { !negative }
}
