//! Beam kernel = single-ray kernel = brute force over all triangles, bit for bit, on every instruction set; and so are
//! the streams that are cut into beams.

use crate::support::{Random, brute_force, kernels, mesh_of, soup, sphere};
use glam::Vec3;
use irt::{
    bvh::{BuildPreset, Bvh},
    kernels::{BvhView, EMPTY_NODE, Face, Flight, Hit, HitBlock, Kernels, MISS, Pick, Ray, RayBlock, SUB},
    scene::{TriangleMesh, procedural},
    trace::{KernelChoice, RayStream, Traversal},
};

fn build(mesh: &TriangleMesh) -> Bvh {
    Bvh::build(mesh, BuildPreset::Medium).expect("builds")
}

fn same(context: &str, kernels: &Kernels, ray: &Ray, got: Hit, want: Hit) {
    let bits = |h: Hit| (h.prim, h.t.to_bits(), h.u.to_bits(), h.v.to_bits());
    assert_eq!(bits(got), bits(want), "{context}, {}: {ray:?}\n got {got:?}\nwant {want:?}", kernels.isa());
}

/// The oracle; rays without a meaning miss.
fn oracle(mesh: &TriangleMesh, ray: &Ray) -> Hit {
    let finite = ray.org.iter().chain(&ray.dir).all(|x| x.is_finite());
    let range = !ray.tnear.is_nan() && ray.tnear.max(0.0) <= ray.tfar;
    if finite && range && ray.dir != [0.0; 3] { brute_force(mesh, ray) } else { Hit::MISS }
}

/// Up to 256 rays as blocks, in an order that is not that of the picks.
fn blocks(rays: &[Ray]) -> (Vec<RayBlock>, Vec<Pick>) {
    let mut blocks = vec![RayBlock::EMPTY];
    let mut picks = Vec::new();
    for rays in rays.chunks(SUB).rev() {
        let mut block = RayBlock::EMPTY;
        rays.iter().enumerate().for_each(|(lane, ray)| block.set(lane, ray));
        blocks.push(block);
        picks.insert(0, Pick { block: blocks.len() as u32 - 1, active: u16::MAX });
    }
    (blocks, picks)
}

/// Traces up to 256 rays with the beam kernel and compares with what is wanted.
fn check_wanted(context: &str, kernels: &Kernels, view: &BvhView, rays: &[Ray], wanted: &[Hit]) {
    let (blocks, picks) = blocks(rays);
    let untouched = Hit { prim: 7, t: -3.0, u: -4.0, v: -5.0 };
    let mut hits = vec![HitBlock::splat(untouched); blocks.len()];
    kernels.beam_intersect(view, &blocks, &picks, &mut hits);
    let at = |i: usize| (picks[i / SUB].block as usize, i % SUB);
    for (i, (ray, want)) in rays.iter().zip(wanted).enumerate() {
        let (block, lane) = at(i);
        same(context, kernels, ray, hits[block].get(lane), *want);
        hits[block].set(lane, untouched);
    }
    assert!(
        hits.iter().all(|&hits| hits == HitBlock::splat(untouched)),
        "{context}: inactive rays keep what was there"
    );
    let mut seed = EMPTY_NODE;
    for round in ["cold", "seeded"] {
        let mut blocked = vec![0x5555; blocks.len()];
        kernels.beam_occluded(view, &blocks, &picks, &mut seed, &mut blocked);
        for (block, &bits) in blocks.iter().zip(&blocked) {
            let others = !block.active;
            assert_eq!(bits & others, 0x5555 & others, "{context}: inactive rays keep what was there");
        }
        for (i, (ray, want)) in rays.iter().zip(wanted).enumerate() {
            let (block, lane) = at(i);
            let got = blocked[block] >> lane & 1 != 0;
            assert_eq!(got, want.prim != MISS, "{context}, {round}, {}: {ray:?}", kernels.isa());
        }
    }
}

