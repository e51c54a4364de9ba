//! Boxes about halves of triangles about halves, down to a few.

use super::Line;
use crate::scene::TriangleMesh;
use glam::DVec3;

/// Most triangles of a leaf.
const LEAF: usize = 4;

struct Node {
    low: DVec3,
    high: DVec3,
    /// Triangles of a leaf, as a range of the order; of an inner node, the number of its second child twice (its first
    /// one follows it).
    range: [usize; 2],
}

/// A binary tree.
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Tree {
    pub(super) fn new(mesh: &TriangleMesh) -> Tree {
        let center = |prim: u32| {
            let [a, b, c] = mesh.corners(prim as usize).map(|p| p.as_dvec3());
            a.min(b).min(c) + a.max(b).max(c)
        };
        let centers: Vec<DVec3> = (0..mesh.len() as u32).map(center).collect();
        let mut tree = Tree { nodes: vec![], order: (0..mesh.len() as u32).collect() };
        if !mesh.is_empty() {
            tree.build(mesh, &centers, 0, mesh.len());
        }
        tree
    }

    fn build(&mut self, mesh: &TriangleMesh, centers: &[DVec3], from: usize, to: usize) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut first, mut last) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &prim in &self.order[from..to] {
            for corner in mesh.corners(prim as usize).map(|p| p.as_dvec3()) {
                (low, high) = (low.min(corner), high.max(corner));
            }
            let center = centers[prim as usize];
            (first, last) = (first.min(center), last.max(center));
        }
        let number = self.nodes.len();
        self.nodes.push(Node { low, high, range: [from, to] });
        if to - from <= LEAF {
            return;
        }
        let axis = (0..3).max_by(|&a, &b| (last - first)[a].total_cmp(&(last - first)[b])).unwrap_or(0);
        let middle = (from + to) / 2;
        let by = |a: &u32, b: &u32| centers[*a as usize][axis].total_cmp(&centers[*b as usize][axis]);
        self.order[from..to].select_nth_unstable_by(middle - from, by);
        self.build(mesh, centers, from, middle);
        let second = self.nodes.len();
        self.nodes[number].range = [second, second];
        self.build(mesh, centers, middle, to);
    }

    /// Visits triangles that a ray may hit, with the greatest depth so far that matters; `visit` tells the next one.
    pub(super) fn visit(&self, line: &Line, mut visit: impl FnMut(u32, f64) -> f64) {
        let (mut waiting, mut end) = (vec![], line.end);
        if !self.nodes.is_empty() {
            waiting.push(0);
        }
        while let Some(number) = waiting.pop() {
            let node = &self.nodes[number];
            if !node.meets(line, end) {
                continue;
            }
            let [from, to] = node.range;
            if from == to {
                // The nearer child is visited first; either order is right.
                waiting.extend([from, number + 1]);
            } else {
                for &prim in &self.order[from..to] {
                    end = visit(prim, end);
                }
            }
        }
    }
}

impl Node {
    /// Whether a ray meets the box before `end`; in doubt, it does.
    fn meets(&self, line: &Line, end: f64) -> bool {
        let (mut near, mut far) = (0.0f64, end);
        for axis in 0..3 {
            let (low, high) = (self.low[axis] - line.org[axis], self.high[axis] - line.org[axis]);
            let d = line.dir[axis];
            if d == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let (a, b) = if d > 0.0 { (low / d, high / d) } else { (high / d, low / d) };
            // Some units in the last place more, for the rounding.
            near = near.max(a - 1.0e-14 * a.abs());
            far = far.min(b + 1.0e-14 * b.abs());
        }
        near <= far
    }
}
