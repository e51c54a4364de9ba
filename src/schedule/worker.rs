//! The worker's side of the protocol.

use super::TileTask;
use super::mail::{Desk, Inbox};
use super::message::{Item, Parcel, Report, Shared, Task, Unfinished, Wait, Work};
use super::pin::pin_current_thread;
use crate::tile::Tile;
use crossbeam_deque::{Steal, Stealer, Worker as Deque};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Results are sent at the latest after this long, so that people see progress.
const LONGEST_SILENCE: Duration = Duration::from_millis(50);

/// Serves tasks until the desk closes. Never panics: a panic outside of the task is told as a lost worker.
pub(super) fn work<T: TileTask>(
    task: &T,
    worker: usize,
    cpu: Option<usize>,
    desk: &Desk<T::Frame, T::Output>,
    inbox: &Inbox<T::Output>,
) {
    let served = guarded(|| {
        let pinned = pin_current_thread(cpu);
        // After pinning, so that the memory is first touched, and thus placed, where it will be used.
        let scratch = guarded(|| task.scratch(worker)).ok();
        inbox.post(Report::Ready { worker, pinned });
        let now = Instant::now();
        let log = Log { waits: vec![], steals: 0, last_post: now };
        Hand { task, worker, desk, inbox, scratch, frame: 0, parcel: None, log }.serve();
    });
    if served.is_err() {
        inbox.post(Report::Lost { worker });
    }
}

/// One worker at work.
struct Hand<'a, T: TileTask> {
    task: &'a T,
    worker: usize,
    desk: &'a Desk<T::Frame, T::Output>,
    inbox: &'a Inbox<T::Output>,
    /// `None` after a panic, until the next tile.
    scratch: Option<T::Scratch>,
    /// Number of the frame that it is on.
    frame: usize,
    /// The one being filled.
    parcel: Option<Box<Parcel<T::Output>>>,
    log: Log,
}

/// What is told with the next parcel.
struct Log {
    waits: Vec<Wait>,
    steals: usize,
    last_post: Instant,
}

impl<T: TileTask> Hand<'_, T> {
    fn serve(&mut self) {
        loop {
            let start = Instant::now();
            let (task, waited) = self.desk.task();
            let Some(Task { shared, work, unfinished }) = task else { return };
            if let Some(latency) = waited {
                self.log.waits.push(Wait { start, end: Instant::now(), deliver: false, latency });
            }
            self.log.last_post = Instant::now();
            self.frame = shared.number;
            let failure = match &work {
                Work::Run(run) => self.run(&shared, &mut run.places()),
                Work::Share(deque) => {
                    let (worker, mut steals) = (self.worker, 0);
                    let mut places =
                        std::iter::from_fn(|| next_or_stolen(worker, deque, &shared.stealers, &mut steals));
                    let failure = self.run(&shared, &mut places);
                    self.log.steals += steals;
                    failure
                }
            };
            // Before the report: when the master has all of a frame's reports, that must be its own again.
            drop(shared);
            if self.hold_parcel().is_none() {
                return;
            }
            if let Some(parcel) = &mut self.parcel {
                parcel.finished = true;
                parcel.failure = failure;
                parcel.deque = match work {
                    Work::Run(_) => None,
                    Work::Share(deque) => Some(deque),
                };
            }
            match unfinished {
                Some(unfinished) => self.tell_if_last(&unfinished),
                None => self.post(),
            }
        }
    }

    /// Sends the last parcel of a task, and wakes the master if it was the last task of its frame, or failed.
    fn tell_if_last(&mut self, unfinished: &Unfinished) {
        let Some(parcel) = self.take_parcel() else { return };
        let failed = parcel.failure.is_some();
        self.inbox.put(Report::Parcel { worker: self.worker, parcel, sent: None });
        // In this order: whoever finds that it was the last one knows that all the others' reports lie there.
        if unfinished.finish(1) || failed {
            self.inbox.wake();
        }
    }

    /// Runs these tiles until the frame stops. Returns the tile that panicked, if one did.
    fn run(
        &mut self,
        shared: &Shared<T::Frame>,
        places: &mut dyn Iterator<Item = usize>,
    ) -> Option<(Tile, String)> {
        let mut next = places.next();
        while let Some(place) = next {
            self.inbox.let_master_read();
            // A closed desk ends the task; `serve` sees it, too.
            let item = self.next_item(place)?;
            // After the wait for a parcel, which may have been long.
            if shared.stop.load(Ordering::Relaxed) {
                return None;
            }
            let tile = shared.tiles[place];
            if let Err(message) = self.run_tile(&shared.frame, tile, item) {
                shared.stop.store(true, Ordering::Relaxed);
                return Some((tile, message));
            }
            next = places.next();
            // The last ones go with the news that the task is finished.
            if next.is_some() && (shared.each_tile || self.has_been_silent()) {
                self.post();
            }
        }
        None
    }

    fn run_tile(&mut self, frame: &T::Frame, tile: Tile, item: usize) -> Result<(), String> {
        let Some(parcel) = &mut self.parcel else { return Ok(()) };
        let Item { start, end, output, .. } = &mut parcel.items[item];
        *start = Instant::now();
        let outcome = guarded(|| {
            let scratch = self.scratch.get_or_insert_with(|| self.task.scratch(self.worker));
            self.task.run(frame, tile, scratch, output);
        });
        *end = Instant::now();
        match outcome {
            Ok(()) => parcel.used += 1,
            Err(_) => {
                // The panic may have left them half-changed.
                let _ = guarded(|| self.scratch = None);
                let _ = guarded(|| parcel.items.truncate(parcel.used));
            }
        }
        outcome
    }

    /// Index of the item to fill next.
    fn next_item(&mut self, place: usize) -> Option<usize> {
        let parcel = self.hold_parcel()?;
        if let Some(item) = parcel.items.get_mut(parcel.used) {
            item.place = place;
        } else {
            let now = Instant::now();
            parcel.items.push(Item { place, start: now, end: now, output: T::Output::default() });
        }
        Some(parcel.used)
    }

    /// Waits for a parcel unless one is held.
    fn hold_parcel(&mut self) -> Option<&mut Box<Parcel<T::Output>>> {
        if self.parcel.is_none() {
            let start = Instant::now();
            let (parcel, waited) = self.desk.parcel();
            if let Some(latency) = waited {
                self.log.waits.push(Wait { start, end: Instant::now(), deliver: true, latency });
            }
            self.parcel = parcel;
        }
        self.parcel.as_mut()
    }

    fn has_been_silent(&self) -> bool {
        let end =
            self.parcel.as_ref().and_then(|parcel| parcel.items[..parcel.used].last()).map(|item| item.end);
        end.is_some_and(|end| end.saturating_duration_since(self.log.last_post) > LONGEST_SILENCE)
    }

    /// Sends the parcel held, if any.
    fn post(&mut self) {
        let Some(parcel) = self.take_parcel() else { return };
        let sent = Some(self.log.last_post);
        self.inbox.post(Report::Parcel { worker: self.worker, parcel, sent });
    }

    /// The parcel held, ready to be sent.
    fn take_parcel(&mut self) -> Option<Box<Parcel<T::Output>>> {
        let mut parcel = self.parcel.take()?;
        parcel.frame = self.frame;
        parcel.waits.append(&mut self.log.waits);
        parcel.steals = std::mem::take(&mut self.log.steals);
        self.log.last_post = Instant::now();
        Some(parcel)
    }
}

