//! Shadow rays that go through things: holes in surfaces, and glass, for which they are taken for unbent.
//!
//! ```text
//!   surface o-----> leaf with holes -----> glass -----> light        what arrives: (1 - alpha) x through x through
//!           first hit ^ goes on behind it  ^  ^ in and out
//! ```

use super::table::PathTable;
use crate::{
    kernels::{HitBlock, MISS, RayBlock, SUB},
    shade::surface::Planes,
    trace::{RayStream, Traversal},
};

/// Surfaces that a shadow ray may go through; what is behind more of them is dark.
const LAYERS: usize = 64;

/// Buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Filter {
    blocks: Vec<RayBlock>,
    hits: Vec<HitBlock>,
    /// What is left of the light, by ray.
    pub(super) tint: Planes,
}

impl Filter {
    /// Finds what gets through along each active ray; sets the bits of those along which nothing does.
    pub(super) fn trace(
        &mut self,
        table: &PathTable,
        traversal: &Traversal,
        stream: &mut RayStream,
        rays: &[RayBlock],
        blocked: &mut [u16],
    ) -> u64 {
        self.tint.iter_mut().for_each(|plane| {
            plane.clear();
            plane.resize(rays.len() * SUB, 1.0);
        });
        self.blocks.clear();
        self.blocks.extend_from_slice(rays);
        self.hits.resize(rays.len(), HitBlock::MISS);
        let mut doubts = 0;
        for _ in 0..LAYERS {
            doubts += stream.intersect(traversal, &self.blocks, &mut self.hits);
            let mut left = false;
            for (index, block) in self.blocks.iter_mut().enumerate() {
                for lane in (0..SUB).filter(|lane| block.active >> lane & 1 != 0).collect::<Lanes>() {
                    let hit = self.hits[index].get(lane);
                    if hit.prim == MISS {
                        block.active &= !(1 << lane);
                        continue;
                    }
                    let ray = index * SUB + lane;
                    let share = through(table, hit.prim, [hit.u, hit.v]);
                    for k in 0..3 {
                        self.tint[k][ray] *= share[k];
                    }
                    if self.tint.iter().all(|plane| plane[ray] <= 0.0) {
                        blocked[index] |= 1 << lane;
                        block.active &= !(1 << lane);
                    } else {
                        block.tnear[lane] = hit.t.next_up();
                        block.skip[lane] = hit.prim;
                        left = true;
                    }
                }
            }
            if !left {
                return doubts;
            }
        }
        for (block, blocked) in self.blocks.iter().zip(blocked) {
            *blocked |= block.active;
        }
        doubts
    }
}

/// Lanes of a block, taken before the block changes.
#[derive(Default)]
struct Lanes(u16);

impl FromIterator<usize> for Lanes {
    fn from_iter<I: IntoIterator<Item = usize>>(lanes: I) -> Lanes {
        Lanes(lanes.into_iter().fold(0, |bits, lane| bits | 1 << lane))
    }
}

impl Iterator for Lanes {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < SUB).then_some(lane)
    }
}

/// What gets through a surface on a straight line.
fn through(table: &PathTable, prim: u32, [b1, b2]: [f32; 2]) -> [f32; 3] {
    let optics = table.optics(prim);
    let Some(map) = optics.map_d.filter(|_| !table.charts.is_empty()) else { return optics.through };
    let uv = table.charts[prim as usize].at(b1, b2);
    let alpha = table.scene.textures[map as usize].sample(uv, 0.0)[0].clamp(0.0, 1.0);
    optics.through.map(|through| (1.0 - alpha) + alpha * through)
}
