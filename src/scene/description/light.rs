//! Lights of a scene file.

use super::{
    schema::{Falloff, Light, LightKind},
    source::Source,
};
use crate::{
    error::{Error, Result},
    scene::{self, AreaLight, MAX_COORDINATE},
};
use glam::Vec3;
use std::ops::Range;
use toml::Spanned;

/// A light of either family.
#[derive(Clone, Copy, Debug)]
pub(super) enum AnyLight {
    /// Without extent.
    Point(scene::Light),
    /// With extent.
    Area(AreaLight),
}

impl LightKind {
    fn name(self) -> &'static str {
        match self {
            LightKind::Point => "point",
            LightKind::Directional => "directional",
            LightKind::Spot => "spot",
            LightKind::Rectangle => "rectangle",
            LightKind::Sphere => "sphere",
        }
    }

    /// The keys that have a meaning, besides `kind`, `color` and `intensity`.
    fn keys(self) -> &'static [&'static str] {
        match self {
            LightKind::Point => &["position", "falloff"],
            LightKind::Directional => &["direction"],
            LightKind::Spot => &["position", "direction", "falloff", "inner", "outer"],
            LightKind::Rectangle => &["corner", "edge_u", "edge_v", "two_sided"],
            LightKind::Sphere => &["position", "radius"],
        }
    }
}

pub(super) fn check(source: &Source<'_>, value: &Spanned<Light>) -> Result<AnyLight> {
    let light = value.get_ref();
    only_of_its_kind(source, light)?;
    let given = Given { source, light, span: value.span() };
    let intensity = given.intensity()?;
    Ok(match light.kind {
        LightKind::Point => AnyLight::Point(scene::Light::Point {
            position: given.vector("position", &light.position)?,
            intensity,
            falloff: given.falloff(),
        }),
        LightKind::Directional => {
            AnyLight::Point(scene::Light::Directional { direction: given.direction()?, intensity })
        }
        LightKind::Spot => {
            let (position, direction) = (given.vector("position", &light.position)?, given.direction()?);
            let (inner, outer) = cone(source, light.inner.as_ref(), given.needs("outer", &light.outer)?)?;
            let falloff = given.falloff();
            AnyLight::Point(scene::Light::Spot { position, direction, intensity, falloff, inner, outer })
        }
        LightKind::Rectangle => AnyLight::Area(given.rectangle(intensity)?),
        LightKind::Sphere => {
            let valid = |radius: f32| radius > 0.0 && radius <= MAX_COORDINATE;
            let radius = given.needs("radius", &light.radius)?;
            AnyLight::Area(AreaLight::Sphere {
                center: given.vector("position", &light.position)?,
                radius: source.within("radius", radius, valid, "must be positive and at most 1e18")?,
                radiance: intensity,
            })
        }
    })
}

/// A light and where it stands in the file.
struct Given<'a> {
    source: &'a Source<'a>,
    light: &'a Light,
    span: Range<usize>,
}

impl Given<'_> {
    fn needs<'v, T>(&self, key: &str, value: &'v Option<Spanned<T>>) -> Result<&'v Spanned<T>> {
        value.as_ref().ok_or_else(|| {
            let what = format!("a {} light needs `{key}`", self.light.kind.name());
            self.source.error(self.span.clone(), what, format!("add `{key} = ...`"))
        })
    }

    fn vector(&self, key: &str, value: &Option<Spanned<[f64; 3]>>) -> Result<Vec3> {
        self.source.vector(key, self.needs(key, value)?)
    }

    fn direction(&self) -> Result<Vec3> {
        self.source.direction("direction", self.needs("direction", &self.light.direction)?)
    }

    fn falloff(&self) -> scene::Falloff {
        match self.light.falloff.as_ref().map(Spanned::get_ref) {
            None | Some(Falloff::None) => scene::Falloff::None,
            Some(Falloff::InverseSquare) => scene::Falloff::InverseSquare,
        }
    }

    fn intensity(&self) -> Result<Vec3> {
        let Given { source, light, .. } = self;
        let color = light.color.as_ref().map_or(Ok(Vec3::ONE), |color| source.color("color", color))?;
        let strength = light.intensity.as_ref().map_or(Ok(1.0), |intensity| {
            source.within("intensity", intensity, |i| i >= 0.0, "must not be negative")
        })?;
        let intensity = color * strength;
        let what = "`color` times `intensity` is too great";
        let error = || source.error(self.span.clone(), what, "lower one of them");
        intensity.is_finite().then_some(intensity).ok_or_else(error)
    }

    fn rectangle(&self, radiance: Vec3) -> Result<AreaLight> {
        let light = self.light;
        let edge_u = self.vector("edge_u", &light.edge_u)?;
        let edge_v = self.vector("edge_v", &light.edge_v)?;
        // In f32, as it is sampled; false for infinity and NaN, too.
        let area = edge_u.cross(edge_v).length();
        let valid = area > 1.0e-6 * edge_u.length() * edge_v.length() && area.is_finite();
        if let Some(given) = &light.edge_v {
            let rule = "must span an area with `edge_u`: be neither zero, nor too great, nor parallel to it";
            self.source.check("edge_v", given, valid, rule)?;
        }
        Ok(AreaLight::Rectangle {
            corner: self.vector("corner", &light.corner)?,
            edge_u,
            edge_v,
            radiance,
            two_sided: light.two_sided.as_ref().is_some_and(|two_sided| *two_sided.get_ref()),
        })
    }
}

/// Half angles of a spot light in radians.
fn cone(source: &Source<'_>, inner: Option<&Spanned<f64>>, outer: &Spanned<f64>) -> Result<(f32, f32)> {
    let valid = |angle: f32| angle > 0.0 && angle <= 90.0;
    let outer_angle = source.within("outer", outer, valid, "must be above 0 and at most 90 degrees")?;
    let inner_angle = match inner {
        None => 0.0,
        Some(inner) => {
            let valid = |angle: f32| angle >= 0.0 && angle < outer_angle;
            source.within("inner", inner, valid, "must be at least 0 degrees and below `outer`")?
        }
    };
    Ok((inner_angle.to_radians(), outer_angle.to_radians()))
}

/// A key that a kind of light does not know would silently do nothing: an error instead.
fn only_of_its_kind(source: &Source<'_>, light: &Light) -> Result<()> {
    fn place<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
        value.as_ref().map(Spanned::span)
    }
    let given: [(&str, Option<Range<usize>>); 10] = [
        ("position", place(&light.position)),
        ("direction", place(&light.direction)),
        ("falloff", place(&light.falloff)),
        ("inner", place(&light.inner)),
        ("outer", place(&light.outer)),
        ("corner", place(&light.corner)),
        ("edge_u", place(&light.edge_u)),
        ("edge_v", place(&light.edge_v)),
        ("two_sided", place(&light.two_sided)),
        ("radius", place(&light.radius)),
    ];
    let unfit = |(key, span): (&'static str, Option<Range<usize>>)| -> Option<Error> {
        let span = span.filter(|_| !light.kind.keys().contains(&key))?;
        let what = format!("a {} light has no `{key}`", light.kind.name());
        Some(source.error(span, what, "remove the key or change `kind`"))
    };
    given.into_iter().find_map(unfit).map_or(Ok(()), Err)
}
