//! Fast visibility leaks where rays are aimed at vertices and edges, and exact visibility does not: with every kernel.

use crate::support::{Random, kernels, sphere};
use glam::Vec3;
use irt::{
    bvh::{BuildPreset, Bvh},
    kernels::{
        EMPTY_NODE, Face, Flight, HitBlock, Kernels, MISS, Pick, Ray, RayBlock, SUB, SUBS, TILE_RAYS,
        TileHits, TilePacket, TileScratch, Visibility,
    },
    scene::TriangleMesh,
};

/// Rays from around the middle of a sphere to its vertices and to points of its edges, in the form that tiles need.
fn aimed(random: &mut Random, mesh: &TriangleMesh, center: Vec3) -> TilePacket {
    let mut packet = TilePacket::new();
    packet.org = (center + 0.3 * random.vec()).to_array();
    packet.face = Face::ALL[random.below(6)];
    let mut ray = 0;
    while ray < TILE_RAYS {
        let [a, b, _] = mesh.corners(random.below(mesh.len()));
        let target = a + [0.0, 0.5, 0.25][random.below(3)] * (b - a);
        let d = target - Vec3::from_array(packet.org);
        let slopes = (d / d.abs().max_element()).to_array();
        if Face::of(slopes) == packet.face {
            let [iu, iv, _] = packet.face.axes();
            (packet.u[ray], packet.v[ray]) = (slopes[iu], slopes[iv]);
            packet.active[ray / SUB] |= 1 << (ray % SUB);
            ray += 1;
        }
    }
    packet
}

/// Rays that miss, and triangles decided exactly, by kernel.
#[derive(Debug, Default)]
struct Counts {
    leaks: [usize; 4],
    doubts: [u64; 4],
}

const KERNELS: [&str; 4] = ["tile", "single", "flight", "beam"];

fn count(kernels: &Kernels, bvh: &Bvh, packet: &TilePacket, counts: &mut Counts) {
    let view = bvh.view();
    let rays: Vec<Ray> = (0..TILE_RAYS).map(|i| packet.ray(i)).collect();
    let mut blocks = Vec::new();
    RayBlock::pack(rays.iter(), &mut blocks);
    let picks: Vec<Pick> = (0..SUBS as u32).map(|block| Pick { block, active: u16::MAX }).collect();
    let (mut scratch, mut hits, mut flight) = (TileScratch::new(), TileHits::new(), Flight::default());
    let missed = |hits: &[HitBlock]| hits.iter().flat_map(|of| of.prim).filter(|&prim| prim == MISS).count();

    let doubts = kernels.tile_intersect(&view, packet, &mut scratch, &mut hits);
    let leaks = hits.prim.iter().filter(|&&prim| prim == MISS).count();
    let mut found = vec![(leaks, doubts)];
    let mut doubts = 0;
    let single = |ray: &&Ray| kernels.intersect_counted(&view, ray, &mut doubts).prim == MISS;
    found.push((rays.iter().filter(single).count(), 0));
    found[1].1 = doubts;
    let mut blocks_hit = vec![HitBlock::MISS; SUBS];
    let doubts = kernels.intersect_each(&view, &blocks, &picks, &mut flight, &mut blocks_hit);
    found.push((missed(&blocks_hit), doubts));
    blocks_hit.fill(HitBlock::MISS);
    let doubts = kernels.beam_intersect(&view, &blocks, &picks, &mut blocks_hit);
    found.push((missed(&blocks_hit), doubts));

    // Occlusion leaks where intersection does, for nothing is behind what is hit.
    let (mut seed, mut blocked) = (EMPTY_NODE, [0; SUBS]);
    kernels.tile_occluded(&view, packet, &mut scratch, &mut seed, &mut blocked);
    let dark: u32 = blocked.iter().map(|bits| bits.count_ones()).sum();
    assert_eq!(TILE_RAYS - dark as usize, found[0].0, "{} {}", kernels.isa(), kernels.visibility());
    for (i, (leaks, doubts)) in found.into_iter().enumerate() {
        counts.leaks[i] += leaks;
        counts.doubts[i] += doubts;
    }
}

