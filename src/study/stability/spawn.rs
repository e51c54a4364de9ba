//! Rays that start on a surface or end on one: they must not meet that surface again, and must see another that is
//! 4e-5 sizes away.
//!
//! ```text
//!            \   o light: ends at the hit, skips the source; blocked by the neighbour
//!   ----------\--/---------- neighbour, 4e-5 sizes or 16 units in the last place away, whichever is more
//!   ===========\/=========== source (and its other half: a second triangle in the same plane)
//!              /
//!             / first ray: from behind, so that the spawned ray goes on through the neighbour
//! ```
//!
//! The spawned ray starts where [`crate::shade::spawn`] puts it, and skips the source. The *facet* column counts those
//! that meet the source's other half: skipping one triangle cannot prevent that, only a start on the right side of the
//! plane can. Rays from a light end where renderers see the hit, at origin + t * direction in f32.

use super::{
    Setup,
    aim::{Form, direction, last_place},
    kernel::{Answers, Batch, Kernel, Tracer},
    leaks::words,
    mesh::indexed,
    random::Random,
    share,
    tally::{First, Place},
};
use crate::{
    bvh::{BuildPreset, Bvh},
    error::{Error, Result},
    kernels::{F32, Hit, Isa, Kernel as SimdKernel, MISS, Ray, SUB, Simd},
    scene::TriangleMesh,
    shade::spawn::Footing,
    trace::{KernelChoice, Traversal},
};
use glam::{DVec3, Vec3};

/// Rays of a scene.
const RAYS: usize = 256;
/// The triangles of a scene.
const SOURCE: u32 = 0;
const FACET: u32 = 1;

/// Counts of one size and place, instruction set and kernel.
#[derive(Clone, Copy, Debug)]
pub struct SpawnCell {
    /// Size of the triangles and how far off they are.
    pub place: Place,
    /// Instruction set.
    pub isa: Isa,
    /// Kernel.
    pub kernel: Kernel,
    /// Rays that started on the source or ended there.
    pub rays: u64,
    /// Those that met the source.
    pub self_hits: u64,
    /// Those that did not see the neighbour.
    pub lost: u64,
    /// Those that met the source's other half instead.
    pub facet: u64,
    /// Distances between the spawned origins and the source's plane, in sizes.
    pub offset: Offset,
}

/// Distances; their sum does not depend on the order in which they are added.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Offset {
    /// In units of 2^-64.
    sum: u128,
    /// The greatest.
    pub most: f64,
}

impl Offset {
    const UNIT: f64 = (1u128 << 64) as f64;

    fn of(distance: f64) -> Offset {
        Offset { sum: (distance * Offset::UNIT) as u128, most: distance }
    }

    /// Adds others.
    pub fn merge(&mut self, other: Offset) {
        self.sum = self.sum.saturating_add(other.sum);
        self.most = self.most.max(other.most);
    }

    /// The mean of `count` distances.
    pub fn mean(&self, count: u64) -> f64 {
        self.sum as f64 / Offset::UNIT / count as f64
    }
}

/// What became of all.
#[derive(Clone, Debug, Default)]
pub struct Spawn {
    /// All cells.
    pub cells: Vec<SpawnCell>,
    /// The first ray that broke a promise.
    pub first: First,
}

/// Sizes, each at 0, 100 and 10,000 sizes from the world's origin.
pub(super) fn places() -> Vec<Place> {
    let sizes = [1.0e-5, 1.0e-3, 1.0, 1.0e3, 1.0e6];
    let offsets = [0.0, 1.0e2, 1.0e4];
    let all = sizes.iter().flat_map(|&radius| {
        offsets.map(|offset| Place { center: offset * radius * Vec3::new(1.0, -0.7, 0.6), radius })
    });
    all.collect()
}

