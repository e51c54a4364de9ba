//! Box tests that reject true hits, and trees that cannot be built.

use super::{all_hit, corners_and_middles, cuboid, hit, hits, ray, square, v};
use crate::support::Random;
use glam::Vec3;
use irt::{
    kernels::{Hit, MISS, Ray},
    scene::TriangleMesh,
    study::stability::mesh::{mesh_of, sphere},
};

/// RenderKit/embree#464: flat squares are missed.
#[test]
fn embree_464_flat_squares() {
    let (one, two) = (v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0));
    let mut triangles = Vec::new();
    for i in 0..40 {
        triangles.extend(square(v(i as f32, 0.0, 3.0), one, two));
        triangles.extend(square(v(i as f32, 3.0, 0.0), one, v(0.0, 0.0, 1.0)));
    }
    for i in 0..40 {
        assert_eq!(hit(&triangles, v(i as f32 + 0.5, 0.25, 0.0), Vec3::Z).t, 3.0);
        assert_eq!(hit(&triangles, v(i as f32 + 0.5, 0.0, 0.25), Vec3::Y).t, 3.0);
    }
}

/// embree#416: a box of +-5.89e8 .. 5.89e11 is hit by rays that pass beside it.
#[test]
fn embree_416_huge_boxes() {
    for half in [5.89e8, 5.89e9, 5.89e10, 5.89e11] {
        let mesh = mesh_of(&cuboid(v(-half, -half, 0.0), v(half, half, 120_000.0)));
        all_hit(&mesh, v(0.5, 0.25, 60_000.0), &corners_and_middles(&mesh));
        let mut random = Random(416);
        let beside: Vec<Ray> = (0..64)
            .map(|_| {
                let dir = v(random.signed(), random.signed(), random.signed().abs() + 1.0e-6);
                ray(v(half * random.signed(), half * random.signed(), 120_001.0 + random.signed().abs()), dir)
            })
            .collect();
        assert!(hits(&mesh, &beside).iter().all(|hit| hit.prim == MISS), "{half:e}");
    }
}

/// embree#149: a stream and the same stream backwards disagree.
#[test]
fn embree_149_a_stream_backwards() {
    let mesh = mesh_of(&cuboid(v(0.0, 0.0, 0.0), v(556.0, 548.8, 559.2)));
    let (eye, at) = (v(996.118, 452.409, 135.084), v(526.171, 392.483, 779.651));
    let forward = (at - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let half = (37.0f32.to_radians() / 2.0).tan();
    let pixel = |i: usize| (i as f32 + 0.5) / 8.0 - 1.0;
    let dirs = (0..256).map(|i| forward + half * (pixel(i % 16) * right + pixel(i / 16) * up));
    let rays: Vec<Ray> = dirs.map(|dir| ray(eye, dir)).collect();
    let backwards: Vec<Ray> = rays.iter().rev().copied().collect();
    let mut found = hits(&mesh, &backwards);
    found.reverse();
    assert_eq!(found, hits(&mesh, &rays));
}

/// jbikker/tinybvh#282, #277, #158: -0 as a component of a direction picks the wrong octant.
#[test]
fn tinybvh_282_minus_zero_in_directions() {
    let mesh = sphere(v(0.3, 0.2, 4.0), 1.0, 12);
    let mut found: Vec<Hit> = Vec::new();
    for x in [0.0, -0.0] {
        for y in [0.0, -0.0] {
            found.extend(hits(&mesh, &[ray(v(0.3, 0.2, 0.0), v(x, y, 1.0))]));
        }
    }
    assert!(found.iter().all(|hit| hit.prim != MISS && hit.t == found[0].t), "{found:?}");
}

/// tinybvh#249, #164, #138: two triangles in a plane divide by zero in the build; few triangles hang it.
#[test]
fn tinybvh_249_planar_pairs_build() {
    let pair = [
        [v(2.0, 1.0, 1.0), v(2.0, 1.0, -1.0), v(2.0, -5.0, -1.0)],
        [v(2.0, -5.0, -1.0), v(2.0, -1.0, 1.0), v(2.0, 1.0, 1.0)],
    ];
    assert_eq!(hit(&pair, v(0.0, 0.0, 0.0), Vec3::X).t, 2.0);
    for count in 1..=5 {
        let same: Vec<_> = (0..count).map(|_| pair[0]).collect();
        let found = hit(&same, v(0.0, 0.0, -0.5), Vec3::X);
        assert_eq!((found.prim, found.t), (0, 2.0), "of {count} equal triangles the first counts");
    }
}

/// madmann91/bvh#20: d = (0, -0, 1) and a copy of the triangle behind it: no hit.
#[test]
fn madmann91_20_minus_zero_and_a_copy_behind() {
    let front = [v(1.0, -1.0, 1.0), v(1.0, 1.0, 1.0), v(-1.0, 1.0, 1.0)];
    let behind = front.map(|p| v(p.x, p.y, 2.1));
    let found = hit(&[front, behind], v(0.25, 0.25, 0.0), v(0.0, -0.0, 1.0));
    assert_eq!((found.prim, found.t), (0, 1.0));
}

/// madmann91/bvh#21 and #28: rays along axes are slow or miss; slivers are dropped by an epsilon.
#[test]
fn madmann91_28_slivers_are_kept() {
    let sliver = [v(0.0, 0.0, 2.0), v(1.0, 0.0, 2.0), v(0.5, 1.0e-7, 2.0)];
    assert_eq!(hit(&[sliver], v(0.5, 0.5e-7, 0.0), Vec3::Z).t, 2.0);
    assert_eq!(hit(&[sliver], v(0.5, 2.0e-7, 0.0), Vec3::Z).prim, MISS);
    // Directions with components that are next to nothing.
    assert_eq!(hit(&[sliver], v(0.5, 0.5e-7, 0.0), v(1.0e-42, -1.0e-41, 1.0)).t, 2.0);
}

/// svenstaro/bvh#107: a flat box is culled.
#[test]
fn svenstaro_107_flat_boxes() {
    let wall = square(v(-1.0, -1.0, 1.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0));
    assert_eq!(hit(&wall, Vec3::ZERO, Vec3::Z).t, 1.0);
}

/// svenstaro/bvh#140: a box plane at 5.693442e-39, a ray along (.7071, .7071, 0): NaN.
#[test]
fn svenstaro_140_denormal_planes() {
    let x = 5.693_442e-39;
    let triangle = [v(x, -10.0, 4990.0), v(x, 10.0, 4990.0), v(x, 0.0, 5010.0)];
    let found = hit(&[triangle], v(-5000.0, -5000.0, 5000.0), v(0.707_106_77, 0.707_106_77, 0.0));
    assert!(found.prim == 0 && (found.t - 7071.068).abs() < 0.01, "{found:?}");
}

/// svenstaro/bvh#44 and libgdx#4901: triangles without area panic or give NaN. Here nothing hits them.
#[test]
fn svenstaro_44_triangles_without_area() {
    let point = [v(1.0, 1.0, 1.0); 3];
    let line = [v(0.0, 0.0, 1.0), v(1.0, 1.0, 1.0), v(2.0, 2.0, 1.0)];
    let good = [v(-1.0, -1.0, 3.0), v(3.0, -1.0, 3.0), v(-1.0, 3.0, 3.0)];
    // `mesh_of` would leave them out.
    let positions: Vec<Vec3> = [point, line, good].concat();
    let triangles = vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]];
    let mesh = TriangleMesh { positions, triangles, materials: vec![0; 3], ..TriangleMesh::default() };
    let rays = [
        ray(v(0.5, 0.5, 0.0), Vec3::Z),
        ray(Vec3::ZERO, v(1.0, 1.0, 1.0)),
        ray(v(0.0, 0.0, 1.0), v(1.0, 1.0, 0.0)),
    ];
    let found = hits(&mesh, &rays);
    assert_eq!(found.iter().map(|hit| hit.prim).collect::<Vec<_>>(), [2, MISS, MISS]);
}

