//! From what a scene file says to values that are certainly usable.

use super::{
    Change, Description, MeshUse,
    place::Placement,
    schema::{Camera, Falloff, File, Light, LightKind, Material, Mesh},
    source::Source,
};
use crate::{
    error::Result,
    scene::{self, CameraDescription, MAX_PIXELS, MAX_SIDE},
};
use glam::Vec3;
use toml::Spanned;

pub(super) fn check(source: &Source<'_>, file: File) -> Result<Description> {
    if file.mesh.is_empty() {
        return Err(source.error(0..0, "the scene has no mesh", "give at least one `[[mesh]]`"));
    }
    let color = |key, value: &Option<_>| match value {
        None => Ok(Vec3::ZERO),
        Some(value) => source.color(key, value),
    };
    Ok(Description {
        path: source.path.into(),
        text: source.text.into(),
        name: file.name,
        size: file.size.map_or(Ok(scene::DEFAULT_SIZE), |size| image_size(source, &size))?,
        background: color("background", &file.background)?,
        ambient: color("ambient", &file.ambient)?,
        camera: file.camera.map(|value| camera(source, &value)).transpose()?,
        meshes: file.mesh.into_iter().map(|value| mesh(source, value)).collect::<Result<_>>()?,
        changes: file.material.iter().map(|value| change(source, value)).collect::<Result<_>>()?,
        lights: file.light.iter().map(|value| light(source, value)).collect::<Result<_>>()?,
    })
}

fn image_size(source: &Source<'_>, size: &Spanned<[i64; 2]>) -> Result<[u32; 2]> {
    let [width, height] = *size.get_ref();
    let valid = [width, height].iter().all(|side| (1..=i64::from(MAX_SIDE)).contains(side));
    source.check("size", size, valid, &format!("must be two integers in 1 to {MAX_SIDE}"))?;
    let fits = (width * height) as u64 <= MAX_PIXELS;
    source.check("size", size, fits, &format!("must be at most {MAX_PIXELS} pixels in all"))?;
    Ok([width as u32, height as u32])
}

fn camera(source: &Source<'_>, value: &Spanned<Camera>) -> Result<CameraDescription> {
    let camera = value.get_ref();
    let eye = source.vector("eye", &camera.eye)?;
    let at = source.vector("at", &camera.at)?;
    let up = camera.up.as_ref().map_or(Ok(Vec3::Y), |up| source.vector("up", up))?;
    let valid = |fov: f32| fov > 0.0 && fov < 180.0;
    let fov_deg = source.within("fov", &camera.fov, valid, "must be between 0 and 180 degrees")?;
    // The camera works in f32, so it must be in f32 that there is a direction.
    source.check("at", &camera.at, (at - eye).try_normalize().is_some(), "must differ from `eye`")?;
    let side = (at - eye).as_dvec3().normalize().cross(up.as_dvec3().normalize_or_zero());
    if side.length() < 1.0e-6 {
        let span = camera.up.as_ref().map_or(value.span(), Spanned::span);
        let what = "`up` must be neither zero nor along the viewing direction";
        return Err(source.error(span, what, "give another `up`"));
    }
    // As long as a unit vector, so that no product with it over- or underflows.
    let up = up.as_dvec3().normalize().as_vec3();
    Ok(CameraDescription { eye, at, up, fov_deg })
}

fn mesh(source: &Source<'_>, mesh: Mesh) -> Result<MeshUse> {
    let mut placement = Placement::default();
    if let Some(scale) = &mesh.scale {
        let factors = scale.get_ref().0;
        let valid = factors.iter().all(|&f| (f as f32).is_finite() && f as f32 != 0.0);
        source.check("scale", scale, valid, "must be finite and not zero")?;
        placement.scale = factors;
    }
    if let Some(rotate) = &mesh.rotate {
        source.vector("rotate", rotate)?;
        placement.rotate = *rotate.get_ref();
    }
    if let Some(translate) = &mesh.translate {
        source.vector("translate", translate)?;
        placement.translate = *translate.get_ref();
    }
    source.check("file", &mesh.file, !mesh.file.get_ref().is_empty(), "must not be empty")?;
    Ok(MeshUse { file: mesh.file, name: mesh.name, material: mesh.material, placement })
}

