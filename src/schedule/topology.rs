//! Which logical CPUs belong to the same physical core, as Linux tells it in `/sys/devices/system/cpu`.
//!
//! Two workers on one physical core share its vector units, so cores are filled one logical CPU at a time.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::str::FromStr;

/// CPU numbers above this are taken for garbage; today's Linux can be built for 8192.
const LARGEST_CPU: usize = 65_535;

/// The logical CPUs of each physical core.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Never empty, and no core is empty; ascending within a core and by the first CPU of each core.
    cores: Vec<Vec<usize>>,
}

impl Topology {
    /// Groups those `allowed` CPUs that are online, by the files under `root` (normally `/sys/devices/system/cpu`).
    /// Whatever is missing or unreadable there is made up for: a CPU about which nothing is known is a core of its
    /// own, and if nothing would be left, all of `allowed` is used.
    pub fn read(root: &Path, allowed: &[usize]) -> Topology {
        let online = read_list(&root.join("online"));
        let mut cores: BTreeMap<CoreKey, BTreeSet<usize>> = BTreeMap::new();
        for &cpu in allowed {
            let listed = online.as_ref().is_none_or(|list| list.contains(&cpu));
            let switched_off = read_number::<u8>(&root.join(format!("cpu{cpu}/online"))) == Some(0);
            if listed && !switched_off {
                cores.entry(core_of(root, cpu)).or_default().insert(cpu);
            }
        }
        let mut cores: Vec<Vec<usize>> = cores.into_values().map(|cpus| cpus.into_iter().collect()).collect();
        cores.sort();
        if cores.is_empty() { Topology::flat(allowed) } else { Topology { cores } }
    }

    /// Every CPU a core of its own: what is assumed where nothing is known.
    pub fn flat(cpus: &[usize]) -> Topology {
        let cpus: BTreeSet<usize> = cpus.iter().copied().collect();
        Topology { cores: cpus.into_iter().map(|cpu| vec![cpu]).collect() }
    }

    /// Number of physical cores.
    pub fn cores(&self) -> usize {
        self.cores.len()
    }

    /// All logical CPUs in the order in which workers should take them: one of every core, then a second one of
    /// every core that has two, and so on.
    pub fn spread(&self) -> Vec<usize> {
        let deepest = self.cores.iter().map(Vec::len).max().unwrap_or(0);
        (0..deepest).flat_map(|i| self.cores.iter().filter_map(move |cpus| cpus.get(i).copied())).collect()
    }
}

/// What the CPUs of one core have in common.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum CoreKey {
    /// The lowest CPU of the core, from the list of its siblings.
    Siblings(usize),
    /// Package and core number; core numbers repeat from package to package.
    Numbers(i64, i64),
    /// The CPU itself.
    Unknown(usize),
}

fn core_of(root: &Path, cpu: usize) -> CoreKey {
    let topology = root.join(format!("cpu{cpu}/topology"));
    // The second name is the older one.
    let siblings = ["core_cpus_list", "thread_siblings_list"]
        .iter()
        .filter_map(|name| read_list(&topology.join(name)))
        .find(|list| list.contains(&cpu));
    if let Some(&first) = siblings.as_ref().and_then(|list| list.first()) {
        return CoreKey::Siblings(first);
    }
    match (read_number(&topology.join("physical_package_id")), read_number(&topology.join("core_id"))) {
        (package, Some(core)) => CoreKey::Numbers(package.unwrap_or(0), core),
        _ => CoreKey::Unknown(cpu),
    }
}

fn read_number<N: FromStr>(path: &Path) -> Option<N> {
    fs::read_to_string(path).ok()?.trim().parse().ok()
}

fn read_list(path: &Path) -> Option<BTreeSet<usize>> {
    parse_list(&fs::read_to_string(path).ok()?)
}

