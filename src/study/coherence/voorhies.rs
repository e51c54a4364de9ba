//! The measure of Voorhies for an order alone: how often it enters a disc until it has seen all of it.
//!
//! A disc has no direction, so that it favours no order (Voorhies, "Space-filling curves and a measure of coherence",
//! Graphics Gems II, 1991). Here as the mean over discs all over the image, all of them within it.
//!
//! Counted to the letter, all orders of unit steps are alike: a disc of radius r has 2 (2 r + 1) steps across its edge in
//! each direction; an order of rows takes all of one direction and none of the other, a curve half of each, and two of
//! them make one entry. What distinguishes a curve is how soon it returns. So entries after a *long* absence are counted
//! too: one of more pixels than the disc has, in which a memory of that many pixels would have forgotten it.

/// Discs for each radius.
const DISCS: usize = 256;

/// The mean number of entries into discs, each at best 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entries {
    /// Radius of the discs in pixels.
    pub radius: u32,
    /// All entries.
    pub all: f64,
    /// The first, and those after an absence of more pixels than the disc has.
    pub long: f64,
}

/// Entries into discs of `radius` pixels; `None` if the image is smaller than one. `pixels` is the order; the discs are
/// the same for all orders of an image.
pub fn entries_per_disc(pixels: &[(u32, u32)], [width, height]: [u32; 2], radius: u32) -> Option<Entries> {
    let room = [width.checked_sub(2 * radius)?, height.checked_sub(2 * radius)?];
    if room.contains(&0) {
        return None;
    }
    let mut rank = vec![0u32; pixels.len()];
    for (i, &(x, y)) in pixels.iter().enumerate() {
        rank[(y * width + x) as usize] = i as u32;
    }
    let r = i64::from(radius);
    let disc: Vec<[i64; 2]> = (-r..=r)
        .flat_map(|y| (-r..=r).map(move |x| [x, y]))
        .filter(|[x, y]| x * x + y * y <= r * r)
        .collect();
    let (mut all, mut long) = (0, 0);
    for number in 0..DISCS {
        let [x, y] = [0, 1].map(|axis| i64::from(radius + place(number, axis, room[axis])));
        let index = |[dx, dy]: &[i64; 2]| ((y + dy) * i64::from(width) + x + dx) as usize;
        let mut ranks: Vec<u32> = disc.iter().map(|offset| rank[index(offset)]).collect();
        ranks.sort_unstable();
        let absences = || ranks.windows(2).map(|pair| (pair[1] - pair[0] - 1) as usize);
        all += 1 + absences().filter(|&absence| absence > 0).count();
        long += 1 + absences().filter(|&absence| absence > disc.len()).count();
    }
    let mean = |sum: usize| sum as f64 / DISCS as f64;
    Some(Entries { radius, all: mean(all), long: mean(long) })
}

/// A place in `0..room` for each disc: multiples of the plastic number's powers, which spread evenly (Roberts 2018).
fn place(disc: usize, axis: usize, room: u32) -> u32 {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let step = 1.0 / if axis == 0 { PLASTIC } else { PLASTIC * PLASTIC };
    ((0.5 + step * disc as f64).fract() * f64::from(room)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tile::{Order, pixels};

    fn entries(order: Order, radius: u32) -> Entries {
        entries_per_disc(&pixels(243, 243, order, None), [243, 243], radius).unwrap()
    }

    #[test]
    fn rows_enter_a_disc_once_for_each_of_its_rows() {
        for radius in [1, 5, 20] {
            let rows = f64::from(2 * radius + 1);
            let Entries { all, long, .. } = entries(Order::Scanline, radius);
            // A wide disc has more pixels than lie between its rows.
            assert_eq!((all, long), (rows, if radius < 9 { rows } else { 1.0 }));
        }
    }

    #[test]
    fn curves_enter_as_often_but_return_soon() {
        for order in [Order::Hilbert, Order::Peano] {
            let Entries { all, long, .. } = entries(order, 7);
            assert!((all / 15.0 - 1.0).abs() < 0.03 && long < 4.0, "{order}: {all}, {long}");
        }
        assert!(entries(Order::Morton, 7).all > 15.0, "steps are longer than one");
    }

    #[test]
    fn a_disc_must_fit() {
        assert_eq!(entries_per_disc(&pixels(8, 64, Order::Hilbert, None), [8, 64], 4), None);
    }
}
