//! `irt render` of a scene that moves: one image at a time of it, or numbered images of all of it.

use super::{
    args::{RenderArgs, Talk},
    export::Export,
    interrupt,
    options::render_options,
    render::ray_counts,
    terminal::{self, Progress},
};
use crate::{
    error::{Error, Result},
    film::Film,
    output::OutputFile,
    render::{Moment, Update, animate},
    report::{AnimationSummary, MomentSummary, to_json},
    scene::{Scene, numbered},
    schedule::Control,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The name of image `number`, if the output is a sequence of them.
pub(super) fn image(output: &Path, number: usize) -> Option<PathBuf> {
    numbered(output.to_str()?, number as u64).map(PathBuf::from)
}

/// Settles what can be told of the arguments without the scene.
///
/// # Errors
/// [`Error::Flag`] for flags that do not go with numbered images, or only with them.
pub(super) fn check(args: &RenderArgs) -> Result<()> {
    let sequence = image(&args.output, 0).is_some();
    let alone = "leave it out, or give --output a name without %d";
    match (sequence, args) {
        (true, RenderArgs { time: Some(_), .. }) => {
            Err(Error::flag("--time", "a numbered --output takes all of the motion", alone))
        }
        (true, RenderArgs { tev: Some(_), .. }) => {
            Err(Error::flag("--tev", "it shows one image, not a numbered sequence", alone))
        }
        (true, RenderArgs { frames: 2.., .. }) => {
            Err(Error::flag("--frames", "it repeats one image, not a numbered sequence", alone))
        }
        (false, RenderArgs { fps: Some(_), .. }) => {
            let remedy = "give --output a name with %04d in place of the number";
            Err(Error::flag("--fps", "it belongs to numbered images", remedy))
        }
        _ => Ok(()),
    }
}

/// Puts the scene where it is at the time of `--time`, and makes sure that it moves where that is needed.
///
/// # Errors
/// [`Error::Flag`] if it does not move.
pub(super) fn pose(scene: &mut Scene, args: &RenderArgs) -> Result<()> {
    let flag = if args.time.is_some() { "--time" } else { "--output" };
    if scene.motion.is_none() && (args.time.is_some() || image(&args.output, 0).is_some()) {
        let what = format!("nothing moves in the scene {}", scene.name);
        return Err(Error::flag(flag, what, "leave out --time, and %d in the name of --output"));
    }
    scene.pose(args.time.unwrap_or(0.0));
    Ok(())
}

/// Renders all of the motion to numbered files.
///
/// # Errors
/// As [`animate`]; images that were finished before stay.
pub(super) fn run(
    args: &RenderArgs,
    mut scene: Scene,
    load_seconds: f64,
    export: Export,
    talk: Talk,
) -> Result<()> {
    let options = render_options(args, &scene)?;
    let motion = scene.motion.as_ref().map(|motion| (motion.rate(), motion));
    let Some((rate, motion)) = motion else { return Ok(()) };
    let fps = args.fps.unwrap_or(rate);
    let moments = motion.moments(fps);
    let mut summary = AnimationSummary {
        scene: scene.name.clone(),
        triangles: scene.mesh.len() as u64,
        size: options.size,
        isa: String::new(),
        fps,
        load_seconds,
        moments: vec![],
    };
    let bar = Progress::new(moments.len() as u32, talk);
    let tick = |frame: crate::schedule::Progress| bar.tick((frame.total * moments.len()) as u64);
    let control = Control::new(interrupt::flag(), &tick);
    let mut done = |number: usize, moment: &Moment, film: &Film| {
        summary.isa = moment.isa.to_string();
        summary.moments.push(write(args, number, moment, film)?);
        Ok(())
    };
    animate(&mut scene, &options, &moments, &control, &mut done)?;
    drop(bar);
    let stdout_taken = export.is_stdout();
    export.write(|| to_json(&summary))?;
    if talk.quiet { Ok(()) } else { terminal::results(&summary.to_string(), stdout_taken, talk) }
}

fn write(args: &RenderArgs, number: usize, moment: &Moment, film: &Film) -> Result<MomentSummary> {
    let start = Instant::now();
    let path = image(&args.output, number).unwrap_or_else(|| args.output.clone());
    OutputFile::create(&path)?.write(film, args.exposure)?;
    log::info!("{} is written", path.display());
    Ok(MomentSummary {
        time: moment.time,
        file: path.display().to_string(),
        tree: match moment.update {
            None => "built",
            Some(Update::Refitted) => "refitted",
            Some(Update::Rebuilt) => "rebuilt",
        },
        sah_cost: moment.sah_cost,
        pose_seconds: moment.pose_seconds,
        tree_seconds: moment.tree_seconds,
        seconds: moment.frame.seconds,
        rays: ray_counts(&moment.frame),
        write_seconds: start.elapsed().as_secs_f64(),
        image_sha256: moment.frame.image_sha256.clone(),
    })
}
