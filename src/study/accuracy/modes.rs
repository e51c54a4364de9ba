//! Every approximation that irt offers, by name: what it changes, which error it can make, and whether a scene calls for it.
//! The only list of them.

use crate::{
    bvh::BuildPreset,
    effects::Reasons,
    kernels::{Isa, Visibility},
    render::{Level, RenderOptions},
    scene::{Effect, EffectSet, Scene},
    trace::KernelChoice,
};
use std::borrow::Cow;
use std::fmt;

/// What is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Knob {
    /// How hits are decided.
    Visibility,
    /// Many rays at once, one, or each packet as it is worth.
    Kernel,
    /// Instruction set.
    Isa,
    /// Quality of the tree.
    Tree,
    /// Camera rays per pixel.
    Samples,
    /// Pixels that get all samples: see [`crate::scene::RenderSettings::adaptive`].
    Adaptive,
    /// Shadow rays to lights with an extent.
    LightSamples,
    /// Diffuse reflections that light is followed over.
    Bounces,
    /// Reflections and refractions in a row.
    Depth,
    /// The share of a pixel below which light is not followed.
    Cutoff,
    /// Pixels traced; the others are filled in between them.
    Fill,
    /// Filtering of pictures on surfaces.
    Textures,
    /// Bits of a channel of the output.
    Colours,
}

impl Knob {
    /// All of them, in the order of reports.
    pub const ALL: [Knob; 13] = {
        use Knob::{
            Adaptive, Bounces, Colours, Cutoff, Depth, Fill, Isa, Kernel, LightSamples, Samples, Textures,
            Tree, Visibility,
        };
        [
            Visibility,
            Kernel,
            Isa,
            Tree,
            Samples,
            Adaptive,
            LightSamples,
            Bounces,
            Depth,
            Cutoff,
            Fill,
            Textures,
            Colours,
        ]
    };

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Knob::Visibility => "visibility",
            Knob::Kernel => "kernel",
            Knob::Isa => "instruction set",
            Knob::Tree => "tree",
            Knob::Samples => "samples",
            Knob::Adaptive => "adaptive samples",
            Knob::LightSamples => "light samples",
            Knob::Bounces => "bounces",
            Knob::Depth => "depth",
            Knob::Cutoff => "cut-off",
            Knob::Fill => "fill",
            Knob::Textures => "texture filter",
            Knob::Colours => "colour depth",
        }
    }

    /// The error that it can make, in words.
    pub fn error(self) -> &'static str {
        match self {
            Knob::Visibility => {
                "leaks where rays meet edges and corners, hits of the wrong one of two neighbours"
            }
            Knob::Kernel | Knob::Isa | Knob::Tree => "none: the image is the same, bit by bit",
            Knob::Samples => "jagged edges, and noise of whatever is sampled",
            Knob::Adaptive => "jagged or missing detail that no first sample of a pixel tells of",
            Knob::LightSamples => "noise in soft shadows",
            Knob::Bounces => "light missing where it arrives by way of other surfaces",
            Knob::Depth => "mirrors and glass that end in darkness",
            Knob::Cutoff => "faint reflections and refractions missing",
            Knob::Fill => "details lost or smeared between traced pixels",
            Knob::Textures => "pictures that flicker and alias where they are far",
            Knob::Colours => "steps between neighbouring colours",
        }
    }

    /// Whether its modes are judged by the converged image alone: what they change is noise or detail. The others change
    /// single pixels of the default image.
    pub fn converges(self) -> bool {
        matches!(self, Knob::Samples | Knob::Adaptive | Knob::LightSamples | Knob::Bounces | Knob::Fill)
    }

    /// Whether it can change what is hit.
    pub fn is_geometric(self) -> bool {
        matches!(self, Knob::Visibility | Knob::Kernel | Knob::Isa | Knob::Tree)
    }
}

