//! The entry points of each instruction set, and the table that is chosen once.

use crate::{
    arch::Scalar,
    generic::{
        beam,
        flight::{self, Flight},
        single,
        tile::{self, TileScratch},
    },
    isa::Isa,
    node::{BvhView, NodeRef},
    packet::{Hit, HitBlock, Pick, Ray, RayBlock, SUBS, TileHits, TilePacket},
    simd::Kernel,
    visibility::{Exact, Fast, Visibility},
};

type TileIntersect = unsafe fn(&BvhView, &TilePacket, &mut TileScratch, &mut TileHits) -> u64;
type TileOccluded = unsafe fn(&BvhView, &TilePacket, &mut TileScratch, &mut NodeRef, &mut [u16; SUBS]) -> u64;
type Intersect = unsafe fn(&BvhView, &Ray, &mut u64) -> Hit;
type Occluded = unsafe fn(&BvhView, &Ray, &mut u64) -> bool;
type IntersectEach = unsafe fn(&BvhView, &[RayBlock], &[Pick], &mut Flight, &mut [HitBlock]) -> u64;
type OccludedEach = unsafe fn(&BvhView, &[RayBlock], &[Pick], &mut Flight, &mut [u16]) -> u64;
type BeamIntersect = unsafe fn(&BvhView, &[RayBlock], &[Pick], &mut [HitBlock]) -> u64;
type BeamOccluded = unsafe fn(&BvhView, &[RayBlock], &[Pick], &mut NodeRef, &mut [u16]) -> u64;

/// The kernels of one instruction set and visibility, known to run on this machine.
///
/// Kernels for many rays return how many pairs of a ray and a triangle the filters left *in doubt*, so that exact
/// arithmetic decided them: 0 with [`Visibility::Fast`]. The number depends on the kernel and the instruction set, since
/// a triangle that is nowhere near a ray may be culled by one of them and not by another; the hits do not.
#[derive(Clone, Copy, Debug)]
pub struct Kernels {
    isa: Isa,
    visibility: Visibility,
    tile_intersect: TileIntersect,
    tile_occluded: TileOccluded,
    intersect: Intersect,
    occluded: Occluded,
    intersect_each: IntersectEach,
    occluded_each: OccludedEach,
    beam_intersect: BeamIntersect,
    beam_occluded: BeamOccluded,
}

impl Kernels {
    /// The kernels of `isa` with exact visibility; `None` if this machine cannot run them.
    pub fn for_isa(isa: Isa) -> Option<Kernels> {
        if !isa.is_available() {
            return None;
        }
        match isa {
            Isa::Scalar => Some(scalar::exact::TABLE),
            #[cfg(target_arch = "x86_64")]
            Isa::Sse42 => Some(sse42::exact::TABLE),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => Some(avx2::exact::TABLE),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => Some(avx512::exact::TABLE),
            #[cfg(not(target_arch = "x86_64"))]
            _ => None,
        }
    }

    /// The kernels of the widest instruction set of this machine, with exact visibility.
    pub fn detect() -> Kernels {
        Kernels::for_isa(Isa::detect()).unwrap_or(scalar::exact::TABLE)
    }

