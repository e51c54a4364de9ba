//! Messages to a thread that shares its core with one who computes.

use super::Load;
use crate::schedule::TileTask;
use crate::schedule::mail::{Desk, Inbox};
use crate::schedule::message::{Item, Parcel, Report};
use crate::schedule::pin::{Pinned, pin_current_thread};
use crate::schedule::policy::compute_in_batches;
use crate::schedule::stats::LATE;
use crate::tile::Tile;
use std::collections::VecDeque;
use std::hint::spin_loop;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Where tiles take long, there are fewer messages.
const LONGEST: Duration = Duration::from_secs(1);

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
    /// The longest time for which who computes on the core stood still, if it looked at the clock.
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

/// Three threads: the reader, and two that run tiles and send each one's output. As soon as one of them ends, all do.
pub(super) struct Bench<'a, T: TileTask> {
    load: &'a Load<'a, T>,
    /// Whoever sends sleeps until the answer comes.
    waits: bool,
    inbox: Inbox<T::Output>,
    desks: [Desk<T::Frame, T::Output>; 2],
    origin: Instant,
    over: AtomicBool,
    times: [Times; 2],
    /// Messages begun and ended by the reader.
    begun: AtomicU64,
    ended: AtomicU64,
    /// The place of the next tile.
    next: AtomicUsize,
    /// Who computes on the reader's core looks at the clock instead, ...
    watches: AtomicBool,
    /// ... so many times so far, ...
    looks: AtomicU64,
    /// ... at most so many nanoseconds apart.
    gap: AtomicU64,
}

impl<'a, T: TileTask> Bench<'a, T> {
    /// Begins with the tile at `first`.
    pub(super) fn new(load: &'a Load<'a, T>, first: usize, waits: bool) -> Bench<'a, T> {
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
            next: AtomicUsize::new(first),
            watches: AtomicBool::new(false),
            looks: AtomicU64::new(0),
            gap: AtomicU64::new(0),
        }
    }

    fn now(&self) -> u64 {
        self.origin.elapsed().as_nanos() as u64
    }

    fn is_over(&self) -> bool {
        self.over.load(Relaxed)
    }

    /// The place of the tile after the last one.
    pub(super) fn next(&self) -> usize {
        self.next.load(Relaxed)
    }

    /// At most so many messages from the other core, and those of the one that computes on the reader's. `None` if a thread
    /// could not be pinned, or a tile panicked.
    pub(super) fn messages(&self, most: usize, [other, core]: [usize; 2]) -> Option<(Vec<Trip>, Vec<Trip>)> {
        let pinned = |cpu| matches!(pin_current_thread(Some(cpu)), Pinned::Cpu(_));
        let worker = |cpu| {
            compute_in_batches();
            pinned(cpu)
        };
        let reader = || {
            let _leave = Leave(self);
            pinned(core).then(|| self.read())
        };
        let own = || {
            let _leave = Leave(self);
            worker(core).then(|| self.compute())
        };
        let theirs = || {
            let _leave = Leave(self);
            worker(other).then(|| self.send(most))
        };
        std::thread::scope(|scope| {
            let (reader, own, theirs) = (scope.spawn(reader), scope.spawn(own), scope.spawn(theirs));
            let (reader, own, theirs) = (reader.join(), own.join(), theirs.join());
            reader.ok().flatten()?;
            theirs.ok().flatten().zip(own.ok().flatten())
        })
    }

    fn read(&self) {
        let mut taken = VecDeque::new();
        while !self.is_over() {
            self.inbox.take(&mut taken, Duration::from_millis(100));
            for message in taken.drain(..) {
                let Report::Parcel { worker, mut parcel, .. } = message else { continue };
                self.begun.fetch_add(1, Relaxed);
                let times = &self.times[worker];
                times.read.store(self.now(), Relaxed);
                for item in &mut parcel.items[..parcel.used] {
                    let (frame, tile) = self.load.at(item.place);
                    (self.load.collect)(frame, tile, &mut item.output);
                }
                times.done.store(self.now(), Relaxed);
                parcel.empty();
                self.desks[worker].lay(Some(parcel), None);
                times.answered.store(self.now(), Relaxed);
                self.ended.fetch_add(1, Relaxed);
            }
        }
    }

    /// Runs tiles and sends, until it is over.
    fn compute(&self) -> Vec<Trip> {
        let mut sender = Sender::new(self, OWN);
        let mut own = vec![];
        while !self.is_over() {
            sender.run_tile();
            let Some(trip) = sender.trip() else { break };
            own.push(trip);
            if self.waits {
                sender.run_half();
                self.watch();
            }
        }
        own
    }

    /// Looks at the clock until the other sender has its answer. That leaves in the caches what the last tile left there, and
    /// shows to the microsecond for how long the reader took the core.
    fn watch(&self) {
        let mut last = self.now();
        self.watches.store(true, Relaxed);
        while self.watches.load(Relaxed) && !self.is_over() {
            let now = self.now();
            self.gap.fetch_max(now - last, Relaxed);
            self.looks.fetch_add(1, Relaxed);
            last = now;
        }
    }

    fn send(&self, most: usize) -> Vec<Trip> {
        let mut sender = Sender::new(self, THEIRS);
        let mut theirs = vec![];
        let is_time = |sent: usize| sent == 0 || self.origin.elapsed() < LONGEST;
        while theirs.len() < most && is_time(theirs.len()) {
            sender.run_tile();
            while self.waits && !self.watches.load(Relaxed) && !self.is_over() {
                spin_loop();
            }
            self.gap.store(0, Relaxed);
            let Some(trip) = sender.trip() else { break };
            theirs.push(Trip { gap: self.watched(), ..trip });
        }
        theirs
    }

    /// For how many seconds who watches stood still; it ends watching.
    fn watched(&self) -> f64 {
        let looks = self.looks.load(Relaxed);
        while self.waits && self.looks.load(Relaxed) < looks + 2 && !self.is_over() {
            spin_loop();
        }
        self.watches.store(false, Relaxed);
        self.gap.load(Relaxed) as f64 * 1e-9
    }
}

