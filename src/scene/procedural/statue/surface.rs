//! Turns a [`Field`] into a closed mesh.
//!
//! ```text
//!   field --surface nets--> quads --relax--> triangles --split n x n--> mesh
//! ```
//!
//! Surface nets put one vertex into every grid cell that the surface crosses and one quad across every grid edge that
//! it crosses: closed by construction. Fine meshes split a coarse one, so that no grid has to hold billions of cells.

use super::field::Field;
use glam::{UVec3, Vec3};
use std::collections::HashMap;

/// An indexed triangle list.
#[derive(Default)]
pub(super) struct Surface {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// The grid that a surface is found on: a box from `min`, cells of side `cell`.
pub(super) struct Grid {
    pub(super) min: Vec3,
    pub(super) cell: f32,
    /// Number of cells along each axis.
    pub(super) cells: UVec3,
}

/// Cells of a block whose middle alone decides whether the surface can be inside it.
const BLOCK: u32 = 8;
/// Rounds of evening out the vertices.
const ROUNDS: usize = 6;

impl Grid {
    /// The grid with cells of side `cell` over the box from `min` to `max`.
    pub(super) fn new(min: Vec3, max: Vec3, cell: f32) -> Grid {
        let blocks = ((max - min) / (cell * BLOCK as f32)).ceil().as_uvec3();
        Grid { min, cell, cells: blocks * BLOCK }
    }

    fn place(&self, x: u32, y: u32, z: u32) -> Vec3 {
        self.min + Vec3::new(x as f32, y as f32, z as f32) * self.cell
    }

    fn index(&self, x: u32, y: u32, z: u32) -> usize {
        let row = (self.cells.x + 1) as usize;
        (z as usize * (self.cells.y + 1) as usize + y as usize) * row + x as usize
    }

    /// Values at all grid corners; far from the surface only their sign is right.
    fn values(&self, field: &Field) -> Vec<f32> {
        let n = self.cells;
        let mut values = vec![1.0; self.index(0, 0, n.z + 1)];
        let half = BLOCK as f32 / 2.0 * self.cell;
        for z in (0..n.z).step_by(BLOCK as usize) {
            for y in (0..n.y).step_by(BLOCK as usize) {
                for x in (0..n.x).step_by(BLOCK as usize) {
                    let middle = field.sample(self.place(x, y, z) + half).value;
                    // Twice the half diagonal: the field is not quite a distance.
                    let crossed = middle.abs() < 2.0 * half * 3f32.sqrt();
                    self.fill(field, [x, y, z], (!crossed).then_some(middle), &mut values);
                }
            }
        }
        values
    }

    fn fill(&self, field: &Field, [x, y, z]: [u32; 3], known: Option<f32>, values: &mut [f32]) {
        for k in z..=z + BLOCK {
            for j in y..=y + BLOCK {
                for i in x..=x + BLOCK {
                    values[self.index(i, j, k)] =
                        known.unwrap_or_else(|| field.sample(self.place(i, j, k)).value);
                }
            }
        }
    }
}

/// The surface of `field` inside `grid`, its quads of about even shape, all vertices on the surface.
pub(super) fn polygonise(field: &Field, grid: &Grid) -> Surface {
    let values = grid.values(field);
    let (mut positions, mut quads) = nets(grid, &values);
    for p in &mut positions {
        *p = field.project(*p);
    }
    for _ in 0..ROUNDS {
        relax(field, &mut positions, &quads);
    }
    let mut triangles = Vec::with_capacity(quads.len() * 2);
    for quad in quads.drain(..) {
        let [a, b, c, d] = quad;
        let length = |i: u32, j: u32| positions[i as usize].distance_squared(positions[j as usize]);
        let halves =
            if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        triangles.extend(halves);
    }
    Surface { positions, triangles }
}

/// One vertex per crossed cell, at the mean of its edge crossings, and one quad per crossed edge, facing outwards.
fn nets(grid: &Grid, values: &[f32]) -> (Vec<Vec3>, Vec<[u32; 4]>) {
    let mut positions = Vec::new();
    let mut vertex_of: HashMap<[u32; 3], u32> = HashMap::new();
    let mut vertex = |cell: [u32; 3]| {
        *vertex_of.entry(cell).or_insert_with(|| {
            positions.push(crossing_mean(grid, values, cell));
            positions.len() as u32 - 1
        })
    };
    let mut quads = Vec::new();
    let n = grid.cells.to_array();
    for z in 1..n[2] {
        for y in 1..n[1] {
            for x in 1..n[0] {
                let at = [x, y, z];
                let here = values[grid.index(x, y, z)] < 0.0;
                for axis in 0..3 {
                    let next = step(at, axis);
                    if here == (values[grid.index(next[0], next[1], next[2])] < 0.0) {
                        continue;
                    }
                    // The four cells around the edge, counter-clockwise as seen against the axis.
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let cell = |du: u32, dv: u32| {
                        let mut cell = at;
                        cell[u] -= du;
                        cell[v] -= dv;
                        cell
                    };
                    let [a, b, c, d] = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)].map(&mut vertex);
                    quads.push(if here { [a, b, c, d] } else { [a, d, c, b] });
                }
            }
        }
    }
    (positions, quads)
}

