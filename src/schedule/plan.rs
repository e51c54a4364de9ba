//! Which tiles a frame really consists of, and in which order. Pure: the simulator uses the same.

use super::{CostMap, Strategy};
use crate::tile::Tile;

/// Tiles are not cut below this side: smaller ones would leave the kernels' packets half empty.
const SMALLEST: u32 = 16;
/// Refinement cuts a tile that is more than the rest of the frame divided by this and the number of workers.
const REST_PER_TILE: f64 = 2.0;
/// A stealing worker's tile is at most the rest of its range divided by this, ...
const REST_PER_STOLEN: f64 = 2.0;
/// ... and at most a worker's share of the frame divided by this, ...
const SHARE_PER_TILE: f64 = 12.0;
/// ... but need not be less than that share divided by this.
const SHARE_PER_LEAST: f64 = 256.0;
/// While the next frame is in flight, a tile need not be cut unless it is more than a worker's share divided by this.
const SHARE_PER_OVERLAPPED: f64 = 3.0;
/// A dealt task should last at least as long as the messages for it are on their way, in seconds, ...
const SHORTEST_TASK: f64 = 40e-6;
/// ... and so long that the master has this much time for it, in seconds, while it serves all others.
const MASTER_PER_TASK: f64 = 4e-6;
/// Where it is not known how long a frame takes, a task need not be less than a worker's share divided by this.
const SHARE_PER_TASK: f64 = 256.0;
/// However short the last frame was, this one may be longer: a task need not be more than a worker's share divided by this.
const SHARE_PER_LONGEST: f64 = 8.0;
/// Cost-guided cuts a tile that takes more than the frame divided by this and the number of workers.
const FRAME_PER_TILE: f64 = 6.0;

/// What workers do when they run out of a frame's tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// They wait for the others: the last tiles must be small.
    Awaited,
    /// They go on with the next frame: only tiles that would last longer than that are cut.
    Overlapped,
}

/// Tiles in the order in which they are dealt, and how much work each is expected to be.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Disjoint, and together the frame.
    pub tiles: Vec<Tile>,
    /// One per tile, in any unit.
    pub(super) weights: Vec<f64>,
    /// Of a stealing strategy, where each worker's range begins, and the end.
    pub(super) bounds: Vec<usize>,
    /// No task need weigh less.
    pub(super) least: f64,
}

impl Plan {
    /// The plan of a frame of `tiles` for `workers` workers. `costs` is what the last frame took; where it does not
    /// cover the tiles, all pixels are taken to be alike, and cost-guided does what refinement does.
    pub fn new(strategy: Strategy, workers: usize, end: End, tiles: &[Tile], costs: &CostMap) -> Plan {
        let mut plan = Plan::default();
        plan.fill(strategy, workers, end, tiles, costs);
        plan
    }

    /// Becomes the plan that [`Plan::new`] returns; keeps its memory.
    pub(super) fn fill(
        &mut self,
        strategy: Strategy,
        workers: usize,
        end: End,
        tiles: &[Tile],
        costs: &CostMap,
    ) {
        self.tiles.clear();
        self.weights.clear();
        self.bounds.clear();
        let known = costs.covers(tiles) && costs.total() > 0.0;
        let least_share = match known {
            true => (SHORTEST_TASK.max(MASTER_PER_TASK * workers as f64) / costs.total())
                .min(1.0 / (SHARE_PER_LONGEST * workers as f64)),
            false => 1.0 / (SHARE_PER_TASK * workers as f64),
        };
        match strategy {
            Strategy::CostGuided if known => self.longest_first(workers, tiles, costs),
            Strategy::Refinement | Strategy::CostGuided => {
                let least = least_share * pixels(tiles);
                self.refine(workers, least, end, tiles);
            }
            Strategy::Stealing => self.share(workers, end, tiles, known.then_some(costs)),
            _ => {
                self.tiles.extend_from_slice(tiles);
                self.weights.resize(tiles.len(), 1.0);
            }
        }
        self.least = least_share * self.weights.iter().sum::<f64>();
    }

