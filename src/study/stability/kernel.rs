//! The kernels under test, all behind one call: a batch of rays in, hits and shadows out.

use crate::{
    kernels::{
        Face, Flight, Hit, HitBlock, MISS, Pick, Ray, RayBlock, SUB, SUBS, TILE_RAYS, TileHits, TilePacket,
    },
    trace::{NO_OCCLUDER, PacketScratch, PointShadows, RayStream, ShadowRays, Traversal},
};
use std::{fmt, str::FromStr};

/// A way to trace rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// One ray at a time.
    Single,
    /// 256 rays of a common origin, by slopes.
    Tile,
    /// Up to 256 general rays, as one beam.
    Beam,
    /// General rays, several on their way at once.
    Flight,
    /// General rays, regrouped into beams and flights.
    Stream,
    /// Shadow rays of a point light, regrouped into tiles. Tells only what is blocked.
    ShadowStream,
}

impl Kernel {
    /// All of them; the first is the one that the others are compared with.
    pub const ALL: [Kernel; 6] =
        [Kernel::Single, Kernel::Tile, Kernel::Beam, Kernel::Flight, Kernel::Stream, Kernel::ShadowStream];

    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Kernel::Single => "single",
            Kernel::Tile => "tile",
            Kernel::Beam => "beam",
            Kernel::Flight => "flight",
            Kernel::Stream => "stream",
            Kernel::ShadowStream => "shadow-stream",
        }
    }

    /// True if it takes only rays of a common origin, by slopes.
    pub fn needs_slopes(self) -> bool {
        matches!(self, Kernel::Tile | Kernel::ShadowStream)
    }
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Kernel {
    type Err = String;

    fn from_str(text: &str) -> Result<Kernel, String> {
        let all = Kernel::ALL.map(Kernel::name).join(", ");
        let found = Kernel::ALL.into_iter().find(|kernel| kernel.name() == text);
        found.ok_or_else(|| format!("unknown kernel '{text}'; use one of {all}"))
    }
}

/// Rays in every form that kernels take.
#[derive(Debug, Default)]
pub struct Batch {
    rays: Vec<Ray>,
    blocks: Vec<RayBlock>,
    picks: Vec<Pick>,
    /// Packets with the numbers of their rays; none unless the rays are slopes from a common origin.
    packets: Vec<(TilePacket, Vec<u32>)>,
    slopes: Option<Slopes>,
}

/// The input of the shadow stream, and the numbers of its rays: a multiple of 16, the last ones not wanted.
#[derive(Debug, Default)]
struct Slopes {
    origin: [f32; 3],
    u: Vec<f32>,
    v: Vec<f32>,
    tfar: Vec<f32>,
    skip: Vec<u32>,
    face: Vec<u32>,
}

impl Batch {
    /// Any rays.
    pub fn general(rays: Vec<Ray>) -> Batch {
        let mut blocks = Vec::new();
        RayBlock::pack(rays.iter(), &mut blocks);
        let picks = (0..blocks.len() as u32).map(|block| Pick { block, active: u16::MAX }).collect();
        Batch { rays, blocks, picks, packets: Vec::new(), slopes: None }
    }

    /// Rays from one origin whose greatest component is 1 or -1, with tnear = 0.
    ///
    /// # Panics
    /// If a ray is not like that.
    pub fn slopes(rays: Vec<Ray>) -> Batch {
        let mut batch = Batch::general(rays);
        let Some(first) = batch.rays.first() else { return batch };
        let mut slopes = Slopes { origin: first.org, ..Slopes::default() };
        let mut faces: [Vec<u32>; 6] = Default::default();
        for (number, ray) in batch.rays.iter().enumerate() {
            let face = Face::of(ray.dir);
            let [iu, iv, iz] = face.axes();
            assert!(ray.dir[iz].abs() == 1.0 && ray.tnear == 0.0 && ray.org == first.org, "{ray:?}");
            faces[face.index()].push(number as u32);
            slopes.push(ray.dir[iu], ray.dir[iv], ray.tfar, ray.skip, face.index() as u32);
        }
        while !slopes.u.len().is_multiple_of(SUB) {
            slopes.push(0.0, 0.0, 0.0, MISS, Face::ALL.len() as u32);
        }
        for (face, numbers) in Face::ALL.into_iter().zip(&faces) {
            let chunks = numbers.chunks(TILE_RAYS);
            batch
                .packets
                .extend(chunks.map(|numbers| (packet(&batch.rays, face, numbers), numbers.to_vec())));
        }
        batch.slopes = Some(slopes);
        batch
    }

    /// The rays.
    pub fn rays(&self) -> &[Ray] {
        &self.rays
    }
}

impl Slopes {
    fn push(&mut self, u: f32, v: f32, tfar: f32, skip: u32, face: u32) {
        self.u.push(u);
        self.v.push(v);
        self.tfar.push(tfar);
        self.skip.push(skip);
        self.face.push(face);
    }
}

