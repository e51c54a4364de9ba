//! The nave: a rib-vaulted church of seven bays with side aisles and an apse, the sun falling in through the
//! clerestory.
//!
//! x runs from the west wall to the altar, y up. Each side is described once, with the nave towards +z and the axis of
//! its piers at z = 0, and turned into place.

mod furniture;
mod gothic;
mod palette;

use super::{
    architecture::{Arch, arched_wall, bar, coursed_wall, facing, moulding, moved},
    builder::Builder,
    hash::unit,
};
use crate::scene::{CameraDescription, Falloff, Light, Scene};
use glam::{Affine3A, Vec2, Vec3};
use gothic::Window;
use palette::Palette;
use std::f32::consts::{FRAC_PI_2, PI};

const BAYS: usize = 7;
/// Width of a bay.
const BAY: f32 = 4.0;
/// Half the length of the nave.
const HALF: f32 = 0.5 * BAY * BAYS as f32;
/// From the axis of the nave to that of the piers.
const PIERS: f32 = 4.0;
/// Thickness of the arcade.
const THICK: f32 = 0.9;
/// Half the clear width of the nave.
const CLEAR: f32 = PIERS - 0.5 * THICK;
/// From the axis of the piers to the inner face of the outer wall.
const AISLE: f32 = 3.6;
/// Height of the piers.
const PIER: f32 = 4.9;
/// Top of the arcade's wall.
const ARCADE: f32 = 7.8;
/// Where the vault of the nave springs.
const SPRINGING: f32 = 9.2;
/// Top of all walls of the nave.
const TOP: f32 = 14.2;

const ARCADE_ARCH: Arch = Arch { half: 1.42, point: 1.6 };
const VAULT: Arch = Arch { half: CLEAR, point: 1.3 };
const AISLE_VAULT: Arch = Arch { half: 1.6, point: 1.3 };
/// In the wall above the arcade, which begins at [`ARCADE`].
const CLERESTORY: Window = Window { arch: Arch { half: 0.95, point: 2.0 }, sill: 1.5, springing: 3.1 };
const AISLE_WINDOW: Window = Window { arch: Arch { half: 0.9, point: 2.0 }, sill: 1.7, springing: 3.7 };
const APSE_WINDOW: Window = Window { arch: Arch { half: 0.55, point: 2.0 }, sill: 2.9, springing: 6.6 };

/// Makes the scene.
pub(super) fn nave(detail: f32) -> Scene {
    let mut b = Builder::new(detail);
    let m = Palette::new(&mut b);
    on_both_sides(&mut b, "piers", |b| piers(b, &m));
    on_both_sides(&mut b, "arcades", |b| arcade(b, &m));
    on_both_sides(&mut b, "clerestory", |b| clerestory(b, &m));
    on_both_sides(&mut b, "aisles", |b| aisle(b, &m));
    b.part("vault");
    vault(&mut b, &m);
    b.part("apse");
    b.at(moved(HALF, 0.0, 0.0), |b| apse(b, &m));
    b.part("end walls");
    end_walls(&mut b, &m);
    b.part("roofs");
    roofs(&mut b, &m);
    b.part("floor");
    floor(&mut b, &m);
    b.part("pews");
    pews(&mut b, &m);
    b.part("altar");
    b.at(moved(HALF + 0.3, 0.0, 0.0), |b| altar(b, &m));
    b.part("chandeliers");
    for x in [-3.0, 5.0] {
        let iron = [m.iron, m.wax, m.flame];
        b.at(moved(x, SPRINGING + VAULT.rise(), 0.0), |b| furniture::chandelier(b, 8.4, iron));
    }
    let camera = CameraDescription {
        eye: Vec3::new(-12.6, 2.5, 0.9),
        at: Vec3::new(2.0, 5.3, -0.2),
        up: Vec3::Y,
        fov_deg: 68.0,
    };
    b.finish("nave", lights(), camera, Vec3::new(0.13, 0.135, 0.155), Vec3::new(0.72, 0.84, 1.0))
}

