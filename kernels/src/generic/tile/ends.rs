//! Where the rays of sub-packets end: planes that lie behind them.
//!
//! Shadow rays end on surfaces, and the triangles of those surfaces are what most rays come across. Over a plane the
//! inverse depth is affine in the slopes, so for each sub-packet an affine function `l(u, v)` is laid below the inverse
//! of its rays' ends, through three of them as well as that goes. A triangle whose inverse depth stays below `l` over
//! the whole rectangle of slopes lies behind all ends, and no ray has to be tested.
//!
//! Any function will do that is below all ends: its slopes may come from anywhere, its constant from the minimum over
//! the rays. With e = 2^-24, evaluating the difference of two affine functions with magnitudes S and T of their
//! coefficients is off by 5 e (S + T); the bound within a triangle's inverse depth has room for its part (see
//! [`crate::generic::leaf`]), and `l` is lowered by [`SLACK`] times its own, which covers the minimum as well.

use super::{State, block::BlockPlanes, rays};
use crate::{generic::F16, packet::SUBS, packet::TilePacket, simd::Simd};

/// 16 * 2^-24.
const SLACK: f32 = 9.536_743e-7;
/// The rays that the plane is laid through: corners of a block of 4x4.
const CORNERS: [usize; 3] = [0, 3, 12];

/// One affine function for each sub-packet, and rectangles of slopes as centre and radius; lane = sub-packet.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Ends {
    plane: [[f32; SUBS]; 3],
    center: [[f32; SUBS]; 2],
    radius: [[f32; SUBS]; 2],
}

impl Ends {
    pub(super) const NONE: Ends =
        Ends { plane: [[0.0; SUBS]; 3], center: [[0.0; SUBS]; 2], radius: [[0.0; SUBS]; 2] };

    /// Sub-packets with a ray that may end behind triangle `lane`; lane = sub-packet.
    #[inline(always)]
    pub(super) fn behind<S: Simd>(&self, s: S, planes: &BlockPlanes, lane: usize) -> u32 {
        let depth = planes.depth(s, lane);
        let x = depth[0] - F16::load(s, &self.plane[0]);
        let y = depth[1] - F16::load(s, &self.plane[1]);
        let z = depth[2] - F16::load(s, &self.plane[2]);
        let middle = x.mul_add(F16::load(s, &self.center[0]), y.mul_add(F16::load(s, &self.center[1]), z));
        let u = F16::load(s, &self.radius[0]);
        let most = x.abs().mul_add(u, y.abs().mul_add(F16::load(s, &self.radius[1]), middle));
        F16::splat(s, 0.0).le(most).bits()
    }
}

impl State {
    /// Lays the planes; the sub-packets' other bounds are known.
    #[inline(always)]
    pub(super) fn lay_ends<S: Simd>(&mut self, s: S, packet: &TilePacket) {
        let two = F16::splat(s, 0.5);
        let widen = F16::splat(s, 1.0 + 4.0 * f32::EPSILON);
        for (axis, slopes) in [&self.u, &self.v].into_iter().enumerate() {
            let (least, most) = (F16::load(s, &slopes[0]), F16::load(s, &slopes[1]));
            let center = (least + most) * two;
            center.store(&mut self.ends.center[axis]);
            ((most - center).max(center - least) * widen).store(&mut self.ends.radius[axis]);
        }
        let slopes = self.end_slopes(s, packet);
        slopes[0].store(&mut self.ends.plane[0]);
        slopes[1].store(&mut self.ends.plane[1]);
        self.end_constants(s, packet);
    }

    /// Slopes of the planes through three rays' ends; zero where there is no such plane.
    #[inline(always)]
    fn end_slopes<S: Simd>(&self, s: S, packet: &TilePacket) -> [F16<S>; 2] {
        let mut points = [[[0.0; SUBS]; 3]; 3];
        for sub in 0..SUBS {
            if packet.active[sub] == u16::MAX {
                for i in 0..3 {
                    let ray = CORNERS[i];
                    points[i][0][sub] = rays(&packet.u)[sub][ray];
                    points[i][1][sub] = rays(&packet.v)[sub][ray];
                    points[i][2][sub] = self.lo[sub][ray];
                }
            }
        }
        let zero = F16::splat(s, 0.0);
        let mut sides = [[zero; 3]; 2];
        for i in 0..2 {
            for j in 0..3 {
                sides[i][j] = F16::load(s, &points[i + 1][j]) - F16::load(s, &points[0][j]);
            }
        }
        let [p, q] = sides;
        let det = p[0] * q[1] - q[0] * p[1];
        let x = (p[2] * q[1] - q[2] * p[1]) / det;
        let y = (p[0] * q[2] - q[0] * p[2]) / det;
        // False for NaN and infinity.
        let sane = (x.abs() + y.abs()).lt(F16::splat(s, f32::MAX));
        [sane.select(x, zero), sane.select(y, zero)]
    }

    /// Lowers the planes below all ends; keeps the constant function where a plane is no better.
    #[inline(always)]
    fn end_constants<S: Simd>(&mut self, s: S, packet: &TilePacket) {
        for sub in 0..SUBS {
            if packet.active[sub] != 0 {
                let (x, y) = (F16::splat(s, self.ends.plane[0][sub]), F16::splat(s, self.ends.plane[1][sub]));
                let (u, v) = (F16::load(s, &rays(&packet.u)[sub]), F16::load(s, &rays(&packet.v)[sub]));
                // Rays that take no part have lo = infinity, and the minimum takes the other operand for NaN.
                let above = (F16::load(s, &self.lo[sub]) - (x * u + y * v)).min(F16::splat(s, f32::INFINITY));
                self.ends.plane[2][sub] = above.reduce_min();
            }
        }
        let zero = F16::splat(s, 0.0);
        let ends = &mut self.ends;
        let [x, y, z] = [F16::load(s, &ends.plane[0]), F16::load(s, &ends.plane[1]), F16::load(s, &ends.plane[2])];
        let z = z - F16::splat(s, SLACK) * (x.abs() + y.abs() + z.abs());
        let middle = x * F16::load(s, &ends.center[0]) + y * F16::load(s, &ends.center[1]) + z;
        let reach = F16::load(s, &self.reach);
        let better = reach.lt(middle);
        better.select(x, zero).store(&mut ends.plane[0]);
        better.select(y, zero).store(&mut ends.plane[1]);
        better.select(z, reach - F16::splat(s, SLACK) * reach).store(&mut ends.plane[2]);
    }
}
