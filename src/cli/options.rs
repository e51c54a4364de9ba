//! What the arguments mean: validated options of the library.

use super::animate;
use super::args::{EngineArgs, RenderArgs, SamplingArgs, ViewArgs};
use crate::{
    error::{Error, Result},
    render::{RenderOptions, choose_kernels},
    scene::{CameraDescription, Falloff, Light, Scene},
    schedule::Schedule,
    trace::{EarlyTermination, KernelChoice},
};
use glam::Vec3;
use std::path::Path;

/// Most tiles of an image; each takes a few bytes of the scheduler's memory.
const MOST_TILES: u64 = 1 << 22;

/// Settles everything that can be told without the scene, so that a mistake is answered at once.
///
/// # Errors
/// [`Error::Flag`] for an instruction set that this machine lacks, two outputs that are one file, tiles too small
/// for the size, and flags of moving scenes that do not go together.
pub(super) fn check(args: &RenderArgs) -> Result<()> {
    if args.export_json.as_deref().is_some_and(|json| json == args.output && json != Path::new("-")) {
        let what = format!("{} is the image already", args.output.display());
        return Err(Error::flag("--export-json", what, "choose another name for one of them"));
    }
    animate::check(args)?;
    check_engine(&args.engine)?;
    args.size.map_or(Ok(()), |size| check_tiles(size, args.engine.tile))
}

/// Settles what can be told of these arguments alone.
///
/// # Errors
/// [`Error::Flag`] for an instruction set that this machine lacks, and for what the kernel would ignore.
pub(super) fn check_engine(args: &EngineArgs) -> Result<()> {
    choose_kernels(args.isa.isa())?;
    let EngineArgs { kernel, early_termination, .. } = *args;
    if kernel == KernelChoice::Single && early_termination != EarlyTermination::default() {
        let remedy = "leave out --kernel single, or study single rays with irt coherence";
        return Err(Error::flag("--early-termination", "it switches the tile kernel only", remedy));
    }
    Ok(())
}

/// How to render `scene`.
///
/// # Errors
/// [`Error::Flag`] if the tiles are too small for the size.
pub(super) fn render_options(args: &RenderArgs, scene: &Scene) -> Result<RenderOptions> {
    let size = args.size.unwrap_or(scene.size);
    check_tiles(size, args.engine.tile)?;
    let RenderArgs { frames, seed, .. } = *args;
    Ok(RenderOptions { frames, seed, ..engine_options(&args.engine, size) })
}

/// How to render one frame of this size.
pub(super) fn engine_options(args: &EngineArgs, size: [u32; 2]) -> RenderOptions {
    let EngineArgs {
        threads,
        pin,
        isa,
        visibility,
        kernel,
        order,
        schedule,
        film,
        tile,
        build,
        early_termination,
        effects,
    } = *args;
    RenderOptions {
        isa: isa.isa(),
        kernel,
        visibility,
        threads,
        pin: pin.pin(),
        order,
        schedule: Schedule { strategy: schedule, film },
        tile,
        size,
        frames: 1,
        build,
        seed: 0,
        early: early_termination,
        effects,
    }
}

pub(super) fn check_tiles([width, height]: [u32; 2], tile: u32) -> Result<()> {
    let tiles = u64::from(width.div_ceil(tile)) * u64::from(height.div_ceil(tile));
    if tiles <= MOST_TILES {
        return Ok(());
    }
    let what = format!("{width}x{height} pixels in tiles of {tile} are {tiles} tiles");
    Err(Error::flag("--tile", what, format!("use larger tiles, so that there are at most {MOST_TILES}")))
}

