//! What stone buildings are made of: arches round and pointed, vaults, columns, mouldings, coursed walls.
//!
//! A wall runs along x with its front towards +z; [`facing`] turns it into place.

use super::{builder::Builder, hash::unit};
use crate::scene::Material;
use glam::{Affine3A, Mat3, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// A matt material.
pub(super) fn matt(name: &str, kd: [f32; 3]) -> Material {
    Material { name: name.into(), kd: kd.into(), ..Material::default() }
}

/// A material with a highlight of strength `ks`.
pub(super) fn polished(name: &str, kd: [f32; 3], ks: f32, ns: f32) -> Material {
    Material { ks: Vec3::splat(ks), ns, ..matt(name, kd) }
}

/// At `position`, with +z turned about the y axis by `quarters` quarter turns (one: towards +x). Exact, so that
/// edges that meet keep on meeting.
pub(super) fn facing(quarters: i32, position: Vec3) -> Affine3A {
    let (sin, cos) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarters.rem_euclid(4) as usize];
    let turn = Mat3::from_cols(Vec3::new(cos, 0.0, -sin), Vec3::Y, Vec3::new(sin, 0.0, cos));
    Affine3A::from_mat3_translation(turn, position)
}

/// Moved, not turned.
pub(super) fn moved(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(x, y, z))
}

/// A smooth curve through `points`, t in [0, 1] (Catmull-Rom).
pub(super) fn spline(points: &[Vec2], t: f32) -> Vec2 {
    let last = points.len() - 1;
    let scaled = t.clamp(0.0, 1.0) * last as f32;
    let i = (scaled as usize).min(last - 1);
    let s = scaled - i as f32;
    let [p0, p1, p2, p3] = [points[i.saturating_sub(1)], points[i], points[i + 1], points[(i + 2).min(last)]];
    let cubic = 3.0 * (p1 - p2) + p3 - p0;
    let square = 2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3;
    p1 + 0.5 * s * (p2 - p0 + s * (square + s * cubic))
}

/// An arch of two arcs over the span [-half, half], springing at height 0.
#[derive(Clone, Copy)]
pub(super) struct Arch {
    /// Half the span.
    pub half: f32,
    /// Radius of the arcs over half the span: 1 is round, 2 equilateral pointed.
    pub point: f32,
}

impl Arch {
    /// The point at `t` in [0, 1] from the springing to the apex of the right arc, `out` outside the arch.
    fn right(self, t: f32, out: f32) -> Vec2 {
        let radius = self.point * self.half;
        let centre = self.half - radius;
        let apex = (-centre / (radius + out)).acos();
        let (sin, cos) = (apex * t).sin_cos();
        // Exactly on the axis, whatever the rounding: both arcs must meet.
        let x = if t == 1.0 { 0.0 } else { centre + (radius + out) * cos };
        Vec2::new(x, (radius + out) * sin)
    }

    /// The point at `u` in [0, 1] of one arc, going left to right: the left one rises, the right one falls.
    pub(super) fn arc(self, right: bool, u: f32, out: f32) -> Vec2 {
        if right { self.right(1.0 - u, out) } else { self.right(u, out) * Vec2::new(-1.0, 1.0) }
    }

    /// Height of the apex over the springing.
    pub(super) fn rise(self) -> f32 {
        self.right(1.0, 0.0).y
    }

    /// Height over the springing at `q` in [0, 1], from the axis to the springing.
    pub(super) fn height(self, q: f32) -> f32 {
        let (radius, centre) = (self.point, 1.0 - self.point);
        self.half * (radius * radius - (q - centre) * (q - centre)).max(0.0).sqrt()
    }
}

/// One bay of a wall with an arched opening: from the springing at y = 0 up to `top`, `2 * bay` wide and `thick` deep
/// about z = 0. Both faces, and the underside of the arch.
pub(super) fn arched_wall(b: &mut Builder, arch: Arch, bay: f32, top: f32, thick: f32) {
    let (along, up) = (b.steps(5.0, 2), b.steps(1.0, 1));
    for quarters in [0, 2] {
        b.at(facing(quarters, Vec3::ZERO), |b| {
            for right in [false, true] {
                b.patch([along, up], false, |u, v| {
                    let foot = arch.arc(right, u, 0.0);
                    Vec3::new(foot.x, foot.y + (top - foot.y) * v, 0.5 * thick)
                });
            }
            let (y, x) = (Vec3::Y * top, Vec3::X * (bay - arch.half));
            let beside = b.steps(1.0, 1);
            b.quad([beside, up], Vec3::new(-bay, 0.0, 0.5 * thick), x, y);
            b.quad([beside, up], Vec3::new(arch.half, 0.0, 0.5 * thick), x, y);
        });
    }
    soffit(b, arch, thick);
}

