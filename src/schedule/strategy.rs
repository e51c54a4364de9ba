//! The modes of the scheduler: who gets which tile when, and how pixels reach the film.

use crate::error::Error;
use std::fmt;
use std::str::FromStr;

/// Which tile goes to which worker when. 1 to 6 are those of the thesis (chapters 4.4 to 4.8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// One contiguous region of the order for each worker, always the same one.
    Static,
    /// Tiles dealt round-robin before the frame starts.
    StaticCyclic,
    /// Demand-driven: a delivered result is answered with the next tile; the worker waits in between.
    Dynamic,
    /// Dynamic with one more tile waiting at each worker, so that the next one is there when the last one ends.
    Overlap,
    /// Overlap with results that are handed over without waiting until the master has taken them.
    NonBlocking,
    /// Non-blocking with tasks that shrink: runs of tiles at first, fractions of a tile at the end.
    Refinement,
    /// Each worker owns a contiguous range of the order; who runs out of it takes half of the largest rest.
    #[default]
    Stealing,
    /// Refinement by the tile times of the last frame: the longest tiles first, cut and bundled by their times.
    CostGuided,
}

impl Strategy {
    /// Every strategy there is, for studies that sweep them and messages that list them.
    pub const ALL: [Strategy; 8] = [
        Strategy::Static,
        Strategy::StaticCyclic,
        Strategy::Dynamic,
        Strategy::Overlap,
        Strategy::NonBlocking,
        Strategy::Refinement,
        Strategy::Stealing,
        Strategy::CostGuided,
    ];

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::Static => "static",
            Strategy::StaticCyclic => "static-cyclic",
            Strategy::Dynamic => "dynamic",
            Strategy::Overlap => "overlap",
            Strategy::NonBlocking => "non-blocking",
            Strategy::Refinement => "refinement",
            Strategy::Stealing => "stealing",
            Strategy::CostGuided => "cost-guided",
        }
    }

    /// Tasks that a worker has at most: the one it is on, and those that wait for it. Of a strategy that deals all of
    /// a frame at first, tasks of each frame in flight.
    pub fn tasks_at_once(self) -> usize {
        match self {
            Strategy::Static | Strategy::StaticCyclic | Strategy::Dynamic | Strategy::Stealing => 1,
            Strategy::Overlap | Strategy::NonBlocking | Strategy::Refinement | Strategy::CostGuided => 2,
        }
    }

    /// Parcels that a worker has for its results. With one it waits until the master has taken them before it goes on.
    /// More than eight would only be more memory: a master that is so far behind does not catch up.
    pub fn parcels(self) -> usize {
        match self {
            Strategy::Static | Strategy::StaticCyclic | Strategy::Dynamic | Strategy::Overlap => 1,
            Strategy::NonBlocking | Strategy::Refinement | Strategy::Stealing | Strategy::CostGuided => 8,
        }
    }

    /// True if all of a frame is dealt when it begins, and nothing afterwards.
    pub fn deals_at_first(self) -> bool {
        matches!(self, Strategy::Static | Strategy::StaticCyclic | Strategy::Stealing)
    }

    /// True if tasks shrink towards the end of the frame.
    pub(super) fn shrinks(self) -> bool {
        matches!(self, Strategy::Refinement | Strategy::CostGuided)
    }
}

/// How finished pixels reach the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FilmMode {
    /// Workers write their disjoint tiles straight into the film.
    #[default]
    Shared,
    /// Each tile's pixels are a message to the master, which copies them into the film, as in the thesis.
    Messages,
}

impl FilmMode {
    /// Both.
    pub const ALL: [FilmMode; 2] = [FilmMode::Shared, FilmMode::Messages];

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            FilmMode::Shared => "shared",
            FilmMode::Messages => "messages",
        }
    }
}

/// How a frame is scheduled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Schedule {
    /// Who gets which tile when.
    pub strategy: Strategy,
    /// How pixels reach the film.
    pub film: FilmMode,
}

impl Schedule {
    /// True if a finished task entitles its worker to nothing, nor does that one wait for its parcel: then only the last one of a
    /// frame is worth waking the master for.
    pub fn tells_only_last(self) -> bool {
        self.film == FilmMode::Shared && self.strategy.deals_at_first() && self.strategy.parcels() > 1
    }

    /// Every strategy with every film mode.
    pub fn all() -> impl Iterator<Item = Schedule> {
        Strategy::ALL
            .into_iter()
            .flat_map(|strategy| FilmMode::ALL.into_iter().map(move |film| Schedule { strategy, film }))
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for FilmMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Strategy {
    type Err = Error;

    /// Parses the name on the command line; the error lists the strategies there are.
    fn from_str(name: &str) -> Result<Strategy, Error> {
        let available = || Strategy::ALL.map(Strategy::name).join(", ");
        Strategy::ALL
            .into_iter()
            .find(|strategy| strategy.name() == name)
            .ok_or_else(|| unknown("--schedule", name, &available()))
    }
}

impl FromStr for FilmMode {
    type Err = Error;

    /// Parses the name on the command line; the error lists the modes there are.
    fn from_str(name: &str) -> Result<FilmMode, Error> {
        let available = || FilmMode::ALL.map(FilmMode::name).join(", ");
        FilmMode::ALL
            .into_iter()
            .find(|mode| mode.name() == name)
            .ok_or_else(|| unknown("--film", name, &available()))
    }
}

fn unknown(flag: &str, name: &str, available: &str) -> Error {
    Error::flag(flag, format!("'{name}' is not available"), format!("use one of: {available}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_parse_back_to_what_they_name() {
        for strategy in Strategy::ALL {
            assert_eq!(strategy.to_string().parse::<Strategy>().unwrap(), strategy);
        }
        for mode in FilmMode::ALL {
            assert_eq!(mode.to_string().parse::<FilmMode>().unwrap(), mode);
        }
    }

    #[test]
    fn unknown_names_are_answered_with_the_available_ones() {
        let message = "eager".parse::<Strategy>().unwrap_err().to_string();
        assert!(
            message.starts_with("--schedule: 'eager' is not available; use one of: static,"),
            "{message}"
        );
        let message = "paper".parse::<FilmMode>().unwrap_err().to_string();
        assert_eq!(message, "--film: 'paper' is not available; use one of: shared, messages");
    }
}
