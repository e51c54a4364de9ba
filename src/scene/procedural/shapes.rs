//! Rounded shapes that furniture is made of: tubes, rods, slabs with soft edges, balls.

use super::builder::Builder;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// A plate with rounded corners and soft edges, centred on the origin, flat along y.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    /// Half the extent along x and z.
    pub(super) half: Vec2,
    /// Extent along y.
    pub(super) thickness: f32,
    /// Radius of the four corners as seen from above, >= `edge`.
    pub(super) corner: f32,
    /// Radius of the edges, at most half the thickness.
    pub(super) edge: f32,
}

/// How finely a [`Slab`] is divided.
#[derive(Clone, Copy)]
pub(super) struct SlabCells {
    /// Of each of the four corners.
    pub(super) corner: usize,
    /// Of each straight side.
    pub(super) side: usize,
    /// Of each rounded edge.
    pub(super) edge: usize,
    /// Rings of the two faces.
    pub(super) face: usize,
}

impl Slab {
    /// Point of the slab at ring `v`, counted in cells from the middle of the underside to the middle of the top, and
    /// `u` around, counted in cells too.
    fn point(&self, cells: SlabCells, u: f32, v: f32) -> Vec3 {
        let (face, edge) = (cells.face as f32, cells.edge as f32);
        let half = self.thickness / 2.0;
        let last = 2.0 * face + 2.0 * edge + 1.0;
        let (side, v) = if v < last / 2.0 { (-1.0, v) } else { (1.0, last - v) };
        let shrink = (v / face).min(1.0);
        let angle = ((v - face) / edge).clamp(0.0, 1.0) * FRAC_PI_2;
        let inset = self.edge * (1.0 - angle.sin());
        // The last half ring, shared by both sides, is the upright part between the two rounded edges.
        let upright = (v - face - edge).clamp(0.0, 0.5) * 2.0;
        let y = (half - self.edge + self.edge * angle.cos()) - upright * (half - self.edge);
        let rim = self.outline(cells, u, inset) * shrink;
        Vec3::new(rim.x, side * y, rim.y)
    }

    /// The outline moved inwards by `inset`, clockwise as seen from above.
    fn outline(&self, cells: SlabCells, u: f32, inset: f32) -> Vec2 {
        let period = (cells.corner + cells.side) as f32;
        let quadrant = (u / period).floor();
        let along = u - quadrant * period;
        let corner = |quadrant: f32, turn: f32| {
            let middle = Vec2::from_angle(-(quadrant + 0.5) * FRAC_PI_2);
            let centre = (self.half - self.corner) * middle.signum();
            centre + Vec2::from_angle(-(quadrant + turn) * FRAC_PI_2) * (self.corner - inset)
        };
        let turn = along / cells.corner as f32;
        if turn <= 1.0 {
            return corner(quadrant, turn);
        }
        let straight = (along - cells.corner as f32) / cells.side as f32;
        corner(quadrant, 1.0).lerp(corner(quadrant + 1.0, 0.0), straight)
    }
}

impl Builder {
    /// An axis-aligned box like [`Builder::cuboid`], every face in `cells` x `cells` quads.
    pub(super) fn block(&mut self, cells: usize, min: Vec3, max: Vec3) {
        let size = max - min;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
        for (corner, du, dv) in
            [(min, y, x), (min, z, y), (min, x, z), (max, -y, -z), (max, -z, -x), (max, -x, -y)]
        {
            self.quad([cells, cells], corner, du, dv);
        }
    }

    /// A round tube along `path`, open at both ends. `side` must nowhere be parallel to the path.
    pub(super) fn tube(
        &mut self,
        [around, along]: [usize; 2],
        side: Vec3,
        radius: impl Fn(f32) -> f32,
        path: impl Fn(f32) -> Vec3,
    ) {
        self.patch([around, along], true, |u, v| {
            let (before, after) = ((v - 1e-3).max(0.0), (v + 1e-3).min(1.0));
            let tangent = (path(after) - path(before)).normalize();
            let across = (side - tangent * side.dot(tangent)).normalize();
            let (sin, cos) = (-u * TAU).sin_cos();
            path(v) + (across * cos + across.cross(tangent) * sin) * radius(v)
        });
    }

    /// A straight round rod from `a` to `b` with flat ends.
    pub(super) fn rod(&mut self, [around, along]: [usize; 2], a: Vec3, b: Vec3, radius: f32) {
        let axis = (b - a).normalize();
        let side = axis.any_orthonormal_vector();
        self.tube([around, along], side, |_| radius, |v| a.lerp(b, v));
        let disc = |centre: Vec3, u: f32, reach: f32| {
            let (sin, cos) = (-u * TAU).sin_cos();
            centre + (side * cos + side.cross(axis) * sin) * (radius * reach)
        };
        self.patch([around, 1], true, |u, v| disc(a, u, v));
        self.patch([around, 1], true, |u, v| disc(b, u, 1.0 - v));
    }

    /// A slab, every point moved by `bend`.
    pub(super) fn slab(&mut self, slab: Slab, cells: SlabCells, bend: impl Fn(Vec3) -> Vec3) {
        let around = 4 * (cells.corner + cells.side);
        let rings = 2 * (cells.face + cells.edge) + 1;
        self.patch([around, rings], true, |u, v| {
            bend(slab.point(cells, u * around as f32, v * rings as f32))
        });
    }

    /// An ellipsoid, `around` cells about the y axis.
    pub(super) fn ball(&mut self, around: usize, centre: Vec3, radii: Vec3) {
        self.patch([around, around.div_ceil(2).max(2)], true, |u, v| {
            let (sin, cos) = (-u * TAU).sin_cos();
            let (height, reach) = ((v - 0.5) * PI).sin_cos();
            // The poles are one point, not a ring as wide as the rounding of a cosine.
            let reach = if v > 0.0 && v < 1.0 { reach } else { 0.0 };
            centre + Vec3::new(reach * cos, height, reach * sin) * radii
        });
    }
}