/// The underside of an arch, `thick` deep about z = 0.
pub(super) fn soffit(b: &mut Builder, arch: Arch, thick: f32) {
    let cells = [b.steps(5.0, 2), b.steps(1.0, 1)];
    for right in [false, true] {
        b.patch(cells, true, |u, v| arch.arc(right, u, 0.0).extend((v - 0.5) * thick));
    }
}

/// A moulding along an arch. `profile` is (outside the arch, out of the wall), from the opening outwards.
pub(super) fn archivolt(b: &mut Builder, arch: Arch, profile: &[Vec2]) {
    let (along, across) = (b.steps(5.0, 2), b.steps(1.0, 1));
    for piece in profile.windows(2) {
        for right in [false, true] {
            b.patch([along, across], true, |u, v| {
                let p = piece[0].lerp(piece[1], v);
                arch.arc(right, u, p.x).extend(p.y)
            });
        }
    }
}

/// A straight moulding from x = 0 to `length`. `profile` is (height, out of the wall), from bottom to top. The ends are
/// cut at 45 degrees towards a corner that it meets there: -1 shorter the further out (an inner corner), 1 longer.
pub(super) fn moulding(b: &mut Builder, length: f32, mitre: [f32; 2], cells: usize, profile: &[Vec2]) {
    let across = b.steps(1.0, 1);
    for piece in profile.windows(2) {
        b.patch([cells, across], false, |u, v| {
            let p = piece[0].lerp(piece[1], v);
            let (low, high) = (-mitre[0] * p.y, length + mitre[1] * p.y);
            Vec3::new(low + (high - low) * u, p.x, p.y)
        });
    }
}

/// A vault over a rectangle of `2 hx` x `2 hz`: two barrels that cross, seen from below. `arch` gives the section
/// over x, its half span taken as the unit of height; the section over z is the same, stretched to its span.
pub(super) fn groin_vault(b: &mut Builder, arch: Arch, hx: f32, hz: f32) {
    let (across, out) = (b.steps(3.0, 1), b.steps(3.0, 2));
    for quarters in 0..4 {
        let (near, far) = if quarters % 2 == 0 { (hx, hz) } else { (hz, hx) };
        b.at(facing(quarters, Vec3::ZERO), |b| {
            for side in [-1.0, 0.0] {
                b.patch([across, out], true, |u, v| {
                    // Denser towards the springing, where the arch is steep.
                    let (s, r) = (((u + side) * FRAC_PI_2).sin(), (v * FRAC_PI_2).sin());
                    let r = if v == 1.0 { 1.0 } else { r };
                    Vec3::new(near * r * s, arch.height((r * s).abs()), far * r)
                });
            }
        });
    }
}

/// A wall of stones in courses, bonded, from the origin to (width, height) and facing +z. Each stone is one of
/// `paints`, by chance of its place; `seed` tells walls apart.
pub(super) fn coursed_wall(b: &mut Builder, size: Vec2, courses: f32, paints: &[u32], seed: u32) {
    let rows = b.steps(courses, 3).min(courses as usize);
    let stone = size.y / rows as f32;
    // Half stones, so that every other course can start with one.
    let halves = (size.x / stone).round().max(2.0) as usize;
    let fine = b.steps(1.0, 1);
    let paint = |i: usize, j: usize| {
        let (i, j) = (i / fine, j / fine);
        let stone = ((i + j % 2) / 2 + 4096 * j) as u32;
        paints[(unit(stone, seed) * paints.len() as f32) as usize]
    };
    b.mosaic([halves * fine, rows * fine], false, paint, |u, v| Vec3::new(size.x * u, size.y * v, 0.0));
}

/// A moulded half round between the heights `low` and `high`, bulging by `out` from the radius `r`.
fn torus(b: &mut Builder, around: usize, [low, high]: [f32; 2], r: f32, out: f32) {
    let up = b.steps(2.0, 1);
    b.turned([around, up], |v| {
        Vec2::new(r + out * (PI * v).sin(), low + (high - low) * 0.5 * (1.0 - (PI * v).cos()))
    });
}

