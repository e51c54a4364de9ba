//! irt: a shared-memory interactive ray tracer.
//!
//! Modules are listed in import order: a module may import only from those above it (`tests/layering.rs` checks).

pub use irt_kernels as kernels;

pub mod bvh;
pub mod camera;
pub mod trace;
pub mod shade;
pub mod error;
pub mod math;
pub mod scene;
pub mod tile;
pub mod film;
pub mod schedule;
pub mod output;
pub mod report;