/// All instruction sets against brute force; returns the number of hits.
fn check(context: &str, mesh: &TriangleMesh, bvh: &Bvh, rays: &[Ray]) -> usize {
    let wanted: Vec<Hit> = rays.iter().map(|ray| oracle(mesh, ray)).collect();
    for kernels in kernels() {
        check_wanted(context, &kernels, &bvh.view(), rays, &wanted);
    }
    wanted.iter().filter(|hit| hit.prim != MISS).count()
}

/// How rays of a beam differ: origins, directions by block, directions within a block.
#[derive(Clone, Copy)]
struct Spread {
    origin: f32,
    blocks: f32,
    rays: f32,
}

/// Rays about one direction, some short, some that start late, some that skip a triangle, some without a meaning.
fn random_rays(random: &mut Random, count: usize, spread: Spread, strange: bool) -> Vec<Ray> {
    let start = 1.2 * random.vec();
    let toward = 0.5 * random.vec() - start;
    let scale = [1.0e-6, 1.0, 1.0e6][random.below(3)];
    let mut rays = Vec::new();
    while rays.len() < count {
        let (start, toward) = (start + spread.origin * random.vec(), toward + spread.blocks * random.vec());
        for _ in 0..SUB.min(count - rays.len()) {
            let mut dir = toward + spread.rays * random.vec();
            match random.below(if strange { 30 } else { 1 << 30 }) {
                1 => dir.x = 0.0,
                2 => (dir.x, dir.y) = (-0.0, 0.0),
                3 => (dir.y, dir.z) = (dir.x, dir.x),
                4 => dir = Vec3::ZERO,
                5 => dir.z = f32::NAN,
                6 => dir.y = f32::NEG_INFINITY,
                7 => dir = random.vec(),
                _ => {}
            }
            let mut org = start + 0.2 * spread.origin * random.vec();
            match random.below(if strange { 60 } else { 1 << 30 }) {
                1 => org.x = f32::NAN,
                2 => org.y = f32::INFINITY,
                3 => org.z = 1.0e30,
                4 => org = random.vec(),
                _ => {}
            }
            rays.push(Ray {
                org: org.to_array(),
                dir: (dir * scale).to_array(),
                tnear: [-1.0, 0.0, 0.0, 0.3 / scale][random.below(4)],
                tfar: [f32::INFINITY, f32::INFINITY, 1.0 / scale, f32::MAX][random.below(4)],
                skip: if random.below(4) == 0 { random.below(8) as u32 } else { MISS },
            });
        }
    }
    rays
}

#[test]
fn beams_agree_on_random_triangles() {
    let mut random = Random(41);
    let mut hits = 0;
    for (count, size) in [(1, 1.0), (7, 1.0), (40, 0.5), (300, 0.3), (1500, 0.1)] {
        let mesh = soup(count as u64 + 5, count, size);
        let bvh = build(&mesh);
        for round in 0..16 {
            let spread = [
                Spread { origin: 0.02, blocks: 0.1, rays: 0.02 },
                Spread { origin: 0.2, blocks: 0.0, rays: 0.0 },
                Spread { origin: 0.0, blocks: 0.3, rays: 0.1 },
                Spread { origin: 0.5, blocks: 1.0, rays: 0.5 },
            ][round % 4];
            let rays = random_rays(&mut random, [256, 250, 40, 3][round / 4], spread, round % 2 == 1);
            hits += check(&format!("{count} triangles, round {round}"), &mesh, &bvh, &rays);
        }
    }
    assert!(hits > 1000, "only {hits} rays hit anything: the test proves little");
}