/// Replaces the scene's camera and lights by those of the command line.
///
/// # Errors
/// [`Error::Flag`] if the camera that results cannot see: eye and at coincide or are too far apart, or up points
/// along the view.
pub(super) fn replace_view(scene: &mut Scene, args: &ViewArgs) -> Result<()> {
    let camera = &mut scene.camera;
    camera.eye = args.camera_eye.unwrap_or(camera.eye);
    camera.at = args.camera_at.unwrap_or(camera.at);
    camera.up = args.camera_up.unwrap_or(camera.up);
    camera.fov_deg = args.fov.unwrap_or(camera.fov_deg);
    if args.camera_eye.is_some() || args.camera_at.is_some() || args.camera_up.is_some() {
        check_camera(camera)?;
    }
    if !args.light.is_empty() {
        // As bright together as one light of strength 1, so that the image is not overexposed.
        let intensity = Vec3::splat(1.0 / args.light.len() as f32);
        let light = |&position: &Vec3| Light::Point { position, intensity, falloff: Falloff::None };
        scene.lights = args.light.iter().map(light).collect();
    }
    Ok(())
}

/// Replaces the scene's sampling by that of the command line.
pub(super) fn replace_sampling(scene: &mut Scene, args: &SamplingArgs) {
    let settings = &mut scene.settings;
    settings.samples = args.samples.unwrap_or(settings.samples);
    settings.adaptive = args.adaptive.or(settings.adaptive);
    settings.light_samples = args.light_samples.unwrap_or(settings.light_samples);
    settings.bounces = args.bounces.unwrap_or(settings.bounces);
    settings.max_depth = args.max_depth.unwrap_or(settings.max_depth);
    settings.cutoff = args.cutoff.unwrap_or(settings.cutoff);
}

fn check_camera(camera: &CameraDescription) -> Result<()> {
    let CameraDescription { eye, at, up, .. } = *camera;
    let [ex, ey, ez] = eye.to_array();
    if eye == at {
        let what = format!("{ex},{ey},{ez} is both where the camera is and where it looks");
        return Err(Error::flag("--camera-at", what, "give it, or --camera-eye, another point"));
    }
    let Some(forward) = (at - eye).try_normalize() else {
        let what = format!("{ex},{ey},{ez} is too near to or too far from what the camera looks at");
        return Err(Error::flag("--camera-eye", what, "use coordinates between 1e-15 and 1e15"));
    };
    let Some(upward) = up.try_normalize() else {
        let what = "the vector that points up has no usable length";
        return Err(Error::flag("--camera-up", what, "give one such as 0,1,0"));
    };
    if forward.cross(upward).length() < 1e-4 {
        let [x, y, z] = up.to_array();
        let what = format!("{x},{y},{z} points along the view");
        return Err(Error::flag("--camera-up", what, "give a vector across it, such as 0,0,1 or 0,1,0"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: Vec3, at: Vec3, up: Vec3) -> CameraDescription {
        CameraDescription { eye, at, up, fov_deg: 50.0 }
    }

    fn flag_at_fault(eye: Vec3, at: Vec3, up: Vec3) -> String {
        let message = check_camera(&camera(eye, at, up)).unwrap_err().to_string();
        message.split(':').next().unwrap().into()
    }

    #[test]
    fn a_camera_that_sees_is_accepted() {
        check_camera(&camera(Vec3::ZERO, Vec3::X, Vec3::Y)).unwrap();
        check_camera(&camera(Vec3::splat(1e6), Vec3::ZERO, Vec3::new(0.0, 1e-3, 0.0))).unwrap();
    }

    #[test]
    fn a_camera_that_cannot_see_is_refused() {
        assert_eq!(flag_at_fault(Vec3::ONE, Vec3::ONE, Vec3::Y), "--camera-at");
        assert_eq!(flag_at_fault(Vec3::splat(3e38), -Vec3::splat(3e38), Vec3::Y), "--camera-eye");
        assert_eq!(flag_at_fault(Vec3::ZERO, Vec3::splat(1e-38), Vec3::Y), "--camera-eye");
        assert_eq!(flag_at_fault(Vec3::ZERO, Vec3::X, Vec3::ZERO), "--camera-up");
        assert_eq!(flag_at_fault(Vec3::ZERO, Vec3::X, Vec3::X * -2.0), "--camera-up");
    }

    #[test]
    fn tiny_tiles_of_a_huge_image_are_refused() {
        check_tiles([16384, 16384], 16).unwrap();
        let message = check_tiles([16384, 16384], 1).unwrap_err().to_string();
        assert!(message.starts_with("--tile: ") && message.contains("larger tiles"), "{message}");
    }
}
