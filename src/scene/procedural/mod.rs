//! Scenes made by this project, each the counterpart of a thesis scene in triangle and light count.
//!
//! Detail multiplies every subdivision, so that the number of triangles grows about with its square.

mod builder;
