//! Messages to a thread that shares its core with one who computes.

use crate::schedule::mail::{Desk, Inbox};
use crate::schedule::message::Report;
use crate::schedule::pin::{Pinned, pin_current_thread};
use crate::schedule::policy::compute_in_batches;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// How long everybody computes between two messages.
const BETWEEN: Duration = Duration::from_micros(150);
/// A message is late if it was not read after so many seconds: several times what waking takes, and a part of any time slice.
pub(super) const LATE: f64 = 3e-4;
/// Bytes that whoever computes walks through: about as many as a tile does, far more than the innermost cache.
const MEMORY: usize = 2 << 20;
/// Bytes between two looks at the clock, a microsecond or two.
const STRIDE: usize = 8 << 10;

/// What is done with a message.
pub trait Load: Sync {
    /// By its sender, 0 or 1, before it is sent.
    fn fill(&self, _sender: usize) {}

    /// By who gets it.
    fn take(&self, sender: usize);
}

/// As long as that.
impl Load for Duration {
    fn take(&self, _sender: usize) {
        let start = Instant::now();
        while start.elapsed() < *self {}
    }
}

/// Who sends.
const THEIRS: usize = 0;
const OWN: usize = 1;

/// A message and its answer, in seconds.
pub(super) struct Trip {
    pub(super) send: f64,
    pub(super) latency: f64,
    pub(super) work: f64,
    pub(super) reply: f64,
    pub(super) back: f64,
    /// From the beginning of sending until the sender goes on.
    pub(super) wait: f64,
    /// The longest time for which who computes on the core stood still, but for its own messages.
    pub(super) gap: f64,
    /// The reader had nothing to do when the message came, ...
    pub(super) asleep: bool,
    /// ... nor from the other sender until it was answered.
    pub(super) alone: bool,
}

impl Trip {
    pub(super) fn is_usual(&self) -> bool {
        self.asleep && self.alone && self.latency <= LATE
    }
}

/// When the reader did what for a sender's last message, in nanoseconds; 0 if it has not.
#[derive(Default)]
struct Times {
    read: AtomicU64,
    done: AtomicU64,
    answered: AtomicU64,
}

pub(super) struct Bench<'a> {
    load: &'a dyn Load,
    /// Whoever sends sleeps until the answer comes.
    waits: bool,
    inbox: Inbox<()>,
    desks: [Desk<(), ()>; 2],
    origin: Instant,
    over: AtomicBool,
    times: [Times; 2],
    /// Messages begun and ended by the reader.
    begun: AtomicU64,
    ended: AtomicU64,
    /// Of [`Trip::gap`], in nanoseconds.
    gap: AtomicU64,
    memory: Vec<u64>,
}

