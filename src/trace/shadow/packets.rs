//! From the stream to a packet and back, sixteen rays at a time.

use super::{Group, ShadowRays};
use crate::kernels::{F32, I32, Kernel, Mask, SUB, SUBS, Simd, TilePacket};

/// The groups of one packet.
#[derive(Clone, Copy)]
pub(super) struct Cast<'a> {
    pub(super) groups: &'a [Group],
    /// Sort key and index of at most 16 groups.
    pub(super) order: &'a [u64],
    /// Sort key and index of the loose rays.
    pub(super) loose: &'a [u64],
}

impl Cast<'_> {
    /// Group of sub-packet `sub`.
    #[inline(always)]
    fn group(&self, sub: usize) -> Group {
        self.groups[self.order[sub] as u32 as usize]
    }

    /// Index of ray `i` of a loose group.
    #[inline(always)]
    fn loose(&self, group: Group, i: usize) -> usize {
        self.loose[group.first as usize + i] as u32 as usize
    }
}

/// Fills a packet; the number of its rays.
pub(super) struct Fill<'a, 'b> {
    pub(super) cast: Cast<'a>,
    pub(super) rays: &'a ShadowRays<'b>,
    pub(super) packet: &'a mut TilePacket,
}

impl Kernel for Fill<'_, '_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u64 {
        let Fill { cast, rays, packet } = self;
        let mut traced = 0;
        for sub in 0..cast.order.len().min(SUBS) {
            let group = cast.group(sub);
            packet.active[sub] = group.active;
            traced += u64::from(group.active.count_ones());
            let to = sub * SUB;
            if group.loose {
                for i in 0..group.active.count_ones() as usize {
                    let ray = cast.loose(group, i);
                    packet.u[to + i] = rays.u[ray];
                    packet.v[to + i] = rays.v[ray];
                    packet.tfar[to + i] = rays.tfar[ray];
                    packet.skip[to + i] = rays.skip[ray];
                }
            } else {
                let from = group.first as usize * SUB;
                F32::<S, SUB>::load_at(s, rays.u, from).store_at(&mut packet.u, to);
                F32::<S, SUB>::load_at(s, rays.v, from).store_at(&mut packet.v, to);
                F32::<S, SUB>::load_at(s, rays.tfar, from).store_at(&mut packet.tfar, to);
                let skip = I32::<S, SUB>::load(s, &rays.skip.as_chunks().0[group.first as usize]);
                skip.store(&mut packet.skip.as_chunks_mut().0[sub]);
            }
        }
        traced
    }
}

/// Clears `visible` where a ray is blocked.
pub(super) struct Clear<'a> {
    pub(super) cast: Cast<'a>,
    pub(super) blocked: &'a [u16; SUBS],
    pub(super) visible: &'a mut [f32],
}

impl Kernel for Clear<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Clear { cast, blocked, visible } = self;
        let zero = F32::<S, SUB>::splat(s, 0.0);
        for sub in 0..cast.order.len().min(SUBS) {
            let group = cast.group(sub);
            let mut bits = u32::from(blocked[sub]);
            if bits == 0 {
                continue;
            }
            if group.loose {
                while bits != 0 {
                    visible[cast.loose(group, bits.trailing_zeros() as usize)] = 0.0;
                    bits &= bits - 1;
                }
            } else {
                let at = group.first as usize * SUB;
                let mask = Mask::from_bits(s, bits);
                mask.select(zero, F32::load_at(s, visible, at)).store_at(visible, at);
            }
        }
    }
}
