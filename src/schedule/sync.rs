//! What the protocol synchronises with. `model.rs` compiles the same protocol with another version of this file.

pub(super) use std::sync::{Condvar, Mutex, MutexGuard};
pub(super) use std::thread::{Scope, scope, yield_now};

use super::policy::compute_in_batches;
use std::{io, thread};

/// Starts a worker thread that ends before `scope` does, and does not take the place of others when it is woken.
pub(super) fn spawn<'scope>(
    scope: &'scope Scope<'scope, '_>,
    worker: usize,
    work: impl FnOnce() + Send + 'scope,
) -> io::Result<()> {
    let work = || {
        compute_in_batches();
        work();
    };
    thread::Builder::new().name(format!("worker {worker}")).spawn_scoped(scope, work).map(|_| ())
}
