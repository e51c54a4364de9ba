//! In which tasks the tiles of a plan are dealt. Pure: the simulator uses the same.

use super::{Plan, Strategy};

/// A task of a strategy that shrinks them is the rest of the frame divided by this and the number of workers.
const REST_PER_TASK: f64 = 3.0;

/// Some tiles of a plan: `first`, `first + step`, ... below `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The first one.
    pub first: usize,
    /// Behind the last one.
    pub end: usize,
    /// Distance between two, >= 1.
    pub step: usize,
}

impl Run {
    /// How many they are.
    pub fn len(self) -> usize {
        self.end.saturating_sub(self.first).div_ceil(self.step)
    }

    /// True if there are none.
    pub fn is_empty(self) -> bool {
        self.first >= self.end
    }

    /// The tiles' places in the plan.
    pub fn places(self) -> impl Iterator<Item = usize> {
        (self.first..self.end).step_by(self.step)
    }
}

/// Deals the tasks of a plan.
#[derive(Debug)]
pub struct Dealer {
    strategy: Strategy,
    workers: usize,
    tiles: usize,
    next: usize,
    /// Weight of the tiles not dealt.
    rest: f64,
}

impl Dealer {
    /// Nothing is dealt yet.
    pub fn new(strategy: Strategy, workers: usize, plan: &Plan) -> Dealer {
        let rest: f64 = plan.weights.iter().sum();
        Dealer { strategy, workers, tiles: plan.tiles.len(), next: 0, rest }
    }

    /// What `worker` gets when the frame begins if the strategy [deals at first](Strategy::deals_at_first): of a
    /// stealing one the range that it owns. `None` if there is nothing for it.
    pub fn first(&self, worker: usize, plan: &Plan) -> Option<Run> {
        let run = match self.strategy {
            Strategy::Static => {
                let place = |i: usize| i * self.tiles / self.workers;
                Run { first: place(worker), end: place(worker + 1), step: 1 }
            }
            Strategy::Stealing => Run { first: plan.bounds[worker], end: plan.bounds[worker + 1], step: 1 },
            Strategy::StaticCyclic => Run { first: worker, end: self.tiles, step: self.workers },
            _ => return None,
        };
        (!run.is_empty()).then_some(run)
    }

    /// What a worker gets next; `None` if all is dealt.
    pub fn next(&mut self, plan: &Plan) -> Option<Run> {
        if self.next >= self.tiles || self.strategy.deals_at_first() {
            return None;
        }
        let first = self.next;
        self.next += 1;
        if self.strategy.shrinks() {
            let share = (self.rest / (REST_PER_TASK * self.workers as f64)).max(plan.least);
            let mut sum = plan.weights[first];
            while self.next < self.tiles && sum + plan.weights[self.next] <= share {
                sum += plan.weights[self.next];
                self.next += 1;
            }
            self.rest -= sum;
        }
        Some(Run { first, end: self.next, step: 1 })
    }
}
