//! The algorithms, each written once, generic over [`crate::Simd`].
//!
//! Private: callers go through [`crate::Kernels`], which reaches an instantiation inside a `#[target_feature]`
//! function. Everything here is `#[inline(always)]`, except the cold functions that decide doubtful lanes exactly.

pub(crate) mod beam;
pub(crate) mod doubt;
pub(crate) mod finish;
pub(crate) mod flight;
pub(crate) mod leaf;
pub mod probe;
pub(crate) mod shear;
pub(crate) mod single;
pub(crate) mod stack;
pub(crate) mod tile;

use crate::{packet::Face, vector::F32};

/// Floats, lane = child or triangle.
pub(crate) type F8<S> = F32<S, 8>;
/// Floats, lane = ray or sub-packet.
pub(crate) type F16<S> = F32<S, 16>;

/// The frame that rays are traced in: origin, axes permuted so that depth comes last, depth flipped to be positive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// The rays' origin, in permuted axes.
    pub(crate) org: [f32; 3],
    /// The world axes of u, v and depth.
    pub(crate) axes: [usize; 3],
    /// The sign bit if depth runs against its world axis.
    pub(crate) flip: u32,
}

impl Frame {
    #[inline(always)]
    pub(crate) fn new(org: [f32; 3], face: Face) -> Frame {
        let axes = face.axes();
        Frame {
            org: [org[axes[0]], org[axes[1]], org[axes[2]]],
            axes,
            flip: if face.negative { 0x8000_0000 } else { 0 },
        }
    }
}