fn lights() -> Vec<Light> {
    let light = |position: Vec3, intensity: [f32; 3], falloff: Falloff| Light::Point {
        position,
        intensity: intensity.into(),
        falloff,
    };
    vec![
        light(Vec3::new(-24.0, 83.0, 40.0), [2.5, 1.95, 1.25], Falloff::None),
        light(Vec3::new(-11.0, 9.5, -1.5), [0.17, 0.20, 0.27], Falloff::None),
        light(Vec3::new(HALF - 1.6, 4.6, 0.0), [15.0, 9.5, 4.6], Falloff::InverseSquare),
        light(Vec3::new(-2.5, 7.3, 0.3), [14.0, 10.0, 6.0], Falloff::InverseSquare),
    ]
}

fn on_both_sides(b: &mut Builder, part: &str, build: impl Fn(&mut Builder)) {
    b.part(part);
    for quarters in [0, 2] {
        b.at(facing(quarters, Vec3::ZERO) * moved(0.0, 0.0, -PIERS), |b| build(b));
    }
}

/// Middle of bay `i`.
fn bay(i: usize) -> f32 {
    (i as f32 + 0.5) * BAY - HALF
}

/// Piers, and the shafts that rise from them to the vault.
fn piers(b: &mut Builder, m: &Palette) {
    for i in 0..=BAYS {
        b.at(moved(i as f32 * BAY - HALF, 0.0, 0.0), |b| {
            gothic::clustered_pier(b, PIER, 0.4, m.carved, m.shaft);
            for x in [-0.2, 0.0, 0.2] {
                let z = 0.5 * THICK + if x == 0.0 { 0.1 } else { 0.03 };
                b.at(moved(x, PIER - 0.01, z), |b| {
                    gothic::colonnette(b, SPRINGING - PIER, 0.085, [m.carved, m.stone]);
                });
            }
            b.paint(m.carved);
            let z = 0.5 * THICK;
            b.cuboid(Vec3::new(-0.4, SPRINGING - 0.12, z - 0.1), Vec3::new(0.4, SPRINGING + 0.04, z + 0.3));
        });
    }
}

fn arcade(b: &mut Builder, m: &Palette) {
    for i in 0..BAYS {
        b.at(moved(bay(i), PIER, 0.0), |b| {
            b.paint(m.stone);
            arched_wall(b, ARCADE_ARCH, 0.5 * BAY, ARCADE - PIER, THICK);
            b.paint(m.carved);
            gothic::arcade_mouldings(b, ARCADE_ARCH, THICK);
        });
    }
    let p = Vec2::new;
    let string = [p(-0.02, 0.44), p(0.04, 0.54), p(0.12, 0.57), p(0.18, 0.56), p(0.24, 0.44)];
    let cells = b.steps(24.0, 1);
    b.at(moved(-HALF, ARCADE, 0.0), |b| moulding(b, 2.0 * HALF, [0.0; 2], cells, &string));
}

fn clerestory(b: &mut Builder, m: &Palette) {
    // In the plane of the arcade's face, but thinner, so that more sun comes in.
    let thick = 0.4;
    for i in 0..BAYS {
        b.at(moved(bay(i), ARCADE, 0.5 * (THICK - thick)), |b| {
            b.paint(m.stone);
            gothic::windowed_wall(b, CLERESTORY, 0.5 * BAY, TOP - ARCADE, thick);
            b.paint(m.carved);
            gothic::tracery(b, CLERESTORY);
        });
    }
}

/// Vaults, outer wall and stained windows of an aisle.
fn aisle(b: &mut Builder, m: &Palette) {
    let middle = -0.5 * (AISLE + 0.5 * THICK);
    let half = Vec2::new(0.5 * BAY, 0.5 * (AISLE - 0.5 * THICK));
    let thick = 0.5;
    for i in 0..BAYS {
        b.at(moved(bay(i), PIER, middle), |b| {
            gothic::ribbed_vault(b, AISLE_VAULT, half, [m.web, m.carved], 0.075);
        });
        b.at(moved(bay(i), 0.0, -AISLE - 0.5 * thick), |b| {
            b.paint(m.stone);
            gothic::windowed_wall(b, AISLE_WINDOW, 0.5 * BAY, ARCADE, thick);
            b.paint(m.carved);
            gothic::tracery(b, AISLE_WINDOW);
            b.at(moved(0.0, 0.0, -0.05), |b| gothic::stained_glass(b, AISLE_WINDOW, &m.glass, i as u32 % 3));
        });
    }
    for i in 0..=BAYS {
        let x = i as f32 * BAY - HALF;
        b.at(moved(x, PIER, middle), |b| gothic::transverse_rib(b, AISLE_VAULT, half.y, 0.12));
        b.at(moved(x, 0.0, -AISLE), |b| gothic::colonnette(b, PIER, 0.16, [m.carved, m.shaft]));
    }
}

