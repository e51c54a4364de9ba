//! Indirect light: a closed room that shines, in closed form, and a Cornell box against an estimate of its own.

use super::{close, cuboid, matt, radiance, rectangle, scene, scene_of};
use crate::support::{Random, mesh_of};
use glam::{DVec3, Vec3};
use irt::scene::{Material, Scene};

#[test]
fn in_a_room_whose_walls_all_shine_light_is_a_geometric_series() {
    let inside: Vec<_> =
        cuboid(Vec3::splat(-1.0), Vec3::ONE).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let (emission, albedo) = (0.3, 0.6);
    for bounces in [0, 1, 5, 20] {
        let mut scene = scene(&inside, Material { ke: Vec3::splat(emission), ..matt(albedo) });
        scene.settings.bounces = bounces;
        let got = radiance(&scene, Vec3::new(0.2, 0.1, -0.3), Vec3::new(0.5, -1.0, 0.7));
        let want = (0..=bounces).map(|n| f64::from(emission) * f64::from(albedo).powi(n as i32)).sum();
        close(got.x, want, 1.0e-4, &format!("{bounces} bounces"));
    }
}

/// A wall of the Cornell box: corner, edges, colour (of one channel) and emission.
struct Wall {
    corner: DVec3,
    u: DVec3,
    v: DVec3,
    albedo: f64,
    emission: f64,
}

/// A room of side 2 about the origin with a lamp below its ceiling, and a block on its floor.
fn walls() -> Vec<Wall> {
    let wall = |corner: [f64; 3], u: [f64; 3], v: [f64; 3], albedo: f64, emission: f64| Wall {
        corner: corner.into(),
        u: u.into(),
        v: v.into(),
        albedo,
        emission,
    };
    let (x, y, z) = ([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    let mut walls = vec![
        wall([-1.0, -1.0, -1.0], z, x, 0.7, 0.0),
        wall([-1.0, 1.0, -1.0], x, z, 0.7, 0.0),
        wall([-1.0, -1.0, -1.0], x, y, 0.7, 0.0),
        wall([-1.0, -1.0, -1.0], y, z, 0.6, 0.0),
        wall([1.0, -1.0, -1.0], z, y, 0.15, 0.0),
        wall([-1.0, -1.0, 1.0], y, x, 0.7, 0.0),
        wall([-0.3, 0.98, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6], 0.0, 12.0),
    ];
    // The sides and the top of a block.
    let (dx, dy, dz) = ([0.7, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.6]);
    walls.push(wall([-0.6, -1.0, -0.5], dx, dy, 0.7, 0.0));
    walls.push(wall([-0.6, -1.0, 0.1], dy, dx, 0.7, 0.0));
    walls.push(wall([-0.6, -1.0, -0.5], dy, dz, 0.7, 0.0));
    walls.push(wall([0.1, -1.0, -0.5], dz, dy, 0.7, 0.0));
    walls.push(wall([-0.6, -0.2, -0.5], dz, dx, 0.7, 0.0));
    walls
}

fn cornell() -> Scene {
    let walls = walls();
    let triangles: Vec<[Vec3; 3]> = walls
        .iter()
        .flat_map(|wall| rectangle(wall.corner.as_vec3(), wall.u.as_vec3(), wall.v.as_vec3()))
        .collect();
    let mut mesh = mesh_of(&triangles);
    mesh.materials = (0..triangles.len()).map(|i| i as u32 / 2).collect();
    let materials = walls
        .iter()
        .map(|wall| Material { ke: Vec3::splat(wall.emission as f32), ..matt(wall.albedo as f32) })
        .collect();
    scene_of(mesh, materials)
}

/// The nearest wall along a ray, how far it is, and its normal against the ray.
fn nearest(walls: &[Wall], org: DVec3, dir: DVec3) -> (&Wall, f64, DVec3) {
    let meet = |wall: &Wall| {
        let n = wall.u.cross(wall.v);
        let t = (wall.corner - org).dot(n) / dir.dot(n);
        let at = org + t * dir - wall.corner;
        let within = |edge: DVec3| (0.0..=1.0).contains(&(at.dot(edge) / edge.length_squared()));
        (t > 1.0e-9 && within(wall.u) && within(wall.v)).then_some((t, n.normalize()))
    };
    let hits = walls.iter().filter_map(|wall| meet(wall).map(|(t, n)| (wall, t, n)));
    let (wall, t, n) = hits.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a closed room");
    (wall, t, if n.dot(dir) > 0.0 { -n } else { n })
}

/// Follows a path that finds lamps only by meeting them: nothing is sampled, so nothing can be counted twice.
fn path(walls: &[Wall], mut org: DVec3, mut dir: DVec3, bounces: u32, random: &mut Random) -> f64 {
    let (mut sum, mut share) = (0.0, 1.0);
    for bounce in 0..=bounces {
        let (wall, t, n) = nearest(walls, org, dir);
        sum += share * wall.emission;
        if bounce == bounces || wall.albedo == 0.0 {
            break;
        }
        share *= wall.albedo;
        org += t * dir;
        // A point of the sphere that touches the surface: cosine-weighted.
        let on_sphere = loop {
            let v = random.vec().as_dvec3();
            if v.length_squared() <= 1.0 && v.length_squared() > 1.0e-6 {
                break v.normalize();
            }
        };
        dir = (n + on_sphere).normalize_or(n);
    }
    sum
}

#[test]
fn a_cornell_box_is_as_bright_as_paths_that_sample_nothing_find_it() {
    let mut scene = cornell();
    scene.settings.emitters = true;
    // Direct light takes one diffuse reflection of the estimate, each bounce another.
    let bounces = 5;
    (scene.settings.bounces, scene.settings.samples, scene.settings.light_samples) = (bounces, 1024, 1);
    let walls = walls();
    let eye = DVec3::new(0.2, 0.1, 0.9);
    for at in [
        DVec3::new(0.5, -1.0, 0.2),
        DVec3::new(-1.0, 0.2, 0.3),
        DVec3::new(-0.3, 0.9999, 0.7),
        DVec3::new(-0.3, -0.2, -0.3),
    ] {
        let dir = (at - eye).normalize();
        let mut random = Random(0x1234_5678);
        let count = 400_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..count {
            let light = path(&walls, eye, dir, bounces + 1, &mut random);
            sum += light;
            squares += light * light;
        }
        let mean = sum / f64::from(count);
        let error = ((squares / f64::from(count) - mean * mean) / f64::from(count)).sqrt();
        let got = f64::from(radiance(&scene, eye.as_vec3(), at.as_vec3()).x);
        // Four standard errors of the estimate, and 4 % for our own noise.
        assert!((got - mean).abs() < 4.0 * error + 0.04 * mean, "{at}: {got}, not {mean} +- {error}");
    }
}
