//! The counting kernel of the coherence study: brute force's hits whatever the switches, and exact counts.

use crate::support::{Random, brute_force, kernels, soup, sphere};
use irt::{
    bvh::{BuildPreset, Bvh},
    kernels::{
        BvhView, Hit, Kernels, MISS, NodeKind, NodeRef, Ray,
        probe::{Blocked, Closest, Counts, NO_TRIANGLE, Occluder, ProbeScratch},
    },
    scene::TriangleMesh,
};

/// Rays that mostly fly towards the middle.
fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|_| {
            let org = random.vec() * 1.5;
            Ray {
                org: org.to_array(),
                dir: (0.5 * random.vec() - org).to_array(),
                tnear: 0.0,
                tfar: if random.below(3) == 0 { f32::INFINITY } else { 2.5 * random.signed().abs() },
                skip: if random.below(3) == 0 { random.below(20) as u32 } else { MISS },
            }
        })
        .collect()
}

/// The switches of [`Blocked`].
#[derive(Clone, Copy)]
struct How {
    stop: bool,
    beyond: bool,
    from_surface: bool,
}

fn blocked(
    kernels: &Kernels,
    bvh: &BvhView,
    ray: &Ray,
    How { stop, beyond, from_surface }: How,
    seeds: &[u32],
    counter: &mut Counts,
) -> Occluder {
    let scratch = &mut ProbeScratch::default();
    kernels.run(Blocked { bvh, ray, from_surface, stop, beyond, seeds, scratch, counter })
}

fn meshes() -> Vec<TriangleMesh> {
    vec![soup(3, 5, 1.0), soup(4, 200, 0.4), soup(5, 1200, 0.15), sphere(glam::Vec3::ZERO, 0.8, 9)]
}

fn bits(hit: Hit) -> [u32; 4] {
    [hit.prim, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()]
}

/// The farthest hit within the ray: the one that a search from its end meets first.
fn last_hit(mesh: &TriangleMesh, ray: &Ray) -> Hit {
    let mut last = Hit::MISS;
    for prim in (0..mesh.len() as u32).filter(|&prim| prim != ray.skip) {
        let corners = mesh.corners(prim as usize);
        let mut one = brute_force(&crate::support::mesh_of(&[corners]), &Ray { skip: MISS, ..*ray });
        if one.prim != MISS && (last.prim == MISS || one.t > last.t) {
            one.prim = prim;
            last = one;
        }
    }
    last
}

#[test]
fn whatever_ends_early_or_is_tried_first_hits_are_those_of_brute_force() {
    let mut random = Random(77);
    let mut seen = 0;
    for mesh in meshes() {
        let bvh = Bvh::build(&mesh, BuildPreset::Medium).unwrap();
        let tree = bvh.view();
        let prim = |slot: u32| tree.blocks[slot as usize / 8].prim[slot as usize % 8];
        let mut seeds = vec![NO_TRIANGLE, u32::MAX - 9, tree.blocks.len() as u32 * 8];
        for ray in rays(&mut random, 120) {
            let want = brute_force(&mesh, &ray);
            let last = last_hit(&mesh, &ray);
            seen += u32::from(want.prim != MISS);
            let seeds_now = [seeds[random.below(seeds.len())], seeds[random.below(seeds.len())]];
            for kernels in kernels() {
                let (mut scratch, mut counts) = (ProbeScratch::default(), Counts::default());
                for bound in [false, true] {
                    for seeds in [&[][..], &seeds_now] {
                        let (bvh, ray, scratch, counter) = (&tree, &ray, &mut scratch, &mut counts);
                        let found = kernels.run(Closest { bvh, ray, bound, seeds, scratch, counter });
                        assert_eq!(bits(found.hit), bits(want), "{} {bound} {ray:?}", kernels.isa());
                        assert_eq!(found.slot == NO_TRIANGLE, want.prim == MISS);
                        if want.prim != MISS {
                            assert_eq!(prim(found.slot), want.prim);
                        }
                    }
                }
                for (stop, beyond, from_surface) in [
                    (false, false, false),
                    (false, true, false),
                    (true, true, false),
                    (true, false, true),
                    (false, false, true),
                ] {
                    for seeds in [&[][..], &seeds_now] {
                        let how = How { stop, beyond, from_surface };
                        let found = blocked(&kernels, &tree, &ray, how, seeds, &mut counts);
                        assert_eq!(found.slot == NO_TRIANGLE, want.prim == MISS, "{} {ray:?}", kernels.isa());
                        if !stop && !found.seeded && want.prim != MISS {
                            let nearest = if from_surface { want } else { last };
                            let found = prim(found.slot);
                            // Coinciding triangles may take each other's place.
                            let twin = mesh.corners(found as usize) == mesh.corners(nearest.prim as usize);
                            assert!(found == nearest.prim || twin, "{found} {nearest:?} {ray:?}");
                        }
                        if found.seeded {
                            assert!(seeds.contains(&found.slot));
                        }
                    }
                }
            }
            if want.prim != MISS {
                let slot = (0..tree.blocks.len() as u32 * 8).find(|&slot| prim(slot) == want.prim);
                seeds.extend(slot);
            }
        }
    }
    assert!(seen > 100, "{seen}");
}

