//! The two places where messages wait: a desk for each worker, and the master's inbox.
//!
//! Both are a mutex around what lies there and a condition to wait on, so that whoever waits is parked. Nobody is
//! notified who does not wait: that would be a system call for nothing. What has been received leaves its memory
//! behind, so that in steady state nothing is allocated.

use super::message::{Parcel, Report, Task};
use super::sync::{Condvar, Mutex, MutexGuard, yield_now};
use std::collections::VecDeque;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What the master laid out for one worker.
pub(super) struct Desk<F, O> {
    state: Mutex<OnDesk<F, O>>,
    changed: Condvar,
}

struct OnDesk<F, O> {
    tasks: VecDeque<Task<F>>,
    /// Empty ones, to be filled and sent. Boxed, because they travel.
    #[allow(clippy::vec_box)]
    parcels: Vec<Box<Parcel<O>>>,
    closed: bool,
    worker_waits: bool,
    /// When it was woken.
    woken: Option<Instant>,
}

impl<F, O> Desk<F, O> {
    pub(super) fn new() -> Desk<F, O> {
        let state = OnDesk {
            tasks: VecDeque::new(),
            parcels: vec![],
            closed: false,
            worker_waits: false,
            woken: None,
        };
        Desk { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Master: makes it `count` parcels, while no task is under way.
    pub(super) fn stock(&self, count: usize) {
        lock(&self.state).parcels.resize_with(count, Box::default);
    }

    /// Master: lays down a parcel, a task, both or nothing. Whether the worker had to be woken.
    pub(super) fn lay(&self, parcel: Option<Box<Parcel<O>>>, task: Option<Task<F>>) -> bool {
        let mut state = lock(&self.state);
        state.parcels.extend(parcel);
        state.tasks.extend(task);
        self.wake(state)
    }

    /// Master: no more tasks and parcels will come.
    pub(super) fn close(&self) {
        let mut state = lock(&self.state);
        state.closed = true;
        self.wake(state);
    }

    /// Master: takes away what its worker, which is no more, left.
    pub(super) fn clear(&self) {
        lock(&self.state).tasks.clear();
    }

    fn wake(&self, mut state: MutexGuard<'_, OnDesk<F, O>>) -> bool {
        let waits = std::mem::take(&mut state.worker_waits);
        if waits {
            state.woken = Some(Instant::now());
        }
        drop(state);
        if waits {
            self.changed.notify_one();
        }
        waits
    }

    /// Worker: the next task, or `None` if the desk is closed. Second, if it had to wait, how long waking it took.
    pub(super) fn task(&self) -> (Option<Task<F>>, Option<Duration>) {
        self.wait_for(|state| state.tasks.pop_front())
    }

    /// Worker: an empty parcel, or `None` if the desk is closed. Second, if it had to wait, how long waking it took.
    pub(super) fn parcel(&self) -> (Option<Box<Parcel<O>>>, Option<Duration>) {
        self.wait_for(|state| state.parcels.pop())
    }

    fn wait_for<T>(&self, take: impl Fn(&mut OnDesk<F, O>) -> Option<T>) -> (Option<T>, Option<Duration>) {
        let mut state = lock(&self.state);
        let mut waited = None;
        loop {
            // A closed desk is left at once: the master is gone, and so is the frame.
            if state.closed {
                return (None, waited);
            }
            if let Some(taken) = take(&mut state) {
                return (Some(taken), waited);
            }
            state.worker_waits = true;
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            state.worker_waits = false;
            waited = Some(state.woken.take().map_or(Duration::ZERO, |woken| woken.elapsed()));
        }
    }
}

/// What the workers sent to the master.
pub(super) struct Inbox<O> {
    state: Mutex<InInbox<O>>,
    changed: Condvar,
    /// Whether there are any that the master was woken for; for those who only want to know that.
    unread: AtomicBool,
}

struct InInbox<O> {
    reports: VecDeque<Report<O>>,
    master_waits: bool,
}

impl<O> Inbox<O> {
    pub(super) fn new() -> Inbox<O> {
        let state = InInbox { reports: VecDeque::new(), master_waits: false };
        Inbox { state: Mutex::new(state), changed: Condvar::new(), unread: AtomicBool::new(false) }
    }

    /// Worker: sends a report. One that the master does not wait for has no latency: it is not told when it was sent.
    pub(super) fn post(&self, mut report: Report<O>) {
        let mut state = lock(&self.state);
        if let Report::Parcel { sent, .. } = &mut report
            && !state.master_waits
        {
            *sent = None;
        }
        state.reports.push_back(report);
        self.notify(state);
    }

    /// Worker: lays down a report that can wait until the master is woken for another one, or wakes up by itself.
    pub(super) fn put(&self, report: Report<O>) {
        lock(&self.state).reports.push_back(report);
    }

    /// Worker: whatever was put down is worth reading now.
    pub(super) fn wake(&self) {
        let state = lock(&self.state);
        if !state.reports.is_empty() {
            self.notify(state);
        }
    }

    fn notify(&self, mut state: MutexGuard<'_, InInbox<O>>) {
        self.unread.store(true, Ordering::Relaxed);
        let waits = std::mem::take(&mut state.master_waits);
        drop(state);
        if waits {
            self.changed.notify_one();
        }
    }

    /// Master: waits until there is a report or `at_most` is over, and exchanges all reports for the empty `taken`.
    pub(super) fn take(&self, taken: &mut VecDeque<Report<O>>, at_most: Duration) {
        let mut state = lock(&self.state);
        if state.reports.is_empty() {
            state.master_waits = true;
            state = self.changed.wait_timeout(state, at_most).unwrap_or_else(PoisonError::into_inner).0;
            state.master_waits = false;
        }
        self.unread.store(false, Ordering::Relaxed);
        std::mem::swap(&mut state.reports, taken);
    }

    /// Worker: a master that has reports to read and waits for its turn on this CPU has it now.
    pub(super) fn let_master_read(&self) {
        if self.unread.load(Ordering::Relaxed) {
            yield_now();
        }
    }
}

/// No panic can leave these states half-changed, so poison means nothing here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
