//! Small mathematics that several modules share: bounds and colour.

mod aabb;
mod color;

pub use aabb::Aabb;
pub use color::linear_to_srgb8;
