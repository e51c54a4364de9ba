//! Anti-aliasing at rest.

use super::*;
use crate::scene::RenderSettings;
use std::sync::Mutex;

/// The scene as the viewer anti-aliases it, by the samples of the command line.
fn finer(scene: &Scene) -> Scene {
    let settings = RenderSettings { samples: 16, adaptive: Some(0.03), ..scene.settings.clone() };
    Scene { settings, ..scene.clone() }
}

/// Light that goes on from surfaces, in few pixels.
fn gallery() -> (Scene, RenderOptions) {
    let mut scene = procedural::build("gallery", 0.1).expect("a built-in scene");
    (scene.settings.samples, scene.settings.light_samples) = (1, 2);
    (scene, RenderOptions { size: [45, 30], ..OPTIONS })
}

fn played_by(scene: &Scene, options: &RenderOptions, script: &str) -> Played {
    let script = Script::parse(script, Path::new("test")).unwrap();
    play(scene, options, Duration::from_millis(33), &script, |_, _, _| Ok(())).unwrap()
}

#[test]
fn at_rest_the_image_becomes_that_of_adaptive_samples() {
    let (atrium, plain) = (scene(), RenderOptions { size: [97, 61], ..OPTIONS });
    let (gallery, small) = gallery();
    let script = "0 set anti-aliasing on\n0 rest\n0 wheel 1\n0 rest\n0 reset\n0 set anti-aliasing off\n0 rest\n0 press n\n0 rest";
    for (scene, options) in [(atrium, plain), (gallery, small)] {
        let (whole, fine) = (hash(&scene, &options), hash(&finer(&scene), &options));
        assert_ne!(whole, fine);
        for threads in [1, 2] {
            for film in crate::schedule::FilmMode::ALL {
                let schedule = Schedule { film, ..options.schedule };
                let options = RenderOptions { threads: Some(threads), schedule, ..options };
                let played = played_by(&scene, &options, script);
                let [first, near, off, again] = &played.antialiased[..] else { panic!("{played:?}") };
                assert_eq!([first, off, again], [&Some(fine.clone()), &None, &Some(fine.clone())]);
                assert!(near.is_some() && near != first);
                let [first, near, off, again] = &played.hashes[..] else { panic!("{played:?}") };
                assert_eq!([first, off, again], [&whole; 3], "the image before is told as ever");
                assert_ne!(near, first);
                assert!(played.frames.last().unwrap().refined.unwrap().complete);
            }
        }
    }
}

#[test]
fn scenes_that_say_how_to_sample_are_sampled_so() {
    let options = RenderOptions { size: [60, 40], ..OPTIONS };
    let with = |samples, adaptive| {
        let mut scene = scene();
        (scene.settings.samples, scene.settings.adaptive) = (samples, adaptive);
        scene
    };
    let [one, all, own, least] =
        [(1, None), (5, None), (5, Some(0.1)), (16, Some(0.1))].map(|(n, t)| hash(&with(n, t), &options));
    let rest = "0 rest\n0 set anti-aliasing on\n0 rest\n0 set anti-aliasing off\n0 rest";
    // All samples everywhere: nothing is left to do.
    let every = played_by(&with(5, None), &options, rest);
    assert_eq!((&every.hashes, &every.antialiased[1]), (&vec![all.clone(); 3], &Some(all.clone())));
    assert!(every.frames.iter().all(|frame| frame.refined.is_none()));
    // Samples where they show: one at first, then those.
    let adaptive = played_by(&with(5, Some(0.1)), &options, rest);
    assert_eq!(
        (&adaptive.hashes, &adaptive.antialiased[1]),
        (&vec![all.clone(), one.clone(), all], &Some(own))
    );
    let threshold = played_by(&with(1, Some(0.1)), &options, rest);
    assert_eq!((&threshold.hashes, &threshold.antialiased[1]), (&vec![one.clone(); 3], &Some(least)));
    // An effect that is left out stays out.
    let without = played_by(&with(1, None), &options, &format!("0 set effects without=antialiasing\n{rest}"));
    assert_eq!((&without.hashes, &without.antialiased[1]), (&vec![one.clone(); 3], &Some(one)));
}

/// What is told while the camera turns once `when` says so of a picture, until it rests.
fn disturbed(scene: &Scene, when: impl Fn(&Frame) -> bool + Sync) -> Vec<News> {
    let link = Link::default();
    let (told, news) = (Mutex::new(vec![]), std::sync::mpsc::channel());
    let mut done = false;
    let tell = |piece: News| {
        if let News::Picture(picture) = &piece
            && !done
            && when(&picture.frame)
        {
            done = true;
            link.send(Event::Drag(Button::Left, [40.0, 10.0]));
        }
        if matches!(piece, News::Rest { .. }) {
            let _ = news.0.send(());
        }
        told.lock().unwrap().push(piece);
    };
    let options = RenderOptions { size: [75, 50], ..OPTIONS };
    // Time for every pixel of each picture.
    beside(scene, &options, Duration::from_secs(1), &link, tell, || {
        link.send(Event::Set(Setting::AntiAliasing(true)));
        news.1.recv().unwrap();
        // Whoever sleeps says nothing more.
        assert!(news.1.recv_timeout(Duration::from_millis(100)).is_err());
        Ok(())
    })
    .unwrap();
    told.into_inner().unwrap()
}