    /// Cuts the tiles at the end: none is more than a share of what comes from it on, unless it is less than `least`.
    fn refine(&mut self, workers: usize, least: f64, end: End, tiles: &[Tile]) {
        let mut rest = pixels(tiles);
        let overlapped = rest / (SHARE_PER_OVERLAPPED * workers as f64);
        for &tile in tiles {
            cut(tile, &mut |part, whole| {
                let pixels = part.len() as f64;
                let most = match end {
                    End::Awaited => rest / (REST_PER_TILE * workers as f64),
                    End::Overlapped => overlapped,
                };
                let stays = whole || pixels <= most.max(least);
                if stays {
                    rest -= pixels;
                    self.tiles.push(part);
                    self.weights.push(pixels);
                }
                stays
            });
        }
    }

    /// A range for each worker. Its last tiles are cut, since they are what is left to share when others run out, and so
    /// are those that are too much for one worker. Weights are seconds if the last frame tells them, else pixels.
    fn share(&mut self, workers: usize, end: End, tiles: &[Tile], costs: Option<&CostMap>) {
        let weigh = |tile: Tile| costs.and_then(|costs| costs.predict(tile)).unwrap_or(tile.len() as f64);
        let weights: Vec<f64> = tiles.iter().map(|&tile| weigh(tile)).collect();
        let share = weights.iter().sum::<f64>() / workers as f64;
        let place = |worker: usize| worker * tiles.len() / workers;
        for worker in 0..workers {
            self.bounds.push(self.tiles.len());
            let range = place(worker)..place(worker + 1);
            let mut rest: f64 = weights[range.clone()].iter().sum();
            for (&tile, &known) in tiles[range.clone()].iter().zip(&weights[range]) {
                cut(tile, &mut |part, whole| {
                    let weight = if part == tile { known } else { weigh(part) };
                    let most = match end {
                        End::Awaited => {
                            (rest / REST_PER_STOLEN).max(share / SHARE_PER_LEAST).min(share / SHARE_PER_TILE)
                        }
                        End::Overlapped => share / SHARE_PER_OVERLAPPED,
                    };
                    let stays = whole || workers == 1 || weight <= most;
                    if stays {
                        rest -= weight;
                        self.tiles.push(part);
                        self.weights.push(weight);
                    }
                    stays
                });
            }
        }
        self.bounds.push(self.tiles.len());
    }

    /// Cuts the tiles that take too long, and sorts. Times within a factor of two count as equal, so that neighbours
    /// in the order stay neighbours.
    fn longest_first(&mut self, workers: usize, tiles: &[Tile], costs: &CostMap) {
        let limit = costs.total() / (FRAME_PER_TILE * workers as f64);
        let mut parts: Vec<(Tile, f64)> = Vec::with_capacity(2 * tiles.len());
        for &tile in tiles {
            cut(tile, &mut |part, whole| {
                let seconds = costs.predict(part).unwrap_or(0.0);
                let stays = whole || seconds <= limit;
                if stays {
                    parts.push((part, seconds));
                }
                stays
            });
        }
        let class = |seconds: f64| (limit / seconds.max(limit * 1e-6)).log2().ceil() as i32;
        parts.sort_by_key(|&(_, seconds)| class(seconds));
        self.tiles.extend(parts.iter().map(|part| part.0));
        self.weights.extend(parts.iter().map(|part| part.1));
    }
}

fn pixels(tiles: &[Tile]) -> f64 {
    tiles.iter().map(|tile| tile.len() as f64).sum()
}

/// Cuts `tile` in four, clockwise, and again, until `stays` takes the part. Its second argument is true for a part that
/// is too small to be cut: it must take that.
fn cut(tile: Tile, stays: &mut impl FnMut(Tile, bool) -> bool) {
    let whole = tile.width.max(tile.height) < 2 * SMALLEST;
    if stays(tile, whole) || whole {
        return;
    }
    let (w, h) = (half(tile.width), half(tile.height));
    let (right, below) = (tile.width - w, tile.height - h);
    for quarter in [
        Tile { width: w, height: h, ..tile },
        Tile { x: tile.x + w, width: right, height: h, ..tile },
        Tile { x: tile.x + w, y: tile.y + h, width: right, height: below },
        Tile { y: tile.y + h, width: w, height: below, ..tile },
    ] {
        if !quarter.is_empty() {
            cut(quarter, stays);
        }
    }
}

