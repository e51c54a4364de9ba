//! Tables 1 and 6 to 8 of the thesis: what consecutive pixels have in common.

use crate::kernels::{Hit, MISS};

/// What consecutive primary rays have in common (table 1).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrimaryTally {
    /// Pixels that hit the triangle that the pixel before them hit.
    pub same: u64,
    /// Pixels that hit nothing, like the pixel before them; the thesis does not count these.
    pub both_missed: u64,
    /// Pixels that hit anything.
    pub hit: u64,
    /// Triangles that are hit at all.
    pub triangles: u64,
    /// By pixel, row by row: counted in `same`.
    pub map: Vec<bool>,
}

impl PrimaryTally {
    /// Counts along `pixels`; `hits` are by pixel, row by row.
    pub fn new(pixels: &[(u32, u32)], width: u32, hits: &[Hit]) -> PrimaryTally {
        let mut tally = PrimaryTally { map: vec![false; hits.len()], ..PrimaryTally::default() };
        let mut before = None;
        for &(x, y) in pixels {
            let pixel = (y * width + x) as usize;
            let prim = hits[pixel].prim;
            tally.hit += u64::from(prim != MISS);
            if before == Some(prim) {
                tally.map[pixel] = prim != MISS;
                tally.same += u64::from(prim != MISS);
                tally.both_missed += u64::from(prim == MISS);
            }
            before = Some(prim);
        }
        let mut seen: Vec<u32> = hits.iter().map(|hit| hit.prim).filter(|&prim| prim != MISS).collect();
        seen.sort_unstable();
        seen.dedup();
        tally.triangles = seen.len() as u64;
        tally
    }

    /// How often the order enters the region of a triangle before it has seen all of it, on average over the triangles
    /// seen: the measure of Voorhies ("Space-filling curves and a measure of coherence", Graphics Gems II, 1991) for the
    /// regions of this picture. 1 is best.
    pub fn entries_per_triangle(&self) -> f64 {
        (self.hit - self.same) as f64 / self.triangles.max(1) as f64
    }
}

/// The share of pixels that hit the triangle that their neighbour to the left hits, and of those that hit the one that
/// their neighbour above hits, 0 to 1.
///
/// What an order of unit steps counts in table 1 is the mean of the two, weighted by its steps along each axis: all along
/// the rows for scanline, half and half for the Hilbert curve.
pub fn likeness(hits: &[Hit], width: u32) -> [f64; 2] {
    let width = width as usize;
    let alike = |a: &Hit, b: &Hit| u64::from(a.prim == b.prim && a.prim != MISS);
    let rows = hits.chunks_exact(width);
    let across: u64 = rows.clone().flat_map(|row| row.windows(2)).map(|pair| alike(&pair[0], &pair[1])).sum();
    let down: u64 = hits.iter().zip(hits.iter().skip(width)).map(|(a, b)| alike(a, b)).sum();
    let height = rows.len();
    let share = |alike: u64, pairs: usize| alike as f64 / pairs.max(1) as f64;
    [share(across, width.saturating_sub(1) * height), share(down, width * height.saturating_sub(1))]
}

/// Rows of tables 6 to 8: 1 to 7 lights, and 8 or more.
pub const ROWS: usize = 8;

/// Pixels by the number of lights that are occluded by the triangle that occluded the ray before (tables 6 to 8).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ShadowTally {
    /// Pixels with 1, 2, ... 7, and with 8 or more such lights.
    pub pixels: [u64; ROWS],
    /// The lights of all pixels together.
    pub total: u64,
}

impl ShadowTally {
    /// Counts pixels; each has so many lights.
    pub fn new(lights: &[u16]) -> ShadowTally {
        let mut tally = ShadowTally::default();
        for &lights in lights.iter().filter(|&&lights| lights > 0) {
            tally.pixels[(lights as usize).min(ROWS) - 1] += 1;
            tally.total += u64::from(lights);
        }
        tally
    }
}

/// The gain of `with` over `without` in percent, by the thesis' formula; `None` over nothing.
pub fn gain(with: f64, without: f64) -> Option<f64> {
    (without != 0.0).then(|| with * 100.0 / without - 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hits(prims: &[u32]) -> Vec<Hit> {
        prims.iter().map(|&prim| Hit { prim, ..Hit::MISS }).collect()
    }

    #[test]
    fn a_pixel_counts_if_the_one_before_it_in_the_order_hit_the_same() {
        let picture = hits(&[5, 5, MISS, MISS, 5, 5]);
        let rows: Vec<_> = (0..2).flat_map(|y| (0..3).map(move |x| (x, y))).collect();
        let tally = PrimaryTally::new(&rows, 3, &picture);
        assert_eq!((tally.same, tally.both_missed, tally.hit, tally.triangles), (2, 1, 4, 1));
        assert_eq!(tally.map, [false, true, false, false, false, true]);
        assert_eq!(tally.entries_per_triangle(), 2.0);
        let serpentine = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)];
        assert_eq!(PrimaryTally::new(&serpentine, 3, &picture).same, 2);
        let columns = [(0, 0), (1, 0), (1, 1), (2, 1), (2, 0), (0, 1)];
        assert_eq!(PrimaryTally::new(&columns, 3, &picture).same, 3);
    }

    #[test]
    fn neighbours_are_alike_across_or_down() {
        // Three columns of two pixels: all pairs down, none across but the misses, which do not count.
        let picture = hits(&[1, 2, MISS, 1, 2, MISS]);
        assert_eq!(likeness(&picture, 3), [0.0, 2.0 / 3.0]);
        assert_eq!(likeness(&hits(&[7, 7, 7]), 3), [1.0, 0.0]);
    }

    #[test]
    fn lights_are_counted_by_pixel_and_together() {
        let tally = ShadowTally::new(&[0, 1, 1, 3, 8, 11]);
        assert_eq!(tally.pixels, [2, 0, 1, 0, 0, 0, 0, 2]);
        assert_eq!(tally.total, 24);
    }

    #[test]
    fn the_gain_is_that_of_the_thesis() {
        let table8 = gain(45_645.0, 44_016.0).unwrap();
        assert!((table8 - 3.701).abs() < 1e-3);
        assert_eq!(gain(1.0, 0.0), None);
    }
}
