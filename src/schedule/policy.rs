//! How the system treats threads that compute. The only file that names `thread_priority`.

/// Tells the system that the calling thread computes for long stretches (`SCHED_BATCH` on Linux, elsewhere nothing): when it is
/// woken, whoever runs on its CPU goes on. It gets no less time. Without this a worker that is woken by a master on its own CPU
/// mostly takes the place of that master, who has answers for others left: they wait for as long as a tile takes.
pub(super) fn compute_in_batches() {
    #[cfg(target_os = "linux")]
    if let Err(why) = linux::compute_in_batches() {
        log::debug!("a thread keeps its scheduling policy: {why}");
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use thread_priority::unix::{set_thread_priority_and_policy, thread_native_id};
    use thread_priority::{
        NormalThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    };

    pub(super) fn compute_in_batches() -> Result<(), String> {
        let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Batch);
        // The crate sets the niceness, too: to what it is.
        let stat = std::fs::read_to_string("/proc/thread-self/stat").map_err(|error| error.to_string())?;
        let nice = niceness(&stat).ok_or("its niceness is not known")?;
        let keeps = |priority: &ThreadPriority| priority.to_posix(policy).is_ok_and(|set| set == nice);
        let all = (0..=99).filter_map(|value| ThreadPriorityValue::try_from(value).ok());
        let priority =
            all.map(ThreadPriority::Crossplatform).find(keeps).ok_or("no priority keeps its niceness")?;
        set_thread_priority_and_policy(thread_native_id(), priority, policy)
            .map_err(|error| format!("{error:?}"))
    }

    /// The 19th field; the second one is a name in brackets, which may hold anything.
    fn niceness(stat: &str) -> Option<i32> {
        stat.rsplit_once(')')?.1.split_whitespace().nth(16)?.parse().ok()
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use crate::schedule::{Control, Machine, Placement, Schedule, TileTask, with_workers};
        use crate::tile::{Order, Tile, tiles};
        use thread_priority::unix::thread_schedule_policy;

        const BATCH: ThreadSchedulePolicy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Batch);
        const OTHER: ThreadSchedulePolicy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);

        /// Some sandboxes refuse it, and then nothing changes.
        fn refused() -> bool {
            std::thread::spawn(|| compute_in_batches().is_err()).join().unwrap()
        }

        /// Tells whether a batch runs it.
        struct IsBatch;

        impl TileTask for IsBatch {
            type Frame = ();
            type Scratch = ();
            type Output = bool;

            fn scratch(&self, _worker: usize) {}

            fn run(&self, (): &(), _tile: Tile, (): &mut (), is_batch: &mut bool) {
                *is_batch = thread_schedule_policy() == Ok(BATCH);
            }
        }

        #[test]
        fn workers_are_batches_and_the_master_is_none() {
            let placement = Placement::new(Machine::get(), Some(2), true);
            let mut batches = 0;
            with_workers(&IsBatch, &placement, |master| {
                let count = |(): &(), _, is_batch: &mut bool| batches += u32::from(*is_batch);
                let tiles = tiles(8, 8, 2, Order::Hilbert);
                master.run_frame(Schedule::default(), (), &tiles, &Control::unattended(), count)
            })
            .unwrap();
            let expected = if refused() { 0 } else { 16 };
            assert_eq!((batches, thread_schedule_policy()), (expected, Ok(OTHER)));
        }

        #[test]
        fn a_thread_that_computes_is_a_batch_and_as_nice_as_before() {
            if refused() {
                return;
            }
            let stat = || std::fs::read_to_string("/proc/thread-self/stat").unwrap();
            let nice = niceness(&stat()).unwrap();
            std::thread::spawn(move || {
                assert_eq!(thread_schedule_policy(), Ok(OTHER));
                compute_in_batches().unwrap();
                assert_eq!(thread_schedule_policy(), Ok(BATCH));
                assert_eq!(niceness(&stat()), Some(nice));
                // A nicer one stays as nice as it is.
                let nicer = ThreadPriority::Min;
                set_thread_priority_and_policy(thread_native_id(), nicer, OTHER).unwrap();
                let nicer = niceness(&stat()).unwrap();
                assert!(nicer >= nice);
                compute_in_batches().unwrap();
                assert_eq!((thread_schedule_policy(), niceness(&stat())), (Ok(BATCH), Some(nicer)));
            })
            .join()
            .unwrap();
            assert_eq!(thread_schedule_policy(), Ok(OTHER), "of others nothing changes");
        }

        #[test]
        fn niceness_is_found_whatever_the_name_is() {
            let line = "12 (a) b (c) S 1 12 12 0 -1 4194304 1 2 3 4 5 6 7 8 20 -5 1 0 99 0 0";
            assert_eq!(niceness(line), Some(-5));
            assert_eq!(niceness("12 (a) S 1"), None);
        }
    }
}
