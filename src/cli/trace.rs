//! `irt trace`.

use super::{
    args::{Talk, TraceArgs},
    interrupt, terminal,
};
use crate::{
    bvh::Bvh,
    error::{Error, Result},
    kernels::{Hit, MISS},
    output::{PendingFile, read_rays, write_blocked, write_hits},
    render::choose_kernels,
    report::{count, significant},
    scene::load,
    schedule::{Machine, Placement, pin_current_thread},
    trace::{KernelChoice, Traversal},
};
use std::fs::canonicalize;
use std::time::Instant;

/// Traces the rays of a file and writes what they hit to another.
///
/// # Errors
/// Whatever is wrong with the arguments, the rays, the scene or the disk; no file is left behind then.
pub(super) fn run(args: &TraceArgs, talk: Talk) -> Result<()> {
    let kernels = choose_kernels(args.isa.isa())?.with_visibility(args.visibility);
    if let (Ok(rays), Ok(hits)) = (canonicalize(&args.rays), canonicalize(&args.hits))
        && rays == hits
    {
        let what = format!("{} holds the rays", args.hits.display());
        return Err(Error::flag("--hits", what, "choose another name"));
    }
    interrupt::install()?;
    let output = PendingFile::create(&args.hits)?;
    let rays = read_rays(&args.rays)?;
    let scene = load(&args.scene)?;
    scene.warnings.iter().for_each(|warning| log::warn!("{warning}"));
    // The machine is enumerated and the tree built before any thread is pinned: pins are inherited.
    let placement = Placement::new(Machine::get(), args.threads, args.pin.pin());
    let bvh = Bvh::build(&scene.mesh, args.build)?;
    let traversal = Traversal::new(&bvh, kernels, KernelChoice::Auto);
    let slots = placement.slots();
    let pin = |thread: usize| {
        pin_current_thread(slots[thread]);
    };

    let (found, doubts, seconds) = if args.occluded {
        let mut blocked = vec![0; rays.len()];
        let (doubts, seconds) = time(|| traversal.occluded_batch(&rays, &mut blocked, slots.len(), &pin));
        write_blocked(output, &blocked)?;
        (blocked.iter().filter(|&&blocked| blocked != 0).count(), doubts, seconds)
    } else {
        let mut hits = vec![Hit::MISS; rays.len()];
        let (doubts, seconds) = time(|| traversal.intersect_batch(&rays, &mut hits, slots.len(), &pin));
        write_hits(output, &hits)?;
        (hits.iter().filter(|hit| hit.prim != MISS).count(), doubts, seconds)
    };
    if talk.quiet {
        Ok(())
    } else {
        terminal::print(&summary(args, rays.len(), found, doubts, seconds, slots.len()))
    }
}

fn time<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

fn summary(args: &TraceArgs, rays: usize, found: usize, doubts: u64, seconds: f64, threads: usize) -> String {
    let speed = rays as f64 / seconds.max(1e-9) * 1e-6;
    format!(
        "{} rays, {} {}, {} triangles decided exactly, {} Mrays/s on {threads} thread{}; written to {}\n",
        count(rays as u64),
        count(found as u64),
        if args.occluded { "blocked" } else { "hits" },
        count(doubts),
        significant(speed, 4),
        if threads == 1 { "" } else { "s" },
        args.hits.display()
    )
}
