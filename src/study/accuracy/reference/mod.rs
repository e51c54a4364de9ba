//! A second renderer for geometry, to measure the first one by: slow, plain, in f64, and with nothing in common with the
//! kernels but the mesh.
//!
//! It takes vertices and rays as the f32 numbers that they are and rounds nothing: vertices relative to the origin are
//! differences in f64, signs of determinants that f64 cannot know are decided with twice that precision, and what even
//! that leaves open lies on an edge, which belongs to the triangle. (The kernels' contract rounds relative vertices to f32
//! once; how much that changes is among the things that are measured.) Its tree halves the triangles by their centres.

mod tree;
mod triangle;

use crate::scene::{Light, TriangleMesh};
use glam::DVec3;
use tree::Tree;
pub use triangle::Crossing;
use triangle::crossing;

/// A first hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// The triangle.
    pub prim: u32,
    /// Depth, and the weights of the triangle's second and third corner.
    pub at: Crossing,
}

/// A ray; `t` counts in lengths of `dir`.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Where it starts.
    pub org: DVec3,
    /// Where it goes; not zero.
    pub dir: DVec3,
    /// Where it ends.
    pub end: f64,
    /// A triangle that it does not see.
    pub skip: Option<u32>,
}

/// Depths that differ by less of themselves are equal: the lower number wins.
const EQUAL: f64 = 1.0e-12;
/// Share of a shadow ray, and of the size of the coordinates, that is left out at the surface that it belongs to.
const CONTACT: f64 = 1.0e-6;

/// A mesh ready to be traced.
pub struct Reference<'a> {
    mesh: &'a TriangleMesh,
    tree: Tree,
}

impl<'a> Reference<'a> {
    /// Builds the tree.
    pub fn new(mesh: &'a TriangleMesh) -> Reference<'a> {
        Reference { mesh, tree: Tree::new(mesh) }
    }

    /// The crossing of a ray with one triangle, if it passes through it, at whatever depth.
    pub fn crossing(&self, prim: u32, line: &Line) -> Option<Crossing> {
        crossing(self.mesh.corners(prim as usize).map(|p| p.as_dvec3() - line.org), line.dir)
    }

    /// The first hit of a ray.
    pub fn intersect(&self, line: &Line) -> Option<FirstHit> {
        let mut best = None;
        self.tree.visit(line, |prim, _| self.improve(&mut best, prim, line));
        best
    }

    /// The same by trying every triangle.
    pub fn intersect_all(&self, line: &Line) -> Option<FirstHit> {
        let mut best = None;
        (0..self.mesh.len() as u32).for_each(|prim| {
            self.improve(&mut best, prim, line);
        });
        best
    }

    /// Takes a triangle that is hit earlier; returns how far the ray still goes.
    fn improve(&self, best: &mut Option<FirstHit>, prim: u32, line: &Line) -> f64 {
        let end = best.map_or(line.end, |hit: FirstHit| hit.at.t * (1.0 + EQUAL));
        if line.skip != Some(prim)
            && let Some(at) = self.crossing(prim, line)
            && at.t >= 0.0
            && at.t <= end
        {
            let nearer = best.is_none_or(|hit| at.t < hit.at.t * (1.0 - EQUAL) || prim < hit.prim);
            if nearer {
                *best = Some(FirstHit { prim, at });
            }
        }
        best.map_or(line.end, |hit| hit.at.t * (1.0 + EQUAL))
    }

    /// Whether anything lies on a ray.
    pub fn occluded(&self, line: &Line) -> bool {
        let mut found = false;
        self.tree.visit(line, |prim, _| {
            let hit =
                line.skip != Some(prim) && self.crossing(prim, line).is_some_and(|at| within(at.t, line));
            found |= hit;
            if found { -1.0 } else { line.end }
        });
        found
    }

    /// Whether a light without extent reaches the point where `line` hits `hit`: in front of the surface, as seen from
    /// where the ray came, inside the light's cone, and with nothing in between.
    pub fn lit(&self, line: &Line, hit: &FirstHit, light: &Light) -> bool {
        let point = line.org + line.dir * hit.at.t;
        let [a, b, c] = self.mesh.corners(hit.prim as usize).map(|p| p.as_dvec3());
        let normal = (b - a).cross(c - a);
        let normal = if normal.dot(line.dir) > 0.0 { -normal } else { normal };
        let size = [a, b, c, line.org].iter().fold(0.0f64, |most, p| most.max(p.abs().max_element()));
        match *light {
            Light::Directional { direction, .. } => {
                let dir = -direction.as_dvec3();
                let org = point + normal.normalize_or_zero() * (CONTACT * size);
                let line = Line { org, dir, end: f64::INFINITY, skip: Some(hit.prim) };
                normal.dot(dir) > 0.0 && !self.occluded(&line)
            }
            Light::Point { position, .. } => self.reached(position.as_dvec3(), point, normal, hit.prim),
            Light::Spot { position, direction, outer, .. } => {
                let way = point - position.as_dvec3();
                let inside = way.normalize_or_zero().dot(direction.as_dvec3()) > f64::from(outer).cos();
                inside && self.reached(position.as_dvec3(), point, normal, hit.prim)
            }
        }
    }

    fn reached(&self, from: DVec3, point: DVec3, normal: DVec3, prim: u32) -> bool {
        let dir = point - from;
        let line = Line { org: from, dir, end: 1.0 - CONTACT, skip: Some(prim) };
        normal.dot(dir) < 0.0 && !self.occluded(&line)
    }
}

fn within(t: f64, line: &Line) -> bool {
    t >= 0.0 && t <= line.end
}
