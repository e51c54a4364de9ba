//! The ground that spawned rays start from: where exactly, on which side, and how far the ray came.

use super::{table::PathTable, wide};
use crate::{
    kernels::{F32, HitBlock, I32, Kernel, MISS, Mask, SUB, Simd},
    shade::{
        SurfaceTable, Surfaces,
        spawn::{Footing, bulge},
        surface::Planes,
    },
};

/// What surfaces need to have rays spawned; one entry per ray, as in [`Surfaces`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Ground {
    /// Barycentric weights of the second and third corner.
    pub(super) b: [Vec<f32>; 2],
    /// Length of the ray that came.
    pub(super) distance: Vec<f32>,
    /// Where rays start towards the viewer's side.
    pub(super) out: Planes,
    /// Where rays start that go through the surface.
    pub(super) through: Planes,
    /// Where rays from lights end: the hit point, or the smooth surface above it.
    pub(super) end: Planes,
    /// Unit normals of the planes above which light is seen: those of the triangles, or of the smooth surface.
    pub(super) horizon: Planes,
    /// 1 where the ray came from outside, by the order of the corners; else -1.
    pub(super) side: Vec<f32>,
    /// Share of the surface that is there.
    pub(super) alpha: Vec<f32>,
    /// Emission.
    pub(super) ke: Planes,
    /// Ambient light reflected, before occlusion.
    pub(super) ambient: Planes,
    /// 0 where a mirror image shows emitters already, else 1.
    pub(super) highlight: Vec<f32>,
}

impl Ground {
    /// Makes room for `len` rays, a multiple of 16.
    pub(crate) fn resize(&mut self, len: usize) {
        let Ground { out, through, end, horizon, ke, ambient, .. } = self;
        let planes = [out, through, end, horizon, ke, ambient];
        let [b1, b2] = &mut self.b;
        let single = [b1, b2, &mut self.distance, &mut self.side, &mut self.alpha, &mut self.highlight];
        for plane in planes.into_iter().flatten().chain(single) {
            plane.resize(len, 0.0);
        }
    }

    /// Keeps a hit of a camera ray.
    pub(crate) fn keep(&mut self, ray: usize, [b1, b2]: [f32; 2], distance: f32) {
        (self.b[0][ray], self.b[1][ray], self.distance[ray]) = (b1, b2, distance);
    }

    /// Keeps the hits of blocks of rays whose directions have length 1.
    pub(super) fn keep_blocks(&mut self, hits: &[HitBlock]) {
        for (block, hits) in hits.iter().enumerate() {
            let at = block * SUB..(block + 1) * SUB;
            self.b[0][at.clone()].copy_from_slice(&hits.u);
            self.b[1][at.clone()].copy_from_slice(&hits.v);
            self.distance[at].copy_from_slice(&hits.t);
        }
    }
}

/// Finds the starts of spawned rays, for surfaces that are finished. `POINT`: also replaces the hit points by those that the
/// barycentric weights give, which are closer to the triangle. `BULGE`: rays start on the smooth surface, and what lies above
/// that is seen; shading normals must not be bent yet.
pub(super) struct Stand<'a, const POINT: bool, const BULGE: bool> {
    pub(super) table: &'a SurfaceTable,
    pub(super) paths: &'a PathTable<'a>,
    pub(super) surfaces: &'a mut Surfaces,
    pub(super) ground: &'a mut Ground,
}

