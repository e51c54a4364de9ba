//! How it is decided whether a ray hits a triangle: exactly, or by rounded numbers alone.
//!
//! ```text
//!                     misses beyond doubt   in doubt             hits beyond doubt
//!   exact             miss                  exact arithmetic     hit
//!   fast              miss                  miss or hit, by the sign of the rounded number
//! ```
//!
//! `Exact` carries an error bound along with each number, pads boxes by their rounding, and decides what is within the
//! bounds by [`crate::exact`]. `Fast` is what other ray tracers do: the same formulas without bounds, padding or second
//! look, so that it leaks at edges and vertices, and where surfaces coincide the first one found wins. It exists to show
//! what exactness costs and that tests of exactness can fail. Depth and barycentric coordinates of a hit come from the
//! same canonical formula in both.
//!
//! Algorithms take the policy as a type, so that neither kind carries the other's instructions.

use std::{fmt, str::FromStr};

/// How it is decided whether a ray hits a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Visibility {
    /// As exact arithmetic says; the same hits from every kernel and instruction set.
    #[default]
    Exact,
    /// As rounded arithmetic says, without error bounds: leaks at edges and vertices.
    Fast,
}

impl Visibility {
    /// All kinds.
    pub const ALL: [Visibility; 2] = [Visibility::Exact, Visibility::Fast];

    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Visibility::Exact => "exact",
            Visibility::Fast => "fast",
        }
    }
}

impl fmt::Display for Visibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Visibility {
    type Err = String;

    fn from_str(text: &str) -> Result<Visibility, String> {
        Visibility::ALL
            .into_iter()
            .find(|visibility| visibility.name() == text)
            .ok_or_else(|| format!("unknown visibility '{text}'; use exact or fast"))
    }
}

/// [`Visibility`] as a type.
pub(crate) trait Policy {
    /// True for [`Visibility::Exact`].
    const EXACT: bool;
}

/// [`Visibility::Exact`].
pub(crate) struct Exact;

/// [`Visibility::Fast`].
pub(crate) struct Fast;

impl Policy for Exact {
    const EXACT: bool = true;
}

impl Policy for Fast {
    const EXACT: bool = false;
}
