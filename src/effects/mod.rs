//! Only the effects that a scene calls for: which these are, and why.
//!
//! An effect is called for by what triangles and light there are, not by what is merely defined: a mirror that no triangle
//! is made of calls for nothing. Each effect, called for or not, comes with a sentence that says why.
//!
//! ```text
//!   scene --derive--> Reasons --the user's choice--> EffectSet --render--> a kernel compiled for (at least) that set
//! ```
//!
//! Leaving out an effect that is not called for changes no bit of the image; that is what makes it free.

mod choice;
mod derive;

pub use crate::scene::{Effect, EffectSet};
pub use choice::EffectChoice;
pub use derive::{Reason, Reasons};
