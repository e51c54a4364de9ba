//! What surrounds a scene, and how far light is followed: `[environment]` and `[settings]`.

use super::{
    schema::{self, Triple},
    source::Source,
};
use crate::{
    error::Result,
    scene::{
        AmbientOcclusion, DepthOfField, Effect, Environment, Library, MAX_COORDINATE, RenderSettings, Sky,
        SkyMap, picture,
    },
};
use glam::Vec3;
use std::path::Path;
use toml::Spanned;

/// An environment whose picture is still to be read.
#[derive(Default)]
pub(super) struct Unread {
    environment: Environment,
    map: Option<Spanned<String>>,
}

pub(super) fn environment(
    source: &Source<'_>,
    value: Option<Spanned<schema::Environment>>,
) -> Result<Unread> {
    let Some(value) = value else { return Ok(Unread::default()) };
    let span = value.span();
    let from = value.into_inner();
    let gradient = [("zenith", &from.zenith), ("horizon", &from.horizon), ("ground", &from.ground)];
    let has_gradient = gradient.iter().any(|(_, value)| value.is_some());
    let sky = match &from.map {
        Some(_) if has_gradient => {
            let what = "a sky is either a picture or a gradient";
            return Err(source.error(span, what, "remove `map`, or `zenith`, `horizon` and `ground`"));
        }
        Some(_) => Sky::Map(sky_map(source, &from)?),
        None => {
            for (key, value) in [("rotation", &from.rotation), ("strength", &from.strength)] {
                if let Some(value) = value {
                    source.check(key, value, false, "belongs to a `map`")?;
                }
            }
            if has_gradient { sky_gradient(source, span, gradient)? } else { Sky::Background }
        }
    };
    Ok(Unread { environment: Environment { sky, light: from.light.unwrap_or(true) }, map: from.map })
}

fn sky_gradient(
    source: &Source<'_>,
    span: std::ops::Range<usize>,
    keys: [(&str, &Option<Spanned<Triple>>); 3],
) -> Result<Sky> {
    let mut colors = [Vec3::ZERO; 3];
    for (color, (key, value)) in colors.iter_mut().zip(keys) {
        let missing = || {
            let what = format!("a gradient needs `{key}`");
            source.error(span.clone(), what, format!("add `{key} = ...`"))
        };
        *color = source.color(key, value.as_ref().ok_or_else(missing)?)?;
    }
    let [zenith, horizon, ground] = colors;
    Ok(Sky::Gradient { zenith, horizon, ground })
}

/// Everything about a sky's picture but its pixels.
fn sky_map(source: &Source<'_>, from: &schema::Environment) -> Result<SkyMap> {
    let rotation = from.rotation.as_ref().map_or(Ok(0.0), |angle| source.finite("rotation", angle))?;
    let strength = from.strength.as_ref().map_or(Ok(1.0), |strength| {
        source.within("strength", strength, |s| s >= 0.0, "must not be negative")
    })?;
    Ok(SkyMap { size: [0; 2], pixels: Vec::new(), rotation: (rotation % 360.0).to_radians(), strength })
}

impl Unread {
    /// Reads the picture, which is looked for as meshes are.
    pub(super) fn read(
        self,
        source: &Source<'_>,
        library: &Library,
        folder: &Path,
        warnings: &mut Vec<String>,
    ) -> Result<Environment> {
        let Unread { mut environment, map } = self;
        let (Sky::Map(sky), Some(file)) = (&mut environment.sky, map) else { return Ok(environment) };
        let name = file.get_ref().escape_debug();
        let path = library
            .locate(folder, file.get_ref())
            .require("environment", "put it there")
            .map_err(|(what, remedy)| source.error(file.span(), what, remedy))?;
        let fault = |what: String, remedy: String| {
            source.error(file.span(), format!("environment `{name}` {what}"), remedy)
        };
        let picture = picture::read_linear(&path).map_err(|e| fault(e.what, e.remedy))?;
        let brightest = picture.texels.iter().flatten().fold(0.0f32, |most, &c| most.max(c));
        if !(brightest * sky.strength).is_finite() {
            let remedy = "lower `strength` or the picture's values";
            return Err(fault("times `strength` is too great".into(), remedy.into()));
        }
        if picture.negative > 0 {
            let path = path.display();
            warnings.push(format!("{path}: negative values of light taken for 0: {}", picture.negative));
        }
        sky.size = picture.size.map(|side| side as u32);
        sky.pixels = picture.texels;
        Ok(environment)
    }
}

/// Most samples, reflections and bounces that a scene may ask for.
const MOST: i64 = 1 << 16;

pub(super) fn settings(source: &Source<'_>, from: &schema::Settings) -> Result<RenderSettings> {
    let default = RenderSettings::default();
    let count = |key: &str, value: &Option<Spanned<i64>>, least: i64, missing: u32| {
        let Some(value) = value else { return Ok(missing) };
        let valid = (least..=MOST).contains(value.get_ref());
        let rule = format!("must be an integer in {least} to {MOST}");
        source.check(key, value, valid, &rule).map(|()| *value.get_ref() as u32)
    };
    let length = |key: &str, value: &Spanned<f64>| {
        let valid = |length: f32| length > 0.0 && length <= MAX_COORDINATE;
        source.within(key, value, valid, "must be positive and at most 1e18")
    };
    let ambient_occlusion = match &from.ambient_occlusion {
        None => None,
        Some(of) => {
            let endless = *of.radius.get_ref() == f64::INFINITY;
            let radius = if endless { f32::INFINITY } else { length("radius", &of.radius)? };
            Some(AmbientOcclusion { radius, samples: count("samples", &of.samples, 1, 16)? })
        }
    };
    let depth_of_field = match &from.depth_of_field {
        None => None,
        Some(of) => Some(DepthOfField {
            aperture: length("aperture", &of.aperture)?,
            focus: length("focus", &of.focus)?,
        }),
    };
    let without = from.without.iter().map(|name| {
        let parsed = name.get_ref().parse::<Effect>();
        parsed.map_err(|what| source.error(name.span(), what, "correct the name"))
    });
    Ok(RenderSettings {
        samples: count("samples", &from.samples, 1, default.samples)?,
        adaptive: match &from.adaptive {
            None => None,
            Some(least) => Some(source.within("adaptive", least, |t| t > 0.0, "must be positive")?),
        },
        light_samples: count("light_samples", &from.light_samples, 1, default.light_samples)?,
        bounces: count("bounces", &from.bounces, 0, default.bounces)?,
        max_depth: count("max_depth", &from.max_depth, 0, default.max_depth)?,
        cutoff: from.cutoff.as_ref().map_or(Ok(default.cutoff), |cutoff| {
            source.within("cutoff", cutoff, |c| c >= 0.0, "must not be negative")
        })?,
        emitters: from.emitters.unwrap_or(default.emitters),
        smooth_terminator: from.smooth_terminator.unwrap_or(default.smooth_terminator),
        ambient_occlusion,
        depth_of_field,
        without: without.collect::<Result<_>>()?,
    })
}