fn vault(b: &mut Builder, m: &Palette) {
    let half = Vec2::new(0.5 * BAY, CLEAR);
    for i in 0..BAYS {
        b.at(moved(bay(i), SPRINGING, 0.0), |b| {
            gothic::ribbed_vault(b, VAULT, half, [m.web, m.carved], 0.11);
        });
    }
    for i in 0..=BAYS {
        let x = i as f32 * BAY - HALF;
        b.at(moved(x, SPRINGING, 0.0), |b| gothic::transverse_rib(b, VAULT, CLEAR, 0.16));
    }
}

/// A half round at the end of the nave, its middle on the origin: wall, half dome with ribs, stained windows.
fn apse(b: &mut Builder, m: &Palette) {
    let angle = |u: f32| (PI * (u - 0.5)).sin_cos();
    let cells = [b.steps(36.0, 8), b.steps(14.0, 4)];
    // Stones keep their size, however fine the mesh.
    let ashlar = |i: usize, j: usize| {
        let (i, j) = (i * 36 / cells[0], j * 14 / cells[1]);
        m.ashlar[(unit(((i + j % 2) / 2 + 4096 * j) as u32, 71) * m.ashlar.len() as f32) as usize]
    };
    b.mosaic(cells, true, ashlar, |u, v| {
        let (sin, cos) = angle(u);
        Vec3::new(CLEAR * cos, SPRINGING * v, CLEAR * sin)
    });
    b.paint(m.web);
    b.patch([cells[0], b.steps(8.0, 3)], true, |u, v| {
        let (sin, cos) = angle(u);
        let s = ((1.0 - v) * FRAC_PI_2).sin();
        Vec3::new(CLEAR * s * cos, SPRINGING + VAULT.height(s), CLEAR * s * sin)
    });
    let rib = [b.steps(6.0, 3), b.steps(10.0, 3)];
    for k in 0..6 {
        let turn = Affine3A::from_rotation_y(-PI * (k as f32 / 5.0 - 0.5) * 0.9);
        b.at(turn, |b| {
            b.paint(m.carved);
            bar(b, rib, 0.1, Vec3::NEG_Z, |v| {
                let s = (v * FRAC_PI_2).sin();
                Vec3::new(CLEAR * s, SPRINGING + VAULT.height(s) - 0.03, 0.0)
            });
            b.at(moved(CLEAR - 0.03, 0.0, 0.0), |b| {
                gothic::colonnette(b, SPRINGING, 0.13, [m.carved, m.shaft]);
            });
        });
    }
    for k in 0..5u32 {
        let turn = Affine3A::from_rotation_y(-PI * ((k as f32 + 0.5) / 5.0 - 0.5) * 0.9);
        b.at(turn * facing(3, Vec3::new(CLEAR - 0.08, 0.0, 0.0)), |b| {
            gothic::stained_glass(b, APSE_WINDOW, &m.glass, 3 + u32::abs_diff(k, 2));
            b.paint(m.carved);
            gothic::tracery(b, APSE_WINDOW);
        });
    }
}

/// The west wall, and the east walls of the aisles.
fn end_walls(b: &mut Builder, m: &Palette) {
    let out = PIERS + AISLE;
    b.at(facing(1, Vec3::new(-HALF, 0.0, out)), |b| {
        coursed_wall(b, Vec2::new(2.0 * out, TOP), 16.0, &m.ashlar, 72);
    });
    for z in [-out, CLEAR] {
        b.at(facing(3, Vec3::new(HALF, 0.0, z)), |b| {
            coursed_wall(b, Vec2::new(out - CLEAR, ARCADE), 9.0, &m.ashlar, 73);
        });
    }
}

