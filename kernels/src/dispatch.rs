//! The entry points of each instruction set, and the table that is chosen once.

use crate::{
    arch::Scalar,
    generic::{
        packet, single,
        tile::{self, TileScratch},
    },
    isa::Isa,
    node::{BvhView, NodeRef},
    packet::{Hit, PACKET_RAYS, Ray, SUBS, TileHits, TilePacket},
    simd::Kernel,
};

type TileIntersect = unsafe fn(&BvhView, &TilePacket, &mut TileScratch, &mut TileHits);
type TileOccluded = unsafe fn(&BvhView, &TilePacket, &mut TileScratch, &mut NodeRef, &mut [u16; SUBS]);
type Intersect = unsafe fn(&BvhView, &Ray) -> Hit;
type Occluded = unsafe fn(&BvhView, &Ray) -> bool;
type PacketIntersect = unsafe fn(&BvhView, &[Ray], &mut [Hit]);
type PacketOccluded = unsafe fn(&BvhView, &[Ray]) -> u32;

/// The kernels of one instruction set, known to run on this machine.
#[derive(Clone, Copy, Debug)]
pub struct Kernels {
    isa: Isa,
    tile_intersect: TileIntersect,
    tile_occluded: TileOccluded,
    intersect: Intersect,
    occluded: Occluded,
    packet_intersect: PacketIntersect,
    packet_occluded: PacketOccluded,
}

impl Kernels {
    /// The kernels of `isa`; `None` if this machine cannot run them.
    pub fn for_isa(isa: Isa) -> Option<Kernels> {
        if !isa.is_available() {
            return None;
        }
        match isa {
            Isa::Scalar => Some(scalar::TABLE),
            #[cfg(target_arch = "x86_64")]
            Isa::Sse42 => Some(sse42::TABLE),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => Some(avx2::TABLE),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => Some(avx512::TABLE),
            #[cfg(not(target_arch = "x86_64"))]
            _ => None,
        }
    }

    /// The kernels of the widest instruction set of this machine.
    pub fn detect() -> Kernels {
        Kernels::for_isa(Isa::detect()).unwrap_or(scalar::TABLE)
    }

    /// The instruction set.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// First hits of the active rays of a packet; hits of other rays are left as they are.
    #[inline]
    pub fn tile_intersect(
        &self,
        bvh: &BvhView,
        packet: &TilePacket,
        scratch: &mut TileScratch,
        hits: &mut TileHits,
    ) {
        // SAFETY: `for_isa` hands out a table only after detecting its features; the function is otherwise safe.
        unsafe { (self.tile_intersect)(bvh, packet, scratch, hits) }
    }

    /// Which active rays of a packet something blocks within `tfar`: bit `i` of `blocked[s]` is ray `16 s + i`.
    ///
    /// `seed` is a subtree to try first (often the leaf that blocked the previous packet), or
    /// [`crate::EMPTY_NODE`]; it is replaced by the leaf that blocked a ray last. It affects time only.
    #[inline]
    pub fn tile_occluded(
        &self,
        bvh: &BvhView,
        packet: &TilePacket,
        scratch: &mut TileScratch,
        seed: &mut NodeRef,
        blocked: &mut [u16; SUBS],
    ) {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.tile_occluded)(bvh, packet, scratch, seed, blocked) }
    }

    /// First hit of a single ray.
    #[inline]
    pub fn intersect(&self, bvh: &BvhView, ray: &Ray) -> Hit {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.intersect)(bvh, ray) }
    }

    /// True if anything blocks a single ray between `tnear` and `tfar`.
    #[inline]
    pub fn occluded(&self, bvh: &BvhView, ray: &Ray) -> bool {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.occluded)(bvh, ray) }
    }

    /// First hits of at most [`PACKET_RAYS`] rays: quickest if they share face and signs and start close together.
    ///
    /// # Panics
    /// If there are more rays than that, or not as many hits as rays.
    #[inline]
    pub fn packet_intersect(&self, bvh: &BvhView, rays: &[Ray], hits: &mut [Hit]) {
        assert!(rays.len() <= PACKET_RAYS && rays.len() == hits.len(), "at most 16 rays, each with a hit");
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.packet_intersect)(bvh, rays, hits) }
    }

    /// Which of at most [`PACKET_RAYS`] rays anything blocks: bit = ray.
    ///
    /// # Panics
    /// If there are more rays than that.
    #[inline]
    pub fn packet_occluded(&self, bvh: &BvhView, rays: &[Ray]) -> u32 {
        assert!(rays.len() <= PACKET_RAYS, "at most 16 rays");
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.packet_occluded)(bvh, rays) }
    }

    /// Runs a computation with this instruction set.
    #[inline]
    pub fn run<K: Kernel>(&self, kernel: K) -> K::Output {
        match self.isa {
            // SAFETY: as in `tile_intersect`.
            #[cfg(target_arch = "x86_64")]
            Isa::Sse42 => unsafe { sse42::run(kernel) },
            // SAFETY: as in `tile_intersect`.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { avx2::run(kernel) },
            // SAFETY: as in `tile_intersect`.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { avx512::run(kernel) },
            _ => kernel.run(Scalar),
        }
    }
}

