//! What messages cost a master on the core of a worker: measured while the scene's tiles are rendered, onto the films that the
//! streams have.

use super::Costs;
use crate::render::Session;
use crate::schedule::{FilmMode, Machine, Placement, SharedCore, SharedCoreProbe};
use crate::tile::Tile;

/// Messages of each kind in a round.
pub(in crate::study::scaling) const MESSAGES: usize = 250;

/// Rounds of messages on the first two cores, if there are two.
pub(in crate::study::scaling) struct SharedCores {
    /// The other one, and that of the master.
    cpus: Option<[usize; 2]>,
    /// Which films are of interest.
    films: Vec<FilmMode>,
    /// Without pixels, and with those of a tile to copy.
    shared: SharedCoreProbe,
    copying: SharedCoreProbe,
}

impl SharedCores {
    pub(in crate::study::scaling) fn new(pin: bool, films: impl Iterator<Item = FilmMode>) -> SharedCores {
        let cpus = match Placement::new(Machine::get(), Some(2), pin).slots() {
            &[Some(other), Some(core)] => Some([other, core]),
            _ => None,
        };
        let probe = SharedCoreProbe::default;
        SharedCores { cpus, films: films.collect(), shared: probe(), copying: probe() }
    }

    /// A round of `messages` of each kind, or fewer if `tiles` take long.
    pub(in crate::study::scaling) fn measure(
        &mut self,
        session: &mut Session<'_, '_>,
        tiles: &[Tile],
        messages: usize,
    ) {
        let Some(cpus) = self.cpus else { return };
        for &film in &self.films {
            let probe = match film {
                FilmMode::Shared => &mut self.shared,
                FilmMode::Messages => &mut self.copying,
            };
            session.probe(probe, film, tiles, messages, cpus);
        }
    }

    /// `costs` with what all rounds found, if any did. These are the tiles.
    pub(in crate::study::scaling) fn found(&self, costs: Costs, tiles: &[Tile]) -> Costs {
        with(costs, self.shared.costs(), self.copying.costs(), tiles)
    }
}

fn with(costs: Costs, shared: Option<SharedCore>, copying: Option<SharedCore>, tiles: &[Tile]) -> Costs {
    let pixels: usize = tiles.iter().map(Tile::len).sum();
    let bytes = 12.0 * pixels as f64 / tiles.len() as f64;
    let copied = copying.map(|copying| copying.work.map(|work| work / bytes));
    // On a busy machine it may be that no message was alone.
    let copied = copied.filter(|copied| copied.iter().all(|&byte| byte > 0.0));
    Costs {
        shared: shared.unwrap_or(costs.shared),
        copying: copying.unwrap_or(costs.copying),
        copied: copied.or(costs.copied),
        ..costs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Stage;
    use crate::scene::Scene;
    use crate::study::{accuracy, scaling::costs::NOTHING};

    #[test]
    fn what_is_found_takes_the_place_of_what_was_known() {
        let known = Costs { copied: Some([7.0, 8.0]), ..NOTHING };
        let shared = SharedCore { work: [2.0; 2], ..NOTHING.shared };
        // Tiles of 12 bytes for each of 16 and of 8 pixels: 144 on average.
        let tile = |width| Tile { x: 0, y: 0, width, height: 4 };
        let tiles = [tile(4), tile(2)];
        let copying = SharedCore { work: [144.0, 2.0 * 144.0], ..NOTHING.shared };
        assert_eq!(with(known, None, None, &tiles), known);
        assert_eq!(with(known, Some(shared), None, &tiles), Costs { shared, ..known });
        let found = Costs { shared, copying, copied: Some([1.0, 2.0]), ..known };
        assert_eq!(with(known, Some(shared), Some(copying), &tiles), found);
        let unseen = SharedCore { work: [144.0, 0.0], ..copying };
        assert_eq!(with(known, None, Some(unseen), &tiles), Costs { copying: unseen, ..known });
    }

    #[test]
    fn what_is_of_interest_is_measured_on_two_cores_and_nothing_without() {
        let (scene, options) = (Scene::default(), accuracy::options());
        let stage = Stage::new(&scene, &options).unwrap();
        let tiles = stage.tiles(16);
        let measured = |shared: &mut SharedCores| {
            let placement = Placement::new(Machine::get(), Some(1), false);
            stage
                .with_session(&placement, |session| {
                    shared.measure(session, &tiles, 5);
                    Ok(())
                })
                .unwrap();
            [&shared.shared, &shared.copying].map(|probe| probe.costs().is_some())
        };
        let mut both = SharedCores::new(true, FilmMode::ALL.into_iter());
        let can = both.cpus.is_some();
        assert_eq!(measured(&mut both), [can, can]);
        assert_eq!(measured(&mut SharedCores::new(true, std::iter::once(FilmMode::Messages))), [false, can]);
        assert_eq!(measured(&mut SharedCores::new(true, std::iter::once(FilmMode::Shared))), [can, false]);
        let mut none = SharedCores { cpus: None, ..SharedCores::new(false, FilmMode::ALL.into_iter()) };
        assert_eq!(measured(&mut none), [false, false]);
        let costs = Costs { copied: Some([1.0, 2.0]), ..NOTHING };
        assert_eq!(none.found(costs, &tiles), costs);
    }
}
