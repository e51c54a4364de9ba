//! Names of what a frame simulates, until the module `effects` decides it.

use crate::scene::Scene;

/// What this scene makes a frame simulate.
pub(super) fn effects(scene: &Scene) -> Vec<String> {
    let effects: &[&str] = if scene.lights.is_empty() { &[] } else { &["direct-light", "shadows"] };
    effects.iter().map(ToString::to_string).collect()
}
