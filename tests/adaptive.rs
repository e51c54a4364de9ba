//! Adaptive antialiasing: pixels that differ from a neighbour get all samples, the others one.

use crate::support::RENDER;
use irt::{
    film::Film,
    kernels::Isa,
    render::{RenderOptions, Rendered, render},
    scene::{DepthOfField, Scene, procedural},
    schedule::{Control, Schedule},
};

const LEAST: f32 = 0.04;
/// For what is rendered often.
const SMALL: [u32; 2] = [75, 53];

fn scene(name: &str, samples: u32, adaptive: Option<f32>) -> Scene {
    let mut scene = procedural::build(name, 0.2).expect("a built-in scene");
    (scene.settings.samples, scene.settings.adaptive) = (samples, adaptive);
    scene.settings.light_samples = scene.settings.light_samples.min(2);
    scene
}

fn image(scene: &Scene, options: &RenderOptions) -> Rendered {
    render(scene, options, &Control::unattended()).expect("renders")
}

/// Whether each pixel differs from one of those around it, straight from the definition.
fn differs(film: &Film) -> Vec<bool> {
    let (width, height) = (film.width() as i32, film.height() as i32);
    let seen: Vec<[f32; 3]> = film.pixels().map(|pixel| pixel.map(|v| v.clamp(0.0, 1.0).sqrt())).collect();
    let at = |x: i32, y: i32| &seen[(y * width + x) as usize];
    let far = |x: i32, y: i32, nx: i32, ny: i32| {
        let inside = (0..width).contains(&nx) && (0..height).contains(&ny);
        inside && at(x, y).iter().zip(at(nx, ny)).any(|(a, b)| (a - b).abs() > LEAST)
    };
    let around = |x, y| (-1..=1).any(|dy| (-1..=1).any(|dx| far(x, y, x + dx, y + dy)));
    (0..width * height).map(|i| around(i % width, i / width)).collect()
}

/// The image must be put together from those of one and of all samples; where centres of pixels differ, of all.
fn check(name: &str, samples: u32, lens: Option<DepthOfField>, tolerance: f32) {
    let with = |samples, adaptive| {
        let mut scene = scene(name, samples, adaptive);
        scene.settings.depth_of_field = lens;
        image(&scene, &RENDER)
    };
    let [one, all, adaptive] = [with(1, None), with(samples, None), with(samples, Some(LEAST))];
    let differs = differs(&one.film);
    let refined = differs.iter().filter(|&&differs| differs).count();
    assert!(refined > 100 && refined < differs.len() - 100, "{name}: {refined}");
    let pixels = one.film.pixels().zip(all.film.pixels()).zip(adaptive.film.pixels()).zip(&differs);
    let mut apart = 0;
    for (i, (((one, all), got), &differs)) in pixels.enumerate() {
        let near = |want: [f32; 3]| (0..3).all(|k| (got[k] - want[k]).abs() <= tolerance * want[k].abs());
        let fits = near(all) || !differs && near(one);
        assert!(fits, "{name}, pixel {} {}: {got:?} of {one:?} and {all:?}", i % 150, i / 150);
        apart += u64::from(!near(one));
    }
    // Centres and corners, and the pixels that are refined: among them all that differ, and all that have changed.
    let rays = adaptive.frames[0].rays.primary - 2 * 150 * 101;
    let (count, rest) = (rays / u64::from(samples), rays % u64::from(samples));
    assert!(rest == 0 && count >= refined as u64 && count >= apart, "{name}: {count} of {refined} {apart}");
    assert!(count < 150 * 101, "{name}: all pixels are refined");
}

#[test]
fn pixels_that_differ_have_all_samples_and_the_others_one() {
    check("atrium", 4, None, 0.0);
    check("atrium", 7, None, 0.0);
}

#[test]
fn so_do_those_behind_a_lens_and_in_scenes_whose_light_is_followed() {
    // Samples are added in another order where rays go on.
    check("gallery", 4, None, 1e-5);
    check("atrium", 3, Some(DepthOfField { aperture: 0.05, focus: 6.0 }), 1e-5);
}

#[test]
fn an_adaptive_image_has_one_hash_too() {
    for name in ["atrium", "gallery"] {
        let scene = scene(name, 5, Some(LEAST));
        let want = image(&scene, &RenderOptions { size: SMALL, ..RENDER }).film.sha256();
        for isa in Isa::available() {
            for (tile, threads) in [(7, 1), (48, 3)] {
                let options =
                    RenderOptions { isa: Some(isa), tile, threads: Some(threads), size: SMALL, ..RENDER };
                assert_eq!(image(&scene, &options).film.sha256(), want, "{name} {isa}, tiles of {tile}");
            }
        }
        for schedule in Schedule::all() {
            let options = RenderOptions { schedule, threads: Some(2), frames: 2, size: SMALL, ..RENDER };
            for frame in &image(&scene, &options).frames {
                assert_eq!(frame.image_sha256, want, "{name} {schedule:?}");
            }
        }
    }
}

#[test]
fn more_samples_than_fly_together_are_taken_too() {
    let mut scene = scene("atrium", 1500, Some(LEAST));
    let options = RenderOptions { size: [24, 16], ..RENDER };
    let adaptive = image(&scene, &options);
    scene.settings.adaptive = None;
    let all = image(&scene, &options);
    let refined = (adaptive.frames[0].rays.primary - 2 * 24 * 16) / 1500;
    assert!(refined > 10, "{refined}");
    let same = adaptive.film.pixels().zip(all.film.pixels()).filter(|(a, b)| a == b).count();
    assert!(same as u64 >= refined, "{same} of {refined}");
}
