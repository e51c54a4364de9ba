//! What messages cost a master on the core of a worker: measured with as many films as a stream has, so that pixels are copied
//! to where they are as far away as in a stream.

use super::Costs;
use crate::film::Film;
use crate::schedule::{Load, Machine, Placement, SharedCore, SharedCoreProbe};
use crate::tile::{Order, Tile, tiles};
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicUsize, Ordering},
};
use std::time::Duration;

/// Side of a tile whose pixels are copied.
pub(super) const SIDE: u32 = 64;
/// Bytes of its pixels.
pub(super) const BYTES: f64 = (SIDE * SIDE) as f64 * 12.0;

/// Films need not be larger, nor more, to be farther away than any cache: 192 MiB.
const LARGEST: u32 = 2048;
const MOST: usize = 4;

/// Rounds of messages on the first two cores, if there are two.
pub(in crate::study::scaling) struct SharedCores {
    /// The other one, and that of the master.
    cores: Option<[usize; 2]>,
    load: Copying,
    shared: SharedCoreProbe,
    copying: SharedCoreProbe,
}

impl SharedCores {
    /// For streams with so many films of that size to copy to; with 0, copying is not measured.
    pub(in crate::study::scaling) fn new(pin: bool, size: [u32; 2], films: usize) -> SharedCores {
        let cores = match Placement::new(Machine::get(), Some(2), pin).slots() {
            &[Some(other), Some(core)] => Some([other, core]),
            _ => None,
        };
        let films = if cores.is_some() { films.min(MOST) } else { 0 };
        let load = Copying::new(size.map(|side| side.min(LARGEST)), films);
        let probe = SharedCoreProbe::default;
        SharedCores { cores, load, shared: probe(), copying: probe() }
    }

    /// A round of `messages` of each kind; where the master does not copy pixels, a report keeps it for so many seconds.
    pub(in crate::study::scaling) fn measure(&mut self, messages: usize, collect: f64) {
        let Some([other, core]) = self.cores else { return };
        self.shared.measure(messages, core, other, &Duration::from_secs_f64(collect));
        if !self.load.films.is_empty() {
            self.copying.measure(messages, core, other, &self.load);
        }
    }

    /// `costs` with what all rounds found, if any did.
    pub(in crate::study::scaling) fn found(&self, costs: Costs) -> Costs {
        with(costs, self.shared.costs(), self.copying.costs())
    }
}

fn with(costs: Costs, shared: Option<SharedCore>, copying: Option<SharedCore>) -> Costs {
    let copied = copying.map(|copying| copying.work.map(|work| work / BYTES));
    // On a busy machine it may be that no message was alone.
    let copied = copied.filter(|copied| copied.iter().all(|&byte| byte > 0.0));
    Costs {
        shared: shared.unwrap_or(costs.shared),
        copying: copying.unwrap_or(costs.copying),
        copied: copied.or(costs.copied),
        ..costs
    }
}

/// Copies tiles that their sender has just written into films, one film after another.
struct Copying {
    films: Vec<Film>,
    tiles: Vec<Tile>,
    next: AtomicUsize,
    planes: [Mutex<Vec<f32>>; 2],
}

impl Copying {
    fn new([width, height]: [u32; 2], films: usize) -> Copying {
        let planes = || Mutex::new(vec![0.0; 3 * (SIDE * SIDE) as usize]);
        // Only whole tiles, so that each has as many bytes.
        let [width, height] = [width, height].map(|side| side.next_multiple_of(SIDE));
        Copying {
            films: (0..films).map(|_| Film::new(width, height)).collect(),
            tiles: tiles(width, height, SIDE, Order::Hilbert),
            next: AtomicUsize::new(0),
            planes: [planes(), planes()],
        }
    }
}

impl Load for Copying {
    fn fill(&self, sender: usize) {
        self.planes[sender].lock().unwrap_or_else(PoisonError::into_inner).fill(0.5);
    }