/// One module of entry functions: the only functions of the crate that carry `#[target_feature]`.
macro_rules! entries {
    ($(#[$gate:meta])* $module:ident, $isa:expr, $token:expr $(, $features:literal)?) => {
        $(#[$gate])*
        mod $module {
            use super::*;

            pub(super) const TABLE: Kernels =
                Kernels { isa: $isa, tile_intersect, tile_occluded, intersect, occluded, packet_intersect, packet_occluded };

            $(#[target_feature(enable = $features)])?
            fn tile_intersect(
                bvh: &BvhView,
                packet: &TilePacket,
                scratch: &mut TileScratch,
                hits: &mut TileHits,
            ) {
                tile::intersect($token, bvh, packet, scratch, hits);
            }

            $(#[target_feature(enable = $features)])?
            fn tile_occluded(
                bvh: &BvhView,
                packet: &TilePacket,
                scratch: &mut TileScratch,
                seed: &mut NodeRef,
                blocked: &mut [u16; SUBS],
            ) {
                tile::occluded($token, bvh, packet, scratch, seed, blocked);
            }

            $(#[target_feature(enable = $features)])?
            fn intersect(bvh: &BvhView, ray: &Ray) -> Hit {
                single::intersect($token, bvh, ray)
            }

            $(#[target_feature(enable = $features)])?
            fn occluded(bvh: &BvhView, ray: &Ray) -> bool {
                single::occluded($token, bvh, ray)
            }

            $(#[target_feature(enable = $features)])?
            fn packet_intersect(bvh: &BvhView, rays: &[Ray], hits: &mut [Hit]) {
                packet::intersect($token, bvh, rays, hits);
            }

            $(#[target_feature(enable = $features)])?
            fn packet_occluded(bvh: &BvhView, rays: &[Ray]) -> u32 {
                packet::occluded($token, bvh, rays)
            }

            /// Runs any computation with the features of this module.
            #[allow(dead_code)]
            $(#[target_feature(enable = $features)])?
            pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
                kernel.run($token)
            }
        }
    };
}

entries!(scalar, Isa::Scalar, Scalar);
entries!(
    #[cfg(target_arch = "x86_64")]
    sse42,
    Isa::Sse42,
    crate::arch::Sse42(()),
    "sse4.2,popcnt"
);
entries!(
    #[cfg(target_arch = "x86_64")]
    avx2,
    Isa::Avx2,
    crate::arch::Avx2(()),
    "avx2,fma,bmi1,bmi2,lzcnt,popcnt"
);
entries!(
    #[cfg(target_arch = "x86_64")]
    avx512,
    Isa::Avx512,
    crate::arch::Avx512(()),
    "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt"
);
