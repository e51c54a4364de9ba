//! An image while it is being refined.

use super::level::{Lattice, Level};
use crate::{film::Film, math::SrgbTable, tile::Tile};
use std::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// Side in pixels of the squares that have a level each. Nobody cuts tiles finer.
pub(super) const CELL: u32 = 16;

/// The traced pixels of an image that is being refined, and how far each cell is. Written by many workers, each its own
/// pixels; whoever reads a pixel has waited for its writer, as the scheduler does.
pub struct Canvas {
    /// Linear.
    pub(super) film: Film,
    /// Whether `film` gets what is traced; else only `samples` do.
    pub(super) linear: bool,
    /// As they are shown: 0x00rrggbb.
    pub(super) samples: Vec<AtomicU32>,
    /// [`Level`] of each cell, row by row.
    levels: Vec<AtomicU8>,
    /// Sum of differences between neighbours in the cell, in bytes of sRGB.
    variation: Vec<AtomicU32>,
    pub(super) columns: u32,
}

impl Default for Canvas {
    /// Without pixels.
    fn default() -> Canvas {
        Canvas::new([0, 0])
    }
}

impl Canvas {
    pub(super) fn new([width, height]: [u32; 2]) -> Canvas {
        let columns = width.div_ceil(CELL);
        let cells = columns as usize * height.div_ceil(CELL) as usize;
        Canvas {
            film: Film::new(width, height),
            linear: true,
            samples: (0..width as usize * height as usize).map(|_| AtomicU32::new(0)).collect(),
            levels: (0..cells).map(|_| AtomicU8::new(0)).collect(),
            variation: (0..cells).map(|_| AtomicU32::new(0)).collect(),
            columns,
        }
    }

