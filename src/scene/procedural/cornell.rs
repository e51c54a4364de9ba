//! The Cornell box: a room whose colours bleed. Measured sizes and colours as published by the Cornell University
//! Program of Computer Graphics (Goral et al. 1984; the data of 1998), in metres, spectra reduced to RGB.

use super::builder::Builder;
use crate::scene::{CameraDescription, Material, RenderSettings, Scene};
use glam::Vec3;

/// Makes the scene. There is nothing curved in it that detail could refine.
pub(super) fn cornell(_detail: f32) -> Scene {
    let mut b = Builder::new(1.0);
    let mut matt = |name: &str, kd: [f32; 3]| {
        b.material(Material { name: name.into(), kd: kd.into(), ..Material::default() })
    };
    let white = matt("white", [0.725, 0.71, 0.68]);
    let red = matt("red", [0.63, 0.065, 0.05]);
    let green = matt("green", [0.14, 0.45, 0.091]);
    let lamp = b.material(Material {
        name: "lamp".into(),
        kd: Vec3::splat(0.78),
        ke: Vec3::new(17.0, 12.0, 4.0),
        ..Material::default()
    });
    room(&mut b, [white, red, green, lamp]);
    b.part("short block");
    b.paint(white);
    let short = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
    block(&mut b, short, 1.65);
    b.part("tall block");
    let tall = [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]];
    block(&mut b, tall, 3.30);
    let camera = CameraDescription {
        eye: Vec3::new(2.78, 2.73, -8.0),
        at: Vec3::new(2.78, 2.73, 0.0),
        up: Vec3::Y,
        fov_deg: 39.3,
    };
    Scene {
        size: [512, 512],
        settings: RenderSettings {
            samples: 64,
            light_samples: 1,
            bounces: 6,
            emitters: true,
            ..RenderSettings::default()
        },
        ..b.finish("cornell", Vec::new(), camera, Vec3::ZERO, Vec3::ZERO)
    }
}

/// Floor, ceiling with the lamp let into it, back wall, red wall on the left, green wall on the right of the view along
/// +z, in which x runs to the left.
fn room(b: &mut Builder, [white, red, green, lamp]: [u32; 4]) {
    let (wide, high, deep) = (5.528, 5.488, 5.592);
    b.part("floor");
    b.paint(white);
    let [across, up, into] = [Vec3::X * wide, Vec3::Y * high, Vec3::Z * deep];
    b.quad([1, 1], Vec3::ZERO, into, across);
    b.part("ceiling");
    let lines = |a: f32, b: f32, end: f32| move |t: f32| [0.0, a, b, end][(3.0 * t).round() as usize];
    let (x, z) = (lines(2.13, 3.43, wide), lines(2.27, 3.32, deep));
    let paint = |i: usize, j: usize| if (i, j) == (1, 1) { lamp } else { white };
    b.mosaic([3, 3], false, paint, |u, v| Vec3::new(x(u), high, z(v)));
    b.part("walls");
    b.quad([1, 1], into, up, across);
    b.paint(green);
    b.quad([1, 1], Vec3::ZERO, up, into);
    b.paint(red);
    b.quad([1, 1], across, into, up);
}

/// An upright prism on the floor over four corners (x, z) in centimetres, which run anticlockwise as seen from above.
fn block(b: &mut Builder, corners: [[f32; 2]; 4], height: f32) {
    let corner = |i: usize, y: f32| Vec3::new(0.01 * corners[i % 4][0], y, 0.01 * corners[i % 4][1]);
    let up = Vec3::Y * height;
    for i in 0..4 {
        let (from, to) = (corner(i, 0.0), corner(i + 1, 0.0));
        b.quad([1, 1], from, to - from, up);
    }
    // Not quite a parallelogram, as measured.
    b.patch([1, 1], false, |u, v| {
        let (near, far) =
            (corner(0, height).lerp(corner(1, height), u), corner(3, height).lerp(corner(2, height), u));
        near.lerp(far, v)
    });
}
