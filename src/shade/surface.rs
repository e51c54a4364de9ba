//! The surfaces that a stream of rays hit: where, which way they face, and how they reflect.

use super::table::SurfaceTable;
use crate::kernels::{
    F32, Face, HitBlock, I32, Kernel, Kernels, MISS, Mask, RayBlock, SUB, SUBS, Simd, TILE_RAYS, TileHits,
    TilePacket,
};

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
        self.reset_len(packets * TILE_RAYS, background);
    }

    /// The same for `len` rays, a multiple of 16.
    pub(super) fn reset_len(&mut self, len: usize, background: [f32; 3]) {
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
    pub fn gather(
        &mut self,
        kernels: &Kernels,
        table: &SurfaceTable,
        index: usize,
        packet: &TilePacket,
        hits: &TileHits,
    ) {
        kernels.run(Gather { surfaces: self, table, first: index * TILE_RAYS, packet, hits });
    }

    /// Takes the hits of blocks of rays, in order. Points are not filled in.
    pub(super) fn gather_blocks(
        &mut self,
        kernels: &Kernels,
        table: &SurfaceTable,
        blocks: &[RayBlock],
        hits: &[HitBlock],
    ) {
        kernels.run(GatherBlocks { surfaces: self, table, blocks, hits });
    }

    /// Normalises directions and turns normals towards the viewer.
    pub fn finish(&mut self, kernels: &Kernels) {
        kernels.run(Orient { surfaces: self });
    }
}

struct Gather<'a> {
    surfaces: &'a mut Surfaces,
    table: &'a SurfaceTable,
    /// The packet's first ray in `surfaces`.
    first: usize,
    packet: &'a TilePacket,
    hits: &'a TileHits,
}

impl Kernel for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        for sub in 0..SUBS {
            let prims: &[u32; SUB] = &self.hits.prim.as_chunks().0[sub];
            let missed = I32::<S, SUB>::load(s, prims).eq(I32::splat(s, MISS)).bits();
            let hit = !missed & u32::from(self.packet.active[sub]);
            if hit != 0 {
                self.place(s, sub, hit);
                let (from, to) = (sub * SUB, self.first + sub * SUB);
                let b = [F32::load_at(s, &self.hits.u, from), F32::load_at(s, &self.hits.v, from)];
                facets(s, self.surfaces, self.table, prims, b, hit, to);
            }
        }
    }
}

struct GatherBlocks<'a> {
    surfaces: &'a mut Surfaces,
    table: &'a SurfaceTable,
    blocks: &'a [RayBlock],
    hits: &'a [HitBlock],
}

impl Kernel for GatherBlocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let GatherBlocks { surfaces, table, blocks, hits } = self;
        for (index, (block, hits)) in blocks.iter().zip(hits).enumerate() {
            let to = index * SUB;
            for axis in 0..3 {
                surfaces.view[axis][to..to + SUB].copy_from_slice(&block.dir[axis]);
            }
            let missed = I32::<S, SUB>::load(s, &hits.prim).eq(I32::splat(s, MISS)).bits();
            let hit = !missed & u32::from(block.active);
            if hit != 0 {
                surfaces.prim[to..to + SUB].copy_from_slice(&hits.prim);
                let b = [F32::load(s, &hits.u), F32::load(s, &hits.v)];
                facets(s, surfaces, table, &hits.prim, b, hit, to);
            }
        }
    }
}

impl Gather<'_> {
    /// Points, and directions for now; `finish` turns them into directions to the viewer.
    #[inline(always)]
    fn place<S: Simd>(&mut self, s: S, sub: usize, hit: u32) {
        let (from, to) = (sub * SUB, self.first + sub * SUB);
        let Gather { surfaces, packet, hits, .. } = self;
        let [iu, iv, iz] = packet.face.axes();
        let mask = Mask::<S, SUB>::from_bits(s, hit);
        let t = F32::load_at(s, &hits.t, from);
        let depth = F32::splat(s, if packet.face.negative { -1.0 } else { 1.0 });
        let dir = [F32::load_at(s, &packet.u, from), F32::load_at(s, &packet.v, from), depth];
        for (axis, dir) in [iu, iv, iz].into_iter().zip(dir) {
            put(s, mask, dir, &mut surfaces.view[axis], to);
            put(s, mask, F32::splat(s, packet.org[axis]) + t * dir, &mut surfaces.point[axis], to);
        }
        let prims: &[u32; SUB] = &hits.prim.as_chunks().0[sub];
        let prim: &mut [u32; SUB] = (&mut surfaces.prim[to..to + SUB]).try_into().expect("16 lanes");
        mask.iselect(I32::load(s, prims), I32::load(s, prim)).store(prim);
    }
}

/// Normals and materials of the surfaces from `to` on: what neighbouring rays share is fetched once.
#[inline(always)]
fn facets<S: Simd>(
    s: S,
    surfaces: &mut Surfaces,
    table: &SurfaceTable,
    prims: &[u32; SUB],
    [b1, b2]: [F32<S, SUB>; 2],
    hit: u32,
    to: usize,
) {
    let zero = F32::<S, SUB>::splat(s, 0.0);
    let prim = I32::<S, SUB>::load(s, prims);
    let (mut ng, mut corner, mut material) = ([zero; 3], [[zero; 3]; 3], I32::splat(s, 0));
    let mut left = hit;
    while left != 0 {
        let one = prims[(left.trailing_zeros() & 15) as usize];
        let facet = &table.facets[one as usize];
        let mask = prim.eq(I32::splat(s, one));
        left &= !mask.bits();
        for k in 0..3 {
            ng[k] = mask.select(F32::splat(s, facet.ng[k]), ng[k]);
            for i in 0..3 {
                corner[i][k] = mask.select(F32::splat(s, facet.corner[i][k]), corner[i][k]);
            }
        }
        material = mask.iselect(I32::splat(s, facet.material), material);
    }
    let mask = Mask::from_bits(s, hit);
    let b0 = F32::splat(s, 1.0) - b1 - b2;
    for k in 0..3 {
        put(s, mask, ng[k], &mut surfaces.ng[k], to);
        let ns = b0 * corner[0][k] + b1 * corner[1][k] + b2 * corner[2][k];
        put(s, mask, ns, &mut surfaces.ns[k], to);
    }
    let mut numbers = [0; SUB];
    material.store(&mut numbers);
    let mut left = hit;
    while left != 0 {
        let one = numbers[(left.trailing_zeros() & 15) as usize];
        let of_it = material.eq(I32::splat(s, one)).bits() & hit;
        left &= !of_it;
        let (mask, material) = (Mask::from_bits(s, of_it), &table.materials[one as usize]);
        put(s, mask, F32::splat(s, material.ns), &mut surfaces.exponent, to);
        for k in 0..3 {
            put(s, mask, F32::splat(s, material.kd[k]), &mut surfaces.kd[k], to);
            put(s, mask, F32::splat(s, material.ks[k]), &mut surfaces.ks[k], to);
            put(s, mask, F32::splat(s, material.base[k]), &mut surfaces.color[k], to);
        }
    }
}

/// Values of the lanes in `mask`; the others stay.
#[inline(always)]
fn put<S: Simd>(s: S, mask: Mask<S, SUB>, value: F32<S, SUB>, plane: &mut [f32], at: usize) {
    mask.select(value, F32::load_at(s, plane, at)).store_at(plane, at);
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
