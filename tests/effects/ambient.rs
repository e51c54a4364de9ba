//! Ambient occlusion against closed forms.

use super::{close, floor, matt, radiance, rectangle, scene};
use glam::Vec3;
use irt::scene::{AmbientOcclusion, Scene};

fn ambient(triangles: &[[Vec3; 3]], radius: f32) -> Scene {
    let mut scene = scene(triangles, matt(0.5));
    scene.ambient = Vec3::splat(0.8);
    scene.settings.ambient_occlusion = Some(AmbientOcclusion { radius, samples: 1024 });
    scene
}

#[test]
fn nothing_is_occluded_on_a_plane_alone() {
    let got = radiance(&ambient(&floor(), f32::INFINITY), Vec3::new(1.0, 2.0, 0.5), Vec3::ZERO);
    close(got.x, 0.4, 1.0e-5, "plane");
}

/// Share of a cosine-weighted hemisphere that does not meet an endless wall at distance `d` nearer than `radius`, by
/// midpoints of the unit disc.
fn open(d: f64, radius: f64) -> f64 {
    let n = 2000;
    let (mut inside, mut free) = (0u32, 0u32);
    for i in 0..n {
        for j in 0..n {
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
            let (x, y) = (at(i), at(j));
            if x * x + y * y < 1.0 {
                inside += 1;
                // The disc is the projection of the directions: x is the component towards the wall.
                free += u32::from(x <= 0.0 || d / x > radius);
            }
        }
    }
    f64::from(free) / f64::from(inside)
}

#[test]
fn a_wall_hides_half_of_the_sky_and_less_of_what_is_near() {
    let mut triangles = floor();
    // So large that its ends do not matter: at x = 0, facing +x.
    triangles.extend(rectangle(Vec3::new(0.0, 0.0, -4000.0), 8000.0 * Vec3::Z, 4000.0 * Vec3::Y));
    for (radius, distance) in [(f32::INFINITY, 0.5f32), (f32::INFINITY, 0.01), (1.0, 0.5), (2.0, 0.3)] {
        let mut scene = ambient(&triangles, radius);
        // What shines by itself is not occluded.
        scene.materials[0].ke = Vec3::splat(0.3);
        let got = radiance(&scene, Vec3::new(distance + 0.7, 1.0, 0.2), Vec3::new(distance, 0.0, 0.0));
        let want = 0.3 + 0.4 * open(f64::from(distance), f64::from(radius));
        close(got.x, want, 0.01, &format!("radius {radius}, distance {distance}"));
    }
}