/// One setting of one knob, all others as they are by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// All knobs by default.
    Default,
    /// See [`Knob::Visibility`].
    Visibility(Visibility),
    /// See [`Knob::Kernel`].
    Kernel(KernelChoice),
    /// See [`Knob::Isa`].
    Isa(Isa),
    /// See [`Knob::Tree`].
    Tree(BuildPreset),
    /// See [`Knob::Samples`].
    Samples(u32),
    /// See [`Knob::Adaptive`]: the samples of pixels that differ, and by how much.
    Adaptive(u32, f32),
    /// See [`Knob::LightSamples`].
    LightSamples(u32),
    /// See [`Knob::Bounces`].
    Bounces(u32),
    /// See [`Knob::Depth`].
    Depth(u32),
    /// See [`Knob::Cutoff`].
    Cutoff(f32),
    /// See [`Knob::Fill`].
    Fill(Level),
    /// Full pictures whatever a pixel sees of them.
    FullTextures,
    /// Eight bits of sRGB.
    EightBits,
}

/// A knob that is left out, and why.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Omission {
    /// Name of the knob.
    pub knob: &'static str,
    /// A sentence without a full stop.
    pub why: String,
}

impl Mode {
    /// What it turns; `None` for the default.
    pub fn knob(self) -> Option<Knob> {
        Some(match self {
            Mode::Default => return None,
            Mode::Visibility(_) => Knob::Visibility,
            Mode::Kernel(_) => Knob::Kernel,
            Mode::Isa(_) => Knob::Isa,
            Mode::Tree(_) => Knob::Tree,
            Mode::Samples(_) => Knob::Samples,
            Mode::Adaptive(..) => Knob::Adaptive,
            Mode::LightSamples(_) => Knob::LightSamples,
            Mode::Bounces(_) => Knob::Bounces,
            Mode::Depth(_) => Knob::Depth,
            Mode::Cutoff(_) => Knob::Cutoff,
            Mode::Fill(_) => Knob::Fill,
            Mode::FullTextures => Knob::Textures,
            Mode::EightBits => Knob::Colours,
        })
    }

    /// The flag of `irt render` that sets it; `None` if there is none.
    pub fn flag(self) -> Option<String> {
        Some(match self {
            Mode::Visibility(visibility) => format!("--visibility {visibility}"),
            Mode::Kernel(kernel) => format!("--kernel {kernel}"),
            Mode::Isa(isa) => format!("--isa {isa}"),
            Mode::Tree(preset) => format!("--build {preset}"),
            Mode::Samples(count) => format!("--samples {count}"),
            Mode::Adaptive(count, least) => format!("--samples {count} --adaptive {least}"),
            Mode::LightSamples(count) => format!("--light-samples {count}"),
            Mode::Bounces(count) => format!("--bounces {count}"),
            Mode::Depth(count) => format!("--max-depth {count}"),
            Mode::Cutoff(share) => format!("--cutoff {share}"),
            Mode::Default | Mode::Fill(_) | Mode::FullTextures | Mode::EightBits => return None,
        })
    }

    /// How it renders.
    pub fn options(self, options: &RenderOptions) -> RenderOptions {
        let mut changed = *options;
        match self {
            Mode::Visibility(visibility) => changed.visibility = visibility,
            Mode::Kernel(kernel) => changed.kernel = kernel,
            Mode::Isa(isa) => changed.isa = Some(isa),
            Mode::Tree(preset) => changed.build = preset,
            _ => {}
        }
        changed
    }