#[test]
fn an_event_drops_what_is_refined_and_nothing_of_it_is_seen_again() {
    let scene = scene();
    let options = RenderOptions { size: [75, 50], ..OPTIONS };
    let refining = |frame: &Frame| frame.refined.is_some_and(|refined| !refined.complete);
    let news = disturbed(&scene, refining);
    let pictures: Vec<&Picture> = news
        .iter()
        .filter_map(|piece| if let News::Picture(picture) = piece { Some(&**picture) } else { None })
        .collect();
    let at = pictures.iter().position(|picture| refining(&picture.frame)).expect("is refined");
    let after = &pictures[at + 1..];
    let camera = after[0].frame.camera;
    assert!(after[0].frame.moved && camera != scene.camera && after[0].frame.latency.is_some());
    let turned = Scene { camera, ..scene };
    let bytes = |scene: &Scene| -> Vec<u8> {
        let film = render(scene, &options, &Control::unattended()).unwrap().film;
        film.pixels().flatten().map(crate::math::linear_to_srgb8).collect()
    };
    let (whole, fine) = (bytes(&turned), bytes(&finer(&turned)));
    assert!(whole != fine);
    for picture in after.iter().filter(|picture| picture.frame.share == 1.0) {
        let ghosts =
            picture.bytes().iter().zip(&whole).zip(&fine).filter(|((a, b), c)| a != b && a != c).count();
        assert_eq!(ghosts, 0, "{:?}", picture.frame.refined);
        assert!(picture.frame.refined.is_some() || picture.bytes() == whole);
    }
    let last = after.last().unwrap();
    assert!(last.bytes() == fine && last.frame.refined.unwrap().complete);
    assert!(matches!(news.last(), Some(News::Rest { .. })));
}

#[test]
fn without_an_event_pictures_become_finer_and_end() {
    let scene = scene();
    let news = disturbed(&scene, |_| false);
    let shares: Vec<f64> = news
        .iter()
        .filter_map(|piece| match piece {
            News::Picture(picture) => picture.frame.refined.map(|refined| refined.share),
            _ => None,
        })
        .collect();
    assert!(shares.is_sorted() && shares.len() > 2 && shares[0] < shares[shares.len() - 1], "{shares:?}");
    assert_eq!(news.iter().filter(|piece| matches!(piece, News::Rest { .. })).count(), 1);
}

#[test]
fn files_have_the_samples_and_the_map_tells_of_them() {
    let (scene, folder) = (scene(), tempfile::tempdir().unwrap());
    let [before, after] = ["before.pfm", "after.pfm"].map(|name| folder.path().join(name));
    let text = format!(
        "0 set overlay samples\n0 screenshot {}\n0 rest\n0 set anti-aliasing on\n0 screenshot {}\n0 rest",
        before.display(),
        after.display()
    );
    let script = Script::parse(&text, Path::new("test")).unwrap();
    let mut last = None;
    play(&scene, &OPTIONS, Duration::from_millis(33), &script, |_, picture, _| {
        last = picture.refined.clone().map(|refined| (refined, picture.frame.refined.unwrap()));
        Ok(())
    })
    .unwrap();
    let [whole, fine] =
        [scene.clone(), finer(&scene)].map(|scene| render(&scene, &OPTIONS, &Control::unattended()).unwrap());
    for (file, film) in [(before, &whole.film), (after, &fine.film)] {
        let bytes = std::fs::read(&file).unwrap();
        let values: Vec<u8> =
            (0..film.height()).rev().flat_map(|y| film.row(y)).flatten().flat_map(f32::to_le_bytes).collect();
        assert!(bytes.ends_with(&values), "{}", file.display());
    }
    let (pixels, refined) = last.unwrap();
    let many = || pixels.iter().map(|&samples| u64::from(samples)).filter(|&samples| samples > 1);
    // Beside a ray through the centre and one through a corner of each pixel.
    let rays = fine.frames[0].rays.primary - 2 * pixels.len() as u64;
    assert_eq!((refined.samples, many().sum()), (16, rays));
    assert_eq!(refined.share, many().count() as f64 / pixels.len() as f64);
    for (i, (a, b)) in whole.film.pixels().zip(fine.film.pixels()).enumerate() {
        assert!(a == b || pixels[i] > 1, "pixel {i} has changed without samples");
    }
}
