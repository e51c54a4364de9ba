//! Shadow rays of a point light: a stream of points, sorted by where the light sees them, cut into packets.
//!
//! Rays start at the light, so that they share their origin. Sixteen neighbouring pixels that straddle a silhouette
//! are far apart as the light sees them and would make a fat packet; so the points of a whole image tile are sorted
//! by cube face and then along a Morton curve over their slopes, by one counting sort, before they are cut into
//! packets of 256.
//!
//! ```text
//!   points of 64x64 pixels -> slopes and face -> key = face, Morton cell -> counting sort -> packets -> blocked bits
//! ```

use super::Traversal;
use crate::kernels::{EMPTY_NODE, Face, NodeRef, SUB, SUBS, TILE_RAYS, TilePacket};

/// Cells along one side of the slope rectangle of a face.
const CELLS: usize = 32;
/// Keys: one per cell and face.
const KEYS: usize = 6 * CELLS * CELLS;

/// Rays from one origin as structure of arrays, all slices of equal length.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRays<'a> {
    /// Slopes along the first axis of the face, in [-1, 1].
    pub u: &'a [f32],
    /// Slopes along the second axis of the face, in [-1, 1].
    pub v: &'a [f32],
    /// Greatest depth at which something blocks the ray.
    pub tfar: &'a [f32],
    /// [`Face::index`] of each ray; 6 or more for rays that are not wanted.
    pub face: &'a [u32],
}

/// Buffers for tracing shadow rays, reused from stream to stream.
#[derive(Clone, Debug)]
pub struct PointShadows {
    counts: Vec<u32>,
    keys: Vec<u16>,
    /// Ray indices in sorted order.
    order: Vec<u32>,
    packet: TilePacket,
    spread: [u16; CELLS],
}

impl Default for PointShadows {
    fn default() -> PointShadows {
        PointShadows {
            counts: vec![0; KEYS + 1],
            keys: Vec::new(),
            order: Vec::new(),
            packet: TilePacket::new(),
            // Bits of the cell number moved apart, for Morton codes.
            spread: std::array::from_fn(|i| (0..5).map(|bit| ((i >> bit & 1) as u16) << (2 * bit)).sum()),
        }
    }
}

impl PointShadows {
    /// Traces the wanted rays from `origin` and clears `visible[i]` to 0 where ray i is blocked. `seed` carries the
    /// last occluder from stream to stream. Returns the number of rays traced.
    pub fn trace(
        &mut self,
        traversal: &Traversal,
        origin: [f32; 3],
        rays: &ShadowRays,
        seed: &mut NodeRef,
        visible: &mut [f32],
    ) -> u64 {
        self.sort(rays);
        self.packet.org = origin;
        let order = std::mem::take(&mut self.order);
        let mut first = 0;
        while first < order.len() {
            let face = rays.face[order[first] as usize];
            let window = &order[first..order.len().min(first + TILE_RAYS)];
            // Keys start with the face, so faces are contiguous.
            let count = window.iter().take_while(|&&i| rays.face[i as usize] == face).count();
            self.trace_packet(traversal, rays, &window[..count], face as usize, seed, visible);
            first += count;
        }
        let traced = order.len() as u64;
        self.order = order;
        traced
    }

    /// Fills `order` with the wanted rays, sorted by key.
    fn sort(&mut self, rays: &ShadowRays) {
        let grids = Grid::around(rays);
        self.keys.clear();
        self.counts.fill(0);
        let mut wanted = 0;
        for i in 0..rays.face.len() {
            let face = rays.face[i] as usize;
            let key = if face < 6 {
                let (x, y) = grids[face].cell(rays.u[i], rays.v[i]);
                face * CELLS * CELLS + usize::from(self.spread[x] | self.spread[y] << 1)
            } else {
                KEYS
            };
            wanted += usize::from(key < KEYS);
            self.keys.push(key as u16);
            self.counts[key] += 1;
        }
        let mut start = 0;
        for count in &mut self.counts {
            start += std::mem::replace(count, start);
        }
        self.order.clear();
        self.order.resize(wanted, 0);
        for (i, &key) in self.keys.iter().enumerate() {
            if usize::from(key) < KEYS {
                let at = &mut self.counts[usize::from(key)];
                self.order[*at as usize] = i as u32;
                *at += 1;
            }
        }
    }

    fn trace_packet(
        &mut self,
        traversal: &Traversal,
        rays: &ShadowRays,
        indices: &[u32],
        face: usize,
        seed: &mut NodeRef,
        visible: &mut [f32],
    ) {
        let packet = &mut self.packet;
        packet.face = Face::ALL[face];
        for (ray, &i) in indices.iter().enumerate() {
            packet.u[ray] = rays.u[i as usize];
            packet.v[ray] = rays.v[i as usize];
            packet.tfar[ray] = rays.tfar[i as usize];
        }
        for (sub, active) in packet.active.iter_mut().enumerate() {
            let count = indices.len().saturating_sub(sub * SUB).min(SUB);
            *active = ((1u32 << count) - 1) as u16;
        }
        let mut blocked = [0; SUBS];
        traversal.occluded(packet, seed, &mut blocked);
        for (sub, mut bits) in blocked.into_iter().enumerate() {
            while bits != 0 {
                visible[indices[sub * SUB + bits.trailing_zeros() as usize] as usize] = 0.0;
                bits &= bits - 1;
            }
        }
    }
}

/// The seed of a light that has not blocked anything yet.
pub const NO_OCCLUDER: NodeRef = EMPTY_NODE;

/// A grid of cells over the slopes that a face's rays actually have.
#[derive(Clone, Copy)]
struct Grid {
    min: [f32; 2],
    scale: [f32; 2],
}

impl Grid {
    fn around(rays: &ShadowRays) -> [Grid; 6] {
        let mut min = [[f32::INFINITY; 2]; 7];
        let mut max = [[f32::NEG_INFINITY; 2]; 7];
        for ((&u, &v), &face) in rays.u.iter().zip(rays.v).zip(rays.face) {
            let face = face.min(6) as usize;
            min[face] = [min[face][0].min(u), min[face][1].min(v)];
            max[face] = [max[face][0].max(u), max[face][1].max(v)];
        }
        std::array::from_fn(|face| {
            let size = |k: usize| (max[face][k] - min[face][k]).max(1.0e-6);
            // Square cells: packets should not be longer than wide.
            let scale = (CELLS as f32 - 0.01) / size(0).max(size(1));
            Grid { min: min[face], scale: [scale; 2] }
        })
    }

    fn cell(&self, u: f32, v: f32) -> (usize, usize) {
        let cell = |x: f32, k: usize| (((x - self.min[k]) * self.scale[k]) as usize).min(CELLS - 1);
        (cell(u, 0), cell(v, 1))
    }
}
