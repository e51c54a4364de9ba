//! Images that are refined step by step: complete at any time, each pixel traced once, and at last the image of a plain
//! render, bit by bit.

use crate::support::{RENDER, Random};
use irt::{
    kernels::Isa,
    render::{Level, Limit, Progressive, RenderOptions, Stage, Target, Tone, render},
    scene::{DepthOfField, Scene, procedural},
    schedule::{Control, FilmMode, Machine, Placement, Schedule, Strategy},
    tile::Order,
};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

fn scene() -> Scene {
    procedural::build("atrium", 0.2).expect("a built-in scene")
}

fn refined<R>(
    scene: &Scene,
    options: &RenderOptions,
    halt: &AtomicBool,
    body: impl FnOnce(&mut Progressive<'_, '_>) -> R,
) -> R {
    let placement = Placement::new(Machine::get(), options.threads, false);
    let stage = Stage::new(scene, options).unwrap();
    let body = |session: &mut Progressive<'_, '_>| {
        session.begin(&scene.camera, &Tone::new(0.0));
        Ok(body(session))
    };
    stage.with_progressive(&placement, halt, body).unwrap()
}

fn to(session: &Progressive, side: u32, level: Level) -> Vec<Target> {
    session.tiles(side).into_iter().map(|tile| Target { tile, level }).collect()
}

fn plain(picture: &[AtomicU32]) -> Vec<u32> {
    picture.iter().map(|pixel| pixel.load(Ordering::Relaxed)).collect()
}

/// Random tiles to random levels until all are full; the number of primary rays.
fn wander(session: &mut Progressive, schedule: Schedule, random: &mut Random) -> u64 {
    let mut rays = 0;
    while !session.complete() {
        let side = [16, 64, 100][random.below(3)];
        let mut targets = to(session, side, Level::Full);
        targets.retain_mut(|target| {
            target.level = Level::ALL[random.below(5)];
            random.below(3) > 0
        });
        rays += session.trace(schedule, &targets, Limit::Whole).unwrap().rays.primary;
    }
    rays
}

#[test]
fn however_it_is_refined_the_image_is_that_of_a_plain_render() {
    let scene = scene();
    let expected = render(&scene, &RENDER, &Control::unattended()).unwrap().film.sha256();
    let mut random = Random(1);
    let orders = Order::ALL.into_iter().cycle();
    for ((isa, schedule), order) in
        Isa::available().flat_map(|isa| Schedule::all().map(move |schedule| (isa, schedule))).zip(orders)
    {
        let options = RenderOptions { isa: Some(isa), order, threads: Some(2), ..RENDER };
        refined(&scene, &options, &AtomicBool::new(false), |session| {
            let rays = wander(session, schedule, &mut random);
            assert_eq!(rays, 150 * 101, "each pixel is traced once");
            assert_eq!(session.film().sha256(), expected, "{isa} {schedule:?} {order}");
            assert_eq!(session.share(), 1.0);
        });
    }
}

#[test]
fn an_image_of_several_samples_and_one_through_a_lens_are_refined_to_the_same_bits() {
    let mut scene = scene();
    scene.settings.samples = 3;
    let mut random = Random(2);
    for lens in [None, Some(DepthOfField { aperture: 0.05, focus: 6.0 })] {
        scene.settings.depth_of_field = lens;
        let expected = render(&scene, &RENDER, &Control::unattended()).unwrap().film.sha256();
        refined(&scene, &RENDER, &AtomicBool::new(false), |session| {
            wander(session, RENDER.schedule, &mut random);
            assert_eq!(session.film().sha256(), expected, "{lens:?}");
        });
    }
}

