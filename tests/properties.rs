//! Properties that hold for all inputs, tried on random ones; what fails is shrunk to something small.
//!
//! More cases: `PROPTEST_CASES=5000 cargo test properties`. Longer runs: `irt stability`.

use crate::{rational, support::kernels};
use glam::Vec3;
use irt::{
    bvh::{BuildPreset, Bvh},
    kernels::{Hit, MISS, exact},
    scene::TriangleMesh,
    study::stability::{Answers, Batch, Kernel, Random, Tracer, mesh::Family, random_rays, same},
    trace::{KernelChoice, Traversal},
};
use proptest::prelude::*;

/// As many cases as the environment asks for, or this many.
fn cases(few: u32) -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(few);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// A scene that can be made smaller.
#[derive(Clone, Debug)]
struct Case {
    family: usize,
    count: usize,
    seed: u64,
    /// Scale 2^this.
    power: i32,
    /// Distance from the origin in scales, 0 or a power of two.
    distance: i32,
    preset: usize,
    slopes: bool,
}

fn case() -> impl Strategy<Value = Case> {
    let power = prop_oneof![Just(0), -50..50i32];
    (0..6usize, 1..60usize, any::<u64>(), power, -1..14i32, 0..3usize, any::<bool>()).prop_map(
        |(family, count, seed, power, distance, preset, slopes)| Case {
            family,
            count,
            seed,
            power,
            distance,
            preset,
            slopes,
        },
    )
}

impl Case {
    fn scene(&self) -> (TriangleMesh, Batch) {
        let mut random = Random::new(self.seed, 0);
        let scale = (self.power as f32).exp2();
        let distance = if self.distance < 0 { 0.0 } else { scale * (self.distance as f32).exp2() };
        let center = distance * Vec3::new(1.0, -0.6, 0.3);
        let mesh = Family::ALL[self.family].mesh(&mut random, self.count, center, scale);
        let rays = random_rays(&mut random, &mesh, center, scale, self.slopes, 48);
        (mesh, if self.slopes { Batch::slopes(rays) } else { Batch::general(rays) })
    }
}

/// Every kernel on every instruction set: first hits and whether anything blocks.
fn for_all_kernels(bvh: &Bvh, batch: &Batch, mut check: impl FnMut(String, &Answers)) {
    let (mut tracer, mut answers) = (Tracer::default(), Answers::default());
    for kernels in kernels() {
        let traversal = Traversal::new(bvh, kernels, KernelChoice::Tile);
        for kernel in Kernel::ALL {
            if tracer.trace(kernel, &traversal, batch, &mut answers) {
                check(format!("{kernel} on {}", kernels.isa()), &answers);
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn hits_are_what_rational_numbers_say(case in case()) {
        let (mesh, batch) = case.scene();
        let bvh = Bvh::build(&mesh, BuildPreset::ALL[case.preset]).expect("builds");
        let mut wanted: Option<Vec<Hit>> = None;
        for_all_kernels(&bvh, &batch, |name, answers| {
            let wanted = wanted.get_or_insert_with(|| {
                for (ray, hit) in batch.rays().iter().zip(&answers.hits) {
                    rational::check(&name, &mesh, ray, hit);
                }
                answers.hits.clone()
            });
            for (i, want) in wanted.iter().enumerate() {
                let ray = batch.rays()[i];
                if let Some(hit) = answers.hits.get(i) {
                    assert!(same(hit, want), "{name}: {ray:?}: {hit:?}, not {want:?}");
                }
                assert_eq!(answers.blocked[i], want.prim != MISS, "{name}: {ray:?}");
            }
        });
    }
}

/// A coordinate: small whole numbers often, so that determinants vanish; else anything finite.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => (-4..5i32).prop_map(|x| x as f32),
        2 => (-4..5i32, -3..4i32).prop_map(|(x, ulps)| f32::from_bits(((x as f32).to_bits() as i32 + ulps).max(0) as u32)),
        1 => any::<f32>().prop_filter("finite", |x| x.is_finite()),
    ]
}

fn vector() -> impl Strategy<Value = [f32; 3]> {
    [coordinate(), coordinate(), coordinate()]
}

proptest! {
    #![proptest_config(cases(20_000))]

    #[test]
    fn signs_of_determinants_are_exact(p in vector(), q in vector(), d in vector(), k in -3..4i32) {
        // Half of the time nearly in the plane of p and q.
        let near = [0, 1, 2].map(|i| p[i] + k as f32 * q[i]);
        let d = if k != 0 && near.iter().all(|x| x.is_finite()) { near } else { d };
        let want = rational::sign(&rational::exact(p), &rational::exact(q), &rational::exact(d));
        prop_assert_eq!(exact::det_sign(p, q, d), want);
        prop_assert_eq!(exact::det_sign(q, p, d), -want);
    }
}
