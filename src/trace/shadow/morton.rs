//! Sort keys: the face, then the place on a Morton curve over the slopes.

use super::blocks::Block;

/// Bits of the place on the curve; the face stands above them.
pub(super) const BITS: u32 = 2 * AXIS_BITS;
const AXIS_BITS: u32 = 10;

/// A grid of cells over the slopes that a face's rays actually have.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    min: [f32; 2],
    scale: f32,
}

impl Grid {
    /// One grid for each face.
    pub(super) fn around(blocks: &[Block]) -> [Grid; 6] {
        let mut min = [[f32::INFINITY; 2]; 6];
        let mut max = [[f32::NEG_INFINITY; 2]; 6];
        for block in blocks.iter().filter(|block| block.active != 0) {
            // A block of several faces counts for all: it only makes their grids coarser.
            let faces = if block.face < 6 { block.face as usize..block.face as usize + 1 } else { 0..6 };
            for face in faces {
                for axis in 0..2 {
                    min[face][axis] = min[face][axis].min(block.min[axis]);
                    max[face][axis] = max[face][axis].max(block.max[axis]);
                }
            }
        }
        std::array::from_fn(|face| {
            let size = |axis: usize| (max[face][axis] - min[face][axis]).max(1.0e-6);
            // Square cells: packets should not be longer than wide.
            Grid { min: min[face], scale: ((1 << AXIS_BITS) as f32 - 0.5) / size(0).max(size(1)) }
        })
    }
}

/// The key of a ray or group at slopes (u, v) of a face below 6.
pub(super) fn key(grids: &[Grid; 6], face: u32, u: f32, v: f32) -> u32 {
    let grid = &grids[face as usize];
    // Casts saturate.
    let x = (((u - grid.min[0]) * grid.scale) as u32).min((1 << AXIS_BITS) - 1);
    let y = (((v - grid.min[1]) * grid.scale) as u32).min((1 << AXIS_BITS) - 1);
    face << BITS | spread(x) | spread(y) << 1
}

/// The bits of a 10-bit number moved apart.
fn spread(x: u32) -> u32 {
    let x = (x | x << 8) & 0x00ff_00ff;
    let x = (x | x << 4) & 0x0f0f_0f0f;
    let x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    #[test]
    fn bits_move_apart() {
        for x in 0..1024u32 {
            let want: u32 = (0..10).map(|bit| (x >> bit & 1) << (2 * bit)).sum();
            assert_eq!(super::spread(x), want);
        }
    }
}
