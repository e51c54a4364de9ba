//! What is counted.

use super::kernel::Kernel;
use crate::kernels::Isa;
use glam::Vec3;

/// Where meshes stand, and how large they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The middle.
    pub center: Vec3,
    /// The radius, or the scale.
    pub radius: f32,
}

/// Counts of rays; all but the first two must be zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Rays traced, each for its first hit and for whether it is blocked.
    pub rays: u64,
    /// Those that were aimed at vertices and edges.
    pub aimed: u64,
    /// Rays that leaked.
    pub leaks: u64,
    /// Rays that missed a triangle which the oracle knows they pass through.
    pub rejected: u64,
    /// Hits with other bits than the reference.
    pub differ: u64,
    /// Hits with a NaN in them.
    pub nan: u64,
    /// Pairs of a ray and a triangle that the filters left to exact arithmetic. May be anything.
    pub doubtful: u64,
}

impl Tally {
    /// Adds the counts of another one.
    pub fn add(&mut self, other: &Tally) {
        self.rays += other.rays;
        self.aimed += other.aimed;
        self.leaks += other.leaks;
        self.rejected += other.rejected;
        self.differ += other.differ;
        self.nan += other.nan;
        self.doubtful += other.doubtful;
    }

    /// Promises broken.
    pub fn broken(&self) -> u64 {
        self.leaks + self.rejected + self.differ + self.nan
    }
}

/// One cell.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Instruction set.
    pub isa: Isa,
    /// Kernel.
    pub kernel: Kernel,
    /// Place of the meshes.
    pub place: Place,
    /// What happened there.
    pub tally: Tally,
}

/// The first broken promise, by the number of its batch: the same, however threads take turns.
#[derive(Clone, Debug, Default)]
pub struct First(Option<(u64, String)>);

impl First {
    /// Remembers what `tell` says of batch `number`, unless an earlier one is known.
    pub fn note(&mut self, number: u64, tell: impl FnOnce() -> String) {
        if self.0.as_ref().is_none_or(|(first, _)| number < *first) {
            self.0 = Some((number, tell()));
        }
    }

    /// The earlier one of both.
    pub fn merge(&mut self, other: First) {
        if let Some((number, text)) = other.0 {
            self.note(number, || text);
        }
    }

    /// In words.
    pub fn text(&self) -> Option<&str> {
        self.0.as_ref().map(|(_, text)| text.as_str())
    }
}
