//! Small, large, far and thin triangles.

use super::{all_hit, corners_and_middles, cuboid, hit, hits, ray, v};
use crate::support::Random;
use glam::Vec3;
use irt::{
    kernels::{MISS, Ray},
    study::stability::mesh::{mesh_of, sphere},
};

/// RenderKit/embree#387: a sliver with sides of 11.2, 9.7 and 1.4 and a ray half a degree off its plane: a hit at
/// t = 12291 although no vertex is farther than 600.
#[test]
fn embree_387_hits_stay_within_the_sliver() {
    let mut random = Random(387);
    let (mut rays, mut triangles) = (Vec::new(), Vec::new());
    for _ in 0..200 {
        let a = 300.0 * random.vec();
        let along = random.vec().normalize();
        let across = along.cross(random.vec()).normalize();
        // Sides as reported: the third corner lies 1.4 off, nearly on the line.
        triangles.push([a, a + 11.2 * along, a + 9.75 * along + 0.06 * across]);
        let normal = along.cross(across);
        let flat = (along + 0.3 * random.signed() * across).normalize();
        let dir = flat + 0.0091 * normal;
        rays.push(ray(a + (5.0 + random.signed()) * along - 400.0 * dir + 0.2 * random.vec(), dir));
    }
    let mesh = mesh_of(&triangles);
    for (ray, hit) in rays.iter().zip(hits(&mesh, &rays)).filter(|(_, hit)| hit.prim != MISS) {
        let org = Vec3::from(ray.org);
        let farthest =
            mesh.corners(hit.prim as usize).map(|p| (p - org).length()).into_iter().fold(0.0, f32::max);
        assert!(
            hit.t * Vec3::from(ray.dir).length() <= farthest * 1.0001,
            "{ray:?}: {hit:?}, farthest {farthest}"
        );
    }
}

/// mmp/pbrt-v4, Triangle.BadCases: three corners on a line are hit by a watertight test without a check of the area.
#[test]
fn pbrt_v4_bad_cases_a_line_is_missed() {
    let line = [
        v(-1_113.454_6, -79.049_614, -56.243_19),
        v(-1_113.454_6, -87.092_27, -56.243_19),
        v(-1_113.454_6, -79.209_015, -56.243_19),
    ];
    let mesh = irt::scene::TriangleMesh {
        positions: line.into(),
        triangles: vec![[0, 1, 2]],
        materials: vec![0],
        ..irt::scene::TriangleMesh::default()
    };
    let ray = Ray {
        tfar: 0.9999,
        ..ray(v(-1_081.479_2, 99.999_954, 87.770_11), v(-32.107_3, -183.355_87, -144.607_64))
    };
    assert_eq!(hits(&mesh, &[ray])[0].prim, MISS);
}

/// jbikker/tinybvh#283: a triangle of size 2e-4 is missed, because its determinant is below a cut-off.
#[test]
fn tinybvh_283_small_triangles() {
    for s in [2.0e-4, 2.0e-7, 2.0e-12] {
        let found = hit(&[[Vec3::ZERO, v(s, 0.0, 0.0), v(0.0, s, 0.0)]], v(s / 3.0, s / 3.0, -1.0), Vec3::Z);
        assert_eq!((found.prim, found.t), (0, 1.0), "size {s:e}");
    }
}

/// gkjohnson/three-mesh-bvh#684: a long triangle is missed by a ray that runs along the plane of its lowest edge.
#[test]
fn three_mesh_bvh_684_a_ray_beside_an_edge() {
    let triangle =
        [v(-1.383_668, -4.480_312, 10.0), v(3.927_311, 5.897_944_5, 8.0), v(-1.383_668, -4.480_312, 8.0)];
    let (org, dir) = (v(-0.028_221_703, -2.505_889, 8.0), v(-0.168_528_38, 0.985_696_8, 0.0));
    // In exact arithmetic, by the sheared plane of the edge at z = 8: whoever hits it does so at its end.
    let found = hit(&[triangle], org, dir);
    let point = org + found.t * dir;
    let [_, b, c] = triangle;
    let along = (b - c).normalize();
    let off = (point - c) - along * (point - c).dot(along);
    assert!(found.prim == 0 && off.length() < 1.0e-5, "{found:?}");
}

/// godotengine/godot#53844: a determinant's cut-off lets light into baked rooms of small triangles.
#[test]
fn godot_53844_rooms_of_small_triangles() {
    for size in [1.0e-2, 1.0e-4, 1.0e-7] {
        let mesh = mesh_of(&cuboid(Vec3::ZERO, Vec3::splat(size)));
        all_hit(&mesh, Vec3::splat(size) * v(0.3, 0.45, 0.6), &corners_and_middles(&mesh));
    }
}

/// RenderKit/ospray#20, #274, LuxCoreRender/LuxCore#79: results change when the scene is scaled. By a power of two,
/// everything scales exactly.
#[test]
fn ospray_20_scaled_scenes_give_scaled_hits() {
    let mut random = Random(20);
    let dirs: Vec<Vec3> = (0..256).map(|_| random.vec()).collect();
    let found = |scale: f32| {
        let mesh = sphere(Vec3::ZERO, 0.12, 12);
        let mesh = mesh_of(&(0..mesh.len()).map(|i| mesh.corners(i).map(|p| p * scale)).collect::<Vec<_>>());
        let rays: Vec<Ray> = dirs.iter().map(|&dir| ray(scale * v(0.01, 0.02, 0.03), dir)).collect();
        hits(&mesh, &rays)
    };
    let one = found(1.0);
    for power in [-30, -10, 10, 30] {
        let scale = (power as f32).exp2();
        for (hit, one) in found(scale).iter().zip(&one) {
            assert_eq!((hit.prim, hit.t, hit.u, hit.v), (one.prim, scale * one.t, one.u, one.v), "2^{power}");
        }
    }
}

/// RenderKit/embree#52: u and v are doubled where a component of the direction is 0.
#[test]
fn embree_52_weights_with_a_zero_component() {
    let (org, dir, t) = (v(0.1, 1.094_82, 29.898_4), v(0.0, 0.994_82, -0.101_655), 294.116);
    let middle = org + t * dir;
    let corners = [middle + v(-3.0, 1.0, -2.0), middle + v(5.0, 1.5, -2.0), middle + v(-0.5, -1.0, 6.0)];
    let found = hit(&[corners], org, dir);
    let [a, b, c] = corners;
    let point = a + found.u * (b - a) + found.v * (c - a);
    assert!(found.prim == 0 && (point - (org + found.t * dir)).length() < 1.0e-3, "{found:?}");
}

/// POV-Ray/povray#121: a shallow pyramid of triangles has gaps.
#[test]
fn povray_121_a_shallow_pyramid() {
    for height in [1.0e-2, 1.0e-4, 1.0e-6] {
        let top = v(0.0, height, 0.0);
        let base = [v(-1.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(1.0, 0.0, 1.0), v(-1.0, 0.0, 1.0)];
        let sides: Vec<[Vec3; 3]> = (0..4).map(|i| [base[i], base[(i + 1) % 4], top]).collect();
        let ridges: Vec<Vec3> = (0..4).map(|i| 0.5 * (base[i] + top)).chain([top]).collect();
        all_hit(&mesh_of(&sides), v(0.1, 2.0, -0.2), &ridges);
    }
}