/// Traces about `goal` rays in all.
///
/// # Errors
/// [`Error::Failed`] if a tree cannot be built, [`Error::Interrupted`].
pub(super) fn run(setup: &Setup, goal: u64, tell: &dyn Fn(u64)) -> Result<Spawn> {
    let places = places();
    let per_scene = (RAYS * setup.kernels.len() * setup.ways.len()) as u64;
    let scenes = goal.div_ceil(per_scene).next_multiple_of(2 * places.len() as u64);
    let per_round = 16 * places.len() as u64;
    let mut total = State::new(setup, &places);
    for first in (0..scenes).step_by(per_round as usize) {
        let work = |state: &mut State, i: usize| {
            let number = first + i as u64;
            let at = number as usize % places.len();
            let random = &mut Random::new(setup.seed, 1 << 41 | number);
            let lit = number / places.len() as u64 % 2 == 1;
            if let Err(error) = state.scene(setup, places[at], at, lit, random, number) {
                state.failed = Some(error);
            }
        };
        let count = per_round.min(scenes - first) as usize;
        for state in share(setup.threads, count, || State::new(setup, &places), work) {
            total.merge(state);
        }
        tell((first * per_scene).min(goal));
        if (setup.stopped)() {
            return Err(Error::Interrupted);
        }
    }
    match total.failed {
        Some(error) => Err(error),
        None => {
            total.spawn.cells.retain(|cell| cell.rays > 0);
            Ok(total.spawn)
        }
    }
}

struct State {
    spawn: Spawn,
    tracer: Tracer,
    answers: Answers,
    failed: Option<Error>,
}

impl State {
    fn new(setup: &Setup, places: &[Place]) -> State {
        let mut cells = Vec::new();
        for &place in places {
            for kernels in &setup.kernels {
                cells.extend(setup.ways.iter().map(|&kernel| SpawnCell {
                    place,
                    isa: kernels.isa(),
                    kernel,
                    rays: 0,
                    self_hits: 0,
                    lost: 0,
                    facet: 0,
                    offset: Offset::default(),
                }));
            }
        }
        let spawn = Spawn { cells, first: First::default() };
        State { spawn, tracer: Tracer::default(), answers: Answers::default(), failed: None }
    }

    fn merge(&mut self, other: State) {
        for (cell, other) in self.spawn.cells.iter_mut().zip(&other.spawn.cells) {
            cell.rays += other.rays;
            cell.self_hits += other.self_hits;
            cell.lost += other.lost;
            cell.facet += other.facet;
            cell.offset.merge(other.offset);
        }
        self.spawn.first.merge(other.spawn.first);
        self.failed = self.failed.take().or(other.failed);
    }

    /// One source, its neighbour, and rays between them.
    fn scene(
        &mut self,
        setup: &Setup,
        place: Place,
        at: usize,
        lit: bool,
        random: &mut Random,
        number: u64,
    ) -> Result<()> {
        let scene = Scene::new(place, random);
        let source = Bvh::build(&scene.source, BuildPreset::Medium)?;
        let both = Bvh::build(&scene.both, random.of(&BuildPreset::ALL))?;
        let light = scene.point(random, 0.3, 2.0);
        let per_place = setup.kernels.len() * setup.ways.len();
        let mut next = at * per_place;
        for &kernels in &setup.kernels {
            // Hits of the source, then what is spawned there; the same for every instruction set.
            let traversal = Traversal::new(&source, kernels, KernelChoice::Single);
            let mut random = Random::new(setup.seed, 1 << 42 | number);
            let spawned = scene.spawn(&traversal, lit.then_some(light), &mut random);
            let offset = scene.offset(&spawned, lit);
            let batch = if lit { Batch::slopes(spawned) } else { Batch::general(spawned) };
            let traversal = Traversal::new(&both, kernels, KernelChoice::Tile);
            for &kernel in &setup.ways {
                if self.tracer.trace(kernel, &traversal, &batch, &mut self.answers) {
                    self.count(next, &batch, offset, number);
                }
                next += 1;
            }
        }
        Ok(())
    }

