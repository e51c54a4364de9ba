//! Rays that start on surfaces or near others, and rays without a meaning.

use super::{cuboid, hit, hits, ray, square, v};
use crate::support::Random;
use glam::Vec3;
use irt::{
    kernels::{MISS, Ray},
    study::stability::mesh::{mesh_of, sphere},
};

const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

/// RenderKit/embree#133: an origin on the triangle hits in one version and misses in the next. The interval is closed:
/// depth 0 is a hit, unless the triangle is skipped.
#[test]
fn embree_133_an_origin_on_the_triangle() {
    for org in [v(0.25, 0.25, 0.0), v(0.5, 0.0, 0.0), Vec3::ZERO] {
        for dir in [Vec3::Z, -Vec3::Z, v(0.3, 0.2, 1.0)] {
            let found = hit(&[TRIANGLE], org, dir);
            assert_eq!((found.prim, found.t), (0, 0.0), "{org} along {dir}");
            let skipping = Ray { skip: 0, ..ray(org, dir) };
            assert_eq!(hits(&mesh_of(&[TRIANGLE]), &[skipping])[0].prim, MISS);
        }
    }
}

/// embree#298: a ray in the plane of the triangle. A miss, by convention.
#[test]
fn embree_298_a_ray_in_the_plane() {
    assert_eq!(hit(&[TRIANGLE], v(-1.0, 0.5, 0.0), Vec3::X).prim, MISS);
    assert_eq!(hit(&[TRIANGLE], v(-1.0, 0.0, 0.0), Vec3::X).prim, MISS);
}

/// mikedh/trimesh#48, #2524: rays that start on a surface meet it again, or an offset lets them miss others.
#[test]
fn trimesh_48_rays_that_start_on_a_surface() {
    let mesh = sphere(Vec3::splat(1.0e3), 1.0, 16);
    let mut random = Random(48);
    let first: Vec<Ray> = (0..256).map(|_| ray(Vec3::splat(1.0e3), random.vec())).collect();
    let spawned: Vec<Ray> = hits(&mesh, &first)
        .iter()
        .zip(&first)
        .map(|(hit, first)| {
            let point = Vec3::from(first.org) + hit.t * Vec3::from(first.dir);
            Ray { skip: hit.prim, ..ray(point, -Vec3::from(first.dir)) }
        })
        .collect();
    for (ray, hit) in spawned.iter().zip(hits(&mesh, &spawned)) {
        assert!(hit.prim != MISS && hit.prim != ray.skip, "{ray:?}: {hit:?}");
    }
}

/// mitsuba-renderer/mitsuba3#1871: spheres of radius 1 and 1 + 4e-5; an epsilon jumps over the outer one.
#[test]
fn mitsuba3_1871_spheres_4e_5_apart() {
    let inner = sphere(Vec3::ZERO, 1.0, 32);
    let outer = sphere(Vec3::ZERO, 1.0 + 4.0e-5, 32);
    let both: Vec<[Vec3; 3]> =
        [&inner, &outer].iter().flat_map(|mesh| (0..mesh.len()).map(|i| mesh.corners(i))).collect();
    let mut random = Random(1871);
    let first: Vec<Ray> = (0..256).map(|_| ray(0.1 * random.vec(), random.vec())).collect();
    let spawned: Vec<Ray> = hits(&inner, &first)
        .iter()
        .zip(&first)
        .map(|(hit, first)| {
            let dir = Vec3::from(first.dir);
            Ray { skip: hit.prim, ..ray(Vec3::from(first.org) + hit.t * dir, dir) }
        })
        .collect();
    for (ray, hit) in spawned.iter().zip(hits(&mesh_of(&both), &spawned)) {
        let reach = hit.t * Vec3::from(ray.dir).length();
        assert!(hit.prim as usize >= inner.len() && reach < 1.0e-3, "{ray:?}: {hit:?}");
    }
}

