//! Bright places in the picture of the sky, such as a small sun, towards which more shadow rays are sent.
//!
//! Directions are taken from two densities at once, cosine / pi about the normal and that of the picture, and what arrives is
//! divided by their mixture (the balance heuristic: E. Veach and L. Guibas, "Optimally Combining Sampling Techniques",
//! 1995). The picture's density counts only what exceeds the mean of the sky, as the cosine finds the rest better (O. Karlík et
//! al., "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", 2019), and it is mixed in by the
//! share of the light that this is: an even sky is sampled by the cosine alone.

use super::{
    ground::Ground,
    sky,
    source::{Squares, cosine_weighted, outward},
    wide,
};
use crate::{
    kernels::{F32, Kernel, MISS, RayBlock, SUB, Simd},
    scene::SkyMap,
    shade::{Surfaces, trig::sin_cos},
};
use glam::Vec3;
use std::{
    f32::consts::FRAC_1_PI,
    f64::consts::{PI, TAU},
};

/// Directions by what exceeds the mean of a picture of the sky: by *cells*, which are quarters of its pixels, because the light of
/// a pixel fades towards those around it.
#[derive(Clone, Debug)]
pub(super) struct Bright<'a> {
    map: &'a SkyMap,
    /// Share of rays that are sent to bright places, in (0, 0.99].
    pub(super) share: f32,
    /// What does not count as bright.
    dark: f32,
    /// Sum of what exceeds it, over all directions.
    bright: f32,
    /// Chance of the rows of cells up to and with each.
    rows: Vec<f32>,
    /// Of each cell of a row, together with those before it.
    columns: Vec<f32>,
    /// Height (y) of the edges of the rows on the unit sphere, from 1 down to -1.
    edges: Vec<f32>,
}

