//! All passes of one scene, each made once: techniques and caches share them.

use super::{
    CoherenceOptions, Figures, Row, TECHNIQUES, Walk,
    cache::{Area, Shape},
    pass::{Pass, PrimaryMode, ShadowMode, primary, shadow},
    shot::Shot,
    tally::{PrimaryTally, ShadowTally},
    voorhies::entries_per_disc,
};
use crate::{
    error::{Error, Result},
    kernels::{
        Hit,
        probe::{Counts, Uncounted},
    },
    scene::CameraDescription,
    tile::Order,
};
use glam::{Quat, Vec3};
use std::time::Instant;

/// How far the camera goes round what it looks at from one frame to the next, in degrees.
const MOTION: f32 = 1.0;
/// Radii of the discs of Voorhies' measure in pixels.
const RADII: [u32; 4] = [4, 8, 16, 32];

/// An order and the pixels in it.
pub(super) type Ordered = (Order, Vec<(u32, u32)>);

/// A mode of primary or of shadow rays.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    Primary(PrimaryMode),
    Shadow(ShadowMode),
}

/// What a camera saw in the frame before: it has gone round since.
pub(super) fn a_moment_ago(camera: &CameraDescription) -> CameraDescription {
    let turn = Quat::from_axis_angle(camera.up.normalize_or(Vec3::Y), -MOTION.to_radians());
    CameraDescription { eye: camera.at + turn * (camera.eye - camera.at), ..*camera }
}

/// Makes passes and remembers what they took.
pub(super) struct Runs<'a> {
    shot: &'a Shot<'a>,
    options: &'a CoherenceOptions,
    orders: &'a [Ordered],
    lights: Vec<usize>,
    /// Slots of the frame before: of primary rays, and of shadow rays.
    before: Option<(Vec<u32>, Vec<u32>)>,
    /// Whether shadow rays are blocked, and the hash of the image.
    blocked: Vec<bool>,
    hash: String,
    /// What is known: the order matters only to modes with a cache.
    known: Vec<((Mode, Option<usize>), Figures)>,
}

