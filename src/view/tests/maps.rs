//! What the maps tell.

use super::super::overlay::tint;
use super::*;
use crate::{
    kernels::MISS,
    render::Level,
    schedule::{FilmMode, Strategy},
};
use std::collections::BTreeSet;
use std::sync::atomic::Ordering;

/// Three workers that all have something to do.
const SHARED_OUT: RenderOptions = RenderOptions {
    threads: Some(3),
    tile: 16,
    schedule: Schedule { strategy: Strategy::StaticCyclic, film: FilmMode::Shared },
    ..OPTIONS
};

/// Colours of the pictures of a script that `wanted` takes, each with what else the picture has.
fn maps<T>(script: &str, wanted: impl Fn(&Picture) -> Option<T>) -> Vec<(Vec<u32>, String, T)> {
    let (script, mut maps) = (Script::parse(script, Path::new("test")).unwrap(), vec![]);
    play(&scene(), &SHARED_OUT, Duration::from_millis(33), &script, |_, picture, _| {
        let Frame { options, .. } = &picture.frame;
        if let (Some((colors, text)), Some(more)) =
            (tint(picture, options.order, options.tile), wanted(picture))
        {
            maps.push((colors, text, more));
        }
        Ok(())
    })
    .unwrap();
    maps
}

#[test]
fn workers_have_a_colour_each_on_their_own_tiles() {
    let maps = maps("0 set overlay workers\n0 rest", |picture| Some(picture.frame.spans.clone()));
    let (colors, text, spans) = maps.last().unwrap();
    assert_eq!(text, "colour: worker, of 3");
    let used: BTreeSet<u32> = colors.iter().copied().collect();
    assert!(used.len() == 3 && !used.contains(&0), "{used:x?}");
    for (worker, color) in [0, 1, 2].map(|worker| {
        let mine: BTreeSet<u32> = spans
            .iter()
            .filter(|span| span.worker == worker)
            .map(|span| colors[(span.tile.y * 150 + span.tile.x) as usize])
            .collect();
        (worker, mine)
    }) {
        assert_eq!(color.len(), 1, "worker {worker}");
    }
}

#[test]
fn times_are_by_tile_and_the_longest_are_red() {
    let maps = maps("0 set overlay time\n0 rest", |picture| Some(picture.frame.spans.clone()));
    let (colors, _, spans) = maps.last().unwrap();
    let slowness = |span: &crate::schedule::Span| (span.end - span.start) / span.tile.len() as f64;
    let color = |span: &crate::schedule::Span| colors[(span.tile.y * 150 + span.tile.x) as usize];
    let mut sorted: Vec<_> = spans.iter().collect();
    sorted.sort_by(|a, b| slowness(a).total_cmp(&slowness(b)));
    let slowest = &sorted[sorted.len() * 19 / 20..];
    assert!(slowest.iter().all(|span| color(span) == 0x00ff_0000), "from the 95th percentile on");
    assert_ne!(color(sorted[0]), 0x00ff_0000);
    for span in spans {
        let tile = span.tile;
        let rows = (tile.y..tile.y + tile.height).map(|y| (y * 150 + tile.x) as usize);
        let same = rows.flat_map(|left| &colors[left..left + tile.width as usize]).all(|c| *c == color(span));
        assert!(same, "{tile:?}");
    }
}

#[test]
fn samples_tell_how_far_each_square_is_traced() {
    let script = Script::parse("0 set overlay samples\n0 rest", Path::new("test")).unwrap();
    let mut maps = vec![];
    play(&scene(), &SHARED_OUT, Duration::from_millis(33), &script, |_, picture, _| {
        // At rest as it is, and as it might be on the way.
        let levels = (0..10 * 7).map(|cell| Level::ALL[1 + cell / 3 % 4]).collect();
        for levels in [picture.frame.levels.clone(), levels] {
            let frame = Frame { levels, ..picture.frame.clone() };
            let Picture { size, overlay, .. } = *picture;
            let picture = Picture { size, overlay, frame, pixels: vec![], map: None, refined: None };
            maps.extend(tint(&picture, Order::Hilbert, 16).map(|(colors, _)| (colors, picture.frame.levels)));
        }
        Ok(())
    })
    .unwrap();
    for (colors, levels) in &maps {
        for (i, &color) in colors.iter().enumerate() {
            let expected = match levels[i / 150 / 16 * 10 + i % 150 / 16] {
                Level::Nothing => panic!("a square without a pixel"),
                Level::Sixteenth => 0x0000_00ff,
                Level::Quarter => 0x0000_ff00,
                Level::Half => 0x00ff_ff00,
                Level::Full => 0x00ff_0000,
            };
            assert_eq!(color, expected, "pixel {i}");
        }
    }
    let rest = &maps[maps.len() - 2].0;
    assert!(rest.iter().all(|&color| color == 0x00ff_0000), "at rest, every pixel is traced");
}

#[test]
fn samples_tell_which_pixels_have_more_than_one() {
    let script = "0 set overlay samples\n0 set anti-aliasing on\n0 rest";
    let maps = maps(script, |picture| Some((picture.refined.clone()?, picture.frame.refined?)));
    let (colors, text, (pixels, refined)) = maps.last().unwrap();
    let by_samples: BTreeSet<_> = pixels.iter().zip(colors).collect();
    let samples: Vec<u32> = by_samples.iter().map(|(samples, _)| **samples).collect();
    assert_eq!(samples, [1, 6, 16], "each with one colour");
    assert!(*by_samples.first().unwrap().1 == 0xff && *by_samples.last().unwrap().1 == 0x00ff_0000);
    assert!(text.contains("1 to 16 samples"), "{text}");
    assert!(refined.share > 0.05 && refined.share < 0.95, "{refined:?}");
}

#[test]
fn maps_of_rays_are_of_the_rays_of_the_image_and_stay_while_it_becomes_finer() {
    for overlay in ["steps", "lanes", "coherence"] {
        let script = format!("0 set overlay {overlay}\n0 rest\n0 set anti-aliasing on\n0 rest");
        let maps = maps(&script, |picture| Some((picture.map.clone()?, picture.frame.refined)));
        let (first, last) = (&maps[0], &maps[maps.len() - 1]);
        assert!(first.2.1.is_none() && last.2.1.unwrap().complete, "{overlay}");
        assert!(maps.iter().all(|map| map.0 == first.0 && map.1 == first.1), "{overlay}");
        assert!(first.0.iter().collect::<BTreeSet<_>>().len() > 1, "{overlay} has one colour");
        let map = &first.2.0;
        let (mut hits, mut most) = (0, 0);
        for (steps, prim) in map.steps.iter().zip(&map.prims) {
            let (steps, prim) = (steps.load(Ordering::Relaxed), prim.load(Ordering::Relaxed));
            assert!(steps >= 2 || prim == MISS, "a hit without a node and a leaf");
            (hits, most) = (hits + usize::from(prim != MISS), most.max(steps));
        }
        assert!(hits > map.prims.len() / 2, "{hits}");
        assert!(overlay != "steps" || first.1.ends_with(&format!("up to {most}")), "{}", first.1);
    }
}
