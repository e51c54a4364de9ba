//! Adaptive antialiasing: pixels that differ from a neighbour get three eighths of the samples, and all if those scatter;
//! the others one.

use crate::support::RENDER;
use irt::{
    film::Film,
    kernels::Isa,
    render::{RenderOptions, Rendered, render},
    scene::{DepthOfField, Scene, procedural},
    schedule::{Control, Schedule},
};

const LEAST: f32 = 0.04;
/// What the seed of the samples that are taken later differs by.
const LATER: u64 = 0x5bd1_e995_9e37_79b9;
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

/// What pixels of an adaptive image may be, other than its definition by scatter (unit tests of src/render/scatter.rs).
struct Parts {
    one: Film,
    /// Of the samples that are taken first, ...
    first: (u32, Film),
    /// ... and of those taken later.
    later: Option<(u32, Film)>,
}

impl Parts {
    fn new(scene: &Scene, samples: u32, options: &RenderOptions) -> Parts {
        let image = |samples: u32, seed: u64| {
            let mut scene = scene.clone();
            (scene.settings.samples, scene.settings.adaptive) = (samples, None);
            image(&scene, &RenderOptions { seed, ..*options }).film
        };
        let first = (samples * 3 / 8).max(4).min(samples);
        let later = samples - first;
        Parts {
            one: image(1, options.seed),
            first: (first, image(first, options.seed)),
            later: (later > 0).then(|| (later, image(later, options.seed ^ LATER))),
        }
    }

    /// The samples of each pixel of `film`, which must be put together from these images.
    fn samples(&self, film: &Film, tolerance: f32) -> Vec<u32> {
        let Parts { one, first: (few, first), later } = self;
        let all = |i: usize, few_mean: [f32; 3]| {
            let (more, later) = later.as_ref()?;
            let later = later.pixels().nth(i)?;
            let (few, more) = (*few as f32, *more as f32);
            Some([0, 1, 2].map(|k| (few * few_mean[k] + more * later[k]) / (few + more)))
        };
        let of = |i: usize, got: [f32; 3], one: [f32; 3], first: [f32; 3]| {
            let near =
                |want: [f32; 3], by: f32| (0..3).all(|k| (got[k] - want[k]).abs() <= by * want[k].abs());
            if near(one, tolerance) {
                1
            } else if near(first, tolerance) {
                *few
            } else {
                // Sums of both are rounded apart.
                let all = all(i, first).filter(|&all| near(all, tolerance.max(1e-5)));
                assert!(all.is_some(), "pixel {i}: {got:?} of {one:?} and {first:?}");
                few + later.as_ref().map_or(0, |(more, _)| *more)
            }
        };
        let pixels = film.pixels().zip(one.pixels()).zip(first.pixels()).enumerate();
        pixels.map(|(i, ((got, one), first))| of(i, got, one, first)).collect()
    }
}

/// The image must be put together from those of one, some and all samples; where centres of pixels differ, not of one.
fn check(name: &str, samples: u32, lens: Option<DepthOfField>, tolerance: f32) {
    let mut scene = scene(name, samples, Some(LEAST));
    scene.settings.depth_of_field = lens;
    let (adaptive, parts) = (image(&scene, &RENDER), Parts::new(&scene, samples, &RENDER));
    let differs = differs(&parts.one);
    let refined = differs.iter().filter(|&&differs| differs).count();
    assert!(refined > 100 && refined < differs.len() - 100, "{name}: {refined}");
    let taken = parts.samples(&adaptive.film, tolerance);
    let first = parts.first.1.pixels().zip(parts.one.pixels());
    for (i, ((&taken, &differs), (first, one))) in taken.iter().zip(&differs).zip(first).enumerate() {
        let same = (0..3).all(|k| (first[k] - one[k]).abs() <= tolerance * one[k].abs());
        assert!(taken > 1 || !differs || same, "{name}, pixel {i} differs and has one sample");
    }
    if parts.later.is_some() {
        let all = taken.iter().filter(|&&taken| taken == samples).count();
        assert!(all > 20 && all < refined, "{name}: all samples of {all} pixels");
    }
    // Centres and corners, and the samples of pixels that are refined: more than are seen in the image, where samples agree.
    let rays = adaptive.frames[0].rays.primary - 2 * 150 * 101;
    let seen: u64 = taken.iter().map(|&taken| u64::from(taken)).filter(|&taken| taken > 1).sum();
    assert!(rays >= seen && rays >= refined as u64 * u64::from(parts.first.0), "{name}: {rays}, {seen}");
    assert!(rays < 150 * 101 * u64::from(parts.first.0), "{name}: all pixels are refined");
}

#[test]
fn pixels_that_differ_have_more_samples_and_the_others_one() {
    check("atrium", 4, None, 0.0);
    check("atrium", 16, None, 0.0);
}

#[test]
fn so_do_those_behind_a_lens_and_in_scenes_whose_light_is_followed() {
    // Samples are added in another order where rays go on.
    check("gallery", 4, None, 1e-5);
    check("gallery", 8, None, 1e-5);
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
    let scene = scene("atrium", 12_000, Some(LEAST));
    let options = RenderOptions { size: [12, 8], ..RENDER };
    let adaptive = image(&scene, &options);
    // So many colours are added up in f32.
    let taken = Parts::new(&scene, 12_000, &options).samples(&adaptive.film, 1e-3);
    let refined = taken.iter().filter(|&&taken| taken > 1).count();
    let rays = adaptive.frames[0].rays.primary - 2 * 12 * 8;
    assert!(
        refined > 10 && rays.is_multiple_of(1500) && rays >= refined as u64 * 4500,
        "{rays} of {refined}"
    );
}
