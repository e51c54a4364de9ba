//! Leaks at edges and vertices, and hits that depend on what has nothing to do with them.

use super::{all_hit, corners_and_middles, cuboid, hit, hits, ray, square, v};
use crate::support::Random;
use glam::Vec3;
use irt::{
    kernels::{MISS, Ray},
    scene::TriangleMesh,
    study::stability::mesh::{indexed, mesh_of, sphere, spindle},
};

/// RenderKit/embree#174: a ray exactly at a vertex of a closed half sphere hits nothing, in robust mode too.
#[test]
fn embree_174_vertices_of_a_closed_half_sphere() {
    let whole = sphere(Vec3::ZERO, 1.0, 16);
    let upper =
        |triangle: &[u32; 3]| triangle.iter().all(|&vertex| whole.positions[vertex as usize].y >= -1.0e-6);
    let mut triangles: Vec<[Vec3; 3]> = whole
        .triangles
        .iter()
        .filter(|triangle| upper(triangle))
        .map(|triangle| triangle.map(|vertex| whole.positions[vertex as usize]))
        .collect();
    // The lid: a fan over the rim.
    let rim: Vec<[Vec3; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|edge| edge.iter().all(|p| p.y.abs() < 1.0e-6))
        .collect();
    triangles.extend(rim.iter().map(|&[a, b]| [a, b, v(0.0, 0.0, 0.0)]));
    let mesh = mesh_of(&triangles);
    all_hit(&mesh, v(0.1, 0.3, -0.05), &corners_and_middles(&mesh));
}

/// A tube of 12 sides and two storeys around the y axis: 48 triangles.
fn cylinder(radius: f32) -> Vec<[Vec3; 3]> {
    let at = |i: usize, y: f32| {
        let phi = std::f32::consts::TAU * (i % 12) as f32 / 12.0;
        v(radius * phi.cos(), y, radius * phi.sin())
    };
    let panel = |i: usize, low: f32, high: f32| {
        [[at(i, low), at(i + 1, low), at(i, high)], [at(i + 1, high), at(i, high), at(i + 1, low)]]
    };
    (0..12).flat_map(|i| [panel(i, -1.0, 0.0), panel(i, 0.0, 1.0)].concat()).collect()
}

/// embree#181: ten nested cylinders, rays through a vertex; adding a mesh that has nothing to do with it changes the
/// hit.
#[test]
fn embree_181_an_unrelated_mesh_changes_nothing() {
    let mut triangles: Vec<[Vec3; 3]> = (1..=10).flat_map(|i| cylinder(0.1 * i as f32)).collect();
    // The rims are open.
    let mut targets = corners_and_middles(&mesh_of(&triangles[..48]));
    targets.retain(|p| p.y.abs() < 0.9);
    let alone = all_hit(&mesh_of(&triangles), v(0.01, 0.1, 0.02), &targets);
    assert!(alone.iter().all(|hit| hit.prim < 48), "the innermost is hit first");
    triangles.extend((0..50).map(|i| [v(5.0, i as f32, 5.0), v(6.0, i as f32, 5.0), v(5.0, i as f32, 6.0)]));
    assert_eq!(all_hit(&mesh_of(&triangles), v(0.01, 0.1, 0.02), &targets), alone);
}

/// embree#188: a ray through an edge gives two hits. Both count; one query names the lower, skipping it the other, and
/// skipping from there on there is no third.
#[test]
fn embree_188_an_edge_belongs_to_both_triangles() {
    let mesh = mesh_of(&square(v(-1.0, -1.0, 2.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0)));
    let first = Ray { tfar: 10.0, ..ray(Vec3::ZERO, Vec3::Z) };
    let found = hits(&mesh, &[first, Ray { skip: 0, ..first }, Ray { skip: 1, tnear: 2.0, ..first }]);
    assert_eq!(found.iter().map(|hit| (hit.prim, hit.t)).collect::<Vec<_>>(), [(0, 2.0), (1, 2.0), (0, 2.0)]);
}

/// embree#381: a closed sphere of radius 5 seen from (100, 0, 0) is hit at its far side, through its front.
#[test]
fn embree_381_no_hit_behind_the_front_of_a_sphere() {
    let mesh = sphere(Vec3::ZERO, 5.0, 24);
    let eye = v(100.0, 0.0, 0.0);
    // Away from the rim, where grazing rays may meet either side.
    let front: Vec<Vec3> = corners_and_middles(&mesh).into_iter().filter(|p| p.x > 1.0).collect();
    for hit in all_hit(&mesh, eye, &front) {
        let [a, b, c] = mesh.corners(hit.prim as usize);
        assert!(a.x.max(b.x).max(c.x) > 0.0, "{hit:?} is at the far side");
    }
}