/// The roof of the nave with its gables, and those of the aisles. Nobody sees them from within, but they keep the sun
/// well away from the vaults.
fn roofs(b: &mut Builder, m: &Palette) {
    let (ends, out) = ([-HALF - 0.4, HALF + CLEAR + 0.4], PIERS + 0.4);
    let (eaves, ridge) = (TOP - 0.02, TOP + 3.4);
    let cells = [b.steps(12.0, 1), b.steps(2.0, 1)];
    b.paint(m.lead);
    for side in [-1.0, 1.0] {
        for (foot, top, [low, high]) in
            [(out, 0.0, [eaves, ridge]), (PIERS + AISLE + 0.9, PIERS, [ARCADE - 0.1, SPRINGING])]
        {
            b.patch(cells, false, |u, v| {
                let x = 0.5 * (ends[0] + ends[1]) + side * (u - 0.5) * (ends[1] - ends[0]);
                Vec3::new(x, low + (high - low) * v, side * (foot + (top - foot) * v))
            });
        }
    }
    for (x, turn) in [(ends[0], 1.0), (ends[1], -1.0)] {
        b.patch([1, 1], false, |u, v| {
            Vec3::new(x, eaves + (ridge - eaves) * v, turn * out * (2.0 * u - 1.0) * (1.0 - v))
        });
    }
}

fn floor(b: &mut Builder, m: &Palette) {
    let (long, wide) = (2.0 * HALF + CLEAR, 2.0 * (PIERS + AISLE));
    let fine = b.steps(1.0, 1);
    let [nx, nz] = [long, wide].map(|length| b.steps(length / 0.6, 4).min((length / 0.6) as usize));
    let paint = |i: usize, j: usize| {
        let (i, j) = (i / fine, j / fine);
        let chance = unit((i + 4096 * j) as u32, 74);
        let from_axis = ((j as f32 + 0.5) / nz as f32 - 0.5).abs() * wide;
        if from_axis < 1.1 && from_axis > 0.7 || (i % 6 == 0) != (from_axis > 3.3 && from_axis < 4.5) {
            m.dark_tiles[(chance * 2.0) as usize]
        } else {
            m.tiles[(chance * 3.0) as usize]
        }
    };
    b.mosaic([nx * fine, nz * fine], false, paint, |u, v| Vec3::new(long * u - HALF, 0.0, wide * (0.5 - v)));
}

fn pews(b: &mut Builder, m: &Palette) {
    b.paint(m.wood);
    for row in 0..12 {
        let x = -8.6 + 1.3 * row as f32;
        for z in [-3.2, 1.2] {
            b.at(moved(x, 0.0, z), |b| furniture::pew(b, 2.0));
        }
    }
}

/// Steps, a carpet, and the altar with candles and a cross.
fn altar(b: &mut Builder, m: &Palette) {
    b.paint(m.marble);
    for (k, x) in [-3.4, -3.0, -2.6].into_iter().enumerate() {
        let (z, y) = (3.0 - 0.25 * k as f32, 0.16 * k as f32);
        b.cuboid(Vec3::new(x, y - 0.02, -z), Vec3::new(1.6 - 0.1 * k as f32, y + 0.16, z));
    }
    b.paint(m.carpet);
    let cells = [b.steps(1.0, 1), b.steps(24.0, 1)];
    b.quad(cells, Vec3::new(-3.42, 0.012, -0.55), Vec3::Z * 1.1, Vec3::NEG_X * 22.0);
    b.at(moved(0.2, 0.48, 0.0), |b| {
        furniture::altar(b, m.marble, m.linen, m.gold);
        for z in [-1.25, -0.9, -0.55, 0.55, 0.9, 1.25] {
            b.at(moved(0.2, 1.11, z), |b| furniture::candlestick(b, m.gold, m.wax, m.flame));
        }
        b.at(moved(0.25, 1.11, 0.0), |b| furniture::cross(b, m.gold));
    });
}
