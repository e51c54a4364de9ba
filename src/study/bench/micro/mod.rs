//! The steps of a frame one by one, for each instruction set: what a box, a triangle or a ray costs.
//!
//! All instruction sets do the same work on the same data, which lies in their caches as far as it fits there, and their
//! rounds are interleaved. Before anything is timed, each step's results are compared bit by bit.

mod stage;
mod steps;

pub use stage::Stage;
pub use steps::{Step, steps};

use super::BenchOptions;
use crate::{
    error::{Error, Result},
    kernels::{Isa, Kernels},
    render::choose_kernels,
    scene::Scene,
    schedule::{Machine, Placement, pin_current_thread},
};
use std::time::Instant;

/// A step is repeated until a round takes about so many seconds: much more than a look at the clock.
const ROUND: f64 = 2.0e-3;

/// One step with one instruction set.
#[derive(Clone, Debug)]
pub struct MicroRow {
    /// Scene.
    pub scene: String,
    /// Step.
    pub step: &'static str,
    /// Instruction set.
    pub isa: Isa,
    /// What is counted.
    pub unit: &'static str,
    /// How many of them one pass has.
    pub units: u64,
    /// Nanoseconds for each, round by round.
    pub ns: Vec<f64>,
    /// True if the results are those of the narrowest instruction set.
    pub agrees: bool,
}

/// Times all steps on one scene: with the instruction set of the options, or with each that this machine has.
///
/// # Errors
/// As [`super::check`], and [`Error::Failed`] if the tree cannot be built.
pub fn micro(scene: &Scene, options: &BenchOptions) -> Result<Vec<MicroRow>> {
    let kernels = match options.isa {
        Some(_) => vec![choose_kernels(options.isa)?],
        None => Isa::available().filter_map(Kernels::for_isa).collect(),
    };
    // Machine and tree come before the pin, which other threads would inherit.
    let placement = Placement::new(Machine::get(), Some(1), options.pin);
    let stage = Stage::new(scene, options.build, options.size)?;
    let measure = || {
        pin_current_thread(placement.slots().first().copied().flatten());
        measure(&stage, &kernels, options.rounds)
    };
    let rows = std::thread::scope(|scope| scope.spawn(measure).join());
    Ok(rows.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
}

fn measure(stage: &Stage, kernels: &[Kernels], rounds: u32) -> Vec<MicroRow> {
    let mut sets: Vec<Vec<Step>> = kernels.iter().map(|&kernels| steps(stage, kernels)).collect();
    let mut rows = Vec::new();
    for index in 0..sets[0].len() {
        let mut rivals: Vec<&mut Step> = sets.iter_mut().map(|steps| &mut steps[index]).collect();
        let sums: Vec<u64> = rivals.iter_mut().map(|step| step.check()).collect();
        // The first round warms up and tells how often to repeat.
        let passes: Vec<u32> =
            rivals.iter_mut().map(|step| (ROUND / seconds(step, 1)).clamp(1.0, 1.0e6) as u32).collect();
        let mut ns = vec![Vec::new(); rivals.len()];
        for _ in 0..rounds {
            for ((step, &passes), ns) in rivals.iter_mut().zip(&passes).zip(&mut ns) {
                ns.push(seconds(step, passes) * 1.0e9 / (step.units() as f64 * f64::from(passes)));
            }
        }
        for (((step, kernels), sum), ns) in rivals.iter().zip(kernels).zip(&sums).zip(ns) {
            rows.push(MicroRow {
                scene: stage.name().into(),
                step: step.name(),
                isa: kernels.isa(),
                unit: step.unit(),
                units: step.units(),
                ns,
                agrees: *sum == sums[0],
            });
        }
    }
    rows
}

/// How long `passes` passes take.
fn seconds(step: &mut Step, passes: u32) -> f64 {
    let start = Instant::now();
    for _ in 0..passes {
        step.run();
    }
    start.elapsed().as_secs_f64()
}

/// The error of steps whose results differ.
///
/// # Errors
/// [`Error::Failed`] if there is such a row.
pub fn micro_verdict(rows: &[MicroRow]) -> Result<()> {
    match rows.iter().find(|row| !row.agrees) {
        None => Ok(()),
        Some(row) => Err(Error::Failed(format!(
            "{} of {}: {} gives other results than the narrowest instruction set; its figures mean nothing",
            row.step, row.scene, row.isa
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_that_differ_are_an_error() {
        let row = |isa, agrees| MicroRow {
            scene: "room".into(),
            step: "box test",
            isa,
            unit: "box",
            units: 1,
            ns: vec![1.0],
            agrees,
        };
        assert!(micro_verdict(&[row(Isa::Scalar, true), row(Isa::Avx2, true)]).is_ok());
        let error = micro_verdict(&[row(Isa::Scalar, true), row(Isa::Avx2, false)]).unwrap_err();
        assert!(error.to_string().contains("box test of room: avx2"), "{error}");
    }
}
