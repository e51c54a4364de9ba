//! Watertightness: rays at closed meshes, from inside and from outside, at several places and sizes.
//!
//! A closed mesh needs no oracle: a ray from inside must hit, and a ray from outside must hit near its target, if all
//! triangles about it face the ray. What is counted for each cell (instruction set x kernel x place):
//!
//! * *leaks*: rays that hit nothing, or only the wall behind; shadow rays that nothing blocks;
//! * *rejections*: the same, but of rays of which the oracle knows one triangle that they pass through;
//! * *differences*: hits that have other bits than those of the reference, the first kernel of the first set;
//! * *NaN* among depths and weights.

use super::{
    Setup,
    accuracy::Accuracy,
    aim::{Shots, Site, last_place},
    kernel::{Answers, Tracer, same},
    mesh::Closed,
    oracle,
    peers::{Peer, PeerCell},
    random::Random,
    share,
    tally::{Cell, First, Place, Tally},
};
use crate::{
    error::{Error, Result},
    kernels::{Hit, MISS, Ray},
    trace::{KernelChoice, Traversal},
};
use glam::Vec3;

/// Rays of a batch: all from one origin.
const BATCH: usize = 1024;
/// Rays of a batch that the oracle judges by every triangle there is.
const JUDGED: usize = 4;

/// All places: centers (the last is that of Embree's own watertightness test) and radii, as long as the radius is 128
/// units in the last place or more; below, rounding would turn the mesh inside out.
pub(super) fn places() -> Vec<Place> {
    let far = Vec3::new(148_376.0, 1234.0, -223_423.0);
    let centers = [Vec3::ZERO, Vec3::splat(1.0e2), Vec3::splat(1.0e4), far];
    let radii = [1.0e-5, 1.0e-3, 2.0, 1.0e3, 1.0e6];
    let all = centers.iter().flat_map(|&center| radii.map(|radius| Place { center, radius }));
    all.filter(|place| place.radius >= 128.0 * last_place(place.center, 0.0)).collect()
}

/// What became of all rays.
#[derive(Clone, Debug, Default)]
pub struct Leaks {
    /// All cells with rays.
    pub cells: Vec<Cell>,
    /// The oracle's opinion of some of the reference's hits.
    pub accuracy: Accuracy,
    /// Judged rays that hit two triangles at one depth. Through an edge or a vertex that is right: each of them counts
    /// as hit, and the lower number wins.
    pub double: u64,
    /// Other engines.
    pub peers: Vec<PeerCell>,
    /// The first ray that broke a promise.
    pub first: First,
}

/// Traces rays until `goal` aimed ones are done; `tell` hears how many are.
///
/// # Errors
/// [`Error::Failed`] if a tree cannot be built, [`Error::Interrupted`].
pub(super) fn run(setup: &Setup, goal: u64, tell: &dyn Fn(u64)) -> Result<Leaks> {
    let places = places();
    let mut sites = Vec::new();
    let mut peers = Vec::new();
    for (i, place) in places.iter().enumerate() {
        for closed in Closed::ALL {
            let site = Site::new(i, closed, place.center, place.radius)?;
            peers.push(Peer::all(&setup.engines, &site.mesh)?);
            sites.push(site);
        }
    }
    let mut total = State::new(setup, &places, &peers[0]);
    let mut round = 0;
    loop {
        let states = share(
            setup.threads,
            sites.len(),
            || State::new(setup, &places, &peers[0]),
            |state, at| {
                let number = round * sites.len() as u64 + at as u64;
                let shots = sites[at].shots(&mut Random::new(setup.seed, number), BATCH);
                state.shoot(setup, &sites[at], &shots, &peers[at], number);
            },
        );
        states.into_iter().for_each(|state| total.merge(state));
        round += 1;
        let aimed = total.aimed();
        tell(aimed.min(goal));
        if (setup.stopped)() {
            return Err(Error::Interrupted);
        }
        if aimed >= goal {
            return Ok(total.finish(setup, &places));
        }
    }
}

/// What one thread found, and its buffers.
struct State {
    /// By place, then instruction set, then kernel.
    tallies: Vec<Tally>,
    leaks: Leaks,
    tracer: Tracer,
    answers: Answers,
    reference: Vec<Hit>,
}

impl State {
    fn new(setup: &Setup, places: &[Place], peers: &[Peer]) -> State {
        let tallies = vec![Tally::default(); places.len() * setup.kernels.len() * setup.ways.len()];
        let cell = |&place| peers.iter().map(move |peer| PeerCell::new(peer, place));
        let leaks = Leaks { peers: places.iter().flat_map(cell).collect(), ..Leaks::default() };
        State {
            tallies,
            leaks,
            tracer: Tracer::default(),
            answers: Answers::default(),
            reference: Vec::new(),
        }
    }

    fn aimed(&self) -> u64 {
        self.tallies.iter().map(|tally| tally.aimed).sum()
    }