impl<const POINT: bool, const BULGE: bool> Kernel for Stand<'_, POINT, BULGE> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Stand { table, paths, surfaces, ground } = self;
        let one = F32::<S, 16>::splat(s, 1.0);
        for at in (0..surfaces.len()).step_by(SUB) {
            let mut corners = [[[0.0; SUB]; 3]; 3];
            let mut normals = [[[0.0; SUB]; 3]; 3];
            let mut raw = [[0.0; SUB]; 3];
            for lane in 0..SUB {
                let prim = surfaces.prim[at + lane];
                if prim == MISS {
                    continue;
                }
                let (corner, facet) = (&paths.corners[prim as usize], &table.facets[prim as usize]);
                for k in 0..3 {
                    raw[k][lane] = facet.ng[k];
                    for i in 0..3 {
                        corners[i][k][lane] = corner[i][k];
                        if BULGE {
                            normals[i][k][lane] = facet.corner[i][k];
                        }
                    }
                }
            }
            let ng = load3(s, &surfaces.ng, at);
            let side = one.flip(wide::dot(ng, wide::load(s, &raw)).sign());
            side.store_at(&mut ground.side, at);
            let [ca, cb, cc] = &corners;
            let corners = [wide::load(s, ca), wide::load(s, cb), wide::load(s, cc)];
            let b = [F32::load_at(s, &ground.b[0], at), F32::load_at(s, &ground.b[1], at)];
            let footing = Footing::new(s, &corners, b);
            let behind = [-ng[0], -ng[1], -ng[2]];
            store3(footing.start(s, &behind), &mut ground.through, at);
            if POINT {
                let hit = lanes_hit(s, surfaces, at);
                for k in 0..3 {
                    let point = F32::load_at(s, &surfaces.point[k], at);
                    hit.select(footing.point[k], point).store_at(&mut surfaces.point[k], at);
                }
            }
            if BULGE {
                let [na, nb, nc] = &normals;
                let [na, nb, nc] = [wide::load(s, na), wide::load(s, nb), wide::load(s, nc)];
                // To the viewer's side as the shading normal was, whatever the order of the corners says.
                let rest = wide::add(wide::scale(nb, b[0]), wide::scale(nc, b[1]));
                let turned = wide::dot(wide::add(wide::scale(na, one - b[0] - b[1]), rest), ng).sign();
                let normals = [wide::flip(na, turned), wide::flip(nb, turned), wide::flip(nc, turned)];
                let by = bulge(s, &corners, &normals, &ng, &footing.point, b);
                let moved = footing.moved(s, &by);
                store3(moved.point, &mut ground.end, at);
                store3(moved.start(s, &ng), &mut ground.out, at);
                store3(load3(s, &surfaces.ns, at), &mut ground.horizon, at);
            } else {
                store3(load3(s, &surfaces.point, at), &mut ground.end, at);
                store3(footing.start(s, &ng), &mut ground.out, at);
                store3(ng, &mut ground.horizon, at);
            }
        }
    }
}

/// What rays along `dir` from surfaces leave out: the triangles that they start on, unless they lead below them.
#[inline(always)]
pub(super) fn left_out<S: Simd>(s: S, surfaces: &Surfaces, at: usize, dir: wide::V3<S>) -> I32<S, 16> {
    let above = F32::splat(s, 0.0).lt(wide::dot(load3(s, &surfaces.ng, at), dir));
    above.iselect(wide::lanes(s, &surfaces.prim, at), I32::splat(s, MISS))
}

/// Lanes whose ray hit something.
#[inline(always)]
pub(super) fn lanes_hit<S: Simd>(s: S, surfaces: &Surfaces, at: usize) -> Mask<S, 16> {
    let missed = wide::lanes(s, &surfaces.prim, at).eq(I32::splat(s, MISS));
    Mask::from_bits(s, !missed.bits() & 0xffff)
}

#[inline(always)]
pub(super) fn load3<S: Simd>(s: S, planes: &Planes, at: usize) -> wide::V3<S> {
    [F32::load_at(s, &planes[0], at), F32::load_at(s, &planes[1], at), F32::load_at(s, &planes[2], at)]
}

#[inline(always)]
pub(super) fn store3<S: Simd>(v: wide::V3<S>, planes: &mut Planes, at: usize) {
    for k in 0..3 {
        v[k].store_at(&mut planes[k], at);
    }
}