/// About half of a side, in whole packets of the kernels; all of a side too short to be cut.
fn half(side: u32) -> u32 {
    if side < 2 * SMALLEST { side } else { (side / 2).next_multiple_of(SMALLEST) }
}

#[cfg(test)]
mod tests {
    use super::super::{Dealer, Run};
    use super::*;
    use crate::tile::{Order, tiles};

    const SIZES: [(u32, u32, u32); 6] =
        [(256, 256, 64), (100, 70, 33), (5, 5, 64), (1, 1, 1), (0, 0, 8), (300, 17, 128)];

    fn costs(tiles: &[Tile]) -> CostMap {
        let mut map = CostMap::covering(tiles);
        for (i, &tile) in tiles.iter().enumerate() {
            map.record(tile, (i * i % 17) as f64);
        }
        map
    }

    #[test]
    fn every_plan_covers_every_pixel_once_and_every_tile_is_dealt_once() {
        for (width, height, side) in SIZES {
            let base = tiles(width, height, side, Order::Hilbert);
            for strategy in Strategy::ALL {
                for (workers, end) in [1, 2, 3, 40].into_iter().zip([End::Awaited, End::Overlapped].repeat(2))
                {
                    let plan = Plan::new(strategy, workers, end, &base, &costs(&base));
                    let mut count = vec![0; (width * height) as usize];
                    for tile in &plan.tiles {
                        assert!(!tile.is_empty());
                        for y in tile.y..tile.y + tile.height {
                            for x in tile.x..tile.x + tile.width {
                                count[(y * width + x) as usize] += 1;
                            }
                        }
                    }
                    assert!(count.iter().all(|&c| c == 1), "{strategy} {workers} {width}x{height}");
                    let mut dealer = Dealer::new(strategy, workers, &plan);
                    let mut dealt: Vec<Run> =
                        (0..workers).filter_map(|worker| dealer.first(worker, &plan)).collect();
                    dealt.extend(std::iter::from_fn(|| dealer.next(&plan)));
                    let mut places: Vec<usize> = dealt.iter().flat_map(|run| run.places()).collect();
                    places.sort_unstable();
                    assert_eq!(places, (0..plan.tiles.len()).collect::<Vec<_>>(), "{strategy} {workers}");
                }
            }
        }
    }

    #[test]
    fn static_strategies_deal_regions_or_every_nth_tile() {
        let base = tiles(256, 256, 64, Order::Hilbert);
        let dealt = |strategy| {
            let plan = Plan::new(strategy, 3, End::Awaited, &base, &CostMap::default());
            let dealer = Dealer::new(strategy, 3, &plan);
            [0, 1, 2].map(|worker| {
                let Run { first, end, step } = dealer.first(worker, &plan).unwrap();
                [first, end, step]
            })
        };
        assert_eq!(dealt(Strategy::Static), [[0, 5, 1], [5, 10, 1], [10, 16, 1]]);
        assert_eq!(dealt(Strategy::StaticCyclic), [[0, 16, 3], [1, 16, 3], [2, 16, 3]]);
    }

    #[test]
    fn refinement_shrinks_tasks_and_tiles() {
        let base = tiles(1024, 1024, 64, Order::Hilbert);
        let plan = Plan::new(Strategy::Refinement, 2, End::Awaited, &base, &CostMap::default());
        assert_eq!((plan.tiles[0].width, plan.tiles.last().unwrap().width), (64, 32));
        assert!(plan.tiles.windows(2).all(|pair| pair[1].len() <= pair[0].len()));
        let mut dealer = Dealer::new(Strategy::Refinement, 2, &plan);
        let pixels = |run: Run| run.places().map(|i| plan.tiles[i].len()).sum::<usize>();
        let tasks: Vec<usize> = std::iter::from_fn(|| dealer.next(&plan)).map(pixels).collect();
        assert!(tasks[0] > 30 * 4096 && *tasks.last().unwrap() <= 4096, "{tasks:?}");
        assert!(tasks.len() < 40, "{}", tasks.len());
    }

