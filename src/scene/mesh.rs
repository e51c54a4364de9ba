//! Triangle meshes.

use crate::math::Aabb;
use glam::{Vec2, Vec3};

/// A named range of triangles: one mesh, group or generated piece.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Name as the source gave it.
    pub name: String,
    /// First triangle.
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
}

/// An indexed triangle list. Triangle `i` has the primitive id `i` everywhere in irt.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    /// Vertex positions, all finite.
    pub positions: Vec<Vec3>,
    /// Vertex normals: empty, or one per position; the zero vector means "use the triangle's own normal".
    pub normals: Vec<Vec3>,
    /// Texture coordinates: empty, or one per position. (0, 0) is the lower left corner of an image, (1, 1) its upper right one.
    pub uvs: Vec<Vec2>,
    /// Vertex indices of each triangle, all below `positions.len()`. No triangle has exactly zero area, but one that moves
    /// may have at times.
    pub triangles: Vec<[u32; 3]>,
    /// Material index of each triangle.
    pub materials: Vec<u32>,
    /// Where the triangles came from, in order, without gaps.
    pub parts: Vec<Part>,
}

impl TriangleMesh {
    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// True if there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The three corners of triangle `prim`.
    pub fn corners(&self, prim: usize) -> [Vec3; 3] {
        self.triangles[prim].map(|v| self.positions[v as usize])
    }

    /// Box around all triangles (unreferenced vertices do not count).
    pub fn bounds(&self) -> Aabb {
        let mut aabb = Aabb::EMPTY;
        for &[a, b, c] in &self.triangles {
            for v in [a, b, c] {
                aabb.grow(self.positions[v as usize]);
            }
        }
        aabb
    }
}