impl<'a> Bright<'a> {
    /// Of a picture; nothing if it is as bright everywhere.
    pub(super) fn new(map: &'a SkyMap) -> Option<Bright<'a>> {
        let [width, height] = map.size.map(|side| 2 * side as usize);
        let edge = |row: usize| (PI * row as f64 / height as f64).cos();
        let solid = |row: usize| (edge(row) - edge(row + 1)) * TAU / width as f64;
        let line = |row: usize| (0..width).map(move |column| f64::from(light(map, [column, row])));
        let total: f64 = (0..height).map(|row| solid(row) * line(row).sum::<f64>()).sum();
        // Less than a thousandth is no place, only rounding.
        let dark = (1.001 * total / (2.0 * TAU)) as f32;
        let mut columns = Vec::with_capacity(width * height);
        let mut powers = Vec::with_capacity(height);
        for row in 0..height {
            let excess: Vec<f64> = line(row).map(|light| (light - f64::from(dark)).max(0.0)).collect();
            powers.push(solid(row) * excess.iter().sum::<f64>());
            columns.extend(sums(&excess));
        }
        let bright: f64 = powers.iter().sum();
        (bright > 0.0).then(|| Bright {
            map,
            share: (bright / total).min(0.99) as f32,
            dark,
            bright: bright as f32,
            rows: sums(&powers),
            columns,
            edges: (0..=height).map(|row| edge(row) as f32).collect(),
        })
    }

    /// Replaces pairs of numbers whose first is below the share by places to send rays to: turn and height. Not in the kernel, as
    /// it searches.
    pub(super) fn aim(&self, squares: &Squares, surfaces: &Surfaces, places: &mut Squares) {
        places.iter_mut().for_each(|plane| plane.resize(surfaces.len(), 0.0));
        for ray in (0..surfaces.len()).filter(|&ray| surfaces.prim[ray] != MISS) {
            let [u, v] = [squares[0][ray], squares[1][ray]];
            if u < self.share {
                [places[0][ray], places[1][ray]] = self.pick([u / self.share, v]);
            }
        }
    }

    /// A direction by two numbers in [0, 1): its turn from +z towards +x, in [0, 1), and its height.
    fn pick(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let width = 2 * self.map.size[0] as usize;
        let (row, down) = find(&self.rows, u);
        let (column, along) = find(&self.columns[row * width..(row + 1) * width], v);
        let turn = sky::turn_of_column(self.map, 0.5 * (column as f32 + along));
        [turn, self.edges[row] + (self.edges[row + 1] - self.edges[row]) * down]
    }

    /// The factor of radiance from `dir`, given that directions are cosine-weighted about `normal` or bright places; both of
    /// length 1.
    pub(super) fn weight(&self, dir: Vec3, normal: Vec3) -> f32 {
        let cosine = normal.dot(dir).max(0.0) * FRAC_1_PI;
        // What has no cosine cannot be seen, and may have no chance either.
        if cosine == 0.0 { 0.0 } else { cosine / (cosine + self.share * (self.density(dir) - cosine)) }
    }

    /// Chance per solid angle of the direction `dir`.
    fn density(&self, dir: Vec3) -> f32 {
        let place = sky::place(self.map, dir);
        let cell = [0, 1].map(|k| ((2.0 * place[k]) as usize).min(2 * self.map.size[k] as usize - 1));
        (light(self.map, cell) - self.dark).max(0.0) / self.bright
    }
}

/// The mean of the picture, as it is looked up, over a cell; all colours together.
fn light(map: &SkyMap, [x, y]: [usize; 2]) -> f32 {
    let [width, height] = map.size.map(|side| side as usize);
    let light = |x: usize, y: usize| map.pixels[y * width + x].iter().sum::<f32>();
    // From the centre of a pixel to its edge, light changes linearly half the way to the next one's.
    let other = (x / 2 + width - 1 + 2 * (x % 2)) % width;
    let row = |y: usize| 0.75 * light(x / 2, y) + 0.25 * light(other, y);
    let next = if y % 2 == 0 { (y / 2).saturating_sub(1) } else { (y / 2 + 1).min(height - 1) };
    0.75 * row(y / 2) + 0.25 * row(next)
}

/// Parts of the whole up to and with each; equal ones if all are 0.
fn sums(parts: &[f64]) -> Vec<f32> {
    let total: f64 = parts.iter().sum();
    let part = |part: f64| if total > 0.0 { part / total } else { 1.0 / parts.len() as f64 };
    let mut sum = 0.0;
    parts
        .iter()
        .map(|&of| {
            sum += part(of);
            sum as f32
        })
        .collect()
}

/// In which part `chance` lies, and where within it, in [0, 1].
fn find(sums: &[f32], chance: f32) -> (usize, f32) {
    // Rounded sums may end below 1, and parts without a chance may follow.
    let end = sums[sums.len() - 1];
    let chance = (chance * end).min(end.next_down());
    let at = sums.partition_point(|&sum| sum <= chance).min(sums.len() - 1);
    let before = if at == 0 { 0.0 } else { sums[at - 1] };
    (at, ((chance - before) / (sums[at] - before)).clamp(0.0, 1.0))
}

/// Shadow rays to the sky for each surface: to bright places where the first number is below their share, else
/// cosine-weighted about the shading normals.
pub(super) struct Aim<'a> {
    pub(super) surfaces: &'a Surfaces,
    pub(super) ground: &'a Ground,
    pub(super) squares: &'a Squares,
    /// Share of bright places.
    pub(super) share: f32,
    /// See [`Bright::aim`].
    pub(super) places: &'a Squares,
    pub(super) blocks: &'a mut [RayBlock],
}

