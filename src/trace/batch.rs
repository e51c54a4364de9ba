//! Many arbitrary rays on several threads.
//!
//! ```text
//!   rays --chunks of 4096--> one origin?  no  -> as a stream: beams where they fly together, else flights
//!                              yes -> by face -> 256 at a time where they are close, else as a stream
//! ```
//!
//! A ray joins a packet only if the packet traces exactly that ray, so that the way it is traced never shows in the
//! result.

use super::{PacketScratch, RayStream, Traversal};
use crate::kernels::{
    Face, Hit, HitBlock, MISS, NodeRef, Ray, RayBlock, SUB, SUBS, TILE_RAYS, TileHits, TilePacket,
};
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU64, Ordering},
};

/// Rays that a thread takes at once.
const CHUNK: usize = 4096;
/// Greatest mean width plus height, in slopes, of a packet's groups of 16 rays: beyond, single rays are faster.
const CLOSE: f32 = 0.1;

impl Traversal<'_> {
    /// First hits of `rays` on `threads` threads. Each thread calls `start` with its number first, for instance to
    /// pin itself. Returns how many pairs of a ray and a triangle exact arithmetic decided.
    ///
    /// # Panics
    /// If there is not one hit per ray.
    pub fn intersect_batch(
        &self,
        rays: &[Ray],
        hits: &mut [Hit],
        threads: usize,
        start: &(impl Fn(usize) + Sync),
    ) -> u64 {
        share(rays, hits, threads, start, |buffers, rays, hits| {
            let Buffers { scratch, stream, blocks, met, .. } = buffers;
            let mut found = TileHits::new();
            let mut doubts = 0;
            scratch.begin();
            let packet = |packet: &TilePacket, members: &[u32]| {
                doubts += self.intersect(packet, scratch, &mut found);
                members.iter().enumerate().for_each(|(i, &ray)| hits[ray as usize] = found.hit(i));
            };
            let numbers = others(rays, packet, blocks);
            met.resize(blocks.len(), HitBlock::MISS);
            doubts += stream.intersect(self, blocks, met);
            for (i, &ray) in numbers.iter().enumerate() {
                hits[ray as usize] = met[i / SUB].get(i % SUB);
            }
            doubts
        })
    }

    /// Which of `rays` are blocked, as 1 or 0; otherwise as [`Traversal::intersect_batch`].
    ///
    /// # Panics
    /// If there is not one byte per ray.
    pub fn occluded_batch(
        &self,
        rays: &[Ray],
        blocked: &mut [u8],
        threads: usize,
        start: &(impl Fn(usize) + Sync),
    ) -> u64 {
        share(rays, blocked, threads, start, |buffers, rays, blocked| {
            let Buffers { scratch, stream, blocks, stopped, .. } = buffers;
            let mut seed: NodeRef = super::NO_OCCLUDER;
            let mut doubts = 0;
            scratch.begin();
            let packet = |packet: &TilePacket, members: &[u32]| {
                let mut bits = [0; SUBS];
                doubts += self.occluded(packet, scratch, &mut seed, &mut bits);
                for (i, &ray) in members.iter().enumerate() {
                    blocked[ray as usize] = (bits[i / SUB] >> (i % SUB) & 1) as u8;
                }
            };
            let numbers = others(rays, packet, blocks);
            stopped.resize(blocks.len(), 0);
            doubts += stream.occluded(self, blocks, stopped);
            for (i, &ray) in numbers.iter().enumerate() {
                blocked[ray as usize] = (stopped[i / SUB] >> (i % SUB) & 1) as u8;
            }
            doubts
        })
    }
}

/// What each thread keeps from chunk to chunk.
#[derive(Default)]
struct Buffers {
    scratch: PacketScratch,
    stream: RayStream,
    /// Rays for the stream, and what becomes of them.
    blocks: Vec<RayBlock>,
    met: Vec<HitBlock>,
    stopped: Vec<u16>,
}

