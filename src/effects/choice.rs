//! What the user wants of the effects that a scene calls for.

use super::{Effect, EffectSet, Reasons};
use std::{fmt, str::FromStr};

/// Which effects are simulated, and by which kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EffectChoice {
    /// Those that the scene calls for, by a kernel for just these.
    #[default]
    Auto,
    /// The same, by the kernel for all effects: the same image, slower.
    All,
    /// Those of a list, as far as the scene calls for them.
    Only(EffectSet),
    /// Those that the scene calls for, but not these.
    Without(EffectSet),
}

impl EffectChoice {
    /// The effects that are simulated.
    pub fn set(self, reasons: &Reasons) -> EffectSet {
        match self {
            EffectChoice::Auto | EffectChoice::All => reasons.set(),
            EffectChoice::Only(set) => set.intersection(reasons.set()),
            EffectChoice::Without(set) => reasons.set().without(set),
        }
    }

    /// Whether an effect would be simulated if a scene called for it.
    pub fn allows(self, effect: Effect) -> bool {
        match self {
            EffectChoice::Auto | EffectChoice::All => true,
            EffectChoice::Only(set) => set.has(effect),
            EffectChoice::Without(set) => !set.has(effect),
        }
    }
}

impl fmt::Display for EffectChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EffectChoice::Auto => f.pad("auto"),
            EffectChoice::All => f.pad("all"),
            EffectChoice::Only(set) => set.fmt(f),
            EffectChoice::Without(set) => write!(f, "without={set}"),
        }
    }
}

impl FromStr for EffectChoice {
    type Err = String;

    /// `auto`, `all`, as [`EffectSet`], or such a list behind `without=`.
    fn from_str(text: &str) -> Result<EffectChoice, String> {
        match text.trim() {
            "auto" => Ok(EffectChoice::Auto),
            "all" => Ok(EffectChoice::All),
            text => match text.strip_prefix("without=") {
                Some(list) => list.parse().map(EffectChoice::Without),
                None => text.parse().map(EffectChoice::Only),
            }
            .map_err(|e: String| format!("{e}; or give auto, all, none or without=LIST")),
        }
    }
}