/// The next tile of the worker's own deque; if that is empty, half of the fullest one moves there. `None` if all are
/// empty: what another worker is just moving is that worker's.
fn next_or_stolen(
    worker: usize,
    own: &Deque<usize>,
    stealers: &[Stealer<usize>],
    steals: &mut usize,
) -> Option<usize> {
    if let Some(place) = own.pop() {
        return Some(place);
    }
    loop {
        let others = stealers.iter().enumerate().filter(|&(other, _)| other != worker);
        let (rest, victim) =
            others.map(|(_, stealer)| (stealer.len(), stealer)).max_by_key(|&(rest, _)| rest)?;
        if rest == 0 {
            return None;
        }
        // Without a limit of the crate's: it takes half.
        if let Steal::Success(place) = victim.steal_batch_with_limit_and_pop(own, usize::MAX) {
            *steals += 1;
            return Some(place);
        }
    }
}

/// Calls `f`; a panic becomes its message. Callers drop whatever a panic may have left inconsistent.
fn guarded<R>(f: impl FnOnce() -> R) -> Result<R, String> {
    catch_unwind(AssertUnwindSafe(f)).map_err(|payload| {
        let message = message_of(payload.as_ref());
        // Even a payload can panic when it is dropped; the second one is leaked.
        if let Err(again) = catch_unwind(AssertUnwindSafe(|| drop(payload))) {
            std::mem::forget(again);
        }
        message
    })
}

fn message_of(payload: &(dyn Any + Send)) -> String {
    match (payload.downcast_ref::<&str>(), payload.downcast_ref::<String>()) {
        (Some(text), _) => (*text).to_string(),
        (_, Some(text)) => text.clone(),
        _ => "a panic without a message".to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thief_takes_half_of_the_fullest_deque_from_its_front() {
        let deques: Vec<Deque<usize>> = (0..4).map(|_| Deque::new_fifo()).collect();
        (0..3).for_each(|place| deques[1].push(place));
        (10..20).for_each(|place| deques[2].push(place));
        let stealers: Vec<Stealer<usize>> = deques.iter().map(Deque::stealer).collect();
        let mut steals = 0;
        let mut next = || next_or_stolen(0, &deques[0], &stealers, &mut steals);
        assert_eq!([(); 5].map(|()| next()), [10, 11, 12, 13, 14].map(Some));
        assert_eq!(deques.iter().map(Deque::len).collect::<Vec<_>>(), [0, 3, 5, 0]);
        assert_eq!(std::iter::from_fn(next).collect::<Vec<_>>(), [15, 16, 17, 0, 1, 18, 19, 2]);
    }
}
