//! Experiments: what irt measures about itself and beside others.

pub mod accuracy;
pub mod bench;
pub mod scaling;
pub mod stability;
pub mod coherence;
mod patience;
pub mod price;