    /// The same instruction set with another visibility.
    pub fn with_visibility(self, visibility: Visibility) -> Kernels {
        let [exact, fast] = match self.isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Sse42 => [sse42::exact::TABLE, sse42::fast::TABLE],
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => [avx2::exact::TABLE, avx2::fast::TABLE],
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => [avx512::exact::TABLE, avx512::fast::TABLE],
            _ => [scalar::exact::TABLE, scalar::fast::TABLE],
        };
        match visibility {
            Visibility::Exact => exact,
            Visibility::Fast => fast,
        }
    }

    /// The instruction set.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// How hits are decided.
    pub fn visibility(&self) -> Visibility {
        self.visibility
    }

    /// First hits of the active rays of a packet; hits of other rays are left as they are, and all are if the packet is given up
    /// (see [`TileScratch::set_budget`]).
    #[inline]
    pub fn tile_intersect(
        &self,
        bvh: &BvhView,
        packet: &TilePacket,
        scratch: &mut TileScratch,
        hits: &mut TileHits,
    ) -> u64 {
        // SAFETY: `for_isa` hands out a table only after detecting its features; the function is otherwise safe.
        unsafe { (self.tile_intersect)(bvh, packet, scratch, hits) }
    }

    /// Which active rays of a packet something blocks within `tfar`: bit `i` of `blocked[s]` is ray `16 s + i`.
    ///
    /// `seed` is a leaf to try first (often what blocked the previous packet), or [`crate::EMPTY_NODE`]; it is replaced
    /// by a leaf that blocked a ray last. It affects time only, and with it whether a packet is given up: some blocked rays are not
    /// told then.
    #[inline]
    pub fn tile_occluded(
        &self,
        bvh: &BvhView,
        packet: &TilePacket,
        scratch: &mut TileScratch,
        seed: &mut NodeRef,
        blocked: &mut [u16; SUBS],
    ) -> u64 {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.tile_occluded)(bvh, packet, scratch, seed, blocked) }
    }

    /// First hit of a single ray.
    #[inline]
    pub fn intersect(&self, bvh: &BvhView, ray: &Ray) -> Hit {
        self.intersect_counted(bvh, ray, &mut 0)
    }

    /// As [`Kernels::intersect`]; adds to `doubts` the number of triangles that exact arithmetic decided.
    #[inline]
    pub fn intersect_counted(&self, bvh: &BvhView, ray: &Ray, doubts: &mut u64) -> Hit {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.intersect)(bvh, ray, doubts) }
    }

    /// True if anything blocks a single ray between `tnear` and `tfar`.
    #[inline]
    pub fn occluded(&self, bvh: &BvhView, ray: &Ray) -> bool {
        self.occluded_counted(bvh, ray, &mut 0)
    }

    /// As [`Kernels::occluded`]; adds to `doubts` the number of triangles that exact arithmetic decided.
    #[inline]
    pub fn occluded_counted(&self, bvh: &BvhView, ray: &Ray, doubts: &mut u64) -> bool {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.occluded)(bvh, ray, doubts) }
    }

    /// First hits of the active rays of the blocks that `picks` names by index, which need have nothing in common: several
    /// are on their way at once. `hits` has an entry for each block; those of other rays are left as they are.
    ///
    /// # Panics
    /// If a pick is out of range of the blocks or hits.
    #[inline]
    pub fn intersect_each(
        &self,
        bvh: &BvhView,
        blocks: &[RayBlock],
        picks: &[Pick],
        flight: &mut Flight,
        hits: &mut [HitBlock],
    ) -> u64 {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.intersect_each)(bvh, blocks, picks, flight, hits) }
    }

    /// Which active rays of the blocks that `picks` names anything blocks: bit `i` of `blocked[b]` is ray `i` of block
    /// `b`. Bits of other rays are left as they are.
    ///
    /// # Panics
    /// As [`Kernels::intersect_each`].
    #[inline]
    pub fn occluded_each(
        &self,
        bvh: &BvhView,
        blocks: &[RayBlock],
        picks: &[Pick],
        flight: &mut Flight,
        blocked: &mut [u16],
    ) -> u64 {
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.occluded_each)(bvh, blocks, picks, flight, blocked) }
    }

    /// As [`Kernels::intersect_each`] for up to 16 picks. Quickest if all rays share a face, those of a pick start close
    /// together and fly about the same way, and neighbouring picks do so more or less.
    ///
    /// # Panics
    /// If there are more picks than that, or one is out of range of the blocks or hits.
    #[inline]
    pub fn beam_intersect(
        &self,
        bvh: &BvhView,
        blocks: &[RayBlock],
        picks: &[Pick],
        hits: &mut [HitBlock],
    ) -> u64 {
        assert!(picks.len() <= SUBS, "at most 16 picks");
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.beam_intersect)(bvh, blocks, picks, hits) }
    }

    /// As [`Kernels::occluded_each`] for rays like those of [`Kernels::beam_intersect`]. `seed` as in
    /// [`Kernels::tile_occluded`].
    ///
    /// # Panics
    /// As [`Kernels::beam_intersect`].
    #[inline]
    pub fn beam_occluded(
        &self,
        bvh: &BvhView,
        blocks: &[RayBlock],
        picks: &[Pick],
        seed: &mut NodeRef,
        blocked: &mut [u16],
    ) -> u64 {
        assert!(picks.len() <= SUBS, "at most 16 picks");
        // SAFETY: as in `tile_intersect`.
        unsafe { (self.beam_occluded)(bvh, blocks, picks, seed, blocked) }
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

/// The entry functions of one instruction set and visibility. They are not generic, so that they are compiled here, once,
/// with the settings of this crate.
macro_rules! table {
    ($module:ident, $policy:ident, $isa:expr, $token:expr $(, $features:literal)?) => {
        pub(super) mod $module {
            use super::super::*;

            pub(in super::super) const TABLE: Kernels = Kernels {
                isa: $isa,
                visibility: Visibility::$policy,
                tile_intersect,
                tile_occluded,
                intersect,
                occluded,
                intersect_each,
                occluded_each,
                beam_intersect,
                beam_occluded,
            };

            $(#[target_feature(enable = $features)])?
            fn tile_intersect(
                bvh: &BvhView,
                packet: &TilePacket,
                scratch: &mut TileScratch,
                hits: &mut TileHits,
            ) -> u64 {
                tile::intersect::<_, $policy>($token, bvh, packet, scratch, hits)
            }

            $(#[target_feature(enable = $features)])?
            fn tile_occluded(
                bvh: &BvhView,
                packet: &TilePacket,
                scratch: &mut TileScratch,
                seed: &mut NodeRef,
                blocked: &mut [u16; SUBS],
            ) -> u64 {
                tile::occluded::<_, $policy>($token, bvh, packet, scratch, seed, blocked)
            }

            $(#[target_feature(enable = $features)])?
            fn intersect(bvh: &BvhView, ray: &Ray, doubts: &mut u64) -> Hit {
                single::intersect::<_, $policy>($token, bvh, ray, doubts)
            }

            $(#[target_feature(enable = $features)])?
            fn occluded(bvh: &BvhView, ray: &Ray, doubts: &mut u64) -> bool {
                single::occluded::<_, $policy>($token, bvh, ray, doubts)
            }

            $(#[target_feature(enable = $features)])?
            fn intersect_each(
                bvh: &BvhView,
                blocks: &[RayBlock],
                picks: &[Pick],
                flight: &mut Flight,
                hits: &mut [HitBlock],
            ) -> u64 {
                flight::intersect::<_, $policy>($token, bvh, blocks, picks, flight, hits)
            }

            $(#[target_feature(enable = $features)])?
            fn occluded_each(
                bvh: &BvhView,
                blocks: &[RayBlock],
                picks: &[Pick],
                flight: &mut Flight,
                blocked: &mut [u16],
            ) -> u64 {
                flight::occluded::<_, $policy>($token, bvh, blocks, picks, flight, blocked)
            }

            $(#[target_feature(enable = $features)])?
            fn beam_intersect(
                bvh: &BvhView,
                blocks: &[RayBlock],
                picks: &[Pick],
                hits: &mut [HitBlock],
            ) -> u64 {
                beam::intersect::<_, $policy>($token, bvh, blocks, picks, hits)
            }

            $(#[target_feature(enable = $features)])?
            fn beam_occluded(
                bvh: &BvhView,
                blocks: &[RayBlock],
                picks: &[Pick],
                seed: &mut NodeRef,
                blocked: &mut [u16],
            ) -> u64 {
                beam::occluded::<_, $policy>($token, bvh, blocks, picks, seed, blocked)
            }
        }
    };
}

/// One module for each instruction set: with `table`, the only functions of the crate that carry `#[target_feature]`.
macro_rules! entries {
    ($(#[$gate:meta])* $module:ident, $isa:expr, $token:expr $(, $features:literal)?) => {
        $(#[$gate])*
        pub(crate) mod $module {
            use super::*;

            table!(exact, Exact, $isa, $token $(, $features)?);
            table!(fast, Fast, $isa, $token $(, $features)?);

            /// Runs any computation with the features of this module.
            #[allow(dead_code)]
            $(#[target_feature(enable = $features)])?
            pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
                kernel.run($token)
            }

            /// [`Simd::apart`].
            #[cold]
            #[inline(never)]
            $(#[target_feature(enable = $features)])?
            pub(crate) fn apart<K: Kernel>(kernel: K) -> K::Output {
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
