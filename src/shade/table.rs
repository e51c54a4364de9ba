//! What shading needs to know of each triangle and material, in the form that is quickest to fetch.

use crate::{
    effects::{Effect, EffectSet, Reasons},
    scene::{Scene, TriangleMesh},
};
use glam::Vec3;

/// One triangle: a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Facet {
    /// Unit normal, by the order of the corners.
    pub(super) ng: [f32; 3],
    pub(super) material: u32,
    /// Unit normals at the corners.
    pub(super) corner: [[f32; 3]; 3],
}

/// The part of a material that shading uses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflectance {
    pub(super) kd: [f32; 3],
    pub(super) ks: [f32; 3],
    pub(super) ns: f32,
    /// Light that leaves the surface by itself: emission plus ambient reflection.
    pub(super) base: [f32; 3],
}

/// Shading data of a scene, built once.
#[derive(Clone, Debug)]
pub struct SurfaceTable {
    pub(super) facets: Vec<Facet>,
    pub(super) materials: Vec<Reflectance>,
    /// Normals of vertices count.
    smooth: bool,
    /// Bound of the rounding of a hit point, in world units: see [`super::light_rays`].
    pub(super) point_error: f32,
}

impl SurfaceTable {
    /// Collects the shading data of a scene with all the effects that it calls for.
    pub fn new(scene: &Scene) -> SurfaceTable {
        SurfaceTable::with_effects(scene, Reasons::new(scene).set())
    }

    /// The same with other effects: surfaces have neither highlights nor smooth normals, nor does light go through them,
    /// unless `set` has these.
    pub fn with_effects(scene: &Scene, set: EffectSet) -> SurfaceTable {
        let materials = scene
            .materials
            .iter()
            .map(|material| {
                let ambient = if material.ka == Vec3::ZERO { material.kd } else { material.ka };
                let refracts = material.refracts() && set.has(Effect::Refraction);
                let kd = if refracts { material.kd * material.d } else { material.kd };
                let ks = if set.has(Effect::Highlights) { material.ks } else { Vec3::ZERO };
                Reflectance {
                    kd: kd.to_array(),
                    ks: ks.to_array(),
                    ns: material.ns,
                    base: (material.ke + ambient * scene.ambient).to_array(),
                }
            })
            .collect();
        let smooth = set.has(Effect::SmoothNormals);
        let mut table = SurfaceTable { facets: Vec::new(), materials, smooth, point_error: 0.0 };
        table.pose(&scene.mesh);
        table
    }

    /// Takes the places and normals of the triangles, which may have moved since, from `mesh`.
    pub fn pose(&mut self, mesh: &TriangleMesh) {
        let SurfaceTable { facets, smooth, .. } = self;
        facets.clear();
        facets.extend((0..mesh.len()).map(|prim| Facet::new(mesh, prim, *smooth)));
        let bounds = mesh.bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        self.point_error = reach * ROUNDING;
    }
}

impl Facet {
    fn new(mesh: &TriangleMesh, prim: usize, smooth: bool) -> Facet {
        let [a, b, c] = mesh.corners(prim).map(Vec3::as_dvec3);
        let ng = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        let corner = mesh.triangles[prim].map(|vertex| {
            let normal = mesh.normals.get(vertex as usize).copied().unwrap_or(Vec3::ZERO);
            (if normal == Vec3::ZERO || !smooth { ng } else { normal }).to_array()
        });
        Facet { ng: ng.to_array(), material: mesh.materials[prim], corner }
    }
}

/// A hit point is a rounded vertex difference, a rounded depth, a product and a sum away from the truth: each at most
/// 2^-24 of the coordinates involved. Eight of those leave room.
pub(super) const ROUNDING: f32 = 8.0 / (1 << 24) as f32;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3Swizzles;

    #[test]
    fn after_a_move_the_table_is_that_of_a_scene_that_always_was_there() {
        // The statue is smooth.
        let mut scene = crate::scene::load("statue@0.1").unwrap();
        let mut table = SurfaceTable::new(&scene);
        let before = format!("{:?}", table.facets);
        for (position, normal) in scene.mesh.positions.iter_mut().zip(&mut scene.mesh.normals) {
            (*position, *normal) = (3.0 * Vec3::new(position.y, -position.x, position.z), -normal.yzx());
        }
        table.pose(&scene.mesh);
        let fresh = SurfaceTable::new(&scene);
        assert_ne!(format!("{:?}", table.facets), before);
        assert_eq!(format!("{:?}", table.facets), format!("{:?}", fresh.facets));
        assert!(table.facets.iter().any(|facet| facet.corner != [facet.ng; 3]), "normals of vertices count");
        assert_eq!(table.point_error, fresh.point_error);
    }
}