fn packet(rays: &[Ray], face: Face, numbers: &[u32]) -> TilePacket {
    let mut packet = TilePacket::new();
    let [iu, iv, _] = face.axes();
    packet.face = face;
    packet.bounded = false;
    for (i, &number) in numbers.iter().enumerate() {
        let ray = &rays[number as usize];
        packet.org = ray.org;
        packet.active[i / SUB] |= 1 << (i % SUB);
        (packet.u[i], packet.v[i]) = (ray.dir[iu], ray.dir[iv]);
        (packet.tfar[i], packet.skip[i]) = (ray.tfar, ray.skip);
        packet.bounded |= ray.tfar < f32::INFINITY || ray.skip != MISS;
    }
    packet
}

/// What became of a batch, one entry for each ray.
#[derive(Clone, Debug, Default)]
pub struct Answers {
    /// First hits; empty if the kernel does not tell them.
    pub hits: Vec<Hit>,
    /// Whether anything blocks the ray.
    pub blocked: Vec<bool>,
    /// Pairs of a ray and a triangle that exact arithmetic decided, for hits and shadows together.
    pub doubtful: u64,
}

/// Buffers of a thread that traces.
#[derive(Debug, Default)]
pub struct Tracer {
    scratch: PacketScratch,
    flight: Flight,
    stream: RayStream,
    shadows: PointShadows,
    hits: Vec<HitBlock>,
    blocked: Vec<u16>,
    found: TileHits,
}

impl Tracer {
    /// Traces a batch; false if the kernel does not take such rays.
    pub fn trace(&mut self, kernel: Kernel, with: &Traversal, batch: &Batch, answers: &mut Answers) -> bool {
        if kernel.needs_slopes() && batch.slopes.is_none() {
            return false;
        }
        answers.doubtful = 0;
        answers.hits.clear();
        answers.blocked.clear();
        // Something that no ray may keep.
        const UNTOUCHED: Hit = Hit { prim: MISS - 1, t: f32::NAN, u: f32::NAN, v: f32::NAN };
        answers.hits.resize(if kernel == Kernel::ShadowStream { 0 } else { batch.rays.len() }, UNTOUCHED);
        answers.blocked.resize(batch.rays.len(), false);
        self.hits.clear();
        self.hits.resize(batch.blocks.len(), HitBlock::splat(UNTOUCHED));
        self.blocked.clear();
        self.blocked.resize(batch.blocks.len(), 0);
        match kernel {
            Kernel::Single => {
                for (i, ray) in batch.rays.iter().enumerate() {
                    let doubtful = &mut answers.doubtful;
                    answers.hits[i] = with.intersect_ray_counted(ray, doubtful);
                    answers.blocked[i] = with.occluded_ray(ray, doubtful);
                }
                return true;
            }
            Kernel::Tile => {
                self.tiles(with, batch, answers);
                return true;
            }
            Kernel::ShadowStream => {
                self.shadow_stream(with, batch, answers);
                return true;
            }
            Kernel::Beam => {
                let mut seed = NO_OCCLUDER;
                for picks in batch.picks.chunks(SUBS) {
                    answers.doubtful += with.intersect_beam(&batch.blocks, picks, &mut self.hits)
                        + with.occluded_beam(&batch.blocks, picks, &mut seed, &mut self.blocked);
                }
            }
            Kernel::Flight => {
                let (blocks, picks) = (&batch.blocks, &batch.picks);
                answers.doubtful += with.intersect_each(blocks, picks, &mut self.flight, &mut self.hits)
                    + with.occluded_each(blocks, picks, &mut self.flight, &mut self.blocked);
            }
            Kernel::Stream => {
                answers.doubtful += self.stream.intersect(with, &batch.blocks, &mut self.hits)
                    + self.stream.occluded(with, &batch.blocks, &mut self.blocked);
            }
        }
        for i in 0..batch.rays.len() {
            answers.hits[i] = self.hits[i / SUB].get(i % SUB);
            answers.blocked[i] = self.blocked[i / SUB] >> (i % SUB) & 1 != 0;
        }
        true
    }

    fn tiles(&mut self, with: &Traversal, batch: &Batch, answers: &mut Answers) {
        let mut seed = NO_OCCLUDER;
        for (packet, numbers) in &batch.packets {
            let mut blocked = [0; SUBS];
            answers.doubtful += with.intersect(packet, &mut self.scratch, &mut self.found)
                + with.occluded(packet, &mut self.scratch, &mut seed, &mut blocked);
            for (i, &number) in numbers.iter().enumerate() {
                answers.hits[number as usize] = self.found.hit(i);
                answers.blocked[number as usize] = blocked[i / SUB] >> (i % SUB) & 1 != 0;
            }
        }
    }

    fn shadow_stream(&mut self, with: &Traversal, batch: &Batch, answers: &mut Answers) {
        let Some(Slopes { origin, u, v, tfar, skip, face }) = &batch.slopes else { return };
        let mut visible = vec![1.0; u.len()];
        let rays = ShadowRays { u, v, tfar, skip, face };
        let traced = self.shadows.trace(with, *origin, &rays, &mut NO_OCCLUDER.clone(), &mut visible);
        answers.doubtful += traced.doubts;
        for (blocked, visible) in answers.blocked.iter_mut().zip(visible) {
            *blocked = visible == 0.0;
        }
    }
}

/// The same bits?
pub fn same(a: &Hit, b: &Hit) -> bool {
    a.prim == b.prim && [a.t, a.u, a.v].map(f32::to_bits) == [b.t, b.u, b.v].map(f32::to_bits)
}
