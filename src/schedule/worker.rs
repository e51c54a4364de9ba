//! The worker's side of the protocol.

use super::TileTask;
use super::pin::pin_current_thread;
use super::protocol::{Command, Report};
use crossbeam_channel::{Receiver, Sender};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Runs commands until their channel closes. Never panics because of the task.
pub(super) fn work<T: TileTask>(
    task: &T,
    worker: usize,
    cpu: Option<usize>,
    commands: Receiver<Command<T::Frame>>,
    reports: Sender<Report<T::Output>>,
) {
    let pinned = pin_current_thread(cpu);
    // After pinning, so that the memory is first touched, and thus placed, where it will be used.
    let mut scratch = guarded(|| task.scratch(worker)).ok();
    if reports.send(Report::Ready { worker, pinned }).is_err() {
        return;
    }
    for Command { frame, tile } in commands {
        let start = Instant::now();
        let outcome = guarded(|| {
            let scratch = scratch.get_or_insert_with(|| task.scratch(worker));
            task.run(&frame, tile, scratch)
        });
        let busy = start.elapsed();
        if outcome.is_err() {
            // The panic may have left it half-changed.
            let _ = guarded(|| scratch = None);
        }
        // Before the report: when the master has all reports, the frame must be its own again.
        drop(frame);
        if reports.send(Report::Done { worker, tile, busy, outcome }).is_err() {
            return;
        }
    }
}

/// Calls `f`; a panic becomes its message. Callers drop whatever a panic may have left inconsistent.
fn guarded<R>(f: impl FnOnce() -> R) -> Result<R, String> {
    catch_unwind(AssertUnwindSafe(f)).map_err(|payload| message_of(payload.as_ref()))
}

fn message_of(payload: &(dyn Any + Send)) -> String {
    match (payload.downcast_ref::<&str>(), payload.downcast_ref::<String>()) {
        (Some(text), _) => (*text).to_string(),
        (_, Some(text)) => text.clone(),
        _ => "a panic without a message".to_string(),
    }
}
