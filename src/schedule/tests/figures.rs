//! What is told of messages.

use super::*;
use crate::schedule::mail::{Desk, Inbox};
use crate::schedule::message::{Parcel, Report};
use std::collections::VecDeque;
use std::time::Instant;

/// Whether it is found in one of many tries: another thread has to wait already, which nobody can see.
fn at_some_time(found: impl Fn() -> bool) -> bool {
    (0..200).any(|_| found())
}

#[test]
fn a_report_that_the_master_does_not_wait_for_has_no_latency() {
    let inbox: Inbox<()> = Inbox::new();
    let post =
        || inbox.post(Report::Parcel { worker: 0, parcel: Box::default(), sent: Some(Instant::now()) });
    let take = || {
        let mut taken = VecDeque::new();
        inbox.take(&mut taken, Duration::from_secs(100));
        matches!(taken.pop_front(), Some(Report::Parcel { sent: Some(_), .. }))
    };
    post();
    assert!(!take());
    assert!(at_some_time(|| {
        std::thread::scope(|scope| {
            let waits = scope.spawn(take);
            std::thread::sleep(Duration::from_millis(5));
            post();
            waits.join().unwrap()
        })
    }));
}

#[test]
fn who_finds_a_parcel_has_not_waited_and_who_waits_is_told_how_long_waking_took() {
    let desk: Desk<(), ()> = Desk::new();
    let lay = || desk.lay(Some(Box::<Parcel<()>>::default()), None);
    let pause = Duration::from_millis(50);
    lay();
    assert_eq!(desk.parcel().1, None);
    // Not the time before it was woken.
    assert!(at_some_time(|| {
        std::thread::scope(|scope| {
            let waits = scope.spawn(|| desk.parcel().1);
            std::thread::sleep(pause);
            lay();
            waits.join().unwrap().is_some_and(|latency| latency > Duration::ZERO && latency < pause)
        })
    }));
}

#[test]
fn each_workers_messages_are_told_and_so_is_the_masters_time_for_them() {
    in_time(|| {
        with_counting(3, |master| {
            for film in FilmMode::ALL {
                let schedule = Schedule { strategy: Strategy::Dynamic, film };
                let stats = check_frame(master, schedule, [128, 128], 8);
                let mut sum = Messages::default();
                for worker in &stats.workers {
                    sum.add(&worker.reports);
                    assert!(worker.reports.count >= worker.tiles, "{worker:?}");
                    // Each tile's answer is waited for; not all of these are told of.
                    assert!(worker.answers.awaited <= 2 * worker.tiles + 2, "{worker:?}");
                }
                let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
                assert!(close(sum.latency_sum, stats.reports.latency_sum), "{stats:?}");
                assert_eq!((sum.count, sum.awaited), (stats.reports.count, stats.reports.awaited));
                assert!(stats.workers.iter().any(|worker| worker.answers.awaited > 0), "{stats:?}");
                let handled: f64 = stats.workers.iter().map(|worker| worker.handled).sum();
                assert!(handled > 0.0 && handled <= stats.master.reports, "{stats:?}");
                assert!(stats.workers.iter().all(|worker| worker.woken <= worker.handled), "{stats:?}");
                assert!(stats.workers.iter().any(|worker| worker.woken > 0.0), "{stats:?}");
            }
            Ok(())
        })
        .unwrap();
    });
}
