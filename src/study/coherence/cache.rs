//! What earlier rays leave to later ones: triangles, remembered by cells.
//!
//! ```text
//!   ray      one cell for all: what the previous ray met, as in the thesis
//!   tile     a cell for each square of pixels
//!   light    a cell for each square of what the light sees: face and slopes of the ray
//!   frame    a cell for each pixel, filled by the frame before
//! ```
//!
//! Every cell has one, two or four entries, the latest first. A cell that has one and serves all rays forgets it when
//! a ray meets nothing, as the thesis does; the others keep it, because the next ray of the cell may come from
//! elsewhere.

use crate::kernels::{Ray, probe::NO_TRIANGLE};
use std::fmt;

/// Pixels along one side of the cells of [`Area::Tile`].
pub const TILE: u32 = 8;
/// Cells along one side of a face of [`Area::Light`].
pub const GRID: u32 = 64;
/// Most entries of a cell.
pub(super) const MOST: usize = 4;

/// Which rays share a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Area {
    /// All of them.
    Ray,
    /// Those of a square of [`TILE`] pixels.
    Tile,
    /// Those that the light sees in one of [`GRID`] x [`GRID`] cells of each of its six faces. Primary rays, which have
    /// no light, share squares of pixels.
    Light,
    /// Those of a pixel and its neighbours to the right and below, in the frame before.
    Frame,
}

impl Area {
    /// All areas.
    pub const ALL: [Area; 4] = [Area::Ray, Area::Tile, Area::Light, Area::Frame];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Area::Ray => "ray",
            Area::Tile => "tile",
            Area::Light => "light",
            Area::Frame => "frame",
        }
    }
}

/// A kind of cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Who shares a cell.
    pub area: Area,
    /// Entries of a cell: 1 to [`MOST`].
    pub entries: usize,
}

impl Shape {
    /// The thesis' own.
    pub const THESIS: Shape = Shape { area: Area::Ray, entries: 1 };

    /// All that the study compares.
    pub fn all() -> impl Iterator<Item = Shape> {
        Area::ALL.into_iter().flat_map(|area| [1, 2, 4].map(|entries| Shape { area, entries }))
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{} x{}", self.area.name(), self.entries))
    }
}

/// A cache while rays are traced.
#[derive(Clone, Debug)]
pub(super) struct Cache {
    shape: Shape,
    /// `entries` slots of each cell, the latest first.
    slots: Vec<u32>,
    columns: u32,
}

/// The rays of which a cache knows: all of an image, for one light or for none.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) pixel: [u32; 2],
    pub(super) ray: &'a Ray,
    pub(super) from_light: bool,
}

impl Cache {
    /// An empty one for an image of this size; `before` are the slots that each pixel met in the frame before.
    pub(super) fn new(shape: Shape, [width, height]: [u32; 2], before: Option<&[u32]>) -> Cache {
        let columns = if shape.area == Area::Frame { width } else { width.div_ceil(TILE) };
        let tiles = columns as usize * height.div_ceil(TILE) as usize;
        let cells = match shape.area {
            Area::Ray => 1,
            Area::Tile => tiles,
            Area::Light => tiles.max(6 * (GRID * GRID) as usize),
            Area::Frame => width as usize * height as usize,
        };
        let mut cache = Cache { shape, slots: vec![NO_TRIANGLE; cells * shape.entries], columns };
        if let (Area::Frame, Some(before)) = (shape.area, before) {
            cache.fill(before, [width, height]);
        }
        cache
    }

    /// Fills the cells with what pixels and their neighbours met.
    fn fill(&mut self, before: &[u32], [width, height]: [u32; 2]) {
        for y in 0..height {
            for x in 0..width {
                // The pixel itself comes last, and so first.
                for (dx, dy) in [(1, 1), (0, 1), (1, 0), (0, 0)] {
                    let (x1, y1) = ((x + dx).min(width - 1), (y + dy).min(height - 1));
                    let slot = before[(y1 * width + x1) as usize];
                    if slot != NO_TRIANGLE {
                        self.insert((y * width + x) as usize, slot);
                    }
                }
            }
        }
    }

    fn cell(&self, place: Place) -> usize {
        let [x, y] = place.pixel;
        match self.shape.area {
            Area::Ray => 0,
            Area::Light if place.from_light => light_cell(place.ray),
            Area::Tile | Area::Light => (y / TILE * self.columns + x / TILE) as usize,
            Area::Frame => (y * self.columns + x) as usize,
        }
    }

