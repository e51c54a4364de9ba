//! Streams of rays that share neither origin nor direction: sorted so that neighbours visit the same nodes.
//!
//! Rays of a tile start near each other but may fly anywhere. A counting sort by face, signs and a coarse grid of
//! slopes brings those together that fly the same way; within a cell they keep the order of the image. Traced in that
//! order, nodes and triangles are found in the cache, branches go the way they went before, and packets hold
//! together.
//!
//! ```text
//!   rays -> key = face, signs of the slopes, cell of the slopes -> counting sort -> packets of one class -> hits
//! ```
//!
//! How rays are grouped never changes what a ray hits.

use super::Traversal;
use crate::kernels::{Face, Hit, MISS, PACKET_RAYS, Ray};

/// Cells along each slope, per sign.
const CELLS: u32 = 2;
/// Keys: 6 faces, 2 signs of each slope, cells; and one for rays that hit nothing by definition.
const KEYS: usize = (6 * 4 * CELLS * CELLS) as usize + 1;

/// Fills packets that are not full; never traced.
const NO_RAY: Ray = Ray { org: [0.0; 3], dir: [0.0; 3], tnear: 0.0, tfar: 0.0, skip: MISS };

/// Buffers for sorting streams, reused from stream to stream.
#[derive(Clone, Debug)]
pub struct RayStream {
    keys: Vec<u16>,
    starts: Vec<u32>,
    /// Ray indices in sorted order.
    order: Vec<u32>,
}

impl Default for RayStream {
    fn default() -> RayStream {
        RayStream { keys: Vec::new(), starts: vec![0; KEYS + 1], order: Vec::new() }
    }
}

impl RayStream {
    /// First hits of all rays, of which there are at most 2^32 - 1.
    ///
    /// # Panics
    /// If there are not as many hits as rays.
    pub fn intersect(&mut self, traversal: &Traversal, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one hit for each ray");
        self.sort(rays);
        let mut packet = [NO_RAY; PACKET_RAYS];
        let mut found = [Hit::MISS; PACKET_RAYS];
        for (first, count) in self.packets() {
            let order = &self.order[first..first + count];
            for (ray, &i) in packet.iter_mut().zip(order) {
                *ray = rays[i as usize];
            }
            traversal.intersect_rays(&packet[..count], &mut found[..count]);
            for (hit, &i) in found.iter().zip(order) {
                hits[i as usize] = *hit;
            }
        }
    }

    /// Whether anything blocks each ray.
    ///
    /// # Panics
    /// If there are not as many answers as rays.
    pub fn occluded(&mut self, traversal: &Traversal, rays: &[Ray], blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len(), "one answer for each ray");
        self.sort(rays);
        let mut packet = [NO_RAY; PACKET_RAYS];
        for (first, count) in self.packets() {
            let order = &self.order[first..first + count];
            for (ray, &i) in packet.iter_mut().zip(order) {
                *ray = rays[i as usize];
            }
            let bits = traversal.occluded_rays(&packet[..count]);
            for (lane, &i) in order.iter().enumerate() {
                blocked[i as usize] = bits >> lane & 1 != 0;
            }
        }
    }

    /// Runs of sorted rays of one class: first and count.
    fn packets(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let class = |at: usize| u32::from(self.keys[self.order[at] as usize]) / (CELLS * CELLS);
        let mut first = 0;
        std::iter::from_fn(move || {
            let end = self.order.len().min(first + PACKET_RAYS);
            (first < end).then(|| {
                let start = first;
                while first < end && class(first) == class(start) {
                    first += 1;
                }
                (start, first - start)
            })
        })
    }

    /// Fills `order`, stable, by key, and returns it.
    pub(crate) fn sort(&mut self, rays: &[Ray]) -> &[u32] {
        self.keys.clear();
        self.keys.extend(rays.iter().map(|ray| key(ray) as u16));
        self.starts.fill(0);
        for &key in &self.keys {
            self.starts[usize::from(key) + 1] += 1;
        }
        for key in 0..KEYS {
            self.starts[key + 1] += self.starts[key];
        }
        self.order.resize(rays.len(), 0);
        for (i, &key) in self.keys.iter().enumerate() {
            let at = &mut self.starts[usize::from(key)];
            self.order[*at as usize] = i as u32;
            *at += 1;
        }
        &self.order
    }
}

/// Where a ray belongs: equal keys mean the same face and signs, and similar slopes.
fn key(ray: &Ray) -> u32 {
    if !ray.dir.iter().all(|x| x.is_finite()) {
        return KEYS as u32 - 1;
    }
    let face = Face::of(ray.dir);
    let [iu, iv, iz] = face.axes();
    let scale = 1.0 / ray.dir[iz].abs();
    let (u, v) = (ray.dir[iu] * scale, ray.dir[iv] * scale);
    // Casts saturate and turn NaN into 0.
    let cell = |slope: f32| ((slope.abs() * CELLS as f32) as u32).min(CELLS - 1);
    let (x, y) = (cell(u), cell(v));
    let morton = (x & 1) | (y & 1) << 1 | (x & 2) << 1 | (y & 2) << 2;
    let signs = u32::from(u.is_sign_negative()) | u32::from(v.is_sign_negative()) << 1;
    (face.index() as u32 * 4 + signs) * CELLS * CELLS + morton
}
