//! Turns a [`Field`] into a closed mesh.
//!
//! ```text
//!   field --marching tetrahedra--> triangles --relax--> even triangles --split n x n--> mesh
//! ```
//!
//! A tetrahedron has no ambiguous case: the mesh is closed, every edge between two triangles, whatever the field.
//! Fine meshes split a coarse one, so that no grid has to hold billions of cells.

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

/// The surface of `field` inside `grid`, its triangles of about even shape, all vertices on the surface.
pub(super) fn polygonise(field: &Field, grid: &Grid) -> Surface {
    let values = grid.values(field);
    let mut march = March { grid, values: &values, surface: Surface::default(), vertex_of: HashMap::new() };
    march.all();
    let mut surface = march.surface;
    for p in &mut surface.positions {
        *p = field.project(*p);
    }
    for _ in 0..ROUNDS {
        relax(field, &mut surface);
    }
    surface
}

/// The six ways to walk from the low to the high corner of a cell along its axes, each a tetrahedron; corners are
/// bit masks of axes.
const TETRAHEDRA: [[u32; 4]; 6] =
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

struct March<'a> {
    grid: &'a Grid,
    values: &'a [f32],
    surface: Surface,
    /// Vertex on the edge from a grid corner along a mask of axes.
    vertex_of: HashMap<(usize, u32), u32>,
}

impl March<'_> {
    fn all(&mut self) {
        let n = self.grid.cells;
        for z in 0..n.z {
            for y in 0..n.y {
                for x in 0..n.x {
                    let inside = |mask: u32| self.value([x, y, z], mask) < 0.0;
                    let count = (0..8).filter(|&mask| inside(mask)).count();
                    if count > 0 && count < 8 {
                        for tetrahedron in TETRAHEDRA {
                            self.tetrahedron([x, y, z], tetrahedron);
                        }
                    }
                }
            }
        }
    }

    fn index(&self, [x, y, z]: [u32; 3], mask: u32) -> usize {
        self.grid.index(x + (mask & 1), y + (mask >> 1 & 1), z + (mask >> 2))
    }

    fn value(&self, cell: [u32; 3], mask: u32) -> f32 {
        self.values[self.index(cell, mask)]
    }

    fn place(&self, [x, y, z]: [u32; 3], mask: u32) -> Vec3 {
        self.grid.place(x + (mask & 1), y + (mask >> 1 & 1), z + (mask >> 2))
    }

    /// The vertex on the edge between two corners of a cell.
    fn vertex(&mut self, cell: [u32; 3], one: u32, other: u32) -> u32 {
        let (low, high) = (one.min(other), one.max(other));
        let key = (self.index(cell, low), high ^ low);
        if let Some(&vertex) = self.vertex_of.get(&key) {
            return vertex;
        }
        let (a, b) = (self.value(cell, low), self.value(cell, high));
        // Off the corners, where several vertices would coincide.
        let t = (a / (a - b)).clamp(0.1, 0.9);
        self.surface.positions.push(self.place(cell, low).lerp(self.place(cell, high), t));
        let vertex = self.surface.positions.len() as u32 - 1;
        self.vertex_of.insert(key, vertex);
        vertex
    }

    fn tetrahedron(&mut self, cell: [u32; 3], corners: [u32; 4]) {
        let (inner, outer): (Vec<u32>, Vec<u32>) = corners.iter().partition(|&&c| self.value(cell, c) < 0.0);
        let mut polygon = Vec::with_capacity(4);
        match (inner.as_slice(), outer.as_slice()) {
            (&[a], others) | (others, &[a]) => {
                polygon.extend(others.iter().map(|&other| self.vertex(cell, a, other)));
            }
            (&[a, b], &[c, d]) => {
                polygon.extend([(a, c), (a, d), (b, d), (b, c)].map(|(i, o)| self.vertex(cell, i, o)));
            }
            _ => return,
        }
        let outwards = self.place(cell, outer[0]) - self.place(cell, inner[0]);
        let [a, b, c] = [0, 1, 2].map(|i| self.surface.positions[polygon[i] as usize]);
        if (b - a).cross(c - a).dot(outwards) < 0.0 {
            polygon.reverse();
        }
        for i in 2..polygon.len() {
            self.surface.triangles.push([polygon[0], polygon[i - 1], polygon[i]]);
        }
    }
}

/// Moves every vertex half way to the mean of its neighbours, then back onto the surface.
fn relax(field: &Field, surface: &mut Surface) {
    let mut sum = vec![(Vec3::ZERO, 0.0); surface.positions.len()];
    for triangle in &surface.triangles {
        for k in 0..3 {
            let (here, next) = (triangle[k] as usize, triangle[(k + 1) % 3] as usize);
            sum[here].0 += surface.positions[next];
            sum[here].1 += 1.0;
        }
    }
    for (p, (neighbours, count)) in surface.positions.iter_mut().zip(sum) {
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