/// A thread of the bench: nobody waits for it when it has gone, whatever the reason.
struct Leave<'b, 'a, T: TileTask>(&'b Bench<'a, T>);

impl<T: TileTask> Drop for Leave<'_, '_, T> {
    fn drop(&mut self) {
        self.0.over.store(true, Relaxed);
        self.0.desks.iter().for_each(Desk::close);
        // So that the reader sees it.
        self.0.inbox.post(Report::Lost { worker: OWN });
    }
}

struct Sender<'b, 'a, T: TileTask> {
    bench: &'b Bench<'a, T>,
    number: usize,
    scratch: T::Scratch,
    /// Empty, or the last tile's output.
    parcel: Box<Parcel<T::Output>>,
}

impl<'b, 'a, T: TileTask> Sender<'b, 'a, T> {
    fn new(bench: &'b Bench<'a, T>, number: usize) -> Sender<'b, 'a, T> {
        Sender { bench, number, scratch: bench.load.task.scratch(number), parcel: Box::default() }
    }

    /// Runs a tile.
    fn run_tile(&mut self) {
        self.run(self.bench.next.fetch_add(1, Relaxed), |tile| tile);
    }

    /// Runs the upper half of a tile.
    fn run_half(&mut self) {
        let half = |tile: Tile| Tile { height: tile.height.div_ceil(2), ..tile };
        self.run(self.bench.next.load(Relaxed), half);
    }

    fn run(&mut self, place: usize, part: impl Fn(Tile) -> Tile) {
        let Sender { bench, scratch, parcel, .. } = self;
        if parcel.items.is_empty() {
            let now = Instant::now();
            parcel.items.push(Item { place, start: now, end: now, output: T::Output::default() });
        }
        parcel.used = 1;
        let item = &mut parcel.items[0];
        item.place = place;
        let (frame, tile) = bench.load.at(place);
        bench.load.task.run(frame, part(tile), scratch, &mut item.output);
    }

    /// Sends the last tile's output. `None` if it is over.
    fn trip(&mut self) -> Option<Trip> {
        let (bench, sender) = (self.bench, self.number);
        let times = &bench.times[sender];
        for time in [&times.read, &times.done, &times.answered] {
            time.store(0, Relaxed);
        }
        let (begun, ended) = (bench.begun.load(Relaxed), bench.ended.load(Relaxed));
        let parcel = std::mem::take(&mut self.parcel);
        let sent = bench.now();
        bench.inbox.post(Report::Parcel { worker: sender, parcel, sent: None });
        let posted = bench.now();
        while !bench.waits && times.answered.load(Relaxed) == 0 {
            if bench.is_over() {
                return None;
            }
        }
        self.parcel = bench.desks[sender].parcel().0?;
        let back = bench.now();
        // The reader's own clock may be a moment behind on the other core; on the same one it waits for this to end.
        while sender == THEIRS && times.answered.load(Relaxed) == 0 && !bench.is_over() {}
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
            alone: bench.begun.load(Relaxed) == begun + 1,
        })
    }
}