/// Rays from a surface, to vertices and edge midpoints of the same and of other triangles.
#[test]
fn rays_aimed_at_vertices_and_edges_agree() {
    for (center, radius) in [
        (Vec3::ZERO, 1.0),
        (Vec3::splat(100.0), 1.0),
        (Vec3::new(148_376.0, 1234.0, -223_423.0), 2.0),
        (Vec3::ZERO, 1.0e-5),
    ] {
        let mesh = sphere(center, radius, 12);
        let bvh = build(&mesh);
        let mut random = Random(6);
        for _ in 0..6 {
            let start = center + 0.3 * radius * random.vec();
            let face = random.below(6);
            let mut rays = Vec::new();
            for i in 0..mesh.len() {
                let [a, b, c] = mesh.corners(i);
                let target = [a, b, c, 0.5 * (a + b), a + 0.5 * (b - a)][i % 5];
                // Two thirds start inside, the others on the surface.
                let org = if i % 3 == 0 {
                    let [a, b, c] = mesh.corners(random.below(mesh.len()));
                    (a + b + c) / 3.0
                } else {
                    start + 0.1 * radius * random.vec()
                };
                let dir = target - org;
                if dir != Vec3::ZERO && Face::of(dir.to_array()).index() == face && rays.len() < 256 {
                    let (org, dir) = (org.to_array(), dir.to_array());
                    rays.push(Ray { org, dir, tnear: 0.0, tfar: f32::INFINITY, skip: MISS });
                }
            }
            check("aimed", &mesh, &bvh, &rays);
        }
    }
}

/// Origins exactly on planes, directions exactly along axes, depths exactly at the ends of the interval.
#[test]
fn rays_on_a_grid_agree() {
    let mut triangles = Vec::new();
    for i in 0..4 {
        for j in 0..4 {
            let corner = Vec3::new(i as f32, j as f32, [0.0, 1.0, 2.0][(i + j) % 3]);
            triangles.push([corner, corner + Vec3::X, corner + Vec3::Y]);
            triangles.push([corner + Vec3::X + Vec3::Y, corner + Vec3::Y, corner + Vec3::X]);
            triangles.push([corner, corner + Vec3::Y, corner + Vec3::Z]);
        }
    }
    let mesh = mesh_of(&triangles);
    let bvh = build(&mesh);
    let mut random = Random(8);
    let mut hits = 0;
    for dir in [Vec3::Z, -Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::new(-1.0, 0.5, 2.0), Vec3::X] {
        let mut rays = Vec::new();
        for _ in 0..256 {
            let org = [0, 1, 2].map(|_| random.below(10) as f32 * 0.5);
            let (tnear, tfar) = ([0.0, 1.0][random.below(2)], [f32::INFINITY, 1.0, 2.0][random.below(3)]);
            rays.push(Ray { org, dir: dir.to_array(), tnear, tfar, skip: MISS });
        }
        hits += check("grid", &mesh, &bvh, &rays);
    }
    assert!(hits > 200, "only {hits} rays hit anything: the test proves little");
}

/// Mirror rays of small patches of every built-in scene.
#[test]
fn reflections_in_the_built_in_scenes_agree() {
    let mut random = Random(22);
    for name in procedural::NAMES {
        let scene = procedural::build(name, 0.2).expect("a built-in scene");
        let bvh = build(&scene.mesh);
        let best = kernels().pop().expect("an instruction set");
        let eye = scene.camera.eye;
        let toward = (scene.camera.at - eye).normalize();
        let mut hits = 0;
        for _ in 0..12 {
            let toward = toward + 0.4 * random.vec();
            let mut rays = Vec::new();
            for i in 0..256 {
                let at = Vec3::new((i % 16) as f32, (i / 16) as f32, 0.0) * 0.002;
                let ray = Ray {
                    org: eye.to_array(),
                    dir: (toward + at).to_array(),
                    tnear: 0.0,
                    tfar: f32::INFINITY,
                    skip: MISS,
                };
                let hit = best.intersect(&bvh.view(), &ray);
                if hit.prim != MISS {
                    let [a, b, c] = scene.mesh.corners(hit.prim as usize);
                    let (n, d) = ((b - a).cross(c - a).normalize_or_zero(), toward + at);
                    let org = (eye + hit.t * d).to_array();
                    let dir = (d - 2.0 * d.dot(n) * n).to_array();
                    rays.push(Ray { org, dir, skip: hit.prim, ..ray });
                }
            }
            let wanted: Vec<Hit> = rays.iter().map(|ray| best.intersect(&bvh.view(), ray)).collect();
            hits += wanted.iter().filter(|hit| hit.prim != MISS).count();
            for kernels in kernels() {
                check_wanted(name, &kernels, &bvh.view(), &rays, &wanted);
            }
            // Brute force looks at every triangle: a few rays must do.
            let few: Vec<Ray> = rays.into_iter().step_by(31).collect();
            check(name, &scene.mesh, &bvh, &few);
        }
        assert!(hits > 100, "{name}: only {hits} rays hit");
    }
}

