//! The image is a function of scene, camera and size alone: one hash, whatever computes it.

use crate::support::RENDER;
use irt::{
    bvh::BuildPreset,
    film::Film,
    kernels::Isa,
    render::{RenderOptions, render},
    scene::{DepthOfField, Scene, procedural},
    schedule::{Control, Schedule},
    tile::Order,
    trace::KernelChoice,
};

fn hash(scene: &Scene, options: &RenderOptions) -> String {
    let rendered = render(scene, options, &Control::unattended()).expect("renders");
    assert_eq!(rendered.nan, None, "{}", scene.name);
    let frame = &rendered.frames[0];
    assert_eq!(frame.rays.primary, 150 * 101);
    assert!(frame.rays.shadow > 1000, "{}: {:?}", scene.name, frame.rays);
    frame.image_sha256.clone()
}

/// With as many samples as a test has time for.
fn scene(name: &str) -> Scene {
    let mut scene = procedural::build(name, 0.3).expect("a built-in scene");
    scene.settings.samples = 1;
    scene.settings.light_samples = scene.settings.light_samples.min(2);
    scene
}

#[test]
fn every_built_in_scene_has_one_image() {
    for name in procedural::NAMES {
        let scene = scene(name);
        let want = hash(&scene, &RENDER);
        for isa in Isa::available() {
            for (kernel, tile) in KernelChoice::ALL.into_iter().zip([48, 64, 32]) {
                let options = RenderOptions { isa: Some(isa), threads: Some(2), tile, kernel, ..RENDER };
                assert_eq!(hash(&scene, &options), want, "{name}, {isa}, {kernel}");
            }
        }
    }
}

#[test]
fn threads_order_tile_size_and_tree_do_not_change_the_image() {
    let scene = scene("atrium");
    let want = hash(&scene, &RENDER);
    for threads in [1, 2, 3, 7] {
        for order in Order::ALL {
            for tile in [1, 7, 16, 33, 64, 1024] {
                // Tiles of one pixel are slow; once is enough.
                if tile > 1 || threads == 3 {
                    let options = RenderOptions { threads: Some(threads), order, tile, ..RENDER };
                    assert_eq!(hash(&scene, &options), want, "{threads} threads, {order}, tiles of {tile}");
                }
            }
        }
    }
    for build in BuildPreset::ALL {
        assert_eq!(hash(&scene, &RenderOptions { build, ..RENDER }), want, "{build} tree");
    }
}

#[test]
fn nothing_is_traced_beside_the_tiles() {
    let scene = scene("atrium");
    let rays = |tile| {
        let options = RenderOptions { tile, ..RENDER };
        render(&scene, &options, &Control::unattended()).expect("renders").frames[0].rays
    };
    let want = rays(64);
    for tile in [1, 7, 33, 1024] {
        assert_eq!(rays(tile), want, "tiles of {tile}");
    }
}

/// Of `of`, in blocks of 4x4 pixels from column and row `first` on: as many as `size`.
fn boxes(of: &Film, [width, height]: [u32; 2], first: u32) -> Vec<[f32; 3]> {
    let pixels: Vec<[f32; 3]> = of.pixels().collect();
    let at = |x: u32, y: u32| pixels[(y.min(of.height() - 1) * of.width() + x.min(of.width() - 1)) as usize];
    let mean = |i: u32| {
        let (x, y) = (i % width * 4 + first, i / width * 4 + first);
        let all = (0..16).map(|j| at(x + j % 4, y + j / 4));
        all.fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|k| sum[k] + pixel[k] / 16.0))
    };
    (0..width * height).map(mean).collect()
}

#[test]
fn the_samples_of_a_pixel_are_spread_around_its_centre() {
    let mut scene = scene("atrium");
    let size = [60, 40];
    let image = |scene: &Scene, size| {
        let options = RenderOptions { size, ..RENDER };
        render(scene, &options, &Control::unattended()).expect("renders").film
    };
    let fine = image(&scene, size.map(|side| 4 * side));
    scene.settings.samples = 64;
    let film = image(&scene, size);
    let distance = |other: Vec<[f32; 3]>| {
        let squares =
            film.pixels().zip(other).map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>());
        (squares.sum::<f32>() / (3.0 * 60.0 * 40.0)).sqrt()
    };
    // Half a pixel elsewhere is two of the fine ones.
    let (here, beside) = (distance(boxes(&fine, size, 0)), distance(boxes(&fine, size, 2)));
    assert!(here < 0.3 * beside, "{here}, {beside} half a pixel away");
}

#[test]
fn tiles_do_not_change_an_image_of_several_samples_nor_one_through_a_lens() {
    let mut scene = scene("gallery");
    scene.settings.samples = 3;
    for lens in [None, Some(DepthOfField { aperture: 0.05, focus: 6.0 })] {
        scene.settings.depth_of_field = lens;
        let image = |tile| {
            let options = RenderOptions { tile, ..RENDER };
            let rendered = render(&scene, &options, &Control::unattended()).expect("renders");
            (rendered.film.sha256(), rendered.frames[0].rays)
        };
        let want = image(64);
        for tile in [7, 33, 48] {
            assert_eq!(image(tile), want, "{lens:?}, tiles of {tile}");
        }
    }
}

#[test]
fn no_schedule_changes_the_image() {
    let scene = scene("atrium");
    let want = hash(&scene, &RENDER);
    for schedule in Schedule::all() {
        for (threads, tile, frames) in [(1, 64, 1), (2, 32, 2), (5, 16, 3), (64, 48, 2)] {
            let options = RenderOptions { threads: Some(threads), schedule, tile, frames, ..RENDER };
            let rendered = render(&scene, &options, &Control::unattended()).expect("renders");
            for frame in &rendered.frames {
                assert_eq!(frame.image_sha256, want, "{schedule:?}, {threads} threads");
                assert_eq!(frame.rays.primary, 150 * 101, "{schedule:?}, {threads} threads");
            }
        }
    }
}

#[test]
fn another_camera_gives_another_image() {
    let mut scene = scene("office");
    let before = hash(&scene, &RENDER);
    scene.camera.fov_deg *= 1.01;
    assert_ne!(hash(&scene, &RENDER), before);
}
