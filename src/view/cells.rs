//! Pictures and text as characters of a terminal: two pixels to a character, one above the other.

use super::ui::{BAR, BAR_AT, Panel, parts};
use std::fmt::Write as _;

/// Colour of text.
const TEXT: u32 = 0x00eb_ebe1;
/// Where lines of the help go on that are too long for their column, in characters.
const INDENT: usize = 11;
/// Most columns of text side by side.
const COLUMNS: usize = 3;

/// A character and its colours, 0x00rrggbb.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) glyph: char,
    pub(super) fore: u32,
    pub(super) back: u32,
}

/// What the terminal shows above its last line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cells {
    columns: usize,
    cells: Vec<Cell>,
}

impl Cells {
    /// Of a picture: the upper pixel of each character is its foreground, the lower one its background. An odd last row
    /// stands for itself.
    pub(super) fn of(pixels: &[u32], [width, height]: [u32; 2]) -> Cells {
        let at = |x: u32, y: u32| pixels[(y.min(height - 1) * width + x) as usize];
        let cell = |x: u32, y: u32| Cell { glyph: '\u{2580}', fore: at(x, y), back: at(x, y + 1) };
        let rows = (0..height).step_by(2);
        let cells = rows.flat_map(|y| (0..width).map(move |x| cell(x, y))).collect();
        Cells { columns: width as usize, cells }
    }

    /// Rows of characters.
    pub(super) fn rows(&self) -> impl ExactSizeIterator<Item = &[Cell]> {
        self.cells.chunks(self.columns)
    }

    /// Writes panels below one another, each over a darker picture, as far as there is room.
    pub(super) fn write(&mut self, panels: impl IntoIterator<Item = Panel>) {
        let mut top = 0;
        for panel in panels {
            let room = [self.columns.saturating_sub(2), self.rows().len().saturating_sub(top)];
            let lines = fitted(&panel.text(), room);
            let width = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0) + 2;
            for (row, line) in self.cells.chunks_mut(self.columns).skip(top).zip(&lines) {
                let text = std::iter::once(' ').chain(line.chars()).chain(std::iter::repeat(' '));
                for (cell, glyph) in row.iter_mut().take(width).zip(text) {
                    *cell = Cell { glyph, fore: TEXT, back: darker(cell) };
                }
            }
            for (i, load) in panel.loads.iter().enumerate() {
                self.bar(top + panel.lines.len() + i, load);
            }
            top += lines.len() + 1;
        }
    }

    /// A worker's time.
    fn bar(&mut self, row: usize, load: &[f64; 5]) {
        let Some(row) = self.cells.chunks_mut(self.columns).nth(row) else { return };
        for (range, back) in parts(load, BAR) {
            let cells = row.iter_mut().skip((1 + BAR_AT + range.start) as usize).take(range.len());
            cells.for_each(|cell| *cell = Cell { glyph: ' ', fore: TEXT, back });
        }
    }

    /// All of it, for a terminal with 24-bit colours. Equal colours are told once.
    pub(super) fn text(&self) -> String {
        let mut text = String::with_capacity(self.cells.len() * 16);
        for (row, cells) in self.rows().enumerate() {
            let _ = write!(text, "\x1b[{};1H", row + 1);
            let mut last = None;
            for Cell { glyph, fore, back } in cells {
                if last.replace([fore, back]) != Some([fore, back]) {
                    let [[_, r, g, b], [_, r2, g2, b2]] = [fore, back].map(|color| color.to_be_bytes());
                    let _ = write!(text, "\x1b[38;2;{r};{g};{b};48;2;{r2};{g2};{b2}m");
                }
                text.push(*glyph);
            }
            text.push_str("\x1b[0m");
        }
        text
    }
}

/// The mean of the colours of a picture's character, darkened so that text on it can be read. Text stays on its own ground.
fn darker(cell: &Cell) -> u32 {
    let half = |color: u32| color >> 1 & 0x007f_7f7f;
    (half(cell.fore) + half(cell.back)) >> 2 & 0x003f_3f3f
}