/// Proportions of a column.
#[derive(Clone, Copy)]
pub(super) struct Column {
    /// From the floor to the top of its abacus.
    pub height: f32,
    /// Radius of the shaft at its foot.
    pub radius: f32,
    /// Facets around the shaft at detail 1.
    pub around: f32,
    /// Rows of leaves on the capital.
    pub leaves: usize,
}

impl Column {
    /// Half the width of the abacus.
    pub(super) fn abacus(self) -> f32 {
        1.62 * self.radius
    }

    /// Adds the column, standing on the origin: `shaft` and `carved` are the materials of the shaft and the rest.
    pub(super) fn build(self, b: &mut Builder, shaft: u32, carved: u32) {
        let r = self.radius;
        let around = b.steps(self.around, 5);
        let bell = self.height - 2.35 * r;
        b.paint(carved);
        self.base(b, around);
        b.paint(shaft);
        let up = b.steps(3.0, 1);
        // A shaft swells a little before it narrows.
        let width = |v: f32| r * (1.0 - 0.17 * v * v + 0.03 * (PI * v).sin());
        b.turned([around, up], |v| Vec2::new(width(v), 0.95 * r + (bell - 0.95 * r) * v));
        b.paint(carved);
        torus(b, around, [bell - 0.12 * r, bell + 0.12 * r], 0.82 * r, 0.14 * r);
        self.capital(b, around, bell);
    }

    fn base(self, b: &mut Builder, around: usize) {
        let r = self.radius;
        let plinth = Vec3::new(1.5 * r, 0.0, 1.5 * r);
        b.cuboid(-plinth - Vec3::Y * 0.02, plinth + Vec3::Y * 0.4 * r);
        torus(b, around, [0.38 * r, 0.68 * r], 1.28 * r, 0.16 * r);
        torus(b, around, [0.67 * r, 0.98 * r], 1.04 * r, 0.14 * r);
    }

    fn capital(self, b: &mut Builder, around: usize, bell: f32) {
        let r = self.radius;
        let tall = 1.75 * r;
        let flare = |v: f32| r * (0.83 + 0.1 * v + 0.4 * v.powi(4));
        let up = b.steps(3.0, 1);
        b.turned([around, up], |v| Vec2::new(flare(v), bell + 0.1 * r + tall * v));
        let a = self.abacus();
        b.cuboid(Vec3::new(-0.9 * a, bell + 1.8 * r, -0.9 * a), Vec3::new(0.9 * a, bell + 2.12 * r, 0.9 * a));
        b.cuboid(Vec3::new(-a, bell + 2.05 * r, -a), Vec3::new(a, bell + 2.35 * r, a));
        // Coarse columns have plain bells.
        let rows = self.leaves * b.steps(1.0, 0).min(1);
        for row in 0..rows {
            let (low, long) = (bell + 0.1 * r + 0.55 * r * row as f32, 0.62 * tall);
            for leaf in 0..8 {
                let turn = (leaf as f32 + 0.5 * row as f32) * PI / 4.0;
                b.at(Affine3A::from_rotation_y(turn), |b| acanthus(b, r, low, long, 0.5 * row as f32));
            }
        }
    }
}

/// A leaf in front of the bell of a capital, curling over at its tip.
fn acanthus(b: &mut Builder, r: f32, low: f32, long: f32, lift: f32) {
    let cells = [b.steps(2.0, 2), b.steps(3.0, 2)];
    b.patch(cells, true, |u, v| {
        let half = 0.36 * r * (1.0 - 0.75 * v * v);
        let side = 2.0 * u - 1.0;
        let out = r * (0.88 + 0.2 * lift * v + 0.12 * v + 0.42 * v.powi(4) - 0.12 * side * side);
        Vec3::new(half * side, low + long * (v - 0.22 * v.powi(6)), out)
    });
}

/// A round bar of `radius` along `path`, which lies in the plane at right angles to `side`; `cells` counts around and
/// along.
pub(super) fn bar(b: &mut Builder, cells: [usize; 2], radius: f32, side: Vec3, path: impl Fn(f32) -> Vec3) {
    const STEP: f32 = 1.0 / 256.0;
    b.patch(cells, true, |u, v| {
        let middle = v.clamp(STEP, 1.0 - STEP);
        let tangent = (path(middle + STEP) - path(middle - STEP)).normalize();
        let (sin, cos) = (2.0 * PI * u).sin_cos();
        path(v) + radius * (side * cos + tangent.cross(side) * sin)
    });
}