impl<'a> Bench<'a> {
    pub(super) fn new(load: &'a dyn Load, waits: bool) -> Bench<'a> {
        Bench {
            load,
            waits,
            inbox: Inbox::new(),
            desks: [Desk::new(), Desk::new()],
            origin: Instant::now(),
            over: AtomicBool::new(false),
            times: Default::default(),
            begun: AtomicU64::new(0),
            ended: AtomicU64::new(0),
            gap: AtomicU64::new(0),
            memory: (0..MEMORY as u64 / 8).collect(),
        }
    }

    fn now(&self) -> u64 {
        self.origin.elapsed().as_nanos() as u64
    }

    /// Messages from the other core, and of the one that computes on the reader's.
    pub(super) fn messages(
        &self,
        rounds: usize,
        core: usize,
        other: usize,
    ) -> Option<(Vec<Trip>, Vec<Trip>)> {
        let pinned = |cpu| matches!(pin_current_thread(Some(cpu)), Pinned::Cpu(_));
        let read = || {
            let done = pinned(core).then(|| self.read());
            // Whoever still waits for an answer.
            self.desks.iter().for_each(Desk::close);
            done
        };
        let worker = |cpu| {
            compute_in_batches();
            pinned(cpu)
        };
        std::thread::scope(|scope| {
            let reader = scope.spawn(read);
            let own = scope.spawn(|| worker(core).then(|| self.compute()));
            let send = || {
                let mut place = 0;
                worker(other).then(|| (0..rounds).map_while(|_| self.send(&mut place)).collect())
            };
            let theirs = scope.spawn(send).join().ok().flatten();
            self.over.store(true, Relaxed);
            // So that the reader sees it.
            self.inbox.post(Report::Lost { worker: OWN });
            let own = own.join().ok().flatten().filter(|own| !own.is_empty());
            reader.join().ok().flatten().and(theirs.zip(own))
        })
    }

    fn read(&self) {
        let mut taken = VecDeque::new();
        while !self.over.load(Relaxed) {
            self.inbox.take(&mut taken, Duration::from_millis(100));
            for message in taken.drain(..) {
                let Report::Parcel { worker, parcel, .. } = message else { continue };
                self.begun.fetch_add(1, Relaxed);
                let times = &self.times[worker];
                times.read.store(self.now(), Relaxed);
                self.load.take(worker);
                times.done.store(self.now(), Relaxed);
                self.desks[worker].lay(Some(parcel), None);
                times.answered.store(self.now(), Relaxed);
                self.ended.fetch_add(1, Relaxed);
            }
        }
    }

    /// Computes and sends, until it is over.
    fn compute(&self) -> Vec<Trip> {
        let mut own = vec![];
        let mut last = self.now();
        let mut next = last;
        let mut place = 0;
        while !self.over.load(Relaxed) {
            self.walk(&mut place);
            let now = self.now();
            self.gap.fetch_max(now - last, Relaxed);
            last = now;
            if now > next {
                self.load.fill(OWN);
                let Some(trip) = self.trip(OWN) else { break };
                own.push(trip);
                last = self.now();
                next = last + BETWEEN.as_nanos() as u64;
            }
        }
        own
    }

    fn send(&self, place: &mut usize) -> Option<Trip> {
        let end = self.now() + BETWEEN.as_nanos() as u64;
        while self.now() < end {
            self.walk(place);
        }
        self.load.fill(THEIRS);
        self.gap.store(0, Relaxed);
        let trip = self.trip(THEIRS)?;
        // Until who was interrupted computes again.
        self.wait_for(BETWEEN / 4);
        Some(Trip { gap: self.gap.load(Relaxed) as f64 * 1e-9, ..trip })
    }

    /// Sends a message. `None` if it is over.
    fn trip(&self, sender: usize) -> Option<Trip> {
        let times = &self.times[sender];
        for time in [&times.read, &times.done, &times.answered] {
            time.store(0, Relaxed);
        }
        let (begun, ended) = (self.begun.load(Relaxed), self.ended.load(Relaxed));
        let parcel = Box::default();
        let sent = self.now();
        self.inbox.post(Report::Parcel { worker: sender, parcel, sent: None });
        let posted = self.now();
        while !self.waits && times.answered.load(Relaxed) == 0 {
            if self.over.load(Relaxed) {
                return None;
            }
        }
        self.desks[sender].parcel().0?;
        let back = self.now();
        // The reader's own clock may be a moment behind on the other core; on the same one it waits for this to end.
        while sender == THEIRS && times.answered.load(Relaxed) == 0 && !self.over.load(Relaxed) {}
        let [read, done, answered] =
            [&times.read, &times.done, &times.answered].map(|time| time.load(Relaxed));
        let seconds = |from: u64, to: u64| (to as f64 - from as f64) * 1e-9;
        Some(Trip {
            send: seconds(sent, posted),
            // On the same core, the reader may be done before the sender goes on.
            latency: seconds(posted, read.max(posted)),
            work: seconds(read, done),
            reply: seconds(done, answered),
            back: seconds(answered.max(posted), back),
            wait: seconds(sent, back),
            gap: 0.0,
            asleep: begun == ended,
            alone: self.begun.load(Relaxed) == begun + 1,
        })
    }

    /// Reads the next bit of memory.
    fn walk(&self, place: &mut usize) {
        let end = *place + STRIDE / 8;
        std::hint::black_box(
            self.memory[*place..end].iter().fold(0, |sum: u64, value| sum.wrapping_add(*value)),
        );
        *place = if end == self.memory.len() { 0 } else { end };
    }

    fn wait_for(&self, time: Duration) {
        let end = self.now() + time.as_nanos() as u64;
        while self.now() < end {}
    }
}