/// libigl/libigl#2232: without Ize's factor, the box of a true hit is missed.
#[test]
fn libigl_2232_far_away_boxes() {
    let center = v(1.0e4, -3.0e4, 2.0e5);
    let mesh = sphere(center, 3.0, 12);
    let mut random = Random(2232);
    for _ in 0..8 {
        all_hit(&mesh, center + 0.5 * random.vec(), &corners_and_middles(&mesh));
    }
}

/// arborx/ArborX#414, adamlwgriffiths/Pyrr#105, io7m-jspatial#7: 0 * infinity where the origin lies on a plane of a box.
#[test]
fn arborx_414_origins_on_planes_of_boxes() {
    let mesh = mesh_of(&cuboid(Vec3::ZERO, Vec3::ONE));
    for (org, dir) in [
        (v(0.0, 0.5, 0.5), v(0.0, 1.0, 0.0)),
        (v(1.0, 0.5, 0.5), v(-0.0, 0.0, 1.0)),
        (v(0.5, 0.0, 0.5), v(0.0, -0.0, -1.0)),
        (v(0.0, 0.0, -1.0), v(0.0, 0.0, 1.0)),
        (v(1.0, 1.0, 2.0), v(-0.0, -0.0, -1.0)),
    ] {
        let found = hits(&mesh, &[ray(org, dir)])[0];
        assert!(found.prim != MISS && found.t <= 1.0, "{org} along {dir}: {found:?}");
    }
}

/// rohan-sawhney/fcpw#14, #20: zero components; several triangles at one place.
#[test]
fn fcpw_14_coinciding_triangles_and_zero_components() {
    let one = [v(0.0, 0.0, 1.0), v(1.0, 0.0, 1.0), v(0.0, 1.0, 1.0)];
    let turned = [one[1], one[2], one[0]];
    let other = [one[2], one[1], one[0]];
    for triangles in [[one, one, one], [one, turned, other], [other, turned, one]] {
        let found = hit(&triangles, v(0.25, 0.25, 0.0), v(0.0, 0.0, 2.0));
        assert_eq!((found.prim, found.t), (0, 0.5));
    }
}