#[test]
fn only_fast_visibility_leaks_and_only_exact_visibility_has_doubts() {
    // By instruction set and kernel. The edge functions of tiles are so symmetric that not every place makes them leak.
    let mut leaks = vec![[0; 4]; kernels().len()];
    for center in [Vec3::ZERO, Vec3::splat(100.0), Vec3::new(148_376.0, 1234.0, -223_423.0)] {
        let mesh = sphere(center, 1.0, 16);
        let bvh = Bvh::build(&mesh, BuildPreset::Medium).expect("builds");
        for (kernels, leaks) in kernels().into_iter().zip(&mut leaks) {
            let [exact, fast] = Visibility::ALL.map(|visibility| {
                let kernels = kernels.with_visibility(visibility);
                assert_eq!((kernels.visibility(), kernels.isa()), (visibility, kernels.isa()));
                let (mut counts, mut random) = (Counts::default(), Random(71));
                for _ in 0..100 {
                    count(&kernels, &bvh, &aimed(&mut random, &mesh, center), &mut counts);
                }
                counts
            });
            let isa = kernels.isa();
            assert_eq!(exact.leaks, [0; 4], "{isa}, {center}");
            assert_eq!(fast.doubts, [0; 4], "{isa}, {center}");
            for (i, name) in KERNELS.into_iter().enumerate() {
                assert!(exact.doubts[i] > 1000, "{name}, {isa}, {center}: {exact:?}");
                leaks[i] += fast.leaks[i];
            }
        }
    }
    for (kernels, leaks) in kernels().iter().zip(&leaks) {
        for (name, &leaks) in KERNELS.iter().zip(leaks) {
            assert!(leaks > 4, "{name}, {}: only {leaks} rays leak", kernels.isa());
        }
    }
}

#[test]
fn what_is_remembered_of_one_visibility_does_not_show_in_the_other() {
    let mesh = sphere(Vec3::ZERO, 1.0, 16);
    let bvh = Bvh::build(&mesh, BuildPreset::Medium).expect("builds");
    let mut random = Random(73);
    for kernels in kernels() {
        let mut scratch = TileScratch::new();
        for _ in 0..10 {
            let packet = aimed(&mut random, &mesh, Vec3::ZERO);
            for visibility in [Visibility::Fast, Visibility::Exact, Visibility::Fast] {
                let kernels = kernels.with_visibility(visibility);
                let (mut hits, mut fresh) = (TileHits::new(), TileHits::new());
                kernels.tile_intersect(&bvh.view(), &packet, &mut scratch, &mut hits);
                kernels.tile_intersect(&bvh.view(), &packet, &mut TileScratch::new(), &mut fresh);
                assert_eq!(hits.prim, fresh.prim, "{} {visibility}", kernels.isa());
            }
        }
    }
}

#[test]
fn rays_at_random_are_seldom_in_doubt() {
    let mesh = sphere(Vec3::ZERO, 1.0, 32);
    let bvh = Bvh::build(&mesh, BuildPreset::Medium).expect("builds");
    let mut random = Random(79);
    for kernels in kernels() {
        let (mut doubts, mut rays) = (0, 0);
        for _ in 0..40 {
            let mut packet = TilePacket::new();
            packet.org = (0.3 * random.vec()).to_array();
            packet.face = Face::ALL[random.below(6)];
            packet.active = [u16::MAX; SUBS];
            for ray in 0..TILE_RAYS {
                (packet.u[ray], packet.v[ray]) = (random.signed(), random.signed());
            }
            doubts +=
                kernels.tile_intersect(&bvh.view(), &packet, &mut TileScratch::new(), &mut TileHits::new());
            rays += TILE_RAYS as u64;
        }
        assert!(doubts * 100 < rays, "{}: {doubts} in {rays} rays", kernels.isa());
    }
}
