//! The surfaces that a stream of rays hit: where, which way they face, and how they reflect.

use super::table::SurfaceTable;
use crate::kernels::{F32, Face, Kernel, Kernels, MISS, SUB, Simd, TILE_RAYS, TileHits, TilePacket};

/// Three planes of floats: x, y, z or r, g, b.
pub(super) type Planes = [Vec<f32>; 3];

/// Surfaces seen by a stream of rays; all arrays have one entry per ray, a multiple of 256.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    /// Primitive hit, or [`MISS`].
    pub prim: Vec<u32>,
    /// Hit points.
    pub(super) point: Planes,
    /// Unit normals of the triangles, towards the viewer.
    pub(super) ng: Planes,
    /// Unit shading normals, towards the viewer.
    pub(super) ns: Planes,
    /// Unit directions to the viewer.
    pub(super) view: Planes,
    pub(super) kd: Planes,
    pub(super) ks: Planes,
    pub(super) exponent: Vec<f32>,
    /// Light collected so far: linear colour leaving the surface towards the viewer.
    pub color: Planes,
}

impl Surfaces {
    /// Makes room for `packets` packets of 256 rays, all of which missed and see `background`.
    pub fn reset(&mut self, packets: usize, background: [f32; 3]) {
        let len = packets * TILE_RAYS;
        self.prim.clear();
        self.prim.resize(len, MISS);
        for planes in
            [&mut self.point, &mut self.ng, &mut self.ns, &mut self.view, &mut self.kd, &mut self.ks]
        {
            for plane in planes {
                plane.resize(len, 0.0);
            }
        }
        self.exponent.resize(len, 0.0);
        for (plane, value) in self.color.iter_mut().zip(background) {
            plane.clear();
            plane.resize(len, value);
        }
    }

    /// Number of rays.
    pub fn len(&self) -> usize {
        self.prim.len()
    }

    /// True if there is room for no ray.
    pub fn is_empty(&self) -> bool {
        self.prim.is_empty()
    }

    /// Takes the hits of the active rays of packet number `packet`. Call it once for each face of the packet, then
    /// [`Surfaces::finish`].
    pub fn gather(&mut self, table: &SurfaceTable, index: usize, packet: &TilePacket, hits: &TileHits) {
        let [iu, iv, iz] = packet.face.axes();
        let depth_sign = if packet.face.negative { -1.0 } else { 1.0 };
        for ray in 0..TILE_RAYS {
            let prim = hits.prim[ray];
            if packet.active[ray / SUB] >> (ray % SUB) & 1 == 0 || prim == MISS {
                continue;
            }
            let i = index * TILE_RAYS + ray;
            let facet = &table.facets[prim as usize];
            let material = &table.materials[facet.material as usize];
            let (b1, b2) = (hits.u[ray], hits.v[ray]);
            let b0 = 1.0 - b1 - b2;
            self.prim[i] = prim;
            self.exponent[i] = material.ns;
            // The direction for now; `finish` turns it into the direction to the viewer.
            self.view[iu][i] = packet.u[ray];
            self.view[iv][i] = packet.v[ray];
            self.view[iz][i] = depth_sign;
            for k in 0..3 {
                self.point[k][i] = packet.org[k] + hits.t[ray] * self.view[k][i];
                self.ng[k][i] = facet.ng[k];
                self.ns[k][i] = b0 * facet.corner[0][k] + b1 * facet.corner[1][k] + b2 * facet.corner[2][k];
                self.kd[k][i] = material.kd[k];
                self.ks[k][i] = material.ks[k];
                self.color[k][i] = material.base[k];
            }
        }
    }

    /// Normalises directions and turns normals towards the viewer.
    pub fn finish(&mut self, kernels: &Kernels) {
        kernels.run(Orient { surfaces: self });
    }
}

/// The face of no ray.
pub(super) const NO_FACE: u32 = Face::ALL.len() as u32;

struct Orient<'a> {
    surfaces: &'a mut Surfaces,
}

impl Kernel for Orient<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let surfaces = self.surfaces;
        for at in (0..surfaces.prim.len()).step_by(16) {
            let dir = load3(s, &surfaces.view, at);
            let scale = F32::splat(s, -1.0) / dot(dir, dir).sqrt();
            let view = [dir[0] * scale, dir[1] * scale, dir[2] * scale];
            store3(view, &mut surfaces.view, at);

            let ng = load3(s, &surfaces.ng, at);
            let turn = dot(ng, view).sign();
            let ng = [ng[0].flip(turn), ng[1].flip(turn), ng[2].flip(turn)];
            store3(ng, &mut surfaces.ng, at);

            // The shading normal goes to the same side as the triangle's own.
            let ns = load3(s, &surfaces.ns, at);
            let turn = dot(ns, ng).sign();
            let length = dot(ns, ns).sqrt();
            let long_enough = F32::splat(s, 1.0e-6).lt(length);
            for k in 0..3 {
                let normal = long_enough.select(ns[k].flip(turn) / length, ng[k]);
                normal.store_at(&mut surfaces.ns[k], at);
            }
        }
    }
}

#[inline(always)]
pub(super) fn splat3<S: Simd>(s: S, v: glam::Vec3) -> [F32<S, 16>; 3] {
    [F32::splat(s, v.x), F32::splat(s, v.y), F32::splat(s, v.z)]
}

#[inline(always)]
pub(super) fn load3<S: Simd>(s: S, planes: &Planes, at: usize) -> [F32<S, 16>; 3] {
    [F32::load_at(s, &planes[0], at), F32::load_at(s, &planes[1], at), F32::load_at(s, &planes[2], at)]
}

#[inline(always)]
pub(super) fn store3<S: Simd>(v: [F32<S, 16>; 3], planes: &mut Planes, at: usize) {
    for k in 0..3 {
        v[k].store_at(&mut planes[k], at);
    }
}

#[inline(always)]
pub(super) fn dot<S: Simd>(a: [F32<S, 16>; 3], b: [F32<S, 16>; 3]) -> F32<S, 16> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
