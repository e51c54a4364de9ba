//! Direct light on whole tiles, in structure-of-arrays form.
//!
//! ```text
//!   hits --gather--> Surfaces (points, normals, materials) --per light--> shadow rays, light added --> colours
//! ```
//!
//! Lambert plus Blinn-Phong from the material, hard shadows, ambient light. Surfaces are two-sided: normals are
//! turned towards the viewer. Lights are added in the scene's order with separate multiplications and additions, so
//! a pixel's colour does not depend on anything but the scene.

mod direct;
mod power;
pub mod spawn;
mod surface;
mod table;

pub use direct::{LightRays, add_light, light_rays};
pub use surface::Surfaces;
pub use table::SurfaceTable;
