//! SIMD ray kernels of irt: every line of `std::arch` and nearly every `unsafe` of the project lives here.
//!
//! # The SIMD contract
//!
//! * A zero-sized *token* per instruction set ([`Scalar`], `Sse42`, `Avx2`, `Avx512`) implements [`Lanes`]`<W>` for
//!   8 and 16 lanes. A token other than [`Scalar`] can only be had where its features were detected, so everything
//!   built on it is safe code.
//! * Each algorithm is written once, generic over `S: `[`Simd`], in functions marked `#[inline(always)]` that neither
//!   recurse nor hand closures to functions that might not be inlined: otherwise every intrinsic becomes a call.
//! * One `#[target_feature]` entry function per instruction set and kernel instantiates it. [`Kernels`] is the table
//!   of these entries, chosen once; only `&` and `&mut` of plain structs cross it.
//! * [`Lanes::mul_add`] is fused where the instruction set fuses and is not where it does not. It may therefore only
//!   feed *filters*, whose error bounds cover both and whose doubtful lanes are decided by [`exact`]; everything that
//!   reaches a result uses separate `*` and `+`. This is why all instruction sets give the same bits.
//!
//! # The tile kernel in one picture
//!
//! ```text
//!   256 rays, one origin            8 child boxes  x  whole tile        lane = child
//!   = 16 sub-packets                survivors      x  16 sub-packets    lane = sub-packet
//!     of 16 rays                    8 triangles    x  whole tile        lane = triangle
//!   +--+--+--+--+                   survivors      x  16 sub-packets    lane = sub-packet
//!   |  |  |  |  |                   pair (triangle, sub-packet): 16 rays, three edge functions
//!   +--+--+--+--+                   and one inverse depth, all affine in the slopes (u, v)
//! ```

mod arch;
mod dispatch;
pub mod exact;
mod generic;
mod isa;
mod node;
mod packet;
mod simd;
mod vector;
mod visibility;

pub use arch::Scalar;
pub use dispatch::Kernels;
pub use generic::flight::Flight;
pub use generic::probe;
pub use generic::tile::{SEEDS, TileEarly, TileScratch, micro};
pub use isa::{Isa, ParseIsaError};
pub use node::{BvhView, EMPTY_NODE, MAX_DEPTH, Node, NodeKind, NodeRef, TriBlock};
pub use packet::{
    Face, Hit, HitBlock, MISS, Pick, Ray, RayBlock, SUB, SUBS, TILE_RAYS, TileHits, TilePacket,
};
pub use simd::{Kernel, Lanes, Simd};
pub use vector::{F32, I32, Mask};
pub use visibility::Visibility;
