//! The one integration-test binary; a module per subject.

mod accuracy; // the f64 reference; promised errors
mod adaptive; // antialiasing where it shows
mod agree; // every kernel against brute force
mod bad_input; // numbers without a meaning
mod batch; // many rays at once against single rays
mod beam; // beams of general rays against single rays
mod build; // trees on every kind of input
mod effects; // effects against closed forms; one image whatever simulates them
mod early; // early terminations and orders; the study of coherence
mod cli; // the commands as users run them
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod entries; // kernels without calls
mod images;
mod layering; // who may know whom
mod light; // direct light against a plain reference
mod progressive; // images refined step by step
mod properties; // hits against rational numbers, on random input
mod rational; // the exact oracle
mod reported; // defects reported of other ray tracers
mod motion; // trees and images of what moves
mod probe; // the counting kernel against brute force
mod scene_load; // readers, scene descriptions, names
mod spawn; // rays that start on surfaces
mod support; // oracles, meshes, random numbers
mod visibility; // exact against fast
