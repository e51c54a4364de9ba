//! The variants of the integrator that are compiled, each for a set of effects.
//!
//! Every variant does what its set needs for every ray, without asking; what is not in the set is not compiled into it. The
//! sets were chosen by what goes together in scenes: light sources with an extent cost samples, not code per surface, and
//! are in all of them; mirrors without glass, glass with its mirrors, textures without either; and everything. More
//! variants would differ in less than the time of a frame shows. Each is about 4 instruction sets times three kernels.

use crate::effects::{Effect, EffectSet};

/// Effects that every variant can do: they show in lists of lights and numbers of samples.
const BASE: EffectSet = EffectSet::of(&[
    Effect::HardShadows,
    Effect::Highlights,
    Effect::SmoothNormals,
    Effect::SoftShadows,
    Effect::Sky,
    Effect::EnvironmentLight,
    Effect::AmbientOcclusion,
    Effect::IndirectLight,
    Effect::DepthOfField,
    Effect::Antialiasing,
]);

/// What the plain tile code does, without following light any further: see `render`.
pub const PLAIN: EffectSet = EffectSet::of(&[Effect::HardShadows, Effect::Highlights, Effect::SmoothNormals]);

const TEXTURES: EffectSet =
    EffectSet::of(&[Effect::DiffuseTexture, Effect::AlphaCutout, Effect::NormalMap, Effect::EmissionTexture]);

/// A compiled set of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// Light of all kinds of sources on opaque matt and shiny surfaces.
    Lit,
    /// The same with textures.
    Textured,
    /// Lit, with perfect mirrors.
    Mirrors,
    /// Lit, with perfect mirrors and glass.
    Glass,
    /// Everything.
    General,
}

impl Variant {
    /// All variants, from the least to the most.
    pub const ALL: [Variant; 5] =
        [Variant::Lit, Variant::Textured, Variant::Mirrors, Variant::Glass, Variant::General];

    /// The effects that it does.
    pub const fn set(self) -> EffectSet {
        match self {
            Variant::Lit => BASE,
            Variant::Textured => BASE.union(TEXTURES),
            Variant::Mirrors => BASE.union(EffectSet::of(&[Effect::Mirror])),
            Variant::Glass => {
                BASE.union(EffectSet::of(&[Effect::Mirror, Effect::Refraction, Effect::Absorption]))
            }
            Variant::General => EffectSet::ALL,
        }
    }

    /// The least variant that does all of `set`.
    pub fn least(set: EffectSet) -> Variant {
        Variant::ALL.into_iter().find(|variant| variant.set().includes(set)).unwrap_or(Variant::General)
    }
}

/// A set of effects as a type, for code to be compiled for.
pub(super) trait Compiled {
    const SET: EffectSet;
    /// Whether images are looked at.
    const TEXTURES: bool = Self::SET.has_any(&[
        Effect::DiffuseTexture,
        Effect::AlphaCutout,
        Effect::NormalMap,
        Effect::EmissionTexture,
    ]);
    /// Whether light goes on from surfaces in certain directions.
    const SCATTERS: bool = Self::SET.has_any(&[Effect::Mirror, Effect::Glossy, Effect::Refraction]);
    const GLOSSY: bool = Self::SET.has(Effect::Glossy);
    const CLEAR: bool = Self::SET.has(Effect::Refraction);
}

macro_rules! compiled {
    ($($name:ident),*) => {
        $(
            pub(super) struct $name;
            impl Compiled for $name {
                const SET: EffectSet = Variant::$name.set();
            }
        )*
    };
}

compiled!(Lit, Textured, Mirrors, Glass, General);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_variant_is_chosen() {
        let least = |effects: &[Effect]| Variant::least(EffectSet::of(effects));
        assert_eq!(Variant::least(PLAIN), Variant::Lit);
        assert_eq!(least(&[Effect::SoftShadows, Effect::Mirror]), Variant::Mirrors);
        assert_eq!(least(&[Effect::Refraction]), Variant::Glass);
        assert_eq!(least(&[Effect::AlphaCutout]), Variant::Textured);
        assert_eq!(least(&[Effect::AlphaCutout, Effect::Mirror]), Variant::General);
        assert_eq!(least(&[Effect::Glossy]), Variant::General);
        assert_eq!(Variant::least(EffectSet::ALL), Variant::General);
    }
}