    /// What to try first, latest first.
    pub(super) fn seeds(&self, place: Place) -> &[u32] {
        let first = self.cell(place) * self.shape.entries;
        &self.slots[first..first + self.shape.entries]
    }

    /// The ray has met this.
    pub(super) fn put(&mut self, place: Place, slot: u32) {
        match self.shape {
            Shape::THESIS => self.slots[0] = slot,
            Shape { area: Area::Frame, .. } => {}
            _ if slot == NO_TRIANGLE => {}
            _ => self.insert(self.cell(place), slot),
        }
    }

    /// Puts a slot before the others of a cell; the last one, or its own old place, gives way.
    fn insert(&mut self, cell: usize, slot: u32) {
        let first = cell * self.shape.entries;
        let entries = &mut self.slots[first..first + self.shape.entries];
        let at = entries.iter().position(|&entry| entry == slot).unwrap_or(entries.len() - 1);
        entries[..=at].rotate_right(1);
        entries[0] = slot;
    }
}

/// The cell of a ray by its face and slopes.
fn light_cell(ray: &Ray) -> usize {
    let face = crate::kernels::Face::of(ray.dir);
    let [iu, iv, iz] = face.axes();
    let depth = ray.dir[iz].abs();
    let index = |slope: f32| (((slope / depth + 1.0) * (GRID / 2) as f32) as usize).min(GRID as usize - 1);
    (face.index() * GRID as usize + index(ray.dir[iv])) * GRID as usize + index(ray.dir[iu])
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAY: Ray = Ray { org: [0.0; 3], dir: [0.2, -0.9, 1.0], tnear: 0.0, tfar: 9.0, skip: u32::MAX };

    fn place(x: u32, y: u32) -> Place<'static> {
        Place { pixel: [x, y], ray: &RAY, from_light: true }
    }

    #[test]
    fn the_thesis_remembers_the_previous_ray_only() {
        let mut cache = Cache::new(Shape::THESIS, [16, 16], None);
        cache.put(place(0, 0), 7);
        assert_eq!(cache.seeds(place(15, 15)), [7]);
        cache.put(place(3, 0), NO_TRIANGLE);
        assert_eq!(cache.seeds(place(3, 0)), [NO_TRIANGLE]);
    }

    #[test]
    fn a_cell_keeps_its_latest_entries_each_once() {
        let mut cache = Cache::new(Shape { area: Area::Tile, entries: 2 }, [16, 16], None);
        for slot in [1, 2, 1, NO_TRIANGLE, 3] {
            cache.put(place(7, 7), slot);
        }
        assert_eq!(cache.seeds(place(0, 0)), [3, 1]);
        assert_eq!(cache.seeds(place(8, 0)), [NO_TRIANGLE; 2], "another tile");
    }

    #[test]
    fn what_the_light_sees_in_one_cell_shares_it() {
        let mut cache = Cache::new(Shape { area: Area::Light, entries: 1 }, [16, 16], None);
        cache.put(place(0, 0), 5);
        assert_eq!(cache.seeds(place(15, 15)), [5]);
        let other = Ray { dir: [0.3, -0.9, 1.0], ..RAY };
        assert_eq!(cache.seeds(Place { ray: &other, ..place(0, 0) }), [NO_TRIANGLE]);
        let corner = Ray { dir: [1.0, 1.0, -1.0], ..RAY };
        cache.put(Place { ray: &corner, ..place(0, 0) }, 6);
        assert_eq!(cache.seeds(Place { ray: &corner, ..place(0, 0) }), [6]);
    }

    #[test]
    fn the_frame_before_is_there_from_the_start_and_stays() {
        let before = [1, 2, 3, NO_TRIANGLE];
        let mut cache = Cache::new(Shape { area: Area::Frame, entries: 4 }, [2, 2], Some(&before));
        assert_eq!(cache.seeds(place(0, 0)), [1, 2, 3, NO_TRIANGLE]);
        cache.put(place(1, 0), 9);
        assert_eq!(cache.seeds(place(1, 0))[0], 2);
        assert_eq!(cache.seeds(place(1, 1)), [NO_TRIANGLE; 4]);
    }
}