    fn take(&self, sender: usize) {
        let next = self.next.fetch_add(1, Ordering::Relaxed);
        let film = &self.films[next / self.tiles.len() % self.films.len()];
        let planes = self.planes[sender].lock().unwrap_or_else(PoisonError::into_inner);
        write(film, self.tiles[next % self.tiles.len()], &planes);
    }
}

/// Copies a tile's pixels.
pub(super) fn write(film: &Film, tile: Tile, planes: &[f32]) {
    let pixels = tile.len();
    let [r, g, b] = [0, 1, 2].map(|plane| &planes[plane * pixels..][..pixels]);
    film.write_tile(tile, r, g, b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::scaling::costs::NOTHING;

    #[test]
    fn tiles_are_copied_to_one_film_after_another() {
        let load = Copying::new([100, 64], 2);
        let value = |film: usize, x: u32| {
            let mut planes = [vec![], vec![], vec![]];
            load.films[film].read_tile(Tile { x, y: 63, width: 1, height: 1 }, &mut planes);
            planes.map(|plane| plane[0])
        };
        load.fill(1);
        (0..3).for_each(|_| load.take(1));
        assert_eq!(
            [value(0, 0), value(0, 127), value(1, 0), value(1, 127)],
            [[0.5; 3], [0.5; 3], [0.5; 3], [0.0; 3]]
        );
        (0..2).for_each(|_| load.take(0));
        // The other sender has written nothing; its tiles are black.
        assert_eq!([value(1, 127), value(0, 0), value(0, 127)], [[0.0; 3], [0.0; 3], [0.5; 3]]);
    }

    #[test]
    fn what_is_found_takes_the_place_of_what_was_known() {
        let known = Costs { copied: Some([7.0, 8.0]), ..NOTHING };
        let shared = SharedCore { work: [2.0; 2], ..NOTHING.shared };
        // A tile has 64 x 64 pixels of 12 bytes.
        let copying = SharedCore { work: [49152.0, 2.0 * 49152.0], ..NOTHING.shared };
        assert_eq!(with(known, None, None), known);
        assert_eq!(with(known, Some(shared), None), Costs { shared, ..known });
        let found = Costs { shared, copying, copied: Some([1.0, 2.0]), ..known };
        assert_eq!(with(known, Some(shared), Some(copying)), found);
        let unseen = SharedCore { work: [49152.0, 0.0], ..copying };
        assert_eq!(with(known, None, Some(unseen)), Costs { copying: unseen, ..known });
    }

    #[test]
    fn copying_is_measured_only_with_films() {
        for films in [0, 1] {
            let mut cores = SharedCores::new(true, [64, 64], films);
            cores.measure(5, 0.0);
            let measured = [cores.shared.costs(), cores.copying.costs()].map(|costs| costs.is_some());
            let can = cores.cores.is_some();
            assert_eq!(measured, [can, can && films > 0]);
        }
    }

    #[test]
    fn films_are_as_many_and_as_large_as_those_of_a_stream_but_no_more_than_caches_call_for() {
        let films = |size, films| {
            let load = SharedCores::new(true, size, films).load;
            load.films.iter().map(|film| [film.width(), film.height()]).collect::<Vec<_>>()
        };
        if SharedCores::new(true, [64, 64], 1).cores.is_some() {
            assert_eq!(films([100, 64], 2), [[128, 64]; 2]);
            assert_eq!(films([100_000, 64], 16), [[2048, 64]; 4]);
        }
    }

    #[test]
    fn without_two_cores_nothing_is_measured_and_costs_stay() {
        let mut shared = SharedCores { cores: None, ..SharedCores::new(false, [64, 64], 1) };
        shared.measure(1, 0.0);
        let costs = Costs { copied: Some([1.0, 2.0]), ..NOTHING };
        assert_eq!(shared.found(costs), costs);
    }
}