#[test]
fn the_picture_is_complete_at_every_level_and_does_not_depend_on_the_cut() {
    let scene = scene();
    let film = render(&scene, &RENDER, &Control::unattended()).unwrap().film;
    let tone = Tone::new(0.0);
    let whole: Vec<u32> = film.pixels().map(|pixel| tone.encode(pixel)).collect();
    let mut errors = vec![];
    for level in [Level::Sixteenth, Level::Quarter, Level::Half, Level::Full] {
        let mut pictures = Schedule::all().map(|schedule| {
            let options = RenderOptions { threads: Some(3), schedule, ..RENDER };
            refined(&scene, &options, &AtomicBool::new(false), |session| {
                let targets = to(session, 64, level);
                session.trace(schedule, &targets, Limit::Whole).unwrap();
                assert!((session.share() - level.share()).abs() < 1e-9);
                let mut picture = vec![];
                session.fill(schedule, &mut picture).unwrap();
                plain(&picture)
            })
        });
        let first = pictures.next().unwrap();
        assert!(pictures.all(|other| other == first), "{level:?}");
        let traced = |i: usize| {
            let (x, y) = (i % 150, i / 150);
            match level {
                Level::Sixteenth => x % 4 == 0 && y % 4 == 0,
                Level::Quarter => x % 2 == 0 && y % 2 == 0,
                Level::Half => (x + y) % 2 == 0,
                _ => true,
            }
        };
        assert!((0..whole.len()).filter(|&i| traced(i)).all(|i| whole[i] == first[i]), "{level:?}");
        let error = |(a, b): (&u32, &u32)| (a >> 8 & 0xff).abs_diff(b >> 8 & 0xff);
        let mean =
            |other: &[u32]| whole.iter().zip(other).map(error).sum::<u32>() as f64 / whole.len() as f64;
        // The plainest way to fill: each pixel takes the colour of the traced one to its upper left.
        let s = level.spacing() as usize;
        let blocky = (0..whole.len()).map(|i| whole[(i / 150 / s * s) * 150 + i % 150 / s * s]);
        if matches!(level, Level::Sixteenth | Level::Quarter) {
            assert!(mean(&first) < mean(&blocky.collect::<Vec<_>>()), "{level:?}");
        }
        errors.push(mean(&first));
    }
    assert!(errors.is_sorted_by(|a, b| a > b) && errors[3] == 0.0, "{errors:?}");
}

#[test]
fn a_pass_that_is_late_or_halted_leaves_tiles_for_later() {
    let scene = scene();
    let expected = render(&scene, &RENDER, &Control::unattended()).unwrap().film.sha256();
    let halt = AtomicBool::new(true);
    refined(&scene, &RENDER, &halt, |session| {
        let schedule = Schedule { strategy: Strategy::Stealing, film: FilmMode::Shared };
        let targets = to(session, 64, Level::Full);
        let past = Instant::now() - Duration::from_secs(1);
        for limit in [Limit::Halt, Limit::Until(past)] {
            let traced = session.trace(schedule, &targets, limit).unwrap();
            assert!(!traced.complete && traced.rays.primary == 0, "{limit:?}");
        }
        let message = session.fill(schedule, &mut vec![]).unwrap_err().to_string();
        assert!(message.contains("no pixels"), "{message}");
        assert!(session.trace(schedule, &targets[..3], Limit::Whole).unwrap().complete);
        halt.store(false, Ordering::Relaxed);
        assert!(session.trace(schedule, &targets, Limit::Halt).unwrap().complete);
        assert_eq!(session.film().sha256(), expected);
    });
}

#[test]
fn a_new_camera_forgets_every_pixel_of_the_last_one() {
    let scene = scene();
    let mut turned = scene.clone();
    turned.camera.eye.y += 0.5;
    let expected = render(&turned, &RENDER, &Control::unattended()).unwrap().film.sha256();
    refined(&scene, &RENDER, &AtomicBool::new(false), |session| {
        let targets = to(session, 64, Level::Full);
        session.trace(RENDER.schedule, &targets[..2], Limit::Whole).unwrap();
        session.begin(&turned.camera, &Tone::new(0.0));
        assert_eq!(session.share(), 0.0);
        wander(session, RENDER.schedule, &mut Random(5));
        assert_eq!(session.film().sha256(), expected);
    });
}

