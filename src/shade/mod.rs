//! Direct light on whole tiles, in structure-of-arrays form.
//!
//! ```text
//!   hits --gather--> Surfaces (points, normals, materials) --per light--> shadow rays, light added --> colours
//! ```
//!
//! Lambert plus Blinn-Phong from the material, hard shadows, ambient light. Surfaces are two-sided: normals are
//! turned towards the viewer. Lights are added in the scene's order with separate multiplications and additions, so
//! a pixel's colour does not depend on anything but the scene.
//!
//! Where a scene calls for more than that, an [`Integrator`] follows the light further; what it finds at first surfaces
//! without more is the same, bit by bit.

mod direct;
mod path;
mod power;
pub mod spawn;
mod surface;
mod table;
mod trig;

pub use direct::{LightRays, add_light, light_rays};
use direct::{add_tinted_light, light_rays_to};
pub(crate) use path::{Disc, Purpose, Sample, Samples, Shot, pixel_keys};
pub use path::{Integrator, Meter, PLAIN, PathScratch, PathTable, RayTally, Variant};
pub use surface::Surfaces;
pub use table::SurfaceTable;
