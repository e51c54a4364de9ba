//! Tracing rays against a tree: the tree and the kernels behind `intersect` and `occluded`.

mod batch;
mod early;
mod packet;
mod shadow;
mod stream;

pub use early::EarlyTermination;
pub use packet::PacketScratch;
pub use shadow::{NO_OCCLUDER, PointShadows, ShadowRays, Traced};
pub use stream::{RayStream, rays_in};

use crate::{
    bvh::Bvh,
    kernels::{
        BvhView, Flight, Hit, HitBlock, Kernel, Kernels, NodeRef, Pick, Ray, RayBlock, Simd, TilePacket,
    },
};
use std::{fmt, str::FromStr};

/// Which kernel traces rays that share their origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum KernelChoice {
    /// The tile kernel for packets whose rays have enough in common, flights of single rays for others.
    #[default]
    Auto,
    /// The common-origin tile kernel: 256 rays at once.
    Tile,
    /// Flights of single rays; the same image.
    Single,
}

impl KernelChoice {
    /// All choices.
    pub const ALL: [KernelChoice; 3] = [KernelChoice::Auto, KernelChoice::Tile, KernelChoice::Single];

    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            KernelChoice::Auto => "auto",
            KernelChoice::Tile => "tile",
            KernelChoice::Single => "single",
        }
    }
}

impl fmt::Display for KernelChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for KernelChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<KernelChoice, String> {
        KernelChoice::ALL
            .into_iter()
            .find(|choice| choice.name() == text)
            .ok_or_else(|| format!("unknown kernel '{text}'; use auto, tile or single"))
    }
}

/// A tree ready to be traversed.
#[derive(Clone, Copy, Debug)]
pub struct Traversal<'a> {
    view: BvhView<'a>,
    kernels: Kernels,
    choice: KernelChoice,
}

impl<'a> Traversal<'a> {
    /// A tree with the kernels to traverse it.
    pub fn new(bvh: &'a Bvh, kernels: Kernels, choice: KernelChoice) -> Traversal<'a> {
        Traversal { view: bvh.view(), kernels, choice }
    }

    /// The kernels.
    pub fn kernels(&self) -> &Kernels {
        &self.kernels
    }

    /// The tree.
    pub fn tree(&self) -> BvhView<'a> {
        self.view
    }

    /// Asks for a packet's rays ahead of tracing them; worth it where packets wait in a long array.
    pub fn fetch(&self, packet: &TilePacket) {
        self.kernels.run(Fetch(packet));
    }

    /// First hit of a single ray.
    pub fn intersect_ray(&self, ray: &Ray) -> Hit {
        self.intersect_ray_counted(ray, &mut 0)
    }

    /// First hit of a single ray; adds to `doubts` the number of triangles that exact arithmetic decided.
    pub fn intersect_ray_counted(&self, ray: &Ray, doubts: &mut u64) -> Hit {
        self.kernels.intersect_counted(&self.view, ray, doubts)
    }

    /// First hits of any rays, which need have nothing in common: quicker than one by one. As
    /// [`Kernels::intersect_each`].
    pub fn intersect_each(
        &self,
        blocks: &[RayBlock],
        picks: &[Pick],
        flight: &mut Flight,
        hits: &mut [HitBlock],
    ) -> u64 {
        self.kernels.intersect_each(&self.view, blocks, picks, flight, hits)
    }

    /// Which of any rays, which need have nothing in common, are blocked. As [`Kernels::occluded_each`].
    pub fn occluded_each(
        &self,
        blocks: &[RayBlock],
        picks: &[Pick],
        flight: &mut Flight,
        blocked: &mut [u16],
    ) -> u64 {
        self.kernels.occluded_each(&self.view, blocks, picks, flight, blocked)
    }

    /// First hits of rays of up to 16 blocks that should fly about the same way. As [`Kernels::beam_intersect`].
    pub fn intersect_beam(&self, blocks: &[RayBlock], picks: &[Pick], hits: &mut [HitBlock]) -> u64 {
        self.kernels.beam_intersect(&self.view, blocks, picks, hits)
    }

    /// Which rays of up to 16 blocks that should fly about the same way are blocked. As [`Kernels::beam_occluded`].
    pub fn occluded_beam(
        &self,
        blocks: &[RayBlock],
        picks: &[Pick],
        seed: &mut NodeRef,
        blocked: &mut [u16],
    ) -> u64 {
        self.kernels.beam_occluded(&self.view, blocks, picks, seed, blocked)
    }

    /// True if a single ray is blocked; adds to `doubts` the number of triangles that exact arithmetic decided.
    pub fn occluded_ray(&self, ray: &Ray, doubts: &mut u64) -> bool {
        self.kernels.occluded_counted(&self.view, ray, doubts)
    }
}

struct Fetch<'a>(&'a TilePacket);

impl Kernel for Fetch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        s.prefetch(&self.0.u);
        s.prefetch(&self.0.v);
        if self.0.bounded {
            s.prefetch(&self.0.tfar);
            s.prefetch(&self.0.skip);
        }
    }
}
