//! What the user's side and the renderer's side of the viewer share. Neither waits for the other longer than it takes
//! to move a few words.

use super::event::Event;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// An event and when it happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// When.
    pub at: Instant,
    /// What.
    pub event: Event,
}

/// From the user's side to the renderer: events; the other way: memory of pictures that were shown.
#[derive(Debug, Default)]
pub struct Link {
    events: Mutex<VecDeque<Timed>>,
    wake: Condvar,
    /// True while there are events: whatever is only refined may stop.
    pub(super) halt: AtomicBool,
    spare: Mutex<Vec<Vec<AtomicU32>>>,
}

/// Pictures that are kept for reuse: one being made, one shown, one between.
const SPARE: usize = 3;

impl Link {
    /// Something happened now.
    pub fn send(&self, event: Event) {
        let mut events = lock(&self.events);
        events.push_back(Timed { at: Instant::now(), event });
        self.halt.store(true, Ordering::Relaxed);
        drop(events);
        self.wake.notify_all();
    }

    /// Everything that happened since the last call; if `wait`, not before something has.
    pub(super) fn take(&self, wait: bool) -> Vec<Timed> {
        let mut events = lock(&self.events);
        while wait && events.is_empty() {
            events = self.wake.wait(events).unwrap_or_else(PoisonError::into_inner);
        }
        self.halt.store(false, Ordering::Relaxed);
        events.drain(..).collect()
    }

    /// A picture was shown; its memory may be used again.
    pub fn give_back(&self, pixels: Vec<AtomicU32>) {
        let mut spare = lock(&self.spare);
        if spare.len() < SPARE {
            spare.push(pixels);
        }
    }

    pub(super) fn spare(&self) -> Vec<AtomicU32> {
        lock(&self.spare).pop().unwrap_or_default()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