    fn merge(&mut self, other: State) {
        self.tallies.iter_mut().zip(&other.tallies).for_each(|(tally, other)| tally.add(other));
        self.leaks.accuracy.merge(other.leaks.accuracy);
        self.leaks.double += other.leaks.double;
        self.leaks.first.merge(other.leaks.first);
        self.leaks.peers.iter_mut().zip(&other.leaks.peers).for_each(|(cell, other)| cell.add(other));
    }

    fn finish(mut self, setup: &Setup, places: &[Place]) -> Leaks {
        let mut tallies = self.tallies.iter();
        for &place in places {
            for kernels in &setup.kernels {
                for (&kernel, &tally) in setup.ways.iter().zip(&mut tallies) {
                    if tally.rays > 0 {
                        self.leaks.cells.push(Cell { isa: kernels.isa(), kernel, place, tally });
                    }
                }
            }
        }
        self.leaks
    }

    /// Traces one batch with everything there is.
    fn shoot(&mut self, setup: &Setup, site: &Site, shots: &Shots, peers: &[Peer], number: u64) {
        self.reference.clear();
        let per_place = setup.kernels.len() * setup.ways.len();
        let mut at = site.place * per_place;
        for &kernels in &setup.kernels {
            let traversal = Traversal::new(&site.bvh, kernels, KernelChoice::Tile);
            for &kernel in &setup.ways {
                if self.tracer.trace(kernel, &traversal, &shots.batch, &mut self.answers) {
                    let context = || {
                        let side = if shots.inside { "inside" } else { "outside" };
                        format!("{kernel} on {}, {site}, from {side}, {}", kernels.isa(), shots.form)
                    };
                    self.count(at, shots, number, &context);
                }
                at += 1;
            }
        }
        for (i, peer) in peers.iter().enumerate() {
            let cell = &mut self.leaks.peers[site.place * peers.len() + i];
            peer.count(shots.batch.rays(), &shots.limits, shots.aimed, cell);
        }
        self.judge(setup, site, shots, number);
    }

    fn count(&mut self, at: usize, shots: &Shots, number: u64, context: &dyn Fn() -> String) {
        let Answers { hits, blocked, doubtful } = &self.answers;
        if self.reference.is_empty() {
            self.reference.clone_from(hits);
        }
        let tally = &mut self.tallies[at];
        tally.rays += blocked.len() as u64;
        tally.aimed += shots.aimed;
        tally.doubtful += doubtful;
        for (i, &blocked) in blocked.iter().enumerate() {
            // A kernel that tells no hits counts as one that found the right ones.
            let hit = hits.get(i).unwrap_or(&self.reference[i]);
            let beyond =
                |limit: f64| hit.prim == MISS || hit.t.is_nan() || f64::from(hit.t) > limit || !blocked;
            let found = Tally {
                leaks: u64::from(beyond(shots.limits[i])),
                rejected: u64::from(shots.sure[i] < f64::INFINITY && beyond(shots.sure[i])),
                differ: u64::from(!same(hit, &self.reference[i])),
                nan: u64::from(hit.t.is_nan() || hit.u.is_nan() || hit.v.is_nan()),
                ..Tally::default()
            };
            if found.broken() > 0 {
                let ray = shots.batch.rays()[i];
                self.leaks.first.note(number, || {
                    format!(
                        "{}: {}, blocked: {blocked}; {hit:?}, reference {:?}",
                        context(),
                        words(&ray),
                        self.reference[i]
                    )
                });
                tally.add(&found);
            }
        }
    }

    /// The oracle on some of the reference's hits.
    fn judge(&mut self, setup: &Setup, site: &Site, shots: &Shots, number: u64) {
        let rays = shots.batch.rays();
        if rays.is_empty() || self.reference.is_empty() {
            return;
        }
        let traversal = Traversal::new(&site.bvh, setup.kernels[0], KernelChoice::Single);
        let mut random = Random::new(!setup.seed, number);
        for _ in 0..JUDGED {
            let i = random.below(rays.len());
            let hit = self.reference[i];
            let opinion = oracle::judge(&site.mesh, &rays[i], &hit);
            self.leaks.accuracy.note(&opinion);
            if let Some(fault) = opinion.fault {
                self.leaks.first.note(number, || format!("{fault:?}, {site}: {}; {hit:?}", words(&rays[i])));
            }
            let again = traversal.intersect_ray(&Ray { tnear: hit.t, skip: hit.prim, ..rays[i] });
            self.leaks.double += u64::from(hit.prim != MISS && again.t == hit.t);
        }
    }
}

/// A ray by its bits, so that it can be traced again.
pub(super) fn words(ray: &Ray) -> String {
    let bits = |v: [f32; 3]| v.map(|x| format!("{x:e} ({:#010x})", x.to_bits())).join(", ");
    format!("ray from {} along {}, {}..{}", bits(ray.org), bits(ray.dir), ray.tnear, ray.tfar)
}