    fn count(&mut self, at: usize, batch: &Batch, offset: Offset, number: u64) {
        let State { spawn, answers, .. } = self;
        let cell = &mut spawn.cells[at];
        cell.rays += batch.rays().len() as u64;
        cell.offset.merge(offset);
        if answers.blocked.is_empty() {
            // The source itself is lost.
            (cell.rays, cell.lost) = (cell.rays + RAYS as u64, cell.lost + RAYS as u64);
            let Place { center, radius } = cell.place;
            spawn.first.note(number, || format!("size {radius:e} at {center}: the source is missed"));
        }
        for (i, &blocked) in answers.blocked.iter().enumerate() {
            let prim = answers.hits.get(i).map(|hit| hit.prim);
            let own = prim == Some(SOURCE);
            let facet = prim == Some(FACET);
            let lost = !blocked || prim == Some(MISS);
            cell.self_hits += u64::from(own);
            cell.facet += u64::from(facet);
            cell.lost += u64::from(lost);
            if own || lost || facet {
                let (isa, kernel, place) = (cell.isa, cell.kernel, cell.place);
                spawn.first.note(number, || {
                    let hit = answers.hits.get(i).copied().unwrap_or(Hit::MISS);
                    let ray = words(&batch.rays()[i]);
                    format!(
                        "{kernel} on {isa}, size {:e} at {}: {ray}; {hit:?}, blocked: {blocked}",
                        place.radius, place.center
                    )
                });
            }
        }
    }
}

/// A source of two triangles in a plane, and the same with a large neighbour above.
struct Scene {
    corners: [Vec3; 3],
    normal: DVec3,
    size: f32,
    source: TriangleMesh,
    both: TriangleMesh,
}

