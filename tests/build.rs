//! Trees: every invariant on every kind of input, and the same tree whatever the number of threads.

use crate::support::{mesh_of, soup, sphere};
use glam::Vec3;
use irt::{
    bvh::{BuildPreset, Bvh},
    scene::TriangleMesh,
};

fn valid(context: &str, mesh: &TriangleMesh) {
    for preset in BuildPreset::ALL {
        let bvh = Bvh::build(mesh, preset).unwrap_or_else(|error| panic!("{context}, {preset}: {error}"));
        bvh.validate(mesh).unwrap_or_else(|violation| panic!("{context}, {preset}: {violation}"));
    }
}

/// A triangle of the given size at a place.
fn small(at: Vec3, size: f32) -> [Vec3; 3] {
    [at, at + size * Vec3::X, at + size * Vec3::Y]
}

#[test]
fn trees_are_valid_for_few_and_many_triangles() {
    for count in [0, 1, 2, 7, 8, 9, 63, 1000, 9000] {
        valid(&format!("{count} triangles"), &soup(31, count, 0.2));
    }
    valid("a sphere", &sphere(Vec3::splat(1.0e4), 3.0, 50));
}

#[test]
fn trees_are_valid_where_no_split_is_better_than_another() {
    let one = small(Vec3::ONE, 1.0);
    valid("the same triangle 5000 times", &mesh_of(&vec![one; 5000]));
    let around_one_point = |i: usize| {
        let size = 1.0 + i as f32;
        [Vec3::new(-size, -size, 0.0), Vec3::new(size, -size, 0.0), Vec3::new(0.0, size, 0.0)]
    };
    let nested: Vec<_> = (0..6000).map(around_one_point).collect();
    valid("6000 triangles around one point", &mesh_of(&nested));
    let row: Vec<_> = (0..5000).map(|i| small(Vec3::X * (i / 100) as f32, 0.5)).collect();
    valid("50 places in a row, 100 triangles each", &mesh_of(&row));
}

#[test]
fn trees_are_valid_for_sizes_of_any_magnitude() {
    let sizes: Vec<_> = (0..4000).map(|i| small(Vec3::ZERO, 2.0f32.powi(i % 240 - 120))).collect();
    valid("sizes from 2^-120 to 2^119", &mesh_of(&sizes));
    let places: Vec<_> =
        (0..4000).map(|i| small(Vec3::X * 2.0f32.powi(i % 240 - 120), 2.0f32.powi(i % 240 - 125))).collect();
    valid("places from 2^-120 to 2^119", &mesh_of(&places));
    let huge: Vec<_> = (0..300).map(|i| small(Vec3::splat((i - 150) as f32 * 1.0e36), 1.0e37)).collect();
    valid("coordinates up to 1e38", &mesh_of(&huge));
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let mesh = soup(32, 60_000, 0.02);
    for preset in BuildPreset::ALL {
        let trees = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Bvh::build(&mesh, preset)).unwrap()
        });
        let [one, others @ ..] = &trees;
        one.validate(&mesh).unwrap_or_else(|violation| panic!("{preset}: {violation}"));
        for other in others {
            let (one, other) = (one.view(), other.view());
            assert_eq!(one.root, other.root, "{preset}");
            let nodes = one.nodes.iter().map(|n| (n.bounds, n.child, n.order));
            assert!(
                nodes.eq(other.nodes.iter().map(|n| (n.bounds, n.child, n.order))),
                "{preset}: other nodes"
            );
            let prims = one.blocks.iter().map(|b| b.prim);
            assert!(prims.eq(other.blocks.iter().map(|b| b.prim)), "{preset}: other blocks");
        }
    }
}
