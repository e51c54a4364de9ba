//! The effects there are, by name. Which of them a scene calls for is found out by the module `effects`.

use std::{fmt, str::FromStr};

/// Something that light does and that costs time to simulate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Effect {
    /// Shadows of lights without extent.
    HardShadows,
    /// Highlights: the light's image in a shiny surface (Blinn-Phong).
    Highlights,
    /// Normals that change smoothly over flat triangles.
    SmoothNormals,
    /// Light of sources with an extent, and their shadows.
    SoftShadows,
    /// Mirror images, perfect or by Fresnel's equations.
    Mirror,
    /// Mirror images in rough surfaces (GGX).
    Glossy,
    /// Light that goes through surfaces, bent, with Fresnel's reflectance and total reflection.
    Refraction,
    /// Light that weakens inside a material (Beer).
    Absorption,
    /// Colours from images.
    DiffuseTexture,
    /// Surfaces with holes, from images.
    AlphaCutout,
    /// Normals bent by images of heights or normals.
    NormalMap,
    /// Emission from images.
    EmissionTexture,
    /// A sky that differs by direction.
    Sky,
    /// Light of the sky.
    EnvironmentLight,
    /// Ambient light that does not reach every corner.
    AmbientOcclusion,
    /// Light that other surfaces reflect.
    IndirectLight,
    /// A lens that is in focus at one distance only.
    DepthOfField,
    /// Several samples of the area of a pixel.
    Antialiasing,
}

impl Effect {
    /// All effects.
    pub const ALL: [Effect; 18] = [
        Effect::HardShadows,
        Effect::Highlights,
        Effect::SmoothNormals,
        Effect::SoftShadows,
        Effect::Mirror,
        Effect::Glossy,
        Effect::Refraction,
        Effect::Absorption,
        Effect::DiffuseTexture,
        Effect::AlphaCutout,
        Effect::NormalMap,
        Effect::EmissionTexture,
        Effect::Sky,
        Effect::EnvironmentLight,
        Effect::AmbientOcclusion,
        Effect::IndirectLight,
        Effect::DepthOfField,
        Effect::Antialiasing,
    ];

    /// Name on the command line, in scene files and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Effect::HardShadows => "hard-shadows",
            Effect::Highlights => "highlights",
            Effect::SmoothNormals => "smooth-normals",
            Effect::SoftShadows => "soft-shadows",
            Effect::Mirror => "mirror",
            Effect::Glossy => "glossy",
            Effect::Refraction => "refraction",
            Effect::Absorption => "absorption",
            Effect::DiffuseTexture => "diffuse-texture",
            Effect::AlphaCutout => "alpha-cutout",
            Effect::NormalMap => "normal-map",
            Effect::EmissionTexture => "emission-texture",
            Effect::Sky => "sky",
            Effect::EnvironmentLight => "environment-light",
            Effect::AmbientOcclusion => "ambient-occlusion",
            Effect::IndirectLight => "indirect-light",
            Effect::DepthOfField => "depth-of-field",
            Effect::Antialiasing => "antialiasing",
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Effect {
    type Err = String;

    fn from_str(text: &str) -> Result<Effect, String> {
        Effect::ALL.into_iter().find(|effect| effect.name() == text).ok_or_else(|| {
            let names: Vec<&str> = Effect::ALL.into_iter().map(Effect::name).collect();
            format!("'{text}' is no effect; there are {}", names.join(", "))
        })
    }
}

/// A set of effects; its operations can be computed while compiling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct EffectSet(u32);

impl EffectSet {
    /// No effect.
    pub const EMPTY: EffectSet = EffectSet(0);
    /// All effects.
    pub const ALL: EffectSet = EffectSet::of(&Effect::ALL);

    /// The set of some effects.
    pub const fn of(effects: &[Effect]) -> EffectSet {
        let (mut bits, mut i) = (0, 0);
        while i < effects.len() {
            bits |= 1 << effects[i] as u32;
            i += 1;
        }
        EffectSet(bits)
    }

    /// Whether `effect` is a member.
    pub const fn has(self, effect: Effect) -> bool {
        self.0 >> effect as u32 & 1 != 0
    }

    /// Whether any of `effects` is a member.
    pub const fn has_any(self, effects: &[Effect]) -> bool {
        self.0 & EffectSet::of(effects).0 != 0
    }

    /// Whether all members of `other` are members of this one.
    pub const fn includes(self, other: EffectSet) -> bool {
        other.0 & !self.0 == 0
    }

    /// Members of either.
    pub const fn union(self, other: EffectSet) -> EffectSet {
        EffectSet(self.0 | other.0)
    }

    /// Members of both.
    pub const fn intersection(self, other: EffectSet) -> EffectSet {
        EffectSet(self.0 & other.0)
    }

    /// Members that are not in `other`.
    pub const fn without(self, other: EffectSet) -> EffectSet {
        EffectSet(self.0 & !other.0)
    }

    /// Number of members.
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// True if there is no member.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The members, in the order of [`Effect::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |&effect| self.has(effect))
    }
}

impl FromIterator<Effect> for EffectSet {
    fn from_iter<I: IntoIterator<Item = Effect>>(effects: I) -> EffectSet {
        effects.into_iter().fold(EffectSet::EMPTY, |set, effect| set.union(EffectSet::of(&[effect])))
    }
}

impl fmt::Display for EffectSet {
    /// As [`FromStr`] reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.iter().map(Effect::name).collect();
        f.pad(&if names.is_empty() { "none".into() } else { names.join(",") })
    }
}

impl FromStr for EffectSet {
    type Err = String;

    /// `none`, or names of effects with commas between.
    fn from_str(text: &str) -> Result<EffectSet, String> {
        match text.trim() {
            "none" => Ok(EffectSet::EMPTY),
            list => list.split(',').map(|name| name.trim().parse::<Effect>()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_written_as_they_are_read() {
        assert_eq!(EffectSet::ALL.len(), Effect::ALL.len());
        for effect in Effect::ALL {
            let others = EffectSet::ALL.without(EffectSet::of(&[effect]));
            assert_eq!(others.to_string().parse(), Ok(others));
            assert_eq!(effect.name().parse(), Ok(effect));
            assert!(!others.has(effect) && EffectSet::ALL.has(effect) && EffectSet::ALL.includes(others));
        }
        assert_eq!("none".parse(), Ok(EffectSet::EMPTY));
        assert_eq!(EffectSet::EMPTY.to_string(), "none");
        assert!("mirror,shine".parse::<EffectSet>().unwrap_err().contains("'shine' is no effect"));
    }
}
