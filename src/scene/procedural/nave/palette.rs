//! The materials of the nave.

use super::super::{
    architecture::{matt, polished},
    builder::Builder,
};
use crate::scene::Material;
use glam::Vec3;

/// Material numbers.
pub(super) struct Palette {
    pub stone: u32,
    pub carved: u32,
    pub shaft: u32,
    pub web: u32,
    pub ashlar: [u32; 3],
    pub tiles: [u32; 3],
    pub dark_tiles: [u32; 2],
    pub wood: u32,
    pub marble: u32,
    pub gold: u32,
    pub iron: u32,
    pub lead: u32,
    pub wax: u32,
    pub flame: u32,
    pub linen: u32,
    pub carpet: u32,
    pub glass: [u32; 7],
}

impl Palette {
    /// Adds the materials to `b`.
    pub(super) fn new(b: &mut Builder) -> Palette {
        let glowing = |name: &str, kd: [f32; 3], strength: f32| Material {
            ke: Vec3::from(kd) * strength,
            ..matt(name, kd)
        };
        let glass = [
            [0.05, 0.14, 0.62],
            [0.08, 0.22, 0.75],
            [0.62, 0.05, 0.06],
            [0.75, 0.10, 0.08],
            [0.85, 0.58, 0.10],
            [0.08, 0.42, 0.18],
            [0.36, 0.10, 0.48],
        ];
        let ashlar = [[0.62, 0.57, 0.48], [0.57, 0.52, 0.44], [0.66, 0.61, 0.52]];
        let tiles = [[0.50, 0.45, 0.38], [0.45, 0.40, 0.34], [0.54, 0.50, 0.43]];
        let dark = [[0.20, 0.19, 0.19], [0.26, 0.15, 0.12]];
        Palette {
            stone: b.material(matt("stone", [0.64, 0.59, 0.50])),
            carved: b.material(matt("carved stone", [0.72, 0.67, 0.57])),
            shaft: b.material(polished("dark shaft", [0.36, 0.32, 0.30], 0.22, 40.0)),
            web: b.material(matt("vault", [0.74, 0.70, 0.62])),
            ashlar: ashlar.map(|kd| b.material(matt("ashlar", kd))),
            tiles: tiles.map(|kd| b.material(polished("floor", kd, 0.12, 30.0))),
            dark_tiles: dark.map(|kd| b.material(polished("dark floor", kd, 0.2, 40.0))),
            wood: b.material(polished("oak", [0.26, 0.13, 0.06], 0.12, 24.0)),
            marble: b.material(polished("marble", [0.78, 0.75, 0.70], 0.2, 50.0)),
            gold: b.material(polished("gold", [0.72, 0.50, 0.14], 0.6, 40.0)),
            lead: b.material(matt("lead roof", [0.32, 0.35, 0.38])),
            iron: b.material(polished("iron", [0.06, 0.06, 0.06], 0.25, 24.0)),
            wax: b.material(matt("wax", [0.85, 0.80, 0.66])),
            flame: b.material(glowing("flame", [1.0, 0.72, 0.30], 1.2)),
            linen: b.material(matt("linen", [0.80, 0.78, 0.72])),
            carpet: b.material(matt("carpet", [0.42, 0.04, 0.05])),
            glass: glass.map(|kd| b.material(glowing("glass", kd, 1.0))),
        }
    }
}
