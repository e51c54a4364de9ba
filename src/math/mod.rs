//! Small mathematics that several modules share: bounds, colour, random numbers, medians.

mod aabb;
mod color;
mod hash;
mod median;

pub use aabb::Aabb;
pub use color::linear_to_srgb8;
pub use hash::hash_unit;
pub use median::median;
