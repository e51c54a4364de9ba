//! Meshes of all kinds and sizes under rays of all kinds: every kernel against the first, the first against the
//! oracle.
//!
//! Rays start anywhere, on vertices, on planes of boxes; they fly anywhere, at vertices, along edges and axes, with
//! components that are 0, -0 or next to nothing; they begin and end anywhere, often exactly where something is hit;
//! some skip a triangle, some are not finite.

use super::{
    Setup,
    accuracy::Accuracy,
    aim::{Form, direction},
    kernel::{Answers, Batch, Tracer, same},
    leaks::words,
    mesh::Family,
    oracle,
    random::Random,
    share,
    tally::{First, Tally},
};
use crate::{
    bvh::{BuildPreset, Bvh},
    error::{Error, Result},
    kernels::{Hit, MISS, Ray},
    scene::TriangleMesh,
    trace::{KernelChoice, Traversal},
};
use glam::Vec3;

/// Rays of a mesh.
const RAYS: usize = 256;
/// Those that the oracle judges.
const JUDGED: usize = 16;

/// What became of one family of meshes.
#[derive(Clone, Debug)]
pub struct FuzzCell {
    /// The family.
    pub family: Family,
    /// Meshes tried.
    pub meshes: u64,
    /// Rays of each kernel on each instruction set.
    pub tally: Tally,
    /// Of the reference.
    pub accuracy: Accuracy,
}

/// What became of all.
#[derive(Clone, Debug)]
pub struct Fuzz {
    /// By family.
    pub cells: Vec<FuzzCell>,
    /// The first ray that broke a promise.
    pub first: First,
}

struct State {
    fuzz: Fuzz,
    tracer: Tracer,
    answers: Answers,
    failed: Option<Error>,
}

impl State {
    fn new() -> State {
        let cell =
            |family| FuzzCell { family, meshes: 0, tally: Tally::default(), accuracy: Accuracy::default() };
        State {
            fuzz: Fuzz { cells: Family::ALL.map(cell).into(), first: First::default() },
            tracer: Tracer::default(),
            answers: Answers::default(),
            failed: None,
        }
    }
}

/// Tries `count` meshes.
///
/// # Errors
/// [`Error::Failed`] if a tree cannot be built, [`Error::Interrupted`].
pub(super) fn run(setup: &Setup, count: u64, tell: &dyn Fn(u64)) -> Result<Fuzz> {
    const ROUND: u64 = 60;
    let mut total = State::new().fuzz;
    for first in (0..count).step_by(ROUND as usize) {
        let work = |state: &mut State, i: usize| {
            if let Err(error) = mesh(setup, state, first + i as u64) {
                state.failed = Some(error);
            }
        };
        for state in share(setup.threads, ROUND.min(count - first) as usize, State::new, work) {
            if let Some(error) = state.failed {
                return Err(error);
            }
            for (cell, other) in total.cells.iter_mut().zip(state.fuzz.cells) {
                cell.meshes += other.meshes;
                cell.tally.add(&other.tally);
                cell.accuracy.merge(other.accuracy);
            }
            total.first.merge(state.fuzz.first);
        }
        tell((first + ROUND).min(count));
        if (setup.stopped)() {
            return Err(Error::Interrupted);
        }
    }
    Ok(total)
}

/// The random mesh number `number`: where, how large, and its triangles.
pub fn random_mesh(random: &mut Random, family: Family) -> (Vec3, f32, TriangleMesh) {
    let count = random.of(&[1, 3, 8, 40, 150, 400]);
    let scale = match random.below(4) {
        0 => 1.0,
        1 => (random.below(9) as f32 - 4.0).exp2(),
        _ => 10.0f32.powf(12.0 * random.signed()),
    };
    let center = match random.below(3) {
        0 => Vec3::ZERO,
        1 => scale * random.of(&[4.0, 64.0, 1024.0]) * Vec3::new(1.0, -1.0, 2.0),
        _ => scale * 10.0f32.powf(4.0 * random.unit()) * random.vec(),
    };
    (center, scale, family.mesh(random, count, center, scale))
}

fn mesh(setup: &Setup, state: &mut State, number: u64) -> Result<()> {
    let mut random = Random::new(setup.seed, 1 << 40 | number);
    let family = Family::ALL[number as usize % Family::ALL.len()];
    let (center, scale, mesh) = random_mesh(&mut random, family);
    let preset = random.of(&BuildPreset::ALL);
    let bvh = Bvh::build(&mesh, preset)?;
    let slopes = random.below(2) == 0;
    let rays = random_rays(&mut random, &mesh, center, scale, slopes, RAYS);
    let batch = if slopes { Batch::slopes(rays) } else { Batch::general(rays) };
    let State { fuzz, tracer, answers, .. } = state;
    let cell = &mut fuzz.cells[number as usize % Family::ALL.len()];
    cell.meshes += 1;
    let mut reference: Vec<Hit> = Vec::new();
    for &kernels in &setup.kernels {
        let traversal = Traversal::new(&bvh, kernels, KernelChoice::Tile);
        for &kernel in &setup.ways {
            if !tracer.trace(kernel, &traversal, &batch, answers) {
                continue;
            }
            if reference.is_empty() {
                reference.clone_from(&answers.hits);
            }
            cell.tally.rays += batch.rays().len() as u64;
            cell.tally.doubtful += answers.doubtful;
            for (i, &blocked) in answers.blocked.iter().enumerate() {
                let hit = answers.hits.get(i).unwrap_or(&reference[i]);
                let differs = !same(hit, &reference[i]) || blocked != (reference[i].prim != MISS);
                cell.tally.differ += u64::from(differs);
                cell.tally.nan += u64::from(hit.t.is_nan() || hit.u.is_nan() || hit.v.is_nan());
                if differs {
                    fuzz.first.note(number, || {
                        let (isa, ray) = (kernels.isa(), words(&batch.rays()[i]));
                        format!("{kernel} on {isa}, {family} {number}: {ray}; {hit:?}, blocked: {blocked}, reference {:?}", reference[i])
                    });
                }
            }
        }
    }
    for _ in 0..JUDGED.min(reference.len()) {
        let i = random.below(reference.len());
        let (ray, hit) = (&batch.rays()[i], &reference[i]);
        let opinion = if is_finite(ray) {
            oracle::judge(&mesh, ray, hit)
        } else {
            oracle::Opinion { fault: (hit.prim != MISS).then_some(oracle::Fault::Imagined), errors: None }
        };
        cell.accuracy.note(&opinion);
        if let Some(fault) = opinion.fault {
            fuzz.first.note(number, || format!("{fault:?}, {family} {number}: {}; {hit:?}", words(ray)));
        }
    }
    Ok(())
}