    /// What it renders.
    pub fn scene(self, scene: &Scene) -> Cow<'_, Scene> {
        let mut settings = scene.settings.clone();
        match self {
            Mode::Samples(count) => (settings.samples, settings.adaptive) = (count, None),
            Mode::Adaptive(count, least) => (settings.samples, settings.adaptive) = (count, Some(least)),
            Mode::LightSamples(count) => settings.light_samples = count,
            Mode::Bounces(count) => settings.bounces = count,
            Mode::Depth(count) => settings.max_depth = count,
            Mode::Cutoff(share) => settings.cutoff = share,
            Mode::FullTextures => {
                let textures = scene.textures.iter().map(|texture| texture.unfiltered()).collect();
                return Cow::Owned(Scene { textures, ..scene.clone() });
            }
            _ => return Cow::Borrowed(scene),
        }
        Cow::Owned(Scene { settings, ..scene.clone() })
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = |level: Level| match level {
            Level::Nothing => "none",
            Level::Sixteenth => "sixteenth",
            Level::Quarter => "quarter",
            Level::Half => "half",
            Level::Full => "all",
        };
        f.pad(&match *self {
            Mode::Default => "default".into(),
            Mode::Visibility(visibility) => format!("visibility {visibility}"),
            Mode::Kernel(kernel) => format!("kernel {kernel}"),
            Mode::Isa(isa) => format!("isa {isa}"),
            Mode::Tree(preset) => format!("tree {preset}"),
            Mode::Samples(count) => format!("samples {count}"),
            Mode::Adaptive(count, least) => format!("samples {count} where {least} apart"),
            Mode::LightSamples(count) => format!("light samples {count}"),
            Mode::Bounces(count) => format!("bounces {count}"),
            Mode::Depth(count) => format!("depth {count}"),
            Mode::Cutoff(0.0) => "cut-off none".into(),
            Mode::Cutoff(share) => format!("cut-off 1/{:.0}", 1.0 / share),
            Mode::Fill(of) => format!("fill {}", level(of)),
            Mode::FullTextures => "textures unfiltered".into(),
            Mode::EightBits => "colours 8 bits".into(),
        })
    }
}

