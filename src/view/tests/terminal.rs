//! What the terminal shows.

use super::super::{cells::Cells, terminal::drawn};
use super::*;

/// The last picture of a script, as the terminal shows it after these keys: its text and its cells.
fn shown_after(script: &str, keys: &[&str]) -> (Vec<String>, Cells) {
    let (script, mut last) = (Script::parse(script, Path::new("test")).unwrap(), None);
    let options = RenderOptions { size: [100, 80], ..OPTIONS };
    play(&scene(), &options, Duration::from_millis(33), &script, |_, picture, ui| {
        // Keys are pressed on a copy: each picture is drawn as if it was the last one.
        let mut ui = ui.clone();
        last = Some(drawn(&mut ui, picture));
        for key in keys {
            ui.key(key, true);
            last = Some(drawn(&mut ui, picture));
        }
        Ok(())
    })
    .unwrap();
    let cells = last.unwrap();
    (cells.rows().map(|row| row.iter().map(|cell| cell.glyph).collect()).collect(), cells)
}

#[test]
fn the_terminal_shows_keys_figures_and_maps_over_the_picture() {
    let (text, plain) = shown_after("0 rest", &[]);
    assert!(text.len() == 40 && text.iter().all(|row| row.chars().all(|glyph| glyph == '\u{2580}')));

    let (text, _) = shown_after("0 rest", &["h"]);
    let all = text.join("\n");
    assert!(all.contains(" w a s d    move ahead") && all.contains("escape     quit"), "{all}");
    let (again, cells) = shown_after("0 rest", &["h", "h"]);
    assert!(cells == plain && again != text, "the keys go away");

    let (text, cells) = shown_after("0 rest", &["i"]);
    let all = text.join("\n");
    assert!(all.contains("100.0 % traced, at rest") && all.contains("Mrays/s"), "{all}");
    let row =
        text.iter().position(|row| row.starts_with(" worker 1 ")).expect("a line for each of two workers");
    assert!(!text.iter().any(|row| row.starts_with(" worker 2 ")));
    let busy = cells.rows().nth(row).unwrap()[12..36].iter().any(|cell| cell.back == 0x0058_a55c);
    assert!(busy, "a bar for what it did");
}

#[test]
fn maps_have_the_colours_of_the_window_in_the_terminal() {
    let (text, cells) = shown_after("0 rest\n0 set overlay samples\n0 rest", &[]);
    assert!(text[0].starts_with(" blue to red: 1/16, 1/4"), "{}", text[0]);
    // All is traced: three quarters of red, and a quarter of the picture in grey.
    let red = |color: u32| color >> 16 >= 191 && color >> 8 & 0xff == color & 0xff && color & 0xff < 64;
    let below = || cells.rows().skip(1).flatten();
    assert!(below().count() == 39 * 100 && below().all(|cell| red(cell.fore) && red(cell.back)));
    let (text, _) = shown_after("0 rest", &["f", "g"]);
    assert!(text[0].starts_with(" difference x8: 0 pixels differ"), "{}", text[0]);
}