/// False for rays that hit nothing by definition.
pub fn is_finite(ray: &Ray) -> bool {
    let numbers = ray.org.iter().chain(&ray.dir).all(|x| x.is_finite());
    numbers && ray.dir != [0.0; 3] && !ray.tnear.is_nan() && ray.tnear.max(0.0) <= ray.tfar
}

/// Rays at a mesh; `slopes` for those that packets take.
pub fn random_rays(
    random: &mut Random,
    mesh: &TriangleMesh,
    center: Vec3,
    scale: f32,
    slopes: bool,
    count: usize,
) -> Vec<Ray> {
    let mut common = origin(random, mesh, center, scale);
    if slopes && !common.is_finite() {
        common = center;
    }
    let mut rays = Vec::new();
    let mut tries = 0;
    while rays.len() < count {
        tries += 1;
        let org = if slopes || random.below(4) == 0 { common } else { origin(random, mesh, center, scale) };
        let mut exact = target(random, mesh, center, scale) - org;
        for axis in 0..3 {
            match random.below(16) {
                0 => exact[axis] = 0.0,
                1 => exact[axis] = -0.0,
                2 => exact[axis] *= 1.0e-30,
                _ => {}
            }
        }
        let form = if slopes { Form::Slopes } else { random.of(&[Form::Exact, Form::Normalised]) };
        let Some(dir) = direction(exact, form) else {
            if tries > 20 * count {
                common = center + 3.0 * scale * random.vec();
            }
            continue;
        };
        let mut ray = Ray { org: org.to_array(), dir, tnear: 0.0, tfar: f32::INFINITY, skip: MISS };
        limit(random, mesh, &mut ray, slopes);
        rays.push(ray);
    }
    rays
}

fn corner(random: &mut Random, mesh: &TriangleMesh) -> Option<Vec3> {
    (!mesh.is_empty()).then(|| mesh.corners(random.below(mesh.len()))[random.below(3)])
}

fn origin(random: &mut Random, mesh: &TriangleMesh, center: Vec3, scale: f32) -> Vec3 {
    let corner = corner(random, mesh).unwrap_or(center);
    let anywhere = center + 2.0 * scale * random.vec();
    match random.below(8) {
        0 => corner,
        // On a plane of some box.
        1 | 2 => {
            let mut at = anywhere;
            let axis = random.below(3);
            at[axis] = corner[axis];
            at
        }
        3 => center + scale * Vec3::from([0; 3].map(|_: i32| random.below(11) as f32 - 5.0)),
        4 => center + 1.0e3 * scale * random.vec(),
        _ => anywhere,
    }
}

fn target(random: &mut Random, mesh: &TriangleMesh, center: Vec3, scale: f32) -> Vec3 {
    if mesh.is_empty() || random.below(8) == 0 {
        return center + scale * random.vec();
    }
    let [a, b, c] = mesh.corners(random.below(mesh.len()));
    match random.below(4) {
        0 => a,
        1 => 0.5 * (b + c),
        2 => a + random.unit() * (b - a),
        _ => (a + b + c) / 3.0,
    }
}

/// Where a ray begins and ends, and what it skips.
fn limit(random: &mut Random, mesh: &TriangleMesh, ray: &mut Ray, slopes: bool) {
    if random.below(4) == 0 && !mesh.is_empty() {
        ray.skip = random.below(mesh.len()) as u32;
    }
    // Few triangles of a large mesh lie on the ray's way.
    let tries = if mesh.is_empty() { 0 } else { 16 };
    let met = (0..tries).find_map(|_| oracle::depth_of(mesh.corners(random.below(mesh.len())), ray));
    let Some(t) = met.map(|t| t as f32).filter(|t| t.is_finite() && *t > 0.0) else { return };
    match random.below(8) {
        0 => ray.tfar = t,
        1 => ray.tfar = t.next_down(),
        2 if !slopes => ray.tnear = t,
        3 if !slopes => ray.tnear = t.next_up(),
        4 if !slopes => (ray.tnear, ray.tfar) = (t, t),
        5 if !slopes && random.below(8) == 0 => ray.org[random.below(3)] = f32::NAN,
        6 if !slopes && random.below(8) == 0 => ray.dir[random.below(3)] = f32::INFINITY,
        7 if !slopes && random.below(8) == 0 => ray.tnear = f32::NAN,
        _ => {}
    }
}
