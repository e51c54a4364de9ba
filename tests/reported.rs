//! Defects that users reported of other ray tracers, each as a test of its own: the report above it, its coordinates
//! in it, every instruction set and kernel under it. Where a report needs a mesh, a small one is generated. Reports
//! whose coordinates are not public are left out; what they are about is covered by the properties.

mod boxes; // box tests and builds
mod edges; // leaks at edges and vertices
mod sizes; // scale, distance, slivers
mod starts; // origins on surfaces, rays without a meaning

use crate::support::kernels;
use glam::Vec3;
use irt::{
    bvh::{BuildPreset, Bvh},
    kernels::{Hit, MISS, Ray},
    scene::TriangleMesh,
    study::stability::{Answers, Batch, Form, Kernel, Tracer, direction, mesh::mesh_of, same},
    trace::{KernelChoice, Traversal},
};

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

fn ray(org: Vec3, dir: Vec3) -> Ray {
    Ray { org: org.to_array(), dir: dir.to_array(), tnear: 0.0, tfar: f32::INFINITY, skip: MISS }
}

/// The hits of these rays, which all instruction sets, kernels and trees agree about.
fn hits(mesh: &TriangleMesh, rays: &[Ray]) -> Vec<Hit> {
    let mut first: Option<Vec<Hit>> = None;
    let mut tracer = Tracer::default();
    let mut answers = Answers::default();
    let batch = Batch::general(rays.to_vec());
    for preset in BuildPreset::ALL {
        let bvh = Bvh::build(mesh, preset).expect("builds");
        bvh.validate(mesh).unwrap_or_else(|violation| panic!("{violation}"));
        for kernels in kernels() {
            let traversal = Traversal::new(&bvh, kernels, KernelChoice::Tile);
            for kernel in Kernel::ALL {
                if !tracer.trace(kernel, &traversal, &batch, &mut answers) {
                    continue;
                }
                let wanted = first.get_or_insert_with(|| answers.hits.clone());
                for (i, (hit, want)) in answers.hits.iter().zip(&*wanted).enumerate() {
                    let context = format!("{kernel} on {}, {preset} tree: {:?}", kernels.isa(), rays[i]);
                    assert!(same(hit, want), "{context}: {hit:?}, not {want:?}");
                    assert_eq!(answers.blocked[i], want.prim != MISS, "{context}: blocked");
                    assert!(!hit.t.is_nan() && !hit.u.is_nan() && !hit.v.is_nan(), "{context}: {hit:?}");
                }
            }
        }
    }
    first.expect("something was traced")
}

/// The hit of one ray.
fn hit(triangles: &[[Vec3; 3]], org: Vec3, dir: Vec3) -> Hit {
    hits(&mesh_of(triangles), &[ray(org, dir)])[0]
}

/// Rays from one origin to these targets, by exact, by normalised, and by sloped directions (the last for the kernels
/// of common origins too); all must hit.
fn all_hit(mesh: &TriangleMesh, org: Vec3, targets: &[Vec3]) -> Vec<Hit> {
    let mut all = Vec::new();
    for form in [Form::Exact, Form::Normalised, Form::Slopes] {
        let to = |target: &Vec3| Some(ray(org, direction(*target - org, form)?.into()));
        let rays: Vec<Ray> = targets.iter().filter_map(to).collect();
        let found = hits(mesh, &rays);
        for (ray, hit) in rays.iter().zip(&found) {
            assert_ne!(hit.prim, MISS, "{form}: {ray:?} leaks");
        }
        if form == Form::Slopes {
            check_slopes(mesh, rays, &found);
        }
        all.extend(found);
    }
    all
}

/// The kernels of a common origin find the same.
fn check_slopes(mesh: &TriangleMesh, rays: Vec<Ray>, wanted: &[Hit]) {
    let batch = Batch::slopes(rays);
    let bvh = Bvh::build(mesh, BuildPreset::Medium).expect("builds");
    let mut answers = Answers::default();
    for kernels in kernels() {
        let traversal = Traversal::new(&bvh, kernels, KernelChoice::Tile);
        for kernel in [Kernel::Tile, Kernel::ShadowStream] {
            assert!(Tracer::default().trace(kernel, &traversal, &batch, &mut answers));
            for (i, want) in wanted.iter().enumerate() {
                let ray = batch.rays()[i];
                let found = answers.hits.get(i).is_none_or(|hit| same(hit, want));
                assert!(found && answers.blocked[i], "{kernel} on {}: {ray:?}, not {want:?}", kernels.isa());
            }
        }
    }
}

/// The corners and the middles of the edges of all triangles.
fn corners_and_middles(mesh: &TriangleMesh) -> Vec<Vec3> {
    let of = |prim: usize| {
        let [a, b, c] = mesh.corners(prim);
        [a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]
    };
    (0..mesh.len()).flat_map(of).collect()
}

/// A square of two triangles: corner, then its sides.
fn square(corner: Vec3, x: Vec3, y: Vec3) -> [[Vec3; 3]; 2] {
    [[corner, corner + x, corner + y], [corner + x + y, corner + y, corner + x]]
}

/// A box.
fn cuboid(low: Vec3, high: Vec3) -> Vec<[Vec3; 3]> {
    // Corners that walls share are computed once.
    let at = |i: bool, j: bool, k: bool| {
        let pick = |far: bool, low: f32, high: f32| if far { high } else { low };
        v(pick(i, low.x, high.x), pick(j, low.y, high.y), pick(k, low.z, high.z))
    };
    let wall = |[a, b, c, d]: [Vec3; 4]| [[a, b, c], [d, c, b]];
    let mut all = Vec::new();
    for side in [false, true] {
        all.extend(wall([
            at(side, false, false),
            at(side, true, false),
            at(side, false, true),
            at(side, true, true),
        ]));
        all.extend(wall([
            at(false, side, false),
            at(true, side, false),
            at(false, side, true),
            at(true, side, true),
        ]));
        all.extend(wall([
            at(false, false, side),
            at(true, false, side),
            at(false, true, side),
            at(true, true, side),
        ]));
    }
    all
}
