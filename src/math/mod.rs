//! Small mathematics that several modules share: bounds, colour, logarithms, random numbers, medians and how far to trust them.

mod aabb;
mod color;
mod hash;
mod log;
mod median;
mod spread;

pub use aabb::Aabb;
pub use color::{SrgbTable, linear_to_srgb8, srgb8_to_linear};
pub use hash::hash_unit;
pub use log::log2;
pub use median::median;
pub use spread::Spread;