    #[test]
    fn a_stealing_worker_has_small_tiles_last() {
        let base = tiles(1024, 1024, 64, Order::Hilbert);
        let plan = Plan::new(Strategy::Stealing, 32, End::Awaited, &base, &CostMap::default());
        let dealer = Dealer::new(Strategy::Stealing, 32, &plan);
        for worker in 0..32 {
            let sides: Vec<u32> =
                dealer.first(worker, &plan).unwrap().places().map(|i| plan.tiles[i].width).collect();
            assert!(sides.is_sorted_by(|a, b| a >= b), "{sides:?}");
            // A share is 8 tiles of 64x64; at most a twelfth of it, at last next to nothing.
            assert_eq!((sides[0], sides.last()), (32, Some(&16)));
        }
        let alone = Plan::new(Strategy::Stealing, 1, End::Awaited, &base, &CostMap::default());
        assert_eq!(alone.tiles, base, "one worker has nobody to share with");
    }

    #[test]
    fn while_the_next_frame_is_in_flight_only_what_would_outlast_it_is_cut() {
        let base = tiles(1024, 1024, 64, Order::Hilbert);
        let unknown = CostMap::default();
        let plan = |strategy, workers, end, costs| Plan::new(strategy, workers, end, &base, costs).tiles;
        // A share is eight tiles, or one.
        for strategy in [Strategy::Refinement, Strategy::Stealing] {
            assert_eq!(plan(strategy, 32, End::Overlapped, &unknown), base, "{strategy}");
            assert!(plan(strategy, 32, End::Awaited, &unknown).len() > base.len(), "{strategy}");
            assert_eq!(plan(strategy, 256, End::Overlapped, &unknown).len(), 4 * base.len(), "{strategy}");
        }
        // One tile as dear as all others together.
        let mut map = CostMap::covering(&base);
        base.iter().for_each(|&tile| map.record(tile, if tile == base[9] { 255.0 } else { 1.0 }));
        // A quarter of it is more than a third of a share, 127.5; a sixteenth is not.
        assert_eq!(plan(Strategy::Stealing, 4, End::Overlapped, &map).len(), 255 + 16);
    }

    #[test]
    fn what_took_one_stealing_worker_too_long_is_cut() {
        let base = tiles(256, 256, 64, Order::Hilbert);
        let mut map = CostMap::covering(&base);
        base.iter().for_each(|&tile| map.record(tile, if tile == base[9] { 100.0 } else { 0.1 }));
        let plan = Plan::new(Strategy::Stealing, 2, End::Awaited, &base, &map);
        let inside = |tile: &&Tile| {
            base[9].x <= tile.x && tile.x < base[9].x + 64 && base[9].y <= tile.y && tile.y < base[9].y + 64
        };
        assert_eq!(plan.tiles.iter().filter(inside).count(), 16);
        assert_eq!(plan.tiles[0], base[0]);
    }

    #[test]
    fn cost_guided_starts_with_the_longest_and_cuts_it() {
        let base = tiles(256, 256, 64, Order::Hilbert);
        let mut map = CostMap::covering(&base);
        base.iter().for_each(|&tile| map.record(tile, if tile == base[9] { 100.0 } else { 1.0 }));
        let plan = Plan::new(Strategy::CostGuided, 2, End::Awaited, &base, &map);
        assert_eq!(plan.tiles.len(), 15 + 16);
        assert!(plan.tiles[..16].iter().all(|tile| tile.width == 16));
        // The others keep their order.
        let others: Vec<Tile> = base.iter().copied().filter(|&tile| tile != base[9]).collect();
        assert_eq!(plan.tiles[16..], others);
    }

    #[test]
    fn without_a_last_frame_cost_guided_refines() {
        let base = tiles(256, 256, 64, Order::Hilbert);
        let [refined, guided] = [Strategy::Refinement, Strategy::CostGuided]
            .map(|strategy| Plan::new(strategy, 3, End::Awaited, &base, &CostMap::default()).tiles);
        assert_eq!(refined, guided);
    }
}
