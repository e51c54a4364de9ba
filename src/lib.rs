//! irt: a shared-memory interactive ray tracer.
//!
//! Modules are listed in import order: a module may import only from those above it (`tests/layering.rs` checks).
//! Data flows the same way: a scene is loaded, a tree is built over it, the camera and the tiles give rays, rays are
//! traced and hits shaded, pixels land in the film, and the film is written.

pub use irt_kernels as kernels;

pub mod error;
pub mod math;
pub mod scene;
pub mod effects;
pub mod bvh;
pub mod camera;
pub mod tile;
pub mod trace;
pub mod shade;
pub mod film;
pub mod schedule;
pub mod render;
pub mod output;
pub mod study;
pub mod report;
pub mod view;
pub mod cli;
