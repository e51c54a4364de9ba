//! Scenes made by this project, each the counterpart of a thesis scene in triangle and light count.
//!
//! Detail multiplies every subdivision, so that the number of triangles grows about with its square.

mod builder;

/// Names of the scenes.
pub const NAMES: &[&str] = &[];

/// Builds a scene.
///
/// # Errors
/// If there is no scene of that name.
pub fn build(name: &str, _detail: f32) -> crate::error::Result<super::Scene> {
    Err(crate::error::Error::file(name, "is no built-in scene", "run `irt scenes` for the names"))
}
