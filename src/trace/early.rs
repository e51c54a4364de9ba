//! The early terminations of the thesis (chapter 4.9): switches that change the work, never the image.

use std::{fmt, str::FromStr};

/// Which searches end early, and what they begin with. All combinations are possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EarlyTermination {
    /// PET, first half: the nearest hit so far bounds the search; without it, all hits are found first.
    pub pet_bound: bool,
    /// PET, second half: the search begins with the triangles that were hit last.
    pub pet_seed: bool,
    /// SET: a shadow ray stops at the first occluder.
    pub set: bool,
    /// OCC: a shadow ray begins with the triangle that occluded the last one of its light.
    pub occ: bool,
    /// More than 0: what `pet_seed` and `occ` remember belongs to an area (of the image, of what the light sees), so many
    /// entries for each, and outlives the rays that go elsewhere in between.
    pub area: usize,
}

/// The switches by name, in the order in which they are told.
const NAMES: [&str; 4] = ["pet-bound", "pet-seed", "set", "occ"];
/// Memory by areas: name and entries. The first one is what is meant without a number.
const AREAS: [(&str, usize); 4] = [("area", 2), ("area1", 1), ("area2", 2), ("area4", 4)];

impl EarlyTermination {
    /// Nothing ends early.
    pub const NONE: EarlyTermination =
        EarlyTermination { pet_bound: false, pet_seed: false, set: false, occ: false, area: 0 };

    /// What is fastest for packets.
    pub const FASTEST: EarlyTermination =
        EarlyTermination { pet_bound: true, pet_seed: false, set: true, occ: true, area: 0 };

    /// All combinations.
    pub fn all() -> impl Iterator<Item = EarlyTermination> {
        [0, 1, 2, 4].into_iter().flat_map(|area| {
            (0..1 << NAMES.len()).map(move |bits: u32| {
                EarlyTermination::of([0, 1, 2, 3].map(|i: u32| bits >> i & 1 != 0), area)
            })
        })
    }

    fn of([pet_bound, pet_seed, set, occ]: [bool; 4], area: usize) -> EarlyTermination {
        EarlyTermination { pet_bound, pet_seed, set, occ, area }
    }
}

impl Default for EarlyTermination {
    fn default() -> EarlyTermination {
        EarlyTermination::FASTEST
    }
}

impl fmt::Display for EarlyTermination {
    /// As [`FromStr`] reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let switches = [self.pet_bound, self.pet_seed, self.set, self.occ];
        let mut on: Vec<&str> =
            NAMES.into_iter().zip(switches).filter(|(_, on)| *on).map(|(name, _)| name).collect();
        on.extend(AREAS.iter().find(|(_, entries)| *entries == self.area).map(|(name, _)| name));
        f.pad(&if on.is_empty() { "none".into() } else { on.join(",") })
    }
}

impl FromStr for EarlyTermination {
    type Err = String;

    /// `none`, or names of switches with commas between.
    fn from_str(text: &str) -> Result<EarlyTermination, String> {
        let (mut switches, mut area) = ([false; NAMES.len()], 0);
        if text.trim() == "none" {
            return Ok(EarlyTermination::NONE);
        }
        for name in text.split(',').map(str::trim) {
            if let Some(at) = NAMES.iter().position(|&known| known == name) {
                switches[at] = true;
            } else if let Some((_, entries)) = AREAS.iter().find(|(known, _)| *known == name) {
                area = *entries;
            } else {
                let names = NAMES.join(", ");
                return Err(format!(
                    "'{name}' is no early termination; give none, or some of {names}, area (area1, area2, area4)"
                ));
            }
        }
        Ok(EarlyTermination::of(switches, area))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_is_written_as_it_is_read() {
        let all: Vec<_> = EarlyTermination::all().collect();
        assert_eq!(all.len(), 64);
        for early in all {
            assert_eq!(early.to_string().parse(), Ok(early));
        }
        assert_eq!("none".parse(), Ok(EarlyTermination::NONE));
        assert_eq!(" set, occ".parse::<EarlyTermination>().unwrap().to_string(), "set,occ");
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_known_ones() {
        for bad in ["", "pet", "set,", "none,set"] {
            let message = bad.parse::<EarlyTermination>().unwrap_err();
            assert!(message.contains("pet-bound, pet-seed, set, occ, area "), "{message}");
        }
    }
}
