//! The materials of the atrium.

use super::super::{
    architecture::{matt, polished},
    builder::Builder,
    hash::unit,
};

/// Material numbers.
pub(super) struct Palette {
    pub wall: u32,
    pub plaster: u32,
    pub carved: u32,
    pub shaft: u32,
    pub marble: u32,
    pub porphyry: u32,
    pub stones: [u32; 3],
    pub red: u32,
    pub blue: u32,
    pub wood: u32,
    pub terracotta: u32,
    pub water: u32,
    pub spray: u32,
    pub earth: u32,
    pub greens: [u32; 2],
    pub agave: [u32; 2],
    pub orange: u32,
    pub iron: u32,
    pub glow: u32,
    /// Field and border of each kind of cloth.
    pub cloths: [[u32; 2]; 3],
    light_tiles: [u32; 3],
    dark_tiles: [u32; 2],
    border_tiles: [u32; 2],
}

impl Palette {
    /// Adds the materials to `b`.
    pub(super) fn new(b: &mut Builder) -> Palette {
        let mut matt = |name: &str, kd| b.material(matt(name, kd));
        let gold = matt("gold cloth", [0.72, 0.48, 0.12]);
        let crimson = matt("crimson cloth", [0.52, 0.035, 0.045]);
        let ultramarine = matt("blue cloth", [0.04, 0.10, 0.38]);
        let green = matt("green cloth", [0.05, 0.24, 0.12]);
        let stones = [[0.66, 0.56, 0.42], [0.60, 0.50, 0.37], [0.70, 0.61, 0.47]];
        let mut palette = Palette {
            wall: matt("limestone", [0.74, 0.64, 0.48]),
            plaster: matt("plaster", [0.72, 0.66, 0.56]),
            carved: matt("carved stone", [0.80, 0.72, 0.58]),
            stones: stones.map(|kd| matt("coursed stone", kd)),
            red: matt("red dado", [0.42, 0.10, 0.06]),
            blue: matt("blue dado", [0.12, 0.22, 0.36]),
            wood: matt("wood", [0.22, 0.11, 0.05]),
            terracotta: matt("terracotta", [0.58, 0.24, 0.12]),
            earth: matt("earth", [0.10, 0.07, 0.05]),
            cloths: [[crimson, gold], [ultramarine, gold], [green, gold]],
            shaft: 0,
            marble: 0,
            porphyry: 0,
            water: 0,
            spray: 0,
            greens: [0; 2],
            agave: [0; 2],
            orange: 0,
            iron: 0,
            glow: 0,
            light_tiles: [0; 3],
            dark_tiles: [0; 2],
            border_tiles: [0; 2],
        };
        palette.add_polished(b);
        palette
    }

    fn add_polished(&mut self, b: &mut Builder) {
        let mut glow = matt("lamp glass", [0.9, 0.8, 0.6]);
        glow.ke = glam::Vec3::new(1.0, 0.72, 0.36);
        self.glow = b.material(glow);
        let mut polished = |name: &str, kd, ks, ns| b.material(polished(name, kd, ks, ns));
        self.shaft = polished("rose granite", [0.60, 0.40, 0.33], 0.22, 40.0);
        self.marble = polished("white marble", [0.82, 0.80, 0.75], 0.18, 50.0);
        self.porphyry = polished("porphyry", [0.32, 0.07, 0.09], 0.35, 60.0);
        self.water = polished("water", [0.08, 0.26, 0.32], 0.8, 160.0);
        self.spray = polished("spray", [0.55, 0.70, 0.76], 0.6, 60.0);
        self.greens = [[0.05, 0.14, 0.03], [0.11, 0.25, 0.05]].map(|kd| polished("leaves", kd, 0.10, 20.0));
        self.agave = [[0.16, 0.30, 0.20], [0.22, 0.38, 0.24]].map(|kd| polished("agave", kd, 0.12, 24.0));
        self.orange = polished("orange", [0.85, 0.32, 0.03], 0.25, 30.0);
        self.iron = polished("iron", [0.07, 0.06, 0.06], 0.25, 24.0);
        let light = [[0.70, 0.63, 0.52], [0.66, 0.58, 0.46], [0.74, 0.68, 0.58]];
        self.light_tiles = light.map(|kd| polished("light tile", kd, 0.10, 30.0));
        let dark = [[0.36, 0.16, 0.10], [0.42, 0.20, 0.13]];
        self.dark_tiles = dark.map(|kd| polished("red tile", kd, 0.12, 30.0));
        let border = [[0.13, 0.16, 0.18], [0.17, 0.20, 0.22]];
        self.border_tiles = border.map(|kd| polished("slate tile", kd, 0.18, 40.0));
    }

    /// The material of floor tile (i, j), `inside` metres from the edge of the court (negative under the arcades).
    pub(super) fn tile(&self, inside: f32, i: usize, j: usize) -> u32 {
        let pick = |tiles: &[u32]| {
            let chance = unit((i + 4096 * j) as u32, 51);
            tiles[(chance * tiles.len() as f32) as usize]
        };
        let framed = (0.6..1.2).contains(&inside) || (-0.6..0.0).contains(&inside);
        match () {
            _ if framed => pick(&self.border_tiles),
            _ if inside > 0.0 && (i + j).is_multiple_of(2) => pick(&self.dark_tiles),
            _ => pick(&self.light_tiles),
        }
    }
}