/// embree#109: holes along the edges that meet in the middle of the image.
#[test]
fn embree_109_edges_through_the_middle_of_the_image() {
    let (a, b) = (v(-3.0, -2.0, 5.0), v(3.0, 2.0, 5.0));
    let mesh = mesh_of(&[[a, b, v(3.0, -4.0, 5.0)], [b, a, v(-3.0, 4.0, 5.0)]]);
    let along: Vec<Vec3> = (1..64).map(|i| a + (b - a) * (i as f32 / 64.0)).collect();
    all_hit(&mesh, Vec3::ZERO, &along);
}

/// mitsuba-renderer/mitsuba3#1149: rays through edges of a part of a sphere, some of them grazing.
#[test]
fn mitsuba3_1149_grazing_rays_through_edges_of_a_sphere() {
    let mesh = sphere(v(0.0, 0.083, 0.4), 0.015, 24);
    // From just inside, along the wall: the farther a target, the flatter the ray.
    let org = v(0.0145, 0.083, 0.4);
    all_hit(&mesh, org, &corners_and_middles(&mesh));
}

/// jbikker/tinybvh#168: a mesh of whole coordinates under rays along the axes leaks.
#[test]
fn tinybvh_168_whole_coordinates_and_axis_rays() {
    let mesh = irt::study::stability::mesh::cube(Vec3::ZERO, 8.0, 8);
    let inside = (-7..=7).flat_map(|x| (-7..=7).map(move |y| v(x as f32, y as f32, 3.0)));
    let rays: Vec<Ray> =
        inside.flat_map(|p| [Vec3::Z, -Vec3::Z, Vec3::X, -Vec3::Y].map(|dir| ray(p, dir))).collect();
    for (ray, hit) in rays.iter().zip(hits(&mesh, &rays)) {
        let axis = (0..3).find(|&axis| ray.dir[axis] != 0.0).expect("an axis");
        let wanted = 8.0 - ray.org[axis] * ray.dir[axis];
        assert_eq!(hit.t, wanted, "{ray:?}");
    }
}

/// madmann91/bvh#51 and #9: a sphere of 32 x 16 has holes where pixel centers fall on edges; dir.x is 0.
#[test]
fn madmann91_51_pixel_centers_on_edges_of_a_uv_sphere() {
    let mesh = sphere(Vec3::ZERO, 1.0, 16);
    let mut rays = Vec::new();
    for i in 0..64 {
        for j in 0..64 {
            let (x, y) = ((i as f32 - 32.0) / 64.0, (j as f32 - 32.0) / 64.0);
            rays.push(ray(v(0.0, 0.0, -3.0), v(x * 0.4, y * 0.4, 1.0)));
        }
    }
    assert!(rays.iter().any(|ray| ray.dir[0] == 0.0));
    for (ray, hit) in rays.iter().zip(hits(&mesh, &rays)) {
        assert!(hit.prim != MISS && hit.t < 3.0, "{ray:?}: {hit:?}");
    }
}

/// Oblikovati/Oblikovati#2146: both triangles of a square of +-5 miss a ray through their diagonal, if edge functions
/// are fused.
#[test]
fn oblikovati_2146_the_diagonal_of_a_square() {
    let [a, b, c, d] = [v(-5.0, -5.0, 0.0), v(5.0, -5.0, 0.0), v(5.0, 5.0, 0.0), v(-5.0, 5.0, 0.0)];
    let dir = v(0.304_584_47, 0.304_584_47, -0.902_472_5);
    let found = hit(&[[a, b, c], [a, c, d]], v(0.0, 0.0, 10.0), dir);
    assert_ne!(found.prim, MISS);
}

