//! Scenes made by this project, each the counterpart of a thesis scene in triangle and light count.
//!
//! Detail multiplies every subdivision, so that the number of triangles grows about with its square.

mod builder;
mod furniture;
mod hall;
mod office;
#[cfg(test)]
mod office_tests;
mod shapes;
mod statue;

/// For looking.
pub fn look(name: &str, detail: f32) -> crate::scene::Scene {
    match name {
        "statue" => statue::statue(detail),
        "office" => office::office(detail),
        "hall" => hall::hall(detail),
        _ => panic!("{name}"),
    }
}