/// Hands out chunks of rays, each with its results, to threads; the sum of what `trace` returns.
fn share<T: Send>(
    rays: &[Ray],
    results: &mut [T],
    threads: usize,
    start: &(impl Fn(usize) + Sync),
    trace: impl Fn(&mut Buffers, &[Ray], &mut [T]) -> u64 + Sync,
) -> u64 {
    assert_eq!(rays.len(), results.len(), "a batch needs one result per ray");
    let chunks = Mutex::new(rays.chunks(CHUNK).zip(results.chunks_mut(CHUNK)));
    let next = || chunks.lock().unwrap_or_else(PoisonError::into_inner).next();
    let sum = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for thread in 0..threads.max(1) {
            let (next, trace, sum) = (&next, &trace, &sum);
            scope.spawn(move || {
                start(thread);
                let mut buffers = Buffers::default();
                while let Some((rays, results)) = next() {
                    sum.fetch_add(trace(&mut buffers, rays, results), Ordering::Relaxed);
                }
            });
        }
    });
    sum.into_inner()
}

/// The numbers of the rays that [`packets`] returns; they themselves go into `blocks`.
fn others(rays: &[Ray], trace: impl FnMut(&TilePacket, &[u32]), blocks: &mut Vec<RayBlock>) -> Vec<u32> {
    let numbers = packets(rays, trace);
    RayBlock::pack(numbers.iter().map(|&ray| &rays[ray as usize]), blocks);
    numbers
}

/// Hands those rays that may be traced together to `trace`, as packets with the number of each ray, and returns the
/// numbers of the others.
fn packets(rays: &[Ray], mut trace: impl FnMut(&TilePacket, &[u32])) -> Vec<u32> {
    let Some(origin) = common_origin(rays) else { return (0..rays.len() as u32).collect() };
    let mut faces: [Vec<u32>; 6] = Default::default();
    let mut single = Vec::new();
    for (number, ray) in rays.iter().enumerate() {
        match slope_face(ray) {
            Some(face) => faces[face.index()].push(number as u32),
            None => single.push(number as u32),
        }
    }
    let mut packet = TilePacket::new();
    packet.org = origin;
    for (face, numbers) in Face::ALL.into_iter().zip(&faces) {
        packet.face = face;
        for members in numbers.chunks(TILE_RAYS) {
            fill(&mut packet, rays, members);
            if is_close(&packet, members.len()) {
                trace(&packet, members);
            } else {
                single.extend_from_slice(members);
            }
        }
    }
    single
}

/// The origin of all rays, bit for bit, if it is one at all.
fn common_origin(rays: &[Ray]) -> Option<[f32; 3]> {
    let bits = |ray: &Ray| ray.org.map(f32::to_bits);
    let first = rays.first()?;
    (first.org.iter().all(|x| x.is_finite()) && rays.iter().all(|ray| bits(ray) == bits(first)))
        .then_some(first.org)
}

/// The face of a ray that a packet can hold as it is: its greatest component is 1 or -1, and it starts at its origin.
/// Scaling another direction would round it, and so change what it hits.
fn slope_face(ray: &Ray) -> Option<Face> {
    if ray.dir.iter().any(|x| x.is_nan()) {
        return None;
    }
    let face = Face::of(ray.dir);
    (ray.dir[face.axis].abs() == 1.0 && ray.tnear == 0.0 && ray.tfar > 0.0).then_some(face)
}

fn fill(packet: &mut TilePacket, rays: &[Ray], members: &[u32]) {
    let [iu, iv, _] = packet.face.axes();
    packet.active = [0; SUBS];
    packet.skip = [MISS; TILE_RAYS];
    for (i, &number) in members.iter().enumerate() {
        let ray = &rays[number as usize];
        packet.active[i / SUB] |= 1 << (i % SUB);
        (packet.u[i], packet.v[i]) = (ray.dir[iu], ray.dir[iv]);
        (packet.tfar[i], packet.skip[i]) = (ray.tfar, ray.skip);
    }
}

/// True if the rays of each group of 16 are neighbours, on average, and there are enough to gain anything.
fn is_close(packet: &TilePacket, len: usize) -> bool {
    let extent = |slopes: &[f32]| {
        let (min, max) =
            slopes.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        max - min
    };
    let sum = |plane: &[f32; TILE_RAYS]| plane[..len].chunks(SUB).map(extent).sum::<f32>();
    len >= SUB && sum(&packet.u) + sum(&packet.v) <= CLOSE * len.div_ceil(SUB) as f32
}
