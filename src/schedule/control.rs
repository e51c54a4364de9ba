//! How the outside watches and stops a frame.

use std::sync::atomic::{AtomicBool, Ordering};

/// How far a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Tiles finished.
    pub done: usize,
    /// Tiles in all.
    pub total: usize,
}

/// A cancel flag to obey and a callback to tell about progress.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    cancel: &'a AtomicBool,
    progress: &'a dyn Fn(Progress),
}

impl<'a> Control<'a> {
    /// Work stops soon after `cancel` becomes true. `progress` is called on the thread that started the work, once per
    /// finished tile.
    pub fn new(cancel: &'a AtomicBool, progress: &'a dyn Fn(Progress)) -> Control<'a> {
        Control { cancel, progress }
    }

    /// Nobody watches and nobody cancels.
    pub fn unattended() -> Control<'static> {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Control { cancel: &NEVER, progress: &|_| {} }
    }

    /// True once the work is no longer wanted. Long steps that are not tiles should ask now and then.
    pub fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// What cancels it.
    pub fn flag(&self) -> &'a AtomicBool {
        self.cancel
    }

    /// Tells the callback.
    pub fn report(&self, progress: Progress) {
        (self.progress)(progress);
    }
}
