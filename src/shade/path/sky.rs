//! What surrounds the scene, by direction.

use crate::scene::{Scene, Sky, SkyMap};
use glam::Vec3;
use std::f32::consts::TAU;

/// Radiance that comes from the direction of the unit vector `dir`, which rays travel along.
pub(super) fn radiance(scene: &Scene, dir: Vec3) -> Vec3 {
    match &scene.environment.sky {
        Sky::Background => scene.background,
        Sky::Gradient { zenith, horizon, ground } => {
            let far = if dir.y >= 0.0 { *zenith } else { *ground };
            *horizon + (far - *horizon) * dir.y.abs().min(1.0)
        }
        Sky::Map(map) => look_up(map, dir),
    }
}

/// Bilinear; round the seam at -z, and up to the poles.
pub(super) fn look_up(map: &SkyMap, dir: Vec3) -> Vec3 {
    let [width, height] = map.size.map(|side| side as usize);
    let [x, y] = place(map, dir);
    let x = x - 0.5;
    let y = (y - 0.5).clamp(0.0, height as f32 - 1.0);
    let (x0, y0) = (x.floor(), y as usize);
    let (fx, fy) = (x - x0, y - y0 as f32);
    let column = |i: isize| i.rem_euclid(width as isize) as usize;
    let (x0, x1) = (column(x0 as isize), column(x0 as isize + 1));
    let y1 = (y0 + 1).min(height - 1);
    let pixel = |x: usize, y: usize| Vec3::from(map.pixels[y * width + x]);
    let row = |y: usize| pixel(x0, y) + (pixel(x1, y) - pixel(x0, y)) * fx;
    map.strength * (row(y0) + (row(y1) - row(y0)) * fy)
}

/// Where the unit vector `dir` lies in the image, in pixels from the upper left corner.
pub(super) fn place(map: &SkyMap, dir: Vec3) -> [f32; 2] {
    let u = turns(dir.z, dir.x) - map.rotation / TAU + 0.5;
    let v = 2.0 * turns(dir.y, (dir.x * dir.x + dir.z * dir.z).sqrt());
    [(u - u.floor()) * map.size[0] as f32, v * map.size[1] as f32]
}

/// The turn from +z towards +x, in [0, 1), of what is `x` pixels from the left edge.
pub(super) fn turn_of_column(map: &SkyMap, x: f32) -> f32 {
    let turn = x / map.size[0] as f32 - 0.5 + map.rotation / TAU;
    // The difference is 1 if it is less than rounding.
    (turn - turn.floor()).min(1.0f32.next_down())
}

/// The angle of (x, y) from +x towards +y in whole turns, in [-1/2, 1/2]; off by less than 2e-6.
///
/// Only `+`, `*` and `/`, so that it is the same on every machine: an eighth of a turn by Abramowitz and Stegun 4.4.49, the
/// rest by symmetry.
fn turns(x: f32, y: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (low, high) = (ax.min(ay), ax.max(ay));
    if high == 0.0 {
        return 0.0;
    }
    let t = low / high;
    let t2 = t * t;
    let series =
        [0.002_866_226, -0.016_165_736, 0.042_909_615, -0.075_289_64, 0.106_562_64, -0.142_089, 0.199_935_5]
            .into_iter()
            .fold(0.0, |sum: f32, coefficient: f32| sum * t2 + coefficient);
    let angle = t + t * t2 * (-0.333_331_46 + t2 * series);
    let eighth = angle / TAU;
    let quarter = if ay > ax { 0.25 - eighth } else { eighth };
    let half = if x < 0.0 { 0.5 - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_right_all_round() {
        for i in 0..4000 {
            let angle = (f64::from(i) / 2000.0 - 1.0) * std::f64::consts::PI;
            let got = f64::from(turns(angle.cos() as f32, angle.sin() as f32)) * std::f64::consts::TAU;
            assert!((got - angle).abs() < 2.0e-5, "{angle}: {got}");
        }
    }

    #[test]
    fn the_image_of_the_sky_lies_as_it_is_told() {
        // Four columns: -z to -x, -x to +z, +z to +x, +x to -z.
        let mut pixels = vec![[0.0; 3]; 8];
        (0..4).for_each(|column| pixels[column] = [column as f32, 0.0, 1.0]);
        let map = SkyMap { size: [4, 2], pixels, rotation: 0.0, strength: 2.0 };
        let up = |x: f32, z: f32| look_up(&map, Vec3::new(x, 2.0, z).normalize());
        for (x, z, column) in [(-1.0, -1.0, 0.0), (-1.0, 1.0, 1.0), (1.0, 1.0, 2.0), (1.0, -1.0, 3.0)] {
            assert!((up(x, z).x - 2.0 * column).abs() < 1.0e-3, "{x} {z}: {}", up(x, z));
        }
        assert!(look_up(&map, -Vec3::Y).z < 1.0e-3 && (look_up(&map, Vec3::Y).z - 2.0).abs() < 1.0e-3);
        // A quarter turn brings what was at +z to +x.
        let turned = SkyMap { rotation: std::f32::consts::FRAC_PI_2, ..map.clone() };
        let (was, is) = (look_up(&map, Vec3::Z), look_up(&turned, Vec3::X));
        assert!((was - is).length() < 1.0e-3, "{was} {is}");
    }
}