/// Parses a CPU list such as `0-3,8,10-11`; `None` if it is anything else.
fn parse_list(text: &str) -> Option<BTreeSet<usize>> {
    let mut cpus = BTreeSet::new();
    for item in text.trim().split(',').filter(|item| !item.is_empty()) {
        let (first, last) = item.split_once('-').unwrap_or((item, item));
        let (first, last): (usize, usize) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
        if first > last || last > LARGEST_CPU {
            return None;
        }
        cpus.extend(first..=last);
    }
    Some(cpus)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    /// A made-up `/sys/devices/system/cpu`.
    struct Sysfs(TempDir);

    impl Sysfs {
        fn new() -> Sysfs {
            Sysfs(TempDir::new().unwrap())
        }

        fn file(self, name: &str, content: &str) -> Sysfs {
            let path = self.0.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
            self
        }

        fn spread(&self, allowed: &[usize]) -> Vec<usize> {
            Topology::read(self.0.path(), allowed).spread()
        }
    }

    #[test]
    fn with_smt_every_core_gets_one_worker_before_any_gets_two() {
        let sysfs = (0..4).fold(Sysfs::new().file("online", "0-7\n"), |sysfs, cpu| {
            let list = format!("{cpu},{}\n", cpu + 4);
            sysfs
                .file(&format!("cpu{cpu}/topology/thread_siblings_list"), &list)
                .file(&format!("cpu{}/topology/core_cpus_list", cpu + 4), &list)
        });
        let all = [0, 1, 2, 3, 4, 5, 6, 7];
        assert_eq!(sysfs.spread(&all), all);
        assert_eq!(Topology::read(sysfs.0.path(), &all).cores(), 4);
        assert_eq!(sysfs.spread(&[1, 2, 5]), [1, 2, 5]);
        assert_eq!(sysfs.spread(&[5, 6, 7]), [5, 6, 7]);
    }

    #[test]
    fn neighbouring_siblings_are_split_up() {
        let sysfs = [(0, "0-1"), (1, "0-1"), (2, "2-3"), (3, "2-3")]
            .iter()
            .fold(Sysfs::new(), |s, (cpu, list)| s.file(&format!("cpu{cpu}/topology/core_cpus_list"), list));
        assert_eq!(sysfs.spread(&[0, 1, 2, 3]), [0, 2, 1, 3]);
    }

    #[test]
    fn gaps_in_the_numbers_are_kept() {
        let sysfs = Sysfs::new().file("online", "0-15");
        assert_eq!(sysfs.spread(&[2, 4, 11]), [2, 4, 11]);
    }

    #[test]
    fn offline_cpus_are_left_out() {
        let sysfs = Sysfs::new().file("online", "0-1,3,5").file("cpu5/online", "0\n");
        assert_eq!(sysfs.spread(&[0, 1, 2, 3, 5]), [0, 1, 3]);
    }

    #[test]
    fn without_sibling_lists_package_and_core_number_decide() {
        let sysfs = [(0, 0, 0), (1, 0, 0), (2, 1, 0), (3, 1, 0)].iter().fold(
            Sysfs::new(),
            |s, (cpu, package, core)| {
                s.file(&format!("cpu{cpu}/topology/physical_package_id"), &format!("{package}\n"))
                    .file(&format!("cpu{cpu}/topology/core_id"), &format!("{core}\n"))
            },
        );
        assert_eq!(sysfs.spread(&[0, 1, 2, 3]), [0, 2, 1, 3]);
    }

    #[test]
    fn without_any_file_every_cpu_is_a_core() {
        let topology = Topology::read(Path::new("/nonexistent"), &[0, 1, 7]);
        assert_eq!((topology.cores(), topology.spread()), (3, vec![0, 1, 7]));
    }

    #[test]
    fn nonsense_in_the_files_is_ignored() {
        let sysfs = Sysfs::new()
            .file("online", "all of them")
            .file("cpu0/topology/core_cpus_list", "3-1")
            .file("cpu1/topology/core_cpus_list", "0-99999999999")
            .file("cpu2/topology/core_cpus_list", "0")
            .file("cpu3/topology/core_id", "x");
        assert_eq!(sysfs.spread(&[0, 1, 2, 3]), [0, 1, 2, 3]);
    }

    #[test]
    fn if_all_allowed_cpus_seem_offline_they_are_used_anyway() {
        assert_eq!(Sysfs::new().file("online", "8-9").spread(&[0, 1]), [0, 1]);
    }
}
