//! From what a scene file says to values that are certainly usable.

use super::{
    Description, MeshUse, light, material, moving,
    place::Placement,
    schema::{Camera, File, Mesh},
    source::Source,
    surroundings,
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
        changes: file
            .material
            .into_iter()
            .map(|value| material::change(source, value))
            .collect::<Result<_>>()?,
        lights: file.light.iter().map(|value| light::check(source, value)).collect::<Result<_>>()?,
        environment: surroundings::environment(source, file.environment)?,
        settings: file.settings.map_or(Ok(scene::RenderSettings::default()), |settings| {
            surroundings::settings(source, &settings)
        })?,
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
    let moving = moving::moving(source, &mesh)?;
    Ok(MeshUse { file: mesh.file, name: mesh.name, material: mesh.material, placement, moving })
}
