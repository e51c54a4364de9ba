//! Small mathematics that several modules share: bounds, colour and random numbers.

mod aabb;
mod color;
mod hash;

pub use aabb::Aabb;
pub use color::linear_to_srgb8;
pub use hash::hash_unit;
