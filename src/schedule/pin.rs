//! Which CPU each worker is pinned to, and the pinning itself. The only file that names `core_affinity`.
//!
//! That crate asks for care: it reads the mask of the calling thread (so a pinned thread would see one CPU: we
//! read it once, before anything is pinned), its numbers may have gaps, a number above 1023 aborts the process,
//! and it tells by a `bool` whether the system agreed.

use super::topology::Topology;
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::OnceLock;
use std::thread;

/// The largest CPU number that fits `core_affinity`'s fixed mask.
const LARGEST_CPU: usize = 1023;

/// The CPUs this process may use.
#[derive(Clone, Debug)]
pub struct Machine {
    /// CPUs in the order in which workers take them.
    spread: Vec<usize>,
    /// Physical cores among them.
    cores: usize,
    /// CPUs' worth of time that affinity mask and cgroup quota grant, rounded down, at least 1.
    parallelism: usize,
}

impl Machine {
    /// The machine this runs on, looked at once: at the first call, which must not come from a pinned thread.
    pub fn get() -> &'static Machine {
        static MACHINE: OnceLock<Machine> = OnceLock::new();
        MACHINE.get_or_init(|| {
            let allowed: Vec<usize> =
                core_affinity::get_core_ids().unwrap_or_default().iter().map(|core| core.id).collect();
            let topology = Topology::read(Path::new("/sys/devices/system/cpu"), &allowed);
            if let Some(text) = gaps(&allowed) {
                log::info!("{text}");
            }
            // The standard library reads the cgroup quotas, of both versions and of every parent.
            Machine::new(&topology, thread::available_parallelism().map_or(1, usize::from))
        })
    }

    /// A machine with these CPUs and a quota of `parallelism` of them.
    pub fn new(topology: &Topology, parallelism: usize) -> Machine {
        Machine { spread: topology.spread(), cores: topology.cores(), parallelism: parallelism.max(1) }
    }

    /// Number of workers unless the user asks for another: one per physical core, but no more than the quota.
    pub fn default_workers(&self) -> usize {
        // Where the CPUs cannot be listed, there are none, and the quota alone is known.
        if self.cores == 0 { self.parallelism } else { self.cores.min(self.parallelism) }
    }

    /// Number of physical cores this process may use; 0 if unknown.
    pub fn cores(&self) -> usize {
        self.cores
    }
}

/// How many workers there are, and the CPU that each one should be pinned to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placement {
    slots: Vec<Option<usize>>,
    notes: Vec<String>,
}

impl Placement {
    /// `threads` workers (at least 1), or the machine's default. With `pin`, they take one CPU of every physical core
    /// first, then further CPUs of the same cores. Workers beyond the number of CPUs or beyond the quota stay unpinned: two
    /// workers pinned to one CPU could never be balanced by the system.
    pub fn new(machine: &Machine, threads: Option<usize>, pin: bool) -> Placement {
        let count = threads.unwrap_or_else(|| machine.default_workers()).max(1);
        let pinnable = if pin { machine.parallelism } else { 0 };
        let cpus = machine.spread.iter().copied().take(pinnable).map(Some);
        let slots = cpus.chain(std::iter::repeat(None)).take(count).collect();
        Placement { slots, notes: notes(machine, count, pin) }
    }

    /// What the user might not expect about where the workers run, a line each. Refused pins are not known here: see
    /// [`refusals`].
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Where the master of these workers disturbs them least: on the CPU of a worker that takes no part, else on that of
    /// the last one. `None` if there is none of either that is pinned.
    pub fn beside(&self, employed: Range<usize>) -> Option<usize> {
        let idle = self.slots.iter().enumerate().filter(|(worker, _)| !employed.contains(worker));
        let last = self.slots.get(..employed.end).and_then(|slots| slots.last().copied().flatten());
        idle.filter_map(|(_, &cpu)| cpu).next().or(last)
    }

    /// The CPU of each worker; `None` leaves it to the operating system.
    pub fn slots(&self) -> &[Option<usize>] {
        &self.slots
    }
}

/// Where a worker runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pinned {
    /// On this CPU only.
    Cpu(usize),
    /// Anywhere: the operating system refused to pin it to this CPU.
    Refused(usize),
    /// Anywhere, as it should.
    Free,
}

impl fmt::Display for Pinned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pinned::Cpu(cpu) => write!(f, "cpu {cpu}"),
            Pinned::Refused(cpu) => write!(f, "unpinned (cpu {cpu} refused)"),
            Pinned::Free => write!(f, "unpinned"),
        }
    }
}

fn notes(machine: &Machine, count: usize, pin: bool) -> Vec<String> {
    let Machine { ref spread, cores, parallelism } = *machine;
    let cpus = spread.len();
    let mut notes = vec![];
    if parallelism < cpus && (parallelism < cores || count > parallelism) {
        notes.push(format!(
            "the quota of this process is {parallelism} of its {cpus} CPUs: more workers gain nothing"
        ));
    }
    if count > cpus && cpus > 0 {
        let unpinned = if pin { " unpinned" } else { "" };
        notes.push(format!(
            "{count} workers share {cpus} CPUs: {} of them run{unpinned} in turns",
            count - cpus
        ));
    } else if count > cores && cores > 0 {
        notes.push(format!(
            "{} of {count} workers share a physical core with another one (SMT): they gain little",
            2 * (count - cores).min(cores)
        ));
    }
    if cpus == 0 && pin {
        notes.push("the CPUs of this machine cannot be listed: workers run unpinned".into());
    }
    notes
}