impl<'a> Runs<'a> {
    pub(super) fn new(
        shot: &'a Shot<'a>,
        before: Option<&Shot>,
        options: &'a CoherenceOptions,
        orders: &'a [Ordered],
    ) -> Runs<'a> {
        let lights: Vec<usize> = (0..shot.lights()).collect();
        let pixels = &orders[0].1;
        let (nearest, stop) = (PrimaryMode { bound: true, seed: None }, ShadowMode::STOP);
        let before = before.map(|shot| {
            let hit = primary::<Uncounted>(shot, pixels, nearest, None).slots;
            (hit, shadow::<Uncounted>(shot, pixels, &lights, stop, None).slots)
        });
        let blocked = shadow::<Uncounted>(shot, pixels, &lights, stop, None).blocked();
        let hash = shot.image(&blocked).sha256();
        Runs { shot, options, orders, lights, before, blocked, hash, known: Vec::new() }
    }

    /// Hash of the image.
    pub(super) fn hash(&self) -> &str {
        &self.hash
    }

    /// Shadow rays that are blocked.
    pub(super) fn blocked(&self) -> u64 {
        self.blocked.iter().filter(|&&blocked| blocked).count() as u64
    }

    /// Everything about one order but times.
    pub(super) fn walk(&mut self, order: usize) -> Result<Walk> {
        let (name, pixels) = &self.orders[order];
        let shape = Shape::THESIS;
        let mut techniques = Vec::new();
        for technique in TECHNIQUES {
            let (first, second) = technique.modes(shape, self.options.end_at_light);
            let primary = self.figures(order, Mode::Primary(first))?;
            let shadow = self.figures(order, Mode::Shadow(second))?;
            techniques.push(Row { technique, shape, primary, shadow });
        }
        let technique = TECHNIQUES[TECHNIQUES.len() - 1];
        let mut caches = Vec::new();
        for shape in Shape::all().filter(|_| self.options.caches) {
            let (first, second) = technique.modes(shape, self.options.end_at_light);
            let primary = self.figures(order, Mode::Primary(first))?;
            let shadow = self.figures(order, Mode::Shadow(second))?;
            caches.push(Row { technique, shape, primary, shadow });
        }
        let map = self.successes(order);
        let discs = RADII
            .into_iter()
            .filter_map(|radius| entries_per_disc(pixels, self.options.size, radius))
            .collect();
        Ok(Walk {
            order: *name,
            primary: PrimaryTally::new(pixels, self.options.size[0], &self.shot.hits),
            shadow: ShadowTally::new(&map),
            map,
            techniques,
            caches,
            discs,
        })
    }

    /// By pixel, the lights that the occluder of the ray before occludes too.
    fn successes(&self, order: usize) -> Vec<u16> {
        let mode = TECHNIQUES[TECHNIQUES.len() - 1].modes(Shape::THESIS, self.options.end_at_light).1;
        shadow::<Uncounted>(self.shot, &self.orders[order].1, &self.lights, mode, None).successes
    }

    /// What a pass takes; it is made if it was not yet.
    fn figures(&mut self, order: usize, mode: Mode) -> Result<Figures> {
        let key = (mode, Self::has_cache(mode).then_some(order));
        if let Some((_, known)) = self.known.iter().find(|(known, _)| *known == key) {
            return Ok(known.clone());
        }
        let pass = self.pass::<Counts>(order, mode);
        self.check(order, mode, &pass)?;
        let Pass { rays, seeded, traversals, counts, .. } = pass;
        let figures = Figures { rays, seeded, traversals, counts, seconds: Vec::new() };
        self.known.push((key, figures.clone()));
        Ok(figures)
    }

    fn has_cache(mode: Mode) -> bool {
        match mode {
            Mode::Primary(mode) => mode.seed.is_some(),
            Mode::Shadow(mode) => mode.seed.is_some(),
        }
    }

    fn pass<C: super::pass::Count>(&self, order: usize, mode: Mode) -> Pass {
        let pixels = &self.orders[order].1;
        let before = self.before.as_ref();
        match mode {
            Mode::Primary(mode) => {
                primary::<C>(self.shot, pixels, mode, before.map(|(primary, _)| &primary[..]))
            }
            Mode::Shadow(mode) => {
                let before = before.filter(|_| mode.seed.is_some_and(|shape| shape.area == Area::Frame));
                shadow::<C>(self.shot, pixels, &self.lights, mode, before.map(|(_, shadow)| &shadow[..]))
            }
        }
    }

    /// The contract: the same hits; the same shadow rays blocked, and so the same image.
    fn check(&self, order: usize, mode: Mode, pass: &Pass) -> Result<()> {
        let same = match mode {
            Mode::Primary(_) => same_hits(&pass.hits, &self.shot.hits),
            Mode::Shadow(_) => pass.blocked() == self.blocked,
        };
        if same {
            return Ok(());
        }
        let order = self.orders[order].0;
        Err(Error::Failed(match mode {
            Mode::Primary(mode) => format!("{order} order, {mode:?}: other hits; please report this"),
            Mode::Shadow(mode) => format!("{order} order, {mode:?}: other shadows; please report this"),
        }))
    }

    /// Times every pass that `walks` name, round by round.
    pub(super) fn time(&mut self, walks: &mut [Walk]) {
        let end = self.options.end_at_light;
        // Passes without a cache are timed in every order: it matters to the processor's own caches.
        let mut jobs: Vec<(usize, Mode, Vec<f64>)> = Vec::new();
        for (order, walk) in walks.iter().enumerate() {
            for row in walk.techniques.iter().chain(&walk.caches) {
                let (first, second) = row.technique.modes(row.shape, end);
                for mode in [Mode::Primary(first), Mode::Shadow(second)] {
                    if !jobs.iter().any(|(o, m, _)| (*o, *m) == (order, mode)) {
                        jobs.push((order, mode, Vec::new()));
                    }
                }
            }
        }
        for _ in 0..self.options.rounds {
            for (order, mode, seconds) in &mut jobs {
                let start = Instant::now();
                let pass = self.pass::<Uncounted>(*order, *mode);
                seconds.push(start.elapsed().as_secs_f64());
                drop(pass);
            }
        }
        for (order, walk) in walks.iter_mut().enumerate() {
            for row in walk.techniques.iter_mut().chain(&mut walk.caches) {
                let (first, second) = row.technique.modes(row.shape, end);
                let seconds = |mode| {
                    let job = jobs.iter().find(|(o, m, _)| (*o, *m) == (order, mode));
                    job.map(|(_, _, seconds)| seconds.clone()).unwrap_or_default()
                };
                row.primary.seconds = seconds(Mode::Primary(first));
                row.shadow.seconds = seconds(Mode::Shadow(second));
            }
        }
    }
}

fn same_hits(a: &[Hit], b: &[Hit]) -> bool {
    let bits = |hit: &Hit| [hit.prim, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()];
    a.iter().map(bits).eq(b.iter().map(bits))
}