impl Scene {
    fn new(place: Place, random: &mut Random) -> Scene {
        let Place { center, radius: size } = place;
        let (corners, normal) = loop {
            let corners = [0; 3].map(|_: i32| center + size * random.vec());
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a);
            if normal.length() > 0.3 * f64::from(size * size) {
                break (corners, normal.normalize());
            }
        };
        let [a, b, c] = corners;
        let other = b + (c - a);
        let gap = (4.0e-5 * size).max(16.0 * last_place(center, 2.0 * size));
        // Large enough that no ray passes beside it.
        let middle = (a.as_dvec3() + b.as_dvec3() + c.as_dvec3()) / 3.0 + f64::from(gap) * normal;
        let side = (b.as_dvec3() - a.as_dvec3()).normalize();
        let across = normal.cross(side);
        let far = 8.0 * f64::from(size);
        let around =
            [-far * side - far * across, 2.0 * far * side - far * across, -far * side + 2.0 * far * across];
        let [x, y, z] = around.map(|p| (middle + p).as_vec3());
        let positions = vec![a, b, c, other, x, y, z];
        let source = indexed(positions.clone(), vec![[0, 1, 2], [1, 3, 2]]);
        let both = indexed(positions, vec![[0, 1, 2], [1, 3, 2], [4, 5, 6]]);
        Scene { corners, normal, size, source, both }
    }

    /// A point of the source moved along its normal by between `near` and `far` sizes.
    fn point(&self, random: &mut Random, near: f32, far: f32) -> Vec3 {
        let height = f64::from(self.size * (near + (far - near) * random.unit()));
        (self.on_source(random).as_dvec3() + height * self.normal).as_vec3()
    }

    fn on_source(&self, random: &mut Random) -> Vec3 {
        let [a, b, c] = self.corners;
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        a + u * (b - a) + v * (c - a)
    }

    /// Rays from where first rays meet the source, or from the light to there; none if hardly any meets it.
    fn spawn(&self, source: &Traversal, light: Option<Vec3>, random: &mut Random) -> Vec<Ray> {
        let (mut u, mut v, mut points) = (Vec::new(), Vec::new(), Vec::new());
        let mut tries = 0..4 * RAYS;
        while points.len() < RAYS {
            if tries.next().is_none() {
                return Vec::new();
            }
            let org = self.point(random, -3.0, -0.1);
            let Some(dir) = direction(self.on_source(random) - org, Form::Normalised) else { continue };
            let first = Ray { org: org.to_array(), dir, tnear: 0.0, tfar: f32::INFINITY, skip: MISS };
            let hit = source.intersect_ray(&first);
            if hit.prim != SOURCE {
                continue;
            }
            points.push([0, 1, 2].map(|k| first.org[k] + hit.t * first.dir[k]));
            u.push(hit.u);
            v.push(hit.v);
        }
        if let Some(light) = light {
            return points.into_iter().filter_map(|point| to_light(point, light)).collect();
        }
        let mut starts = [vec![0.0; RAYS], vec![0.0; RAYS], vec![0.0; RAYS]];
        source.kernels().run(Starts { scene: self, u: &u, v: &v, starts: &mut starts });
        let start = |i: usize| [starts[0][i], starts[1][i], starts[2][i]];
        (0..RAYS).filter_map(|i| self.outgoing(start(i), random)).collect()
    }

    /// A ray into any direction above the source, but not so flat that it could pass the neighbour.
    fn outgoing(&self, org: [f32; 3], random: &mut Random) -> Option<Ray> {
        let dir = random.direction().as_dvec3();
        let cosine = dir.dot(self.normal);
        let dir = if cosine < 0.0 { -dir } else { dir };
        (cosine.abs() > 0.02).then(|| Ray {
            org,
            dir: dir.as_vec3().to_array(),
            tnear: 0.0,
            tfar: f32::INFINITY,
            skip: SOURCE,
        })
    }

    /// How far the spawned rays start (or the lit ones end) from the source's plane, in sizes.
    fn offset(&self, rays: &[Ray], lit: bool) -> Offset {
        let distance = |ray: &Ray| {
            let reach = if lit { f64::from(ray.tfar) } else { 0.0 };
            let end = DVec3::from(ray.org.map(f64::from)) + reach * DVec3::from(ray.dir.map(f64::from));
            (end - self.corners[0].as_dvec3()).dot(self.normal).abs() / f64::from(self.size)
        };
        let mut offset = Offset::default();
        rays.iter().map(distance).for_each(|distance| offset.merge(Offset::of(distance)));
        offset
    }
}

/// Where the rays start that leave the points (u, v) of the source.
struct Starts<'a> {
    scene: &'a Scene,
    u: &'a [f32],
    v: &'a [f32],
    /// By axis.
    starts: &'a mut [Vec<f32>; 3],
}

impl SimdKernel for Starts<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let [a, b, c] = self.scene.corners;
        let corners = [splat(s, a), splat(s, b), splat(s, c)];
        let normal = splat(s, self.scene.normal.as_vec3());
        for at in (0..self.u.len()).step_by(SUB) {
            let hit = [F32::load_at(s, self.u, at), F32::load_at(s, self.v, at)];
            let start = Footing::new(s, &corners, hit).start(s, &normal);
            for axis in 0..3 {
                start[axis].store_at(&mut self.starts[axis], at);
            }
        }
    }
}

#[inline(always)]
fn splat<S: Simd>(s: S, v: Vec3) -> [F32<S, SUB>; 3] {
    [F32::splat(s, v.x), F32::splat(s, v.y), F32::splat(s, v.z)]
}

/// The segment from a light to a point, as packets take it.
fn to_light(point: [f32; 3], light: Vec3) -> Option<Ray> {
    let way = Vec3::from(point) - light;
    let dir = direction(way, Form::Slopes)?;
    let tfar = way.abs().max_element();
    Some(Ray { org: light.to_array(), dir, tnear: 0.0, tfar, skip: SOURCE })
}
