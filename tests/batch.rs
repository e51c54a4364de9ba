//! Batches of arbitrary rays give exactly what single rays give, however they are grouped and on any number of
//! threads.

use crate::support::{Random, kernels, soup};
use irt::{
    bvh::{BuildPreset, Bvh},
    kernels::{Hit, Kernels, MISS, Ray},
    scene::TriangleMesh,
    trace::{KernelChoice, Traversal},
};

/// Rays that hit nothing by definition, and directions that are hard to group.
fn odd_rays(origin: [f32; 3]) -> Vec<Ray> {
    let ray = |dir: [f32; 3]| Ray { org: origin, dir, tnear: 0.0, tfar: f32::INFINITY, skip: MISS };
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let mut rays: Vec<Ray> = [
        [0.0; 3],
        [nan, 1.0, 0.0],
        [1.0, nan, 0.0],
        [1.0, 0.0, nan],
        [inf, 1.0, 0.0],
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, -1.0],
        [1.0, -0.0, 0.0],
        [0.0, -1.0, 1e-45],
        [2.0, 1.0, 0.0],
        [1e-40, 1e-41, 0.0],
    ]
    .map(ray)
    .into();
    for (tnear, tfar) in
        [(nan, inf), (0.0, nan), (0.0, 0.0), (0.0, -1.0), (-1.0, inf), (2.0, 1.0), (-0.0, 1.5), (0.3, 0.9)]
    {
        rays.push(Ray { tnear, tfar, ..ray([1.0, 0.25, -0.5]) });
    }
    rays
}

/// Rays from one origin: along rows of an image on each face, with odd ones among them.
fn fan(random: &mut Random, count: usize) -> Vec<Ray> {
    let origin = (0.2 * random.vec()).to_array();
    let odd = odd_rays(origin);
    let ray = |i: usize| {
        // Odd directions keep whole packets apart: further on, neighbours stay close and only other things are odd.
        let calm = i >= 4000;
        if i % 97 == 5 && !calm {
            return odd[i / 97 % odd.len()];
        }
        // 600 rays side by side, then the next row; every 1500 rays another face.
        let (u, v) = ((i % 600) as f32 / 300.0 - 1.0, (i / 600 % 100) as f32 / 50.0 - 1.0);
        let dir = irt::kernels::Face::ALL[i / 1500 % 6].direction(u, v);
        let tfar = if i.is_multiple_of(7) { 0.5 } else { f32::INFINITY };
        let ray = Ray { org: origin, dir, tnear: 0.0, tfar, skip: MISS };
        match i % 29 {
            3 if calm => Ray { tnear: 0.4, ..ray },
            5 if calm => Ray { tnear: -1.0, ..ray },
            7 if calm => Ray { dir: dir.map(|x| 0.75 * x), tfar: 0.5, ..ray },
            _ => ray,
        }
    };
    (0..count).map(ray).collect()
}

fn random_ray(random: &mut Random) -> Ray {
    let (org, dir) = ((1.5 * random.vec()).to_array(), random.vec().to_array());
    let tnear = random.signed().max(0.0);
    let tfar = if random.below(2) == 0 { f32::INFINITY } else { tnear + 2.0 * random.signed().abs() };
    Ray { org, dir, tnear, tfar, skip: MISS }
}

fn same(a: &Hit, b: &Hit) -> bool {
    a.prim == b.prim && [a.t, a.u, a.v].map(f32::to_bits) == [b.t, b.u, b.v].map(f32::to_bits)
}

/// Compares batches with single rays; returns the number of hits.
fn compare(mesh: &TriangleMesh, kernels: Kernels, rays: &[Ray], threads: usize) -> usize {
    let bvh = Bvh::build(mesh, BuildPreset::Fast).unwrap();
    let traversal = |kernel| Traversal::new(&bvh, kernels, kernel);
    let expected: Vec<Hit> =
        rays.iter().map(|ray| traversal(KernelChoice::Single).intersect_ray(ray)).collect();
    for kernel in KernelChoice::ALL {
        // Something that no result equals, so that a ray left out is found.
        let mut hits = vec![Hit { prim: 12_345, t: -1.0, u: -1.0, v: -1.0 }; rays.len()];
        let mut blocked = vec![2; rays.len()];
        traversal(kernel).intersect_batch(rays, &mut hits, threads, &|_| ());
        traversal(kernel).occluded_batch(rays, &mut blocked, threads, &|_| ());
        for (i, (ray, expected)) in rays.iter().zip(&expected).enumerate() {
            let isa = kernels.isa();
            let (hit, blocked) = (&hits[i], blocked[i]);
            assert!(same(hit, expected), "{isa}, {kernel}, ray {i} {ray:?}: {hit:?}, not {expected:?}");
            assert_eq!(blocked, u8::from(expected.prim != MISS), "{isa}, {kernel}, ray {i} {ray:?}");
        }
    }
    expected.iter().filter(|hit| hit.prim != MISS).count()
}

#[test]
fn a_common_origin_gives_what_single_rays_give() {
    let mesh = soup(7, 300, 0.4);
    let mut random = Random(8);
    for kernels in kernels() {
        let rays = fan(&mut random, 9000);
        let hits = compare(&mesh, kernels, &rays, 2);
        assert!(hits > 1000 && hits < rays.len() - 300, "{hits} hits");
        // Nearly common is not common.
        let mut rays = rays;
        rays.iter_mut().skip(4000).step_by(11).for_each(|ray| ray.org[1] += 0.05);
        compare(&mesh, kernels, &rays, 2);
    }
}

#[test]
fn random_and_odd_rays_give_what_single_rays_give() {
    let mesh = soup(17, 300, 0.4);
    let mut random = Random(18);
    for (kernels, threads) in kernels().into_iter().zip([1, 2, 3, 7]) {
        let mut rays: Vec<Ray> = (0..5000).map(|_| random_ray(&mut random)).collect();
        rays.extend(odd_rays([0.1, 0.2, -0.3]));
        rays.extend(odd_rays([f32::NAN, 0.0, 0.0]));
        rays.extend(odd_rays([0.0, f32::INFINITY, 0.0]));
        assert!(compare(&mesh, kernels, &rays, threads) > 500);
        // A whole batch without a usable origin, and one without a ray.
        assert_eq!(compare(&mesh, kernels, &odd_rays([f32::NAN; 3]), threads), 0);
        assert_eq!(compare(&mesh, kernels, &[], threads), 0);
    }
}

#[test]
fn ten_million_rays_give_what_single_rays_give() {
    let mesh = soup(27, 20_000, 0.05);
    let mut random = Random(28);
    let mut rays: Vec<Ray> = (0..5_000_000).map(|_| random_ray(&mut random)).collect();
    rays.extend(fan(&mut random, 5_000_000));
    assert!(compare(&mesh, Kernels::detect(), &rays, 2) > 1_000_000);
}
