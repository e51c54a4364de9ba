//! Meshes that are hard to hit and to miss: closed ones for watertightness, and families of others for the fuzzer.
//!
//! Closed meshes share the bits of their vertices, so that what exact arithmetic says about one triangle it says
//! about its neighbour as well:
//!
//! ```text
//!   sphere   slivers at the poles, no two edges alike
//!   cube     a lattice: rays that pass through vertices and along edges exactly, flat boxes, origins on planes
//!   spindle  two closed fans: many triangles about one vertex
//! ```

use super::random::Random;
use crate::scene::{Part, TriangleMesh};
use glam::{DVec3, Vec3};
use std::{f64::consts::PI, fmt};

/// A closed mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// Rows and columns of triangles.
    Sphere,
    /// Six lattices, each a wall along two axes.
    Cube,
    /// Two fans, each about an apex.
    Spindle,
}

impl Closed {
    /// All of them.
    pub const ALL: [Closed; 3] = [Closed::Sphere, Closed::Cube, Closed::Spindle];

    /// The mesh around `center`, no vertex nearer than 0.5 or farther than 1.8 radii. `detail` is the number of
    /// triangles along a quarter of it, at least 2. The cube's radius is rounded to a power of two.
    pub fn mesh(self, center: Vec3, radius: f32, detail: usize) -> TriangleMesh {
        match self {
            Closed::Sphere => sphere(center, radius, 2 * detail),
            Closed::Cube => cube(center, radius.log2().round().exp2(), detail),
            Closed::Spindle => spindle(center, radius, 4 * detail),
        }
    }
}

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Closed::Sphere => "sphere",
            Closed::Cube => "cube",
            Closed::Spindle => "spindle",
        })
    }
}

/// A mesh of indexed triangles; those without area are left out.
pub fn indexed(positions: Vec<Vec3>, mut triangles: Vec<[u32; 3]>) -> TriangleMesh {
    triangles.retain(|triangle| {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize].as_dvec3());
        (b - a).cross(c - a) != DVec3::ZERO
    });
    let count = triangles.len();
    TriangleMesh {
        positions,
        normals: Vec::new(),
        uvs: Vec::new(),
        triangles,
        materials: vec![0; count],
        parts: vec![Part { name: "made up".into(), first: 0, count: count as u32 }],
    }
}

/// A mesh of triangles that share no indices.
pub fn mesh_of(triangles: &[[Vec3; 3]]) -> TriangleMesh {
    let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    indexed(triangles.iter().flatten().copied().collect(), indices.collect())
}

/// A sphere of `rows` rows and twice as many columns; positions are rounded once.
pub fn sphere(center: Vec3, radius: f32, rows: usize) -> TriangleMesh {
    let columns = 2 * rows;
    let point = |row: usize, column: usize| {
        let (theta, phi) = (PI * row as f64 / rows as f64, 2.0 * PI * column as f64 / columns as f64);
        let on_unit = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        (center.as_dvec3() + f64::from(radius) * on_unit).as_vec3()
    };
    let mut positions = vec![point(0, 0)];
    positions.extend(
        (1..rows).flat_map(|row| (0..columns).map(move |column| (row, column))).map(|(r, c)| point(r, c)),
    );
    positions.push(center - radius * Vec3::Y);
    let last = positions.len() as u32 - 1;
    let at = |row: usize, column: usize| match row {
        0 => 0,
        row if row == rows => last,
        row => (1 + (row - 1) * columns + column % columns) as u32,
    };
    let mut triangles = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b] = [at(row, column), at(row, column + 1)];
        let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
        triangles.extend([[a, b, c], [b, d, c]].iter().filter(|[x, y, z]| x != y && y != z && x != z));
    }
    indexed(positions, triangles)
}

/// A cube of six walls of `2 * detail` squared cells.
pub fn cube(center: Vec3, half: f32, detail: usize) -> TriangleMesh {
    let cells = 2 * detail;
    let step = half / detail as f32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for wall in 0..6 {
        let (axis, side) = (wall / 2, if wall % 2 == 0 { -half } else { half });
        let first = positions.len() as u32;
        for (i, j) in (0..=cells).flat_map(|i| (0..=cells).map(move |j| (i, j))) {
            let mut at = Vec3::ZERO;
            at[axis] = side;
            at[(axis + 1) % 3] = i as f32 * step - half;
            at[(axis + 2) % 3] = j as f32 * step - half;
            positions.push(center + at);
        }
        let at = |i: usize, j: usize| first + (i * (cells + 1) + j) as u32;
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
            // Both diagonals occur.
            let pair = if (i + j) % 2 == 0 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] };
            triangles.extend(pair);
        }
    }
    indexed(positions, triangles)
}

/// Two fans of `segments` triangles over one ring of vertices.
pub fn spindle(center: Vec3, radius: f32, segments: usize) -> TriangleMesh {
    let ring = |i: usize| {
        let phi = 2.0 * PI * i as f64 / segments as f64;
        // Neither flat nor round.
        let r = f64::from(radius) * (1.0 + 0.2 * (5.0 * phi).sin());
        (center.as_dvec3() + DVec3::new(r * phi.cos(), 0.1 * r * (3.0 * phi).cos(), r * phi.sin())).as_vec3()
    };
    let mut positions =
        vec![center + radius * Vec3::new(0.1, 1.0, 0.05), center - radius * Vec3::new(0.05, 0.9, 0.1)];
    positions.extend((0..segments).map(ring));
    let at = |i: usize| 2 + (i % segments) as u32;
    indexed(positions, (0..segments).flat_map(|i| [[0, at(i), at(i + 1)], [1, at(i + 1), at(i)]]).collect())
}

