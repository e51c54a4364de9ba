//! Tables 2 to 5 of the thesis: frames per second and efficiency of each strategy on a cluster of 8 quad-core Xeons with a
//! 10 Gb/s network, median of 10 runs.

use crate::schedule::Strategy;

/// `scene,strategy,workers,fps,efficiency`, efficiency as a fraction and absent for one worker; `#` begins a comment.
const TABLES: &str = include_str!("thesis.csv");

/// What the thesis reports for one cell of its tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThesisFigure {
    /// Frames per second.
    pub fps: f64,
    /// T1 / (n Tn); `None` for one worker.
    pub efficiency: Option<f64>,
}

/// The thesis' figure; `None` where it has none.
pub(super) fn thesis_figure(scene: &str, strategy: Strategy, workers: usize) -> Option<ThesisFigure> {
    TABLES.lines().filter(|line| !line.starts_with('#')).find_map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let &[name, by, count, fps, efficiency] = cells.as_slice() else { return None };
        let matches = name == scene && by == strategy.name() && count.parse() == Ok(workers);
        matches
            .then(|| fps.parse().ok())?
            .map(|fps| ThesisFigure { fps, efficiency: efficiency.parse().ok() })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_found_by_scene_strategy_and_workers() {
        let found = |scene, strategy, workers| thesis_figure(scene, strategy, workers).unwrap();
        let static2 = found("bunny", Strategy::Static, 2);
        assert_eq!((static2.fps, static2.efficiency), (1.6438, Some(0.786946)));
        let refined = found("sponza", Strategy::Refinement, 32);
        assert_eq!((refined.fps, refined.efficiency), (12.8608, Some(1.011701)));
        assert_eq!(found("office", Strategy::Overlap, 1).efficiency, None);
        assert_eq!(thesis_figure("bunny", Strategy::Stealing, 2), None);
        assert_eq!(thesis_figure("conference", Strategy::Static, 2), None);
        assert_eq!(thesis_figure("bunny", Strategy::Static, 3), None);
    }

    #[test]
    fn all_of_the_four_tables_are_there() {
        let count = ["bunny", "office", "sibenik", "sponza"]
            .iter()
            .flat_map(|scene| {
                Strategy::ALL.map(|strategy| [1, 2, 4, 16, 32].map(|n| thesis_figure(scene, strategy, n)))
            })
            .flatten()
            .flatten()
            .count();
        assert_eq!(count, 4 * 6 * 5);
    }
}