    /// Width and height.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.film.width(), self.film.height()]
    }

    /// Forgets everything; from now on, linear values are kept or not.
    pub(super) fn clear(&mut self, linear: bool) {
        self.linear = linear;
        if self.film.nan().is_some() {
            self.film = Film::new(self.film.width(), self.film.height());
        }
        self.levels.iter_mut().for_each(|level| *level.get_mut() = 0);
        self.variation.iter_mut().for_each(|variation| *variation.get_mut() = 0);
    }

    /// Cells that `area` touches.
    pub(super) fn cells(&self, area: Tile) -> impl Iterator<Item = usize> + Clone + use<> {
        let columns = self.columns;
        let across = area.x / CELL..(area.x + area.width).div_ceil(CELL);
        (area.y / CELL..(area.y + area.height).div_ceil(CELL))
            .flat_map(move |row| across.clone().map(move |column| (row * columns + column) as usize))
    }

    /// `area` cut into cells.
    pub(super) fn parts(&self, area: Tile) -> impl Iterator<Item = Tile> + use<> {
        let (right, bottom) = (area.x + area.width, area.y + area.height);
        (area.y / CELL..bottom.div_ceil(CELL)).flat_map(move |row| {
            (area.x / CELL..right.div_ceil(CELL)).map(move |column| {
                let (x, y) = (area.x.max(column * CELL), area.y.max(row * CELL));
                Tile {
                    x,
                    y,
                    width: right.min((column + 1) * CELL) - x,
                    height: bottom.min((row + 1) * CELL) - y,
                }
            })
        })
    }

    pub(super) fn level(&self, cell: usize) -> Level {
        Level::of(self.levels[cell].load(Ordering::Relaxed))
    }

    /// The lowest level in `area`.
    pub(super) fn least(&self, area: Tile) -> Level {
        self.cells(area).map(|cell| self.level(cell)).min().unwrap_or(Level::Full)
    }

    /// All cells of `area` have reached `level`.
    pub(super) fn reach(&self, area: Tile, level: Level) {
        self.cells(area).for_each(|cell| self.levels[cell].store(level as u8, Ordering::Relaxed));
    }

    /// Share of the pixels that are traced.
    pub(super) fn share(&self) -> f64 {
        let whole = Tile { x: 0, y: 0, width: self.film.width(), height: self.film.height() };
        self.cells(whole).map(|cell| self.level(cell).share()).sum::<f64>() / self.levels.len().max(1) as f64
    }

    /// Mean difference between neighbours of the finest lattice in `area`, in bytes of sRGB summed over channels.
    pub(super) fn variation(&self, area: Tile) -> f64 {
        let sum: u64 =
            self.cells(area).map(|cell| u64::from(self.variation[cell].load(Ordering::Relaxed))).sum();
        let spacing = f64::from(self.least(area).spacing());
        sum as f64 * spacing * spacing / area.len().max(1) as f64
    }

    /// Stores the colours of a part of a lattice, in the lattice's own columns and rows.
    pub(super) fn write(&self, lattice: Lattice, part: Tile, pixels: &[Vec<f32>; 3], tone: &Tone) {
        let Lattice { first, spacing } = lattice;
        let [r, g, b] = pixels;
        match (self.linear, spacing) {
            (false, _) => {}
            (true, 1) => self.film.write_tile(part, r, g, b),
            (true, _) => self.film.write_spaced(part, first, spacing, r, g, b),
        }
        let width = part.width as usize;
        for row in 0..part.height {
            let line = (first[1] + spacing * (part.y + row)) as usize * self.film.width() as usize;
            let left = line + (first[0] + spacing * part.x) as usize;
            let from = row as usize * width..(row as usize + 1) * width;
            let colors = r[from.clone()].iter().zip(&g[from.clone()]).zip(&b[from]);
            // What surrounds a scene is often of one colour.
            let (mut last, mut known) = ([f32::NAN; 3], 0);
            let shown = colors.map(|((&r, &g), &b)| {
                if last != [r, g, b] {
                    (last, known) = ([r, g, b], tone.encode([r, g, b]));
                }
                known
            });
            let samples = self.samples[left..].iter();
            let store = |(sample, shown): (&AtomicU32, u32)| sample.store(shown, Ordering::Relaxed);
            match spacing {
                1 => samples.zip(shown).for_each(store),
                _ => samples.step_by(spacing as usize).zip(shown).for_each(store),
            }
        }
    }

    /// Stores the colours of a whole tile: on another film if there is one, else as those of [`Canvas::write`].
    pub(super) fn write_to(&self, other: Option<&Film>, tile: Tile, pixels: &[Vec<f32>; 3], tone: &Tone) {
        let [r, g, b] = pixels;
        match other {
            Some(film) => film.write_tile(tile, r, g, b),
            None => self.write(Lattice::WHOLE, tile, pixels, tone),
        }
    }

    /// Measures anew how varied a part of one cell or more is; `level` is what all of it has reached.
    pub(super) fn measure(&self, area: Tile, level: Level) {
        let spacing = level.spacing();
        // Nothing depends on it any more.
        if level == Level::Full {
            return;
        }
        for cell in self.cells(area) {
            let [column, row] = [cell as u32 % self.columns, cell as u32 / self.columns];
            let (x, y) = (column * CELL, row * CELL);
            let right = (x + CELL).min(self.film.width());
            let bottom = (y + CELL).min(self.film.height());
            let mut sum = 0;
            for y in (y..bottom).step_by(spacing as usize) {
                for x in (x..right).step_by(spacing as usize) {
                    let here = self.sample(x, y);
                    if x + spacing < right {
                        sum += difference(here, self.sample(x + spacing, y));
                    }
                    if y + spacing < bottom {
                        sum += difference(here, self.sample(x, y + spacing));
                    }
                }
            }
            self.variation[cell].store(sum, Ordering::Relaxed);
        }
    }

    fn sample(&self, x: u32, y: u32) -> u32 {
        self.samples[y as usize * self.film.width() as usize + x as usize].load(Ordering::Relaxed)
    }
}

/// Sum of the differences of the three channels.
fn difference(a: u32, b: u32) -> u32 {
    let channel = |shift: u32| (a >> shift & 0xff).abs_diff(b >> shift & 0xff);
    channel(0) + channel(8) + channel(16)
}

/// From linear colours to those that are shown.
#[derive(Clone, Debug)]
pub struct Tone {
    table: SrgbTable,
    scale: f32,
}

impl Tone {
    /// Brightened by `exposure` stops, then sRGB.
    pub fn new(exposure: f32) -> Tone {
        Tone { table: SrgbTable::new(), scale: exposure.exp2() }
    }

    /// 0x00rrggbb. What is not finite is black, as in the film.
    // Without closures: they are not always inlined, and this is called for every pixel of every picture.
    #[inline(always)]
    pub fn encode(&self, [r, g, b]: [f32; 3]) -> u32 {
        let finite = r.is_finite() & g.is_finite() & b.is_finite();
        let [red, green, blue] = [self.byte(r), self.byte(g), self.byte(b)];
        if finite { red << 16 | green << 8 | blue } else { 0 }
    }

    #[inline(always)]
    fn byte(&self, linear: f32) -> u32 {
        self.table.encode(linear * self.scale).into()
    }
}