#[test]
fn a_sketch_shows_the_same_and_leaves_the_image_for_later() {
    let scene = scene();
    let expected = render(&scene, &RENDER, &Control::unattended()).unwrap().film.sha256();
    for schedule in Schedule::all() {
        let options = RenderOptions { threads: Some(2), schedule, ..RENDER };
        refined(&scene, &options, &AtomicBool::new(false), |session| {
            let [sketch, image] = [true, false].map(|sketch| {
                match sketch {
                    true => session.begin_sketch(&scene.camera, &Tone::new(0.5)),
                    false => session.begin(&scene.camera, &Tone::new(0.5)),
                }
                assert_eq!((session.share(), session.is_sketch()), (0.0, sketch));
                [Level::Half, Level::Full].map(|level| {
                    let targets = to(session, 64, level);
                    session.trace(schedule, &targets, Limit::Whole).unwrap();
                    let full = level == Level::Full;
                    assert_eq!((session.traced(), session.complete()), (full, full && !sketch));
                    let mut picture = vec![];
                    session.fill(schedule, &mut picture).unwrap();
                    assert_eq!(session.film().sha256() == expected, full && !sketch);
                    plain(&picture)
                })
            });
            assert!(sketch == image && sketch[0] != sketch[1], "{schedule:?}");
        });
    }
}

#[test]
fn whatever_stops_its_passes_an_image_becomes_that_of_adaptive_samples() {
    let mut adaptive = scene();
    let whole = render(&adaptive, &RENDER, &Control::unattended()).unwrap().film.sha256();
    let scene = adaptive.clone();
    (adaptive.settings.samples, adaptive.settings.adaptive) = (16, Some(0.03));
    let expected = render(&adaptive, &RENDER, &Control::unattended()).unwrap();
    let far = || Instant::now() + Duration::from_secs(3600);
    for schedule in Schedule::all() {
        let options = RenderOptions { threads: Some(2), schedule, ..RENDER };
        let halt = AtomicBool::new(false);
        refined(&scene, &options, &halt, |session| {
            assert!(session.antialias(schedule, 64, far()).unwrap().is_none(), "nothing is traced yet");
            session.trace(schedule, &to(session, 64, Level::Full), Limit::Whole).unwrap();
            let (mut rays, mut passes) = (0, 0);
            while !session.antialiased() {
                assert!(session.antialiased_film().is_none());
                halt.store(true, Ordering::Relaxed);
                let halted = session.antialias(schedule, 64, far()).unwrap().unwrap();
                halt.store(false, Ordering::Relaxed);
                let late = session.antialias(schedule, 64, Instant::now() - Duration::from_secs(1));
                for nothing in [halted, late.unwrap().unwrap()] {
                    assert!(!nothing.complete && nothing.rays.primary == 0, "{schedule:?}");
                }
                // Some tiles in time, most of them not.
                for deadline in [Instant::now() + Duration::from_micros(300), far()] {
                    let traced = session.antialias(schedule, 64, deadline).unwrap();
                    rays += traced.map_or(0, |traced| traced.rays.primary);
                }
                passes += 1;
            }
            assert!((2..=4).contains(&passes), "{passes}");
            // The centres are there already.
            assert_eq!(rays, expected.frames[0].rays.primary - 150 * 101, "{schedule:?}");
            let film = session.antialiased_film().unwrap().sha256();
            assert_eq!(
                (film, session.film().sha256()),
                (expected.film.sha256(), whole.clone()),
                "{schedule:?}"
            );
            assert!(session.antialias(schedule, 64, far()).unwrap().is_none(), "nothing is left");
            session.begin(&scene.camera, &Tone::new(0.0));
            assert!(!session.antialiased() && session.refined().is_none());
        });
    }
}