/// A family of meshes for the fuzzer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Triangles anywhere, among them slivers, copies and axis-parallel ones.
    Soup,
    /// Squares of an uneven height field.
    Grid,
    /// Triangles about one vertex.
    Fan,
    /// Shells, each 4e-5 larger than the one before.
    Nested,
    /// Every triangle several times, its corners in another order.
    Duplicated,
    /// Whole coordinates between -4 and 4.
    Lattice,
}

impl Family {
    /// All of them.
    pub const ALL: [Family; 6] =
        [Family::Soup, Family::Grid, Family::Fan, Family::Nested, Family::Duplicated, Family::Lattice];

    /// About `count` triangles between -1 and 1 (-4 and 4 for the lattice), moved and scaled: `center + scale * p`.
    pub fn mesh(self, random: &mut Random, count: usize, center: Vec3, scale: f32) -> TriangleMesh {
        let mesh = match self {
            Family::Soup => soup(random, count),
            Family::Grid => grid(random, count),
            Family::Fan => fan(random, count),
            Family::Nested => nested(count),
            Family::Duplicated => duplicated(random, count),
            Family::Lattice => lattice(random, count),
        };
        let positions = mesh.positions.iter().map(|&p| center + scale * p).collect();
        indexed(positions, mesh.triangles)
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Family::Soup => "soup",
            Family::Grid => "grid",
            Family::Fan => "fan",
            Family::Nested => "nested",
            Family::Duplicated => "duplicated",
            Family::Lattice => "lattice",
        })
    }
}

fn soup(random: &mut Random, count: usize) -> TriangleMesh {
    let size = (2.0 / (count as f32).sqrt()).min(1.0);
    let mut triangles: Vec<[Vec3; 3]> = Vec::new();
    for _ in 0..count {
        let a = random.vec();
        let (mut b, mut c) = (a + size * random.vec(), a + size * random.vec());
        match random.below(10) {
            0 if !triangles.is_empty() => [_, b, c] = triangles[random.below(triangles.len())],
            1 => c = a + (b - a) * 0.5 + 1.0e-5 * size * random.vec(),
            2 => (b.z, c.z) = (a.z, a.z),
            3 => (b.x, c.x) = (a.x, a.x),
            _ => {}
        }
        triangles.push([a, b, c]);
    }
    mesh_of(&triangles)
}

fn grid(random: &mut Random, count: usize) -> TriangleMesh {
    let cells = ((count as f32 / 2.0).sqrt() as usize).max(1);
    let rough = random.of(&[0.0, 1.0e-6, 0.2]);
    let step = 2.0 / cells as f32;
    let place = |i: usize| i as f32 * step - 1.0;
    let at = |i: usize, j: usize| (i * (cells + 1) + j) as u32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (i, j) in (0..=cells).flat_map(|i| (0..=cells).map(move |j| (i, j))) {
        positions.push(Vec3::new(place(i), rough * random.signed(), place(j)));
        if i < cells && j < cells {
            triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    indexed(positions, triangles)
}

fn fan(random: &mut Random, count: usize) -> TriangleMesh {
    let rim = |i: usize| {
        let phi = 2.0 * std::f32::consts::PI * i as f32 / count as f32;
        Vec3::new(phi.cos(), 0.0, phi.sin())
    };
    let mut positions = vec![0.3 * random.vec()];
    positions.extend((0..count).map(rim));
    let at = |i: usize| 1 + (i % count) as u32;
    indexed(positions, (0..count).map(|i| [0, at(i), at(i + 1)]).collect())
}

fn nested(count: usize) -> TriangleMesh {
    let rows = ((count as f32 / 16.0).sqrt() as usize).max(2);
    let mut all = TriangleMesh::default();
    for shell in 0..4 {
        let mesh = sphere(Vec3::ZERO, 0.9 * (1.0 + 4.0e-5 * shell as f32), rows);
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|vertex| first + vertex)));
    }
    indexed(all.positions, all.triangles)
}

fn duplicated(random: &mut Random, count: usize) -> TriangleMesh {
    let mut mesh = soup(random, count.div_ceil(3));
    let once = mesh.triangles.clone();
    mesh.triangles.extend(once.iter().map(|&[a, b, c]| [b, c, a]));
    mesh.triangles.extend(once.iter().map(|&[a, b, c]| [c, b, a]));
    indexed(mesh.positions, mesh.triangles)
}

fn lattice(random: &mut Random, count: usize) -> TriangleMesh {
    let mut corner = || [0; 3].map(|_: i32| random.below(9) as f32 - 4.0);
    let triangles: Vec<_> = (0..count).map(|_| [corner(), corner(), corner()].map(Vec3::from)).collect();
    mesh_of(&triangles)
}