impl serde::Serialize for Mode {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

const SAMPLES: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Samples, and by how much pixels differ that get them.
const ADAPTIVE: [(u32, f32); 4] = [(8, 0.04), (16, 0.03), (32, 0.01), (32, 0.005)];
const LIGHT_SAMPLES: [u32; 4] = [1, 4, 16, 64];
const DEPTHS: [u32; 4] = [1, 2, 4, 16];
const CUTOFFS: [f32; 3] = [0.0, 1.0 / 64.0, 1.0 / 16.0];
const LEVELS: [Level; 3] = [Level::Sixteenth, Level::Quarter, Level::Half];
/// Effects whose rays go on.
const SENDS_ON: [Effect; 3] = [Effect::Mirror, Effect::Glossy, Effect::Refraction];
const SAMPLED_LIGHTS: [Effect; 2] = [Effect::SoftShadows, Effect::EnvironmentLight];
const PICTURES: [Effect; 4] =
    [Effect::DiffuseTexture, Effect::AlphaCutout, Effect::NormalMap, Effect::EmissionTexture];

/// The modes that a scene calls for, the default first, and the knobs that it does not call for.
pub fn modes(scene: &Scene, options: &RenderOptions) -> (Vec<Mode>, Vec<Omission>) {
    let set = options.effects.set(&Reasons::new(scene));
    let (mut modes, mut omissions) = (vec![Mode::Default], vec![]);
    for knob in Knob::ALL {
        match of_knob(knob, scene, set, options) {
            Ok(of_knob) => modes.extend(of_knob),
            Err(why) => omissions.push(Omission { knob: knob.name(), why: why.into() }),
        }
    }
    (modes, omissions)
}

/// All settings of a knob but the default one, or why there are none.
fn of_knob(
    knob: Knob,
    scene: &Scene,
    set: EffectSet,
    options: &RenderOptions,
) -> Result<Vec<Mode>, &'static str> {
    let settings = &scene.settings;
    let counts = |all: &[u32], now: u32, mode: fn(u32) -> Mode| {
        all.iter().copied().filter(|&count| count != now).map(mode).collect::<Vec<Mode>>()
    };
    let called = |effects: &[Effect], why| if set.has_any(effects) { Ok(()) } else { Err(why) };
    let sends_on = || called(&SENDS_ON, "no surface reflects or refracts");
    let modes = match knob {
        Knob::Visibility => {
            let others = Visibility::ALL.into_iter().filter(|&other| other != options.visibility);
            others.map(Mode::Visibility).collect()
        }
        Knob::Kernel => {
            KernelChoice::ALL.into_iter().filter(|&other| other != options.kernel).map(Mode::Kernel).collect()
        }
        Knob::Isa => {
            let now = options.isa.unwrap_or_else(Isa::detect);
            Isa::available().filter(|&other| other != now).map(Mode::Isa).collect()
        }
        Knob::Tree => {
            BuildPreset::ALL.into_iter().filter(|&other| other != options.build).map(Mode::Tree).collect()
        }
        Knob::Samples => counts(&SAMPLES, settings.samples, Mode::Samples),
        Knob::Adaptive => ADAPTIVE.map(|(count, least)| Mode::Adaptive(count, least)).into(),
        Knob::LightSamples => {
            called(&SAMPLED_LIGHTS, "no light has an extent")?;
            counts(&LIGHT_SAMPLES, settings.light_samples, Mode::LightSamples)
        }
        Knob::Bounces => {
            called(&[Effect::IndirectLight], "the scene asks for no indirect light")?;
            (0..settings.bounces).map(Mode::Bounces).collect()
        }
        Knob::Depth => {
            sends_on()?;
            counts(&DEPTHS, settings.max_depth, Mode::Depth)
        }
        Knob::Cutoff => {
            sends_on()?;
            CUTOFFS.into_iter().filter(|&share| share != settings.cutoff).map(Mode::Cutoff).collect()
        }
        Knob::Fill => LEVELS.map(Mode::Fill).into(),
        Knob::Textures => {
            called(&PICTURES, "no surface has a picture on it")?;
            vec![Mode::FullTextures]
        }
        Knob::Colours => vec![Mode::EightBits],
    };
    if modes.is_empty() { Err("this machine has no other") } else { Ok(modes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_scene_calls_for_no_mirrors_pictures_or_soft_shadows() {
        let scene = crate::scene::load("atrium@0.1").unwrap();
        let options = super::super::options();
        let (modes, omissions) = modes(&scene, &options);
        assert_eq!(modes[0], Mode::Default);
        assert!(modes.contains(&Mode::Visibility(Visibility::Fast)) && modes.contains(&Mode::Samples(16)));
        assert!(!modes.contains(&Mode::Samples(1)), "that is the default");
        let left: Vec<&str> = omissions.iter().map(|omission| omission.knob).collect();
        for knob in ["light samples", "bounces", "depth", "cut-off", "texture filter"] {
            assert!(left.contains(&knob), "{knob} is not among {left:?}");
        }
        let names: std::collections::HashSet<String> = modes.iter().map(Mode::to_string).collect();
        assert_eq!(names.len(), modes.len(), "names differ");
    }

    #[test]
    fn samples_are_for_all_pixels_unless_they_are_adaptive() {
        let mut scene = crate::scene::load("atrium@0.1").unwrap();
        let of = |mode: Mode, scene: &Scene| {
            let settings = mode.scene(scene).settings.clone();
            (settings.samples, settings.adaptive)
        };
        assert_eq!(of(Mode::Adaptive(20, 0.25), &scene), (20, Some(0.25)));
        scene.settings.adaptive = Some(0.5);
        assert_eq!(of(Mode::Samples(4), &scene), (4, None));
        assert_eq!(of(Mode::Default, &scene), (1, Some(0.5)));
        assert_eq!(Mode::Adaptive(20, 0.25).flag().as_deref(), Some("--samples 20 --adaptive 0.25"));
        assert_eq!(super::super::converged_scene(&scene, 128).settings.adaptive, None);
    }

    #[test]
    fn a_mode_changes_its_knob_alone() {
        let scene = crate::scene::load("gallery@0.2").unwrap();
        let options = super::super::options();
        let (modes, _) = modes(&scene, &options);
        assert!(modes.contains(&Mode::Depth(2)) && modes.contains(&Mode::FullTextures));
        for mode in modes {
            let (of_scene, of_options) = (mode.scene(&scene), mode.options(&options));
            let settings = of_scene.settings != scene.settings;
            let textures = of_scene.textures != scene.textures;
            let how = format!("{of_options:?}") != format!("{options:?}");
            let outside = matches!(mode, Mode::Default | Mode::Fill(_) | Mode::EightBits);
            assert_eq!(
                u32::from(settings) + u32::from(textures) + u32::from(how),
                u32::from(!outside),
                "{mode}"
            );
        }
    }
}
