//! A moving scene, moment by moment.

use super::{FrameReport, Geometry, RenderOptions, Stage, Update};
use crate::{
    error::{Error, Result},
    film::Film,
    kernels::Isa,
    scene::Scene,
    schedule::{Control, Machine, Placement},
};
use std::time::Instant;

/// One rendered moment.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Seconds from the beginning of the motion.
    pub time: f64,
    /// Seconds to move the vertices.
    pub pose_seconds: f64,
    /// Seconds to let tree and surface table follow, or, for the first moment, to build them.
    pub tree_seconds: f64,
    /// What was done to the tree; `None` for the first moment.
    pub update: Option<Update>,
    /// Expected cost of a random ray in it.
    pub sah_cost: f64,
    /// Instruction set used.
    pub isa: Isa,
    /// The image.
    pub frame: FrameReport,
}

/// Renders `scene` at each of the moments, one after the other; `done` gets each with its number, counted from 0, and the
/// image. The scene stays as it is at the last one. Every image is that of a scene that never was at another moment.
///
/// # Errors
/// As [`super::render()`], and what `done` returns.
pub fn animate(
    scene: &mut Scene,
    options: &RenderOptions,
    moments: &[f64],
    control: &Control,
    done: &mut dyn FnMut(usize, &Moment, &Film) -> Result<()>,
) -> Result<()> {
    let placement = Placement::new(Machine::get(), options.threads, options.pin);
    let mut geometry: Option<Geometry> = None;
    for (number, &time) in moments.iter().enumerate() {
        if control.cancelled() {
            return Err(Error::Interrupted);
        }
        let start = Instant::now();
        scene.pose(time);
        let posed = Instant::now();
        let (stage, update) = match geometry {
            None => (Stage::new(scene, options)?, None),
            Some(mut geometry) => {
                let update = geometry.follow(scene, options.build)?;
                (Stage::again(scene, options, geometry)?, Some(update))
            }
        };
        let tree_seconds = posed.elapsed().as_secs_f64();
        let tiles = stage.tiles(options.tile);
        let (frame, film) = stage.with_session(&placement, |session| {
            let frame = session.reported_frame(options.schedule, &tiles, control, &mut |_, _| {})?;
            Ok((frame, session.take_film()))
        })?;
        let moment = Moment {
            time,
            pose_seconds: (posed - start).as_secs_f64(),
            tree_seconds,
            update,
            sah_cost: stage.geometry.bvh.sah_cost(),
            isa: stage.kernels.isa(),
            frame,
        };
        geometry = Some(stage.leave());
        done(number, &moment, &film)?;
    }
    Ok(())
}