/// Lines for so much room: side by side if they are too many, and broken if they are too long for that. What finds no room
/// even so is left out.
fn fitted(lines: &[String], [width, height]: [usize; 2]) -> Vec<String> {
    let cut = |line: String| line.chars().take(width).collect::<String>();
    if lines.len() <= height {
        return lines.iter().cloned().map(cut).collect();
    }
    let broken = |columns: usize| -> Vec<String> {
        lines.iter().flat_map(|line| broken(line, (width / columns).saturating_sub(2))).collect()
    };
    let columns = (1..COLUMNS).find(|&n| broken(n).len() <= n * height).unwrap_or(COLUMNS);
    let (lines, wide) = (broken(columns), width / columns);
    let high = lines.len().div_ceil(columns).min(height).max(1);
    let row = |row: usize| {
        let parts = lines.iter().skip(row).step_by(high).take(columns);
        cut(parts.map(|part| format!("{part:wide$}")).collect())
    };
    (0..high.min(height)).map(row).collect()
}

/// A line in parts that are no longer than `width`.
fn broken(line: &str, width: usize) -> Vec<String> {
    let (mut parts, mut part) = (vec![], String::new());
    for word in line.split_inclusive(' ') {
        let long = part.chars().count() + word.trim_end().chars().count() > width;
        if long && !part.trim().is_empty() {
            parts.push(std::mem::replace(&mut part, " ".repeat(INDENT)));
        }
        part += word;
    }
    parts.push(part);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pixels_share_a_character_and_equal_colours_are_told_once() {
        let text = Cells::of(&[0x0001_0203, 0x0001_0203, 0x000a_0b0c, 0x000a_0b0c], [2, 2]).text();
        assert_eq!(text, "\x1b[1;1H\x1b[38;2;1;2;3;48;2;10;11;12m\u{2580}\u{2580}\x1b[0m");
        let odd = Cells::of(&[1, 2, 3], [1, 3]).text();
        assert!(odd.ends_with("\x1b[2;1H\x1b[38;2;0;0;3;48;2;0;0;3m\u{2580}\x1b[0m"), "{odd:?}");
    }

    fn glyphs(cells: &Cells) -> Vec<String> {
        cells.rows().map(|row| row.iter().map(|cell| cell.glyph).collect()).collect()
    }

    #[test]
    fn panels_stand_below_one_another_over_a_darker_picture() {
        let mut cells = Cells::of(&[0x00c0_8040; 40 * 12], [40, 12]);
        let load = [0.5, 0.25, 0.0, 0.0, 0.25];
        let panel =
            |line: &str, loads: &[[f64; 5]]| Panel { lines: vec![line.into()], loads: loads.to_vec() };
        cells.write([panel("one", &[]), panel("two", &[load])]);
        let [one, _, two, worker, ..] = &glyphs(&cells)[..] else { panic!() };
        assert!(
            one.starts_with(" one \u{2580}") && two.starts_with(" two ") && worker.starts_with(" worker 0 ")
        );
        let rows: Vec<&[Cell]> = cells.rows().collect();
        assert_eq!(rows[0][1], Cell { glyph: 'o', fore: TEXT, back: 0x0030_2010 });
        assert_eq!(rows[1][0], Cell { glyph: '\u{2580}', fore: 0x00c0_8040, back: 0x00c0_8040 });
        let colors: Vec<u32> = rows[3][12..36].iter().map(|cell| cell.back).collect();
        let count = |color| colors.iter().filter(|&&c| c == color).count();
        assert_eq!([count(colors[0]), count(colors[12]), count(colors[23])], [12, 6, 6]);
    }

    #[test]
    fn the_whole_help_has_room_in_an_ordinary_terminal() {
        let help = super::super::bindings::help();
        for size in [[80, 46], [120, 46], [250, 100]] {
            let mut cells = Cells::of(&vec![0; (size[0] * size[1]) as usize], size);
            cells.write([Panel { lines: help.clone(), loads: vec![] }]);
            let shown = glyphs(&cells).join("\n");
            for word in help.iter().flat_map(|line| line.split_whitespace()) {
                assert!(shown.contains(word), "{word} in {size:?}:\n{shown}");
            }
        }
        // Too small for any text, and no harm done.
        for size in [[1, 1], [2, 3], [5, 2]] {
            let mut cells = Cells::of(&vec![7; (size[0] * size[1]) as usize], size);
            cells.write([Panel { lines: help.clone(), loads: vec![[0.2; 5]] }]);
            assert_eq!(cells.rows().len(), size[1].div_ceil(2) as usize);
        }
    }
}