fn change(source: &Source<'_>, value: &Spanned<Material>) -> Result<Change> {
    let from = value.get_ref();
    let reflectance =
        |key, value: &Option<_>| value.as_ref().map(|value| source.reflectance(key, value)).transpose();
    let number = |key, value: &Option<_>, valid: fn(f32) -> bool, rule| {
        value.as_ref().map(|value| source.within(key, value, valid, rule)).transpose()
    };
    let illum = from.illum.as_ref().map(|illum| {
        let valid = (0..=10).contains(illum.get_ref());
        source.check("illum", illum, valid, "must be in 0 to 10").map(|()| *illum.get_ref() as u8)
    });
    source.check("name", &from.name, !from.name.get_ref().is_empty(), "must not be empty")?;
    Ok(Change {
        name: from.name.get_ref().clone(),
        ka: reflectance("ka", &from.ka)?,
        kd: reflectance("kd", &from.kd)?,
        ks: reflectance("ks", &from.ks)?,
        ke: from.ke.as_ref().map(|ke| source.color("ke", ke)).transpose()?,
        ns: number("ns", &from.ns, |ns| ns >= 0.0, "must not be negative")?,
        ni: number("ni", &from.ni, |ni| ni > 0.0, "must be positive")?,
        d: number("d", &from.d, |d| (0.0..=1.0).contains(&d), "must be in 0 to 1")?,
        illum: illum.transpose()?,
    })
}

fn light(source: &Source<'_>, value: &Spanned<Light>) -> Result<scene::Light> {
    let light = value.get_ref();
    let missing = |key: &str, of: &str| {
        source.error(value.span(), format!("a {of} light needs `{key}`"), format!("add `{key} = ...`"))
    };
    let color = light.color.as_ref().map_or(Ok(Vec3::ONE), |color| source.color("color", color))?;
    let strength = light.intensity.as_ref().map_or(Ok(1.0), |intensity| {
        source.within("intensity", intensity, |i| i >= 0.0, "must not be negative")
    })?;
    let intensity = color * strength;
    if !intensity.is_finite() {
        return Err(source.error(
            value.span(),
            "`color` times `intensity` is too great",
            "lower one of them",
        ));
    }
    let falloff = match light.falloff.as_ref().map(Spanned::get_ref) {
        None | Some(Falloff::None) => scene::Falloff::None,
        Some(Falloff::InverseSquare) => scene::Falloff::InverseSquare,
    };
    let position = |of: &str| match &light.position {
        Some(position) => source.vector("position", position),
        None => Err(missing("position", of)),
    };
    let direction = |of: &str| match &light.direction {
        Some(direction) => source.direction("direction", direction),
        None => Err(missing("direction", of)),
    };
    only_of_its_kind(source, light)?;
    Ok(match light.kind {
        LightKind::Point => scene::Light::Point { position: position("point")?, intensity, falloff },
        LightKind::Directional => {
            scene::Light::Directional { direction: direction("directional")?, intensity }
        }
        LightKind::Spot => {
            let (position, direction) = (position("spot")?, direction("spot")?);
            let outer = light.outer.as_ref().ok_or_else(|| missing("outer", "spot"))?;
            let (inner, outer) = cone(source, light.inner.as_ref(), outer)?;
            scene::Light::Spot { position, direction, intensity, falloff, inner, outer }
        }
    })
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
    let unfit = |span: Option<std::ops::Range<usize>>, key: &str, of: &str| match span {
        None => Ok(()),
        Some(span) => {
            let what = format!("a {of} light has no `{key}`");
            Err(source.error(span, what, "remove the key or change `kind`"))
        }
    };
    match light.kind {
        LightKind::Point => {
            unfit(light.direction.as_ref().map(Spanned::span), "direction", "point")?;
            unfit(light.inner.as_ref().map(Spanned::span), "inner", "point")?;
            unfit(light.outer.as_ref().map(Spanned::span), "outer", "point")
        }
        LightKind::Directional => {
            unfit(light.position.as_ref().map(Spanned::span), "position", "directional")?;
            unfit(light.falloff.as_ref().map(Spanned::span), "falloff", "directional")?;
            unfit(light.inner.as_ref().map(Spanned::span), "inner", "directional")?;
            unfit(light.outer.as_ref().map(Spanned::span), "outer", "directional")
        }
        LightKind::Spot => Ok(()),
    }
}
