//! Which nodes of the binary tree become wide nodes, leaves, or vanish.
//!
//! Chosen by dynamic programming over the surface area heuristic (Ylitie, Karras, Laine 2017, section 3.1):
//! `cost[i]` is the least expected cost of a subtree when it may appear as up to `i + 1` children of some wide node.

/// Cost of visiting a wide node; the unit of the others.
pub(super) const NODE_COST: f32 = 1.0;
/// Cost of setting up a block.
pub(super) const LEAF_COST: f32 = 0.9;
/// Cost of each triangle in it.
pub(super) const TRIANGLE_COST: f32 = 0.12;
/// Triangles a leaf may hold.
pub(super) const LEAF_MAX: u32 = 8;

/// The best way to present a binary node as up to 1..=7 children (index 0 = one child).
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    cost: [f32; 7],
    /// For up to `i + 1` children: how many go to the left; 0 = fewer children are as good. `split[0]` is unused.
    split: [u8; 7],
    /// For a wide node made here: how many of its eight children go to the left.
    pub(super) inner_split: u8,
    /// As one child: true if a leaf is best.
    pub(super) leaf: bool,
    /// References below.
    pub(super) references: u32,
}

impl Choice {
    /// Of a node still to be built.
    pub(super) const NONE: Choice =
        Choice { cost: [0.0; 7], split: [0; 7], inner_split: 0, leaf: true, references: 0 };

    /// A binary leaf.
    pub(super) fn leaf(area: f32, references: u32) -> Choice {
        let cost = area * leaf_cost(references);
        Choice { cost: [cost; 7], references, ..Choice::NONE }
    }

    /// A binary node with two children.
    pub(super) fn inner(area: f32, left: &Choice, right: &Choice) -> Choice {
        let references = left.references + right.references;
        let (inner, inner_split) = distribute(left, right, 8);
        let inner_cost = inner + area * NODE_COST;
        let leaf_cost = if references <= LEAF_MAX { area * leaf_cost(references) } else { f32::INFINITY };
        // A leaf of too many triangles is none, however large the boxes.
        let leaf = references <= LEAF_MAX && (leaf_cost <= inner_cost || inner_cost.is_nan());
        let mut choice = Choice { cost: [0.0; 7], split: [0; 7], inner_split, leaf, references };
        choice.cost[0] = leaf_cost.min(inner_cost);
        for children in 2..=7 {
            let (cost, split) = distribute(left, right, children);
            let fewer = choice.cost[children - 2];
            let better = cost < fewer;
            choice.cost[children - 1] = if better { cost } else { fewer };
            choice.split[children - 1] = if better { split } else { 0 };
        }
        choice
    }

    /// How many of up to `limit` children go to the left; `None` if the node is best presented as one.
    pub(super) fn children(&self, mut limit: u8) -> Option<[u8; 2]> {
        while limit > 1 && self.split[limit as usize - 1] == 0 {
            limit -= 1;
        }
        let left = self.split[limit as usize - 1];
        (limit > 1).then(|| [left, limit - left])
    }
}

fn leaf_cost(references: u32) -> f32 {
    LEAF_COST + TRIANGLE_COST * references as f32
}

/// The cheapest way to share `children` among the two sides: cost and number on the left.
#[inline(always)]
fn distribute(left: &Choice, right: &Choice, children: usize) -> (f32, u8) {
    // What is not a number loses to what is; some way there must be.
    let (mut best, mut split) = (f32::INFINITY, (children / 2) as u8);
    for k in children.saturating_sub(7).max(1)..=(children - 1).min(7) {
        let cost = left.cost[k - 1] + right.cost[children - k - 1];
        if cost < best {
            (best, split) = (cost, k as u8);
        }
    }
    (best, split)
}