/// mikedh/trimesh#1766: a square of +-1, a ray through the middle of its diagonal.
#[test]
fn trimesh_1766_the_middle_of_a_square() {
    let [a, b, c, d] = [v(-1.0, -1.0, 0.0), v(1.0, -1.0, 0.0), v(1.0, 1.0, 0.0), v(-1.0, 1.0, 0.0)];
    for triangles in [[[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]] {
        assert_eq!(hit(&triangles, v(0.0, 0.0, -1.0), Vec3::Z).t, 1.0);
        assert_eq!(hit(&triangles, v(0.0, 0.0, 1.0), -Vec3::Z).prim, 0);
    }
}

/// trimesh#1496: rays from the middle of nested boxes to their vertices.
#[test]
fn trimesh_1496_corners_of_nested_boxes() {
    let mut triangles = Vec::new();
    for i in 1..=4 {
        triangles.extend(cuboid(Vec3::splat(-(i as f32) * 0.7), Vec3::splat(i as f32 * 0.7)));
    }
    let targets = corners_and_middles(&mesh_of(&triangles[..12]));
    let found = all_hit(&mesh_of(&triangles), Vec3::ZERO, &targets);
    assert!(found.iter().all(|hit| hit.prim < 12), "the innermost box is hit");
}

/// mrdoob/three.js#11449: Moller and Trumbore's test leaks at the edges of a box.
#[test]
fn three_js_11449_edges_of_a_box() {
    let mut random = Random(11_449);
    let mesh = mesh_of(&cuboid(v(-0.3, -1.1, -0.7), v(1.3, 0.9, 0.1)));
    for _ in 0..20 {
        let org = v(0.5, -0.1, -0.3) + 0.3 * random.vec();
        let on_edges = (0..mesh.len()).map(|prim| {
            let [a, b, _] = mesh.corners(prim);
            a + random.signed().abs() * (b - a)
        });
        all_hit(&mesh, org, &on_edges.collect::<Vec<_>>());
    }
}

/// dimforge/parry#444: holes of one pixel in a scanned model, where small triangles meet.
#[test]
fn parry_444_holes_between_small_triangles() {
    let mesh = sphere(v(0.02, 0.11, 0.0), 0.08, 48);
    let targets: Vec<Vec3> = corners_and_middles(&mesh).into_iter().step_by(23).collect();
    all_hit(&mesh, v(0.021, 0.105, 0.003), &targets);
}

/// chunky-dev/chunky#799: rays leak between blocks that touch along an edge.
#[test]
fn chunky_799_blocks_that_share_an_edge() {
    let mut triangles = cuboid(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(v(1.0, 0.0, 1.0), v(2.0, 1.0, 2.0)));
    let on_edge: Vec<Vec3> = (1..32).map(|i| v(1.0, i as f32 / 32.0, 1.0)).collect();
    // Between the blocks, from the side where neither is.
    for org in [v(2.5, 0.4, -0.5), v(1.7, 0.9, 0.3), v(4.0, 0.5, -2.0)] {
        all_hit(&mesh_of(&triangles), org, &on_edge);
    }
}

/// KhronosGroup/VK-GL-CTS, closed fan (and #446): the middle of a fan and the middles of its edges are hit.
#[test]
fn vk_gl_cts_446_closed_fans() {
    let mut random = Random(446);
    for segments in [3, 4, 7, 64] {
        let mut positions = vec![0.1 * random.vec()];
        positions.extend((0..segments).map(|i| {
            let phi = std::f32::consts::TAU * i as f32 / segments as f32;
            v(phi.cos(), phi.sin(), 0.3 * random.signed())
        }));
        let spokes: Vec<Vec3> = (1..=segments).map(|i| 0.5 * (positions[0] + positions[i])).collect();
        let triangles = (0..segments as u32).map(|i| [0, 1 + i, 1 + (i + 1) % segments as u32]);
        let mesh: TriangleMesh = indexed(positions.clone(), triangles.collect());
        for org in [v(0.0, 0.0, -4.0), v(0.1, -0.1, 7.0), v(0.0, 0.0, -1.0e4)] {
            // Spokes of the widest angle are inner edges for any origin far enough along z.
            let targets: Vec<Vec3> = spokes.iter().chain(&positions[..1]).copied().collect();
            all_hit(&mesh, org, &targets);
        }
    }
}

/// lighttransport/embree-aarch64#28: the watertight test fails where reciprocals are approximate; and
/// isl-org/Open3D#6278: rays at vertices miss.
#[test]
fn embree_aarch64_28_closed_meshes_on_every_instruction_set() {
    let center = v(148_376.0, 1234.0, -223_423.0);
    for mesh in [sphere(center, 2.0, 8), spindle(center, 2.0, 16)] {
        all_hit(&mesh, center + v(0.125, 0.25, -0.125), &corners_and_middles(&mesh));
    }
}