impl Kernel for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Aim { surfaces, ground, squares, share, places, blocks } = self;
        let (zero, one) = (F32::<S, 16>::splat(s, 0.0), F32::<S, 16>::splat(s, 1.0));
        let share = F32::splat(s, share);
        for (index, block) in blocks.iter_mut().enumerate() {
            let at = index * SUB;
            let [u, v] = [F32::load_at(s, &squares[0], at), F32::load_at(s, &squares[1], at)];
            let aimed = u.lt(share);
            let [sin, cos] = sin_cos(s, F32::load_at(s, &places[0], at));
            let height = F32::load_at(s, &places[1], at);
            let level = (one - height * height).max(zero).sqrt();
            let rest = ((u - share) / (one - share)).max(zero);
            let around = cosine_weighted(s, surfaces, [rest, v], at);
            let dir = wide::select(aimed, [sin * level, height, cos * level], around);
            outward(s, surfaces, ground, at, dir, f32::INFINITY, block);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky with a small bright place, and one pixel at either pole.
    fn sky(size: [u32; 2]) -> SkyMap {
        let [width, height] = size.map(|side| side as usize);
        let mut pixels = vec![[0.1, 0.2, 0.3]; width * height];
        pixels[(height / 3) * width + width / 4] = [900.0, 800.0, 500.0];
        pixels[width - 1] = [50.0, 0.0, 0.0];
        pixels[width * height - width] = [0.0, 70.0, 0.0];
        SkyMap { size, pixels, rotation: 1.1, strength: 1.0 }
    }

    fn direction([turn, height]: [f32; 2]) -> Vec3 {
        let (sin, cos) = (f64::from(turn) * TAU).sin_cos();
        let level = (1.0 - f64::from(height).powi(2)).max(0.0).sqrt();
        Vec3::new((sin * level) as f32, height, (cos * level) as f32)
    }

    /// Points that fill the unit square evenly.
    fn squares(count: u32) -> impl Iterator<Item = [f32; 2]> {
        (0..count * count).map(move |i| [i % count, i / count].map(|at| (at as f32 + 0.5) / count as f32))
    }

    #[test]
    fn an_even_sky_has_no_bright_place() {
        let map = SkyMap { size: [7, 5], pixels: vec![[0.3, 2.0, 0.7]; 35], rotation: 0.0, strength: 1.0 };
        assert!(Bright::new(&map).is_none());
        let black = SkyMap { pixels: vec![[0.0; 3]; 35], ..map };
        assert!(Bright::new(&black).is_none());
    }

    #[test]
    fn directions_have_the_density_that_is_told() {
        for size in [[1, 2], [9, 6], [64, 32]] {
            let map = sky(size);
            let bright = Bright::new(&map).unwrap();
            // By Monte Carlo's own rule: the mean of f / density is the integral of f where there is a chance at all.
            let f = |dir: Vec3| f64::from(1.0 + dir.x + dir.y * dir.z);
            let picked = squares(1000).map(|square| {
                let dir = direction(bright.pick(square));
                f(dir) / f64::from(bright.density(dir))
            });
            let picked: f64 = picked.sum::<f64>() / 1.0e6;
            let (mut whole, mut chance) = (0.0, 0.0);
            let [width, height] = size.map(|side| 2 * side);
            for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
                let edge = |row: u32| (PI * f64::from(row) / f64::from(height)).cos();
                let (top, bottom) = (edge(row), edge(row + 1));
                let solid = (top - bottom) * TAU / f64::from(width) / 64.0;
                for [u, v] in squares(8) {
                    let turn = (column as f32 + u) / width as f32 + map.rotation / std::f32::consts::TAU;
                    let dir = direction([turn, (top + (bottom - top) * f64::from(v)) as f32]);
                    let density = f64::from(bright.density(dir));
                    chance += solid * density;
                    whole += if density > 0.0 { solid * f(dir) } else { 0.0 };
                }
            }
            assert!((chance - 1.0).abs() < 1.0e-4, "{size:?}: {chance}");
            assert!((picked / whole - 1.0).abs() < 1.0e-2, "{size:?}: {picked} {whole}");
        }
    }

    #[test]
    fn no_direction_counts_much_more_than_another() {
        let map = sky([64, 32]);
        let bright = Bright::new(&map).unwrap();
        let turn = sky::turn_of_column(&map, 16.5);
        let normal = direction([turn, (10.5 * PI / 32.0).cos() as f32]);
        let (mut most, mut mean) = (0.0f32, 0.0);
        for [u, v] in squares(1500) {
            let dir = direction([u, 1.0 - 2.0 * v]);
            let light = sky::look_up(&map, dir).element_sum();
            most = most.max(light * bright.weight(dir, normal));
            mean += light * normal.dot(dir).max(0.0) * 4.0 / 2.25e6;
        }
        // Nowhere in a cell is there more than four times its mean. The cosine alone meets 300 times the mean.
        assert!(most < 4.0 / bright.share * mean, "{most} {mean}");
    }
}