#[test]
fn an_empty_scene_is_missed_by_beams() {
    let bvh = build(&TriangleMesh::default());
    let rays = random_rays(&mut Random(9), 256, Spread { origin: 0.1, blocks: 0.1, rays: 0.1 }, true);
    assert_eq!(check("empty", &TriangleMesh::default(), &bvh, &rays), 0);
    check("no rays", &TriangleMesh::default(), &bvh, &[]);
}

/// A stream or flight of any rays in any order, and of rays that fly together.
#[test]
fn streams_and_flights_agree_with_single_rays() {
    let mut random = Random(6);
    let mesh = soup(14, 900, 0.2);
    let bvh = build(&mesh);
    let (mut stream, mut flight) = (RayStream::default(), Flight::default());
    for count in [0, 1, 15, 700, 9000] {
        for spread in [2.0, 0.05] {
            let rays = wandering(&mut random, count, spread);
            let mut blocks = Vec::new();
            RayBlock::pack(rays.iter(), &mut blocks);
            // Some are left out; in flights, whole blocks too.
            blocks.iter_mut().step_by(7).for_each(|block| block.active &= 0xf37f);
            let picks: Vec<Pick> = (0..blocks.len() as u32)
                .filter(|block| block % 13 != 5)
                .map(|block| Pick { block, active: 0xfdff })
                .collect();
            for kernels in kernels() {
                let traversal = Traversal::new(&bvh, kernels, KernelChoice::Tile);
                let untouched = Hit { prim: 7, t: -3.0, u: -4.0, v: -5.0 };
                let mut hits = vec![HitBlock::splat(untouched); blocks.len()];
                let mut flown = hits.clone();
                let mut blocked = vec![0x5555; blocks.len()];
                let mut stopped = blocked.clone();
                stream.intersect(&traversal, &blocks, &mut hits);
                stream.occluded(&traversal, &blocks, &mut blocked);
                traversal.intersect_each(&blocks, &picks, &mut flight, &mut flown);
                traversal.occluded_each(&blocks, &picks, &mut flight, &mut stopped);
                for (i, ray) in rays.iter().enumerate() {
                    let (block, lane) = (i / SUB, i % SUB);
                    let hit = kernels.intersect(&bvh.view(), ray);
                    let bit = |bits: u16| bits >> lane & 1 != 0;
                    let active = bit(blocks[block].active);
                    let (want, wanted) =
                        if active { (hit, hit.prim != MISS) } else { (untouched, bit(0x5555)) };
                    same("stream", &kernels, ray, hits[block].get(lane), want);
                    assert_eq!(bit(blocked[block]), wanted, "stream, {}: {ray:?}", kernels.isa());
                    let active = active && bit(0xfdff) && block % 13 != 5;
                    let (want, wanted) =
                        if active { (hit, hit.prim != MISS) } else { (untouched, bit(0x5555)) };
                    same("flight", &kernels, ray, flown[block].get(lane), want);
                    assert_eq!(bit(stopped[block]), wanted, "flight, {}: {ray:?}", kernels.isa());
                }
            }
        }
    }
}

/// Rays about a direction that changes now and then, some without a meaning.
fn wandering(random: &mut Random, count: usize, spread: f32) -> Vec<Ray> {
    let mut rays: Vec<Ray> = Vec::new();
    let mut toward = random.vec();
    while rays.len() < count {
        if random.below(100) == 0 {
            toward = random.vec();
        }
        let mut dir = toward + spread * random.vec();
        match random.below(50) {
            0 => (dir.x, dir.y) = (0.0, -0.0),
            1 => dir = Vec3::ZERO,
            2 => dir.x = f32::INFINITY,
            _ => {}
        }
        let org = 0.5 * random.vec();
        let tfar = if random.below(3) == 0 { 0.5 } else { f32::INFINITY };
        rays.push(Ray { org: org.to_array(), dir: dir.to_array(), tnear: 0.0, tfar, skip: MISS });
    }
    rays
}