/// A line for each worker that the system did not let run where it should.
pub fn refusals(pinned: &[Pinned]) -> Vec<String> {
    let refused = |(worker, pinned): (usize, &Pinned)| match pinned {
        Pinned::Refused(cpu) => {
            Some(format!("the system refused CPU {cpu} to worker {worker}: it runs unpinned"))
        }
        _ => None,
    };
    pinned.iter().enumerate().filter_map(refused).collect()
}

/// Tells about a set of CPUs that leaves some out.
fn gaps(allowed: &[usize]) -> Option<String> {
    let (first, last) = (allowed.iter().min()?, allowed.iter().max()?);
    let whole = *first == 0 && last - first + 1 == allowed.len();
    let list = || allowed.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    (!whole).then(|| format!("this process may run on CPUs {} only", list()))
}

/// Pins the calling thread to `cpu`, if any.
pub fn pin_current_thread(cpu: Option<usize>) -> Pinned {
    let Some(id) = cpu else { return Pinned::Free };
    let done = id <= LARGEST_CPU && core_affinity::set_for_current(core_affinity::CoreId { id });
    if done { Pinned::Cpu(id) } else { Pinned::Refused(id) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn four_cores_with_smt() -> Machine {
        Machine { spread: vec![0, 2, 4, 6, 1, 3, 5, 7], cores: 4, parallelism: 8 }
    }

    #[test]
    fn by_default_there_is_one_pinned_worker_per_physical_core() {
        let placement = Placement::new(&four_cores_with_smt(), None, true);
        assert_eq!(placement.slots(), [Some(0), Some(2), Some(4), Some(6)]);
    }

    #[test]
    fn further_workers_take_the_siblings_and_the_rest_is_unpinned() {
        let placement = Placement::new(&four_cores_with_smt(), Some(10), true);
        assert_eq!(placement.slots()[3..6], [Some(6), Some(1), Some(3)]);
        assert_eq!(placement.slots()[7..], [Some(7), None, None]);
    }

    #[test]
    fn the_quota_bounds_the_default_and_the_pinning() {
        let machine = Machine { parallelism: 2, ..four_cores_with_smt() };
        assert_eq!(Placement::new(&machine, None, true).slots(), [Some(0), Some(2)]);
        assert_eq!(Placement::new(&machine, Some(3), true).slots(), [Some(0), Some(2), None]);
    }

    #[test]
    fn what_the_user_might_not_expect_is_told_in_one_line_each() {
        let notes = |machine: &Machine, threads| Placement::new(machine, threads, true).notes().to_vec();
        let smt = four_cores_with_smt();
        assert_eq!(notes(&smt, None), [""; 0]);
        assert_eq!(notes(&smt, Some(4)), [""; 0]);
        let shared = notes(&smt, Some(6));
        assert!(
            shared.len() == 1 && shared[0].starts_with("4 of 6 workers share a physical core"),
            "{shared:?}"
        );
        let crowd = notes(&smt, Some(64));
        assert!(crowd.len() == 1 && crowd[0].starts_with("64 workers share 8 CPUs: 56 of them"), "{crowd:?}");
        let quota = notes(&Machine { parallelism: 2, ..smt }, None);
        assert!(quota.len() == 1 && quota[0].contains("is 2 of its 8 CPUs"), "{quota:?}");
        let unknown = notes(&Machine::new(&Topology::flat(&[]), 3), None);
        assert!(unknown.len() == 1 && unknown[0].contains("cannot be listed"), "{unknown:?}");
        let refused = refusals(&[Pinned::Cpu(0), Pinned::Refused(7), Pinned::Free]);
        assert_eq!(refused, ["the system refused CPU 7 to worker 1: it runs unpinned"]);
    }

    #[test]
    fn a_set_of_cpus_with_gaps_is_told() {
        assert_eq!(gaps(&[0, 1, 2, 3]), None);
        assert_eq!(gaps(&[]), None);
        assert_eq!(gaps(&[2, 4, 11]).unwrap(), "this process may run on CPUs 2,4,11 only");
        assert!(gaps(&[1, 2]).is_some());
    }

    #[test]
    fn the_master_takes_a_core_without_a_worker_or_else_the_last_ones() {
        let placement = Placement::new(&four_cores_with_smt(), Some(4), true);
        assert_eq!(placement.beside(0..2), Some(4));
        assert_eq!(placement.beside(1..4), Some(0));
        assert_eq!(placement.beside(0..4), Some(6));
        assert_eq!(placement.beside(0..9), None);
        let free = Placement::new(&four_cores_with_smt(), Some(4), false);
        assert_eq!((free.beside(0..2), free.beside(0..4)), (None, None));
    }

    #[test]
    fn nobody_is_pinned_unless_asked_for() {
        assert_eq!(Placement::new(&four_cores_with_smt(), Some(2), false).slots(), [None, None]);
    }

    #[test]
    fn an_unknown_machine_still_gets_workers() {
        let machine = Machine::new(&Topology::flat(&[]), 3);
        assert_eq!(Placement::new(&machine, None, true).slots(), [None, None, None]);
    }

    #[test]
    fn a_cpu_number_too_large_for_the_mask_is_refused() {
        for cpu in [1024, usize::MAX] {
            let pinned = thread::spawn(move || pin_current_thread(Some(cpu))).join().unwrap();
            assert_eq!(pinned, Pinned::Refused(cpu));
        }
    }

    #[test]
    fn pinning_a_thread_leaves_the_list_of_cpus_as_it_was() {
        let before = Machine::get().spread.clone();
        let cpu = before.first().copied();
        thread::spawn(move || pin_current_thread(cpu)).join().unwrap();
        assert_eq!(Machine::get().spread, before);
    }
}