/// Nodes, boxes and triangles of a search that skips nothing, by plain recursion.
fn count(tree: &BvhView, node: NodeRef, ray: &Ray, counts: &mut Counts) {
    counts.steps += 1;
    match node.kind() {
        NodeKind::Empty => unreachable!("an empty child is never met"),
        NodeKind::Leaf { count, .. } => counts.triangles += u64::from(count),
        NodeKind::Inner(index) => {
            let node = &tree.nodes[index];
            for child in (0..8).filter(|&child| node.child[child].kind() != NodeKind::Empty) {
                counts.boxes += 1;
                let (mut near, mut far) = (f64::from(ray.tnear), f64::from(ray.tfar));
                for axis in 0..3 {
                    let plane = |side: usize| {
                        let distance =
                            f64::from(node.bounds[2 * axis + side][child]) - f64::from(ray.org[axis]);
                        distance / f64::from(ray.dir[axis])
                    };
                    near = near.max(plane(0).min(plane(1)));
                    far = far.min(plane(0).max(plane(1)));
                }
                if near <= far {
                    count(tree, node.child[child], ray, counts);
                }
            }
        }
    }
}

#[test]
fn counts_are_those_of_a_plain_recursion() {
    let mut random = Random(5);
    let mut total = Counts::default();
    for mesh in meshes() {
        let bvh = Bvh::build(&mesh, BuildPreset::Medium).unwrap();
        let tree = bvh.view();
        for ray in rays(&mut random, 200) {
            let mut want = Counts::default();
            count(&tree, tree.root, &ray, &mut want);
            for kernels in kernels() {
                let (mut scratch, mut got) = (ProbeScratch::default(), Counts::default());
                let (bvh, ray, scratch) = (&tree, &ray, &mut scratch);
                kernels.run(Closest { bvh, ray, bound: false, seeds: &[], scratch, counter: &mut got });
                assert_eq!(got, want, "{} {ray:?}", kernels.isa());
                let mut bounded = Counts::default();
                kernels.run(Closest { bvh, ray, bound: true, seeds: &[], scratch, counter: &mut bounded });
                assert!(bounded.steps <= want.steps && bounded.boxes <= want.boxes);
                assert!(bounded.triangles <= want.triangles);
                let mut all = Counts::default();
                let how = How { stop: false, beyond: false, from_surface: false };
                blocked(&kernels, &tree, ray, how, &[NO_TRIANGLE], &mut all);
                assert_eq!(all, want, "{} {ray:?}", kernels.isa());
            }
            total.steps += want.steps;
        }
    }
    assert!(total.steps > 4000, "{total:?}");
}