fn step(mut at: [u32; 3], axis: usize) -> [u32; 3] {
    at[axis] += 1;
    at
}

fn crossing_mean(grid: &Grid, values: &[f32], cell: [u32; 3]) -> Vec3 {
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for [du, dv] in [[0, 0], [0, 1], [1, 0], [1, 1]] {
            let mut a = cell;
            a[u] += du;
            a[v] += dv;
            let b = step(a, axis);
            let [va, vb] = [a, b].map(|c| values[grid.index(c[0], c[1], c[2])]);
            if (va < 0.0) != (vb < 0.0) {
                let [pa, pb] = [a, b].map(|c| grid.place(c[0], c[1], c[2]));
                sum += pa.lerp(pb, va / (va - vb));
                count += 1.0;
            }
        }
    }
    sum / count
}

/// Moves every vertex half way to the mean of its neighbours, then back onto the surface.
fn relax(field: &Field, positions: &mut [Vec3], quads: &[[u32; 4]]) {
    let mut sum = vec![(Vec3::ZERO, 0.0); positions.len()];
    for quad in quads {
        for k in 0..4 {
            let (here, next) = (quad[k] as usize, quad[(k + 1) % 4] as usize);
            sum[here].0 += positions[next];
            sum[here].1 += 1.0;
        }
    }
    for (p, (neighbours, count)) in positions.iter_mut().zip(sum) {
        *p = field.project(p.lerp(neighbours / count, 0.5));
    }
}

/// Splits every triangle into `n` x `n`, the new vertices on the surface.
pub(super) fn split(field: &Field, coarse: &Surface, n: u32) -> Surface {
    if n == 1 {
        return Surface { positions: coarse.positions.clone(), triangles: coarse.triangles.clone() };
    }
    let mut splitter = Splitter { field, n, fine: Surface::default(), edges: HashMap::new() };
    splitter.fine.positions.clone_from(&coarse.positions);
    for &corners in &coarse.triangles {
        splitter.triangle(corners);
    }
    splitter.fine
}

struct Splitter<'a> {
    field: &'a Field,
    n: u32,
    fine: Surface,
    /// First of the n - 1 vertices on the edge from the lower to the higher vertex.
    edges: HashMap<[u32; 2], u32>,
}

impl Splitter<'_> {
    fn add(&mut self, p: Vec3) -> u32 {
        self.fine.positions.push(self.field.project(p));
        self.fine.positions.len() as u32 - 1
    }

    /// Vertex `k` of n on the way from `a` to `b`, shared by both triangles of the edge.
    fn on_edge(&mut self, a: u32, b: u32, k: u32) -> u32 {
        let (low, high, k) = if a < b { (a, b, k) } else { (b, a, self.n - k) };
        if k == 0 || k == self.n {
            return if k == 0 { low } else { high };
        }
        if let Some(first) = self.edges.get(&[low, high]) {
            return first + k - 1;
        }
        let ends = [low, high].map(|v| self.fine.positions[v as usize]);
        let first = self.fine.positions.len() as u32;
        for i in 1..self.n {
            self.add(ends[0].lerp(ends[1], i as f32 / self.n as f32));
        }
        self.edges.insert([low, high], first);
        first + k - 1
    }

    fn triangle(&mut self, [a, b, c]: [u32; 3]) {
        let n = self.n;
        let [pa, pb, pc] = [a, b, c].map(|v| self.fine.positions[v as usize]);
        let mut above = vec![a];
        for row in 1..=n {
            let mut below = Vec::with_capacity(row as usize + 1);
            for i in 0..=row {
                below.push(match (row, i) {
                    (_, 0) => self.on_edge(a, b, row),
                    (row, i) if i == row => self.on_edge(a, c, row),
                    (row, i) if row == n => self.on_edge(b, c, i),
                    _ => self.add(pa + ((pb - pa) * (row - i) as f32 + (pc - pa) * i as f32) / n as f32),
                });
            }
            for i in 0..row as usize {
                self.fine.triangles.push([above[i], below[i], below[i + 1]]);
                if i + 1 < row as usize {
                    self.fine.triangles.push([above[i], below[i + 1], above[i + 1]]);
                }
            }
            above = below;
        }
    }
}