/// mitsuba2#171: a plane far off is missed or met again, because the offset grows with the distance.
#[test]
fn mitsuba2_171_distant_planes() {
    for distance in [1.0e4, 1.0e7] {
        let far = square(v(-distance, -1.0, distance), v(2.0 * distance, 0.0, 0.0), v(0.0, 2.0, 0.0));
        let near = square(v(-2.0, -2.0, 0.5), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0));
        let found = hit(&far, v(0.1, 0.25, 0.0), Vec3::Z);
        assert_eq!(found.t, distance);
        // Back from there: not the plane itself, but what stands near the eye.
        let mesh = mesh_of(&[far, near].concat());
        let back = Ray { skip: found.prim, ..ray(v(0.1, 0.25, distance), -Vec3::Z) };
        let found = hits(&mesh, &[back])[0];
        assert!(found.prim >= 2 && found.t > 0.99 * distance, "{found:?}");
    }
}

/// POV-Ray/povray#125: a box at -1 stands 7e-5 above a plane at y = -1.00007.
#[test]
fn povray_125_a_box_just_above_a_plane() {
    let mut triangles = cuboid(v(-1.0, -1.0, -1.0), v(1.0, 0.0, 1.0));
    let floor = triangles.len() as u32;
    triangles.extend(square(v(-9.0, -1.000_07, -9.0), v(18.0, 0.0, 0.0), v(0.0, 0.0, 18.0)));
    let found = hit(&triangles, v(0.3, -2.0, 0.2), Vec3::Y);
    assert!(found.prim >= floor, "from below, the plane comes first");
    let skip_floor = Ray { tnear: found.t.next_up(), ..ray(v(0.3, -2.0, 0.2), Vec3::Y) };
    assert!(hits(&mesh_of(&triangles), &[skip_floor])[0].prim < floor, "then the box");
    // A ray from the floor beneath the box sees the box, 7e-5 above.
    let from_floor = Ray { skip: found.prim, ..ray(v(0.3, -1.000_07, 0.2), Vec3::Y) };
    assert!(hits(&mesh_of(&triangles), &[from_floor])[0].prim < floor);
}

/// modawan/reone#341: a NaN in the direction disables culling. It hits nothing, and its neighbours do not notice.
#[test]
fn reone_341_nan_among_good_rays() {
    let mesh = sphere(v(0.0, 0.0, 5.0), 1.0, 16);
    let mut random = Random(341);
    let good: Vec<Ray> = (0..256)
        .map(|_| ray(0.1 * random.vec(), v(0.1 * random.signed(), 0.1 * random.signed(), 1.0)))
        .collect();
    let wanted = hits(&mesh, &good);
    let mut mixed = good.clone();
    for (i, ray) in mixed.iter_mut().enumerate().step_by(3) {
        match i % 4 {
            0 => ray.dir[i % 3] = f32::NAN,
            1 => ray.dir[i % 3] = f32::INFINITY,
            2 => ray.org[i % 3] = f32::NAN,
            _ => ray.org[i % 3] = f32::NEG_INFINITY,
        }
    }
    for (i, (hit, want)) in hits(&mesh, &mixed).iter().zip(&wanted).enumerate() {
        if i % 3 == 0 {
            assert_eq!(hit.prim, MISS, "{:?}", mixed[i]);
        } else {
            assert_eq!(hit, want, "{:?}", mixed[i]);
        }
    }
}

/// mmp/pbrt-v3#322: directions with zero components give NaN.
#[test]
fn pbrt_v3_322_zero_components() {
    let mesh = mesh_of(&cuboid(Vec3::splat(-1.0), Vec3::ONE));
    let mut rays = Vec::new();
    for x in [-1.0, -0.0, 0.0, 1.0] {
        for y in [-1.0, -0.0, 0.0, 1.0] {
            for z in [-1.0, -0.0, 0.0, 1.0] {
                if (x, y, z) != (0.0, 0.0, 0.0) {
                    rays.push(ray(Vec3::ZERO, v(x, y, z)));
                }
            }
        }
    }
    for (ray, hit) in rays.iter().zip(hits(&mesh, &rays)) {
        assert!(hit.prim != MISS && hit.t == 1.0, "{ray:?}: {hit:?}");
    }
}
