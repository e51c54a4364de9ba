//! The atrium: a court between two storeys of arcades, open to the sky, with a fountain, plants and banners.
//!
//! The court is 18 x 9 metres in plan, in bays of 3; x runs along it, y up. Each of its four sides is described once,
//! with the court towards +z, and turned into place.

mod furnish;
mod palette;

use super::{
    architecture::{
        Arch, Column, arched_wall, archivolt, coursed_wall, facing, groin_vault, moulding, moved,
    },
    builder::Builder,
    garden,
};
use crate::scene::{CameraDescription, Scene};
use glam::{Vec2, Vec3};
use palette::Palette;

/// Width of a bay.
const BAY: f32 = 3.0;
/// Half the length and half the width of the court, between the axes of the arcades.
const COURT: Vec2 = Vec2::new(9.0, 4.5);
/// From the axis of an arcade to the wall behind it.
const WALK: f32 = 3.3;
/// Thickness of the arcades.
const THICK: f32 = 0.6;
/// Height of the gallery's floor.
const GALLERY: f32 = 5.0;
/// Height of the eaves.
const EAVES: f32 = 9.35;

const GROUND_COLUMN: Column = Column { height: 3.2, radius: 0.24, around: 14.0, leaves: 2 };
const UPPER_COLUMN: Column = Column { height: 2.55, radius: 0.16, around: 10.0, leaves: 1 };
const GROUND_ARCH: Arch = Arch { half: 1.13, point: 1.0 };
const UPPER_ARCH: Arch = Arch { half: 1.24, point: 1.0 };

/// One side of the court, in its own frame: the axis of its arcade is z = 0, its middle x = 0.
#[derive(Clone, Copy)]
struct Side {
    quarters: i32,
    /// From the middle of the court to the axis of the arcade.
    distance: f32,
    bays: usize,
}

impl Side {
    /// Half the length between the axes of its corners.
    fn half(self) -> f32 {
        0.5 * BAY * self.bays as f32
    }

    /// Middle of bay `i`.
    fn bay(self, i: usize) -> f32 {
        (i as f32 + 0.5) * BAY - self.half()
    }

    fn is_long(self) -> bool {
        self.bays > 3
    }
}

/// The far long side in the sun, the near long side, the end behind the camera, the end in front of it.
const SIDES: [Side; 4] = [
    Side { quarters: 0, distance: COURT.y, bays: 6 },
    Side { quarters: 2, distance: COURT.y, bays: 6 },
    Side { quarters: 1, distance: COURT.x, bays: 3 },
    Side { quarters: 3, distance: COURT.x, bays: 3 },
];

/// Makes the scene.
pub(super) fn atrium(detail: f32) -> Scene {
    let mut b = Builder::new(detail);
    let m = Palette::new(&mut b);
    on_each_side(&mut b, "columns", |b, side| columns(b, &m, side));
    on_each_side(&mut b, "arcades", |b, side| arcades(b, &m, side));
    on_each_side(&mut b, "balustrades", |b, side| balustrade(b, &m, side));
    on_each_side(&mut b, "vaults", |b, side| vaults(b, &m, side));
    on_each_side(&mut b, "walls", |b, side| walls(b, &m, side));
    on_each_side(&mut b, "roof", |b, side| roof(b, &m, side));
    b.part("floor");
    floor(&mut b, &m);
    on_each_side(&mut b, "cloth", |b, side| furnish::cloth(b, &m, side));
    b.part("fountain");
    b.at(moved(1.5, 0.0, 0.0), |b| garden::fountain(b, m.marble, m.water, m.spray));
    b.part("plants");
    furnish::plants(&mut b, &m);
    b.part("lanterns");
    let lights = furnish::lights(&mut b, &m);
    let camera = CameraDescription {
        eye: Vec3::new(-8.2, 2.3, -1.3),
        at: Vec3::new(0.0, 3.35, 0.35),
        up: Vec3::Y,
        fov_deg: 64.0,
    };
    b.finish("atrium", lights, camera, Vec3::new(0.105, 0.125, 0.17), Vec3::new(0.30, 0.52, 0.86))
}

fn on_each_side(b: &mut Builder, part: &str, build: impl Fn(&mut Builder, Side)) {
    b.part(part);
    for side in SIDES {
        let place = facing(side.quarters, Vec3::ZERO) * moved(0.0, 0.0, -side.distance);
        b.at(place, |b| build(b, side));
    }
}

/// Columns between the bays, and the pier at the left corner of the side (the right one belongs to the next side).
fn columns(b: &mut Builder, m: &Palette, side: Side) {
    for i in 1..side.bays {
        let x = i as f32 * BAY - side.half();
        b.at(moved(x, 0.0, 0.0), |b| GROUND_COLUMN.build(b, m.shaft, m.carved));
        b.at(moved(x, GALLERY, 0.0), |b| UPPER_COLUMN.build(b, m.marble, m.carved));
    }
    for (low, column) in [(0.0, GROUND_COLUMN), (GALLERY, UPPER_COLUMN)] {
        b.at(moved(-side.half(), low, 0.0), |b| pier(b, m, column));
    }
}

/// A square pier as high as `column`.
fn pier(b: &mut Builder, m: &Palette, column: Column) {
    let (a, h) = (column.abacus(), column.height);
    b.paint(m.carved);
    let mut slab = |half: f32, low: f32, high: f32| {
        b.cuboid(Vec3::new(-half, low, -half), Vec3::new(half, high, half));
    };
    slab(a + 0.05, -0.02, 0.3);
    slab(a - 0.03, 0.29, h - 0.28);
    slab(a, h - 0.29, h - 0.2);
    slab(a + 0.03, h - 0.21, h + 0.001);
    slab(0.5 * THICK - 0.004, h - 0.01, h + 1.6);
}

/// The arched walls of both storeys with their mouldings.
fn arcades(b: &mut Builder, m: &Palette, side: Side) {
    let p = Vec2::new;
    let profile = [p(0.0, 0.29), p(0.0, 0.36), p(0.12, 0.36), p(0.16, 0.41), p(0.26, 0.41), p(0.29, 0.29)];
    for i in 0..side.bays {
        for (springing, arch, top) in [
            (GROUND_COLUMN.height, GROUND_ARCH, GALLERY - 0.05),
            (GALLERY + UPPER_COLUMN.height, UPPER_ARCH, EAVES),
        ] {
            b.at(moved(side.bay(i), springing, 0.0), |b| {
                b.paint(m.wall);
                arched_wall(b, arch, 0.5 * BAY, top - springing, THICK);
                b.paint(m.carved);
                archivolt(b, arch, &profile);
                keystone(b, arch);
            });
        }
        b.at(moved(side.bay(i) - 0.5 * BAY, 3.95, 0.5 * THICK), |b| roundel(b, m, i > 0));
    }
    let string = [p(0.0, 0.29), p(0.05, 0.4), p(0.12, 0.42), p(0.2, 0.5), p(0.35, 0.5), p(0.35, 0.34)];
    let cells = b.steps(6.0 * side.bays as f32, 1);
    b.paint(m.carved);
    b.at(moved(-side.half(), GALLERY - 0.35, 0.0), |b| {
        moulding(b, 2.0 * side.half(), [-1.0, -1.0], cells, &string);
    });
}

fn keystone(b: &mut Builder, arch: Arch) {
    let y = arch.rise();
    b.cuboid(Vec3::new(-0.09, y - 0.04, 0.28), Vec3::new(0.09, y + 0.31, 0.46));
}

/// A disc of coloured marble in the spandrel, framed; nothing at the corners, where there is no room for it.
fn roundel(b: &mut Builder, m: &Palette, room: bool) {
    if !room {
        return;
    }
    let p = Vec2::new;
    let around = b.steps(14.0, 5);
    let upright = glam::Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
    b.at(upright, |b| {
        b.paint(m.carved);
        b.lathe(&[p(0.25, -0.01), p(0.25, 0.05), p(0.19, 0.05), p(0.17, 0.02)], around);
        b.paint(m.porphyry);
        b.lathe(&[p(0.18, 0.02), p(0.0, 0.045)], around);
    });
}

/// Turned balusters between two rails, in every bay of the gallery.
fn balustrade(b: &mut Builder, m: &Palette, side: Side) {
    let p = Vec2::new;
    let outline = [
        p(0.055, 0.1),
        p(0.05, 0.14),
        p(0.03, 0.19),
        p(0.06, 0.27),
        p(0.075, 0.36),
        p(0.05, 0.5),
        p(0.03, 0.64),
        p(0.045, 0.68),
        p(0.032, 0.72),
        p(0.055, 0.8),
    ];
    let count = b.steps(7.0, 3).min(7);
    b.paint(m.marble);
    for i in 0..side.bays {
        for k in 0..count {
            let x = ((k as f32 + 0.5) / count as f32 - 0.5) * 2.42;
            b.at(moved(side.bay(i) + x, GALLERY, 0.12), |b| garden::vessel(b, 6.0, 6.0, &outline));
        }
        let half = 0.5 * BAY - 0.15;
        b.at(moved(side.bay(i), GALLERY, 0.12), |b| {
            b.cuboid(Vec3::new(-half, -0.01, -0.1), Vec3::new(half, 0.11, 0.1));
            b.cuboid(Vec3::new(-half, 0.79, -0.09), Vec3::new(half, 0.85, 0.09));
            b.cuboid(Vec3::new(-half, 0.84, -0.13), Vec3::new(half, 0.94, 0.13));
        });
    }
}

/// Vaults over the ground floor's walk, with arches across it; beams under the gallery's ceiling.
fn vaults(b: &mut Builder, m: &Palette, side: Side) {
    let half = 0.5 * (WALK - 0.5 * THICK);
    let middle = -0.5 * (WALK + 0.5 * THICK);
    let springing = GROUND_COLUMN.height;
    let shape = Arch { half: 1.48, point: 1.0 };
    b.paint(m.plaster);
    for i in 0..side.bays {
        b.at(moved(side.bay(i), springing, middle), |b| groin_vault(b, shape, 0.5 * BAY, half));
    }
    let corner = 0.5 * WALK;
    b.at(moved(-side.half() - corner, springing, -corner), |b| groin_vault(b, shape, corner, corner));

    let across = Arch { half: 1.3, point: 1.0 };
    for i in 0..=side.bays {
        let x = i as f32 * BAY - side.half();
        b.paint(m.carved);
        b.at(moved(x, springing, middle) * facing(1, Vec3::ZERO), |b| {
            arched_wall(b, across, half, 1.75, 0.36);
        });
        b.at(moved(x, 0.0, -WALK), |b| pilaster(b, springing));
        b.paint(m.wood);
        b.cuboid(Vec3::new(x - 0.1, EAVES - 0.3, -WALK), Vec3::new(x + 0.1, EAVES - 0.01, -0.29));
        let x = x + 0.5 * BAY;
        if i < side.bays {
            b.cuboid(Vec3::new(x - 0.1, EAVES - 0.3, -WALK), Vec3::new(x + 0.1, EAVES - 0.01, -0.29));
        }
    }
}

/// A flat pier against the wall behind it.
fn pilaster(b: &mut Builder, height: f32) {
    b.cuboid(Vec3::new(-0.24, -0.02, -0.1), Vec3::new(0.24, 0.3, 0.24));
    b.cuboid(Vec3::new(-0.18, 0.29, -0.1), Vec3::new(0.18, height - 0.2, 0.19));
    b.cuboid(Vec3::new(-0.24, height - 0.21, -0.1), Vec3::new(0.24, height + 0.003, 0.25));
}

/// The walls behind both walks, with painted dado and doors.
fn walls(b: &mut Builder, m: &Palette, side: Side) {
    let half = side.half() + WALK;
    let p = Vec2::new;
    let cells = b.steps(3.0 * side.bays as f32, 1);
    for (storey, low, high) in [(0, 0.0, GALLERY - 0.02), (1, GALLERY, EAVES)] {
        let dado = 1.15;
        b.at(moved(-half, low, -WALK), |b| {
            b.paint(if storey == 0 { m.red } else { m.blue });
            b.quad([cells, 1], Vec3::ZERO, Vec3::X * 2.0 * half, Vec3::Y * dado);
            b.paint(m.carved);
            let rail = [p(dado - 0.03, -0.01), p(dado, 0.05), p(dado + 0.06, 0.05), p(dado + 0.08, -0.01)];
            moulding(b, 2.0 * half, [-1.0, -1.0], cells, &rail);
        });
        b.at(moved(-half, low + dado, -WALK), |b| {
            let size = p(2.0 * half, high - low - dado);
            coursed_wall(b, size, 5.0, &m.stones, 7 + storey);
        });
        for i in (0..side.bays).filter(|i| i % 2 == usize::from(!side.is_long())) {
            b.at(moved(side.bay(i), low, -WALK), |b| {
                garden::door(b, Arch { half: 0.62, point: 1.0 }, 2.1, m.wood, m.carved);
            });
        }
    }
}

/// The floor and the ceiling of the gallery, the cornice, and the tiled slope above.
fn roof(b: &mut Builder, m: &Palette, side: Side) {
    let (near, far) = (side.half(), side.half() + WALK);
    let rows = b.steps(2.0, 1);
    let strip = |b: &mut Builder, cells: usize, y: [f32; 2], z: [f32; 2], [near, far]: [f32; 2], up: bool| {
        b.patch([cells, rows], false, |u, v| {
            let v = if up { 1.0 - v } else { v };
            let half = near + (far - near) * v;
            Vec3::new(half * (2.0 * u - 1.0), y[0] + (y[1] - y[0]) * v, z[0] + (z[1] - z[0]) * v)
        });
    };
    let cells = b.steps(2.0 * side.bays as f32, 1);
    b.paint(m.terracotta);
    strip(b, cells, [GALLERY; 2], [0.34, -WALK], [near - 0.34, far], false);
    b.paint(m.plaster);
    strip(b, cells, [EAVES - 0.02; 2], [0.28, -WALK], [near - 0.28, far], true);
    let p = Vec2::new;
    let cornice = [
        p(-0.3, 0.29),
        p(-0.25, 0.36),
        p(-0.12, 0.36),
        p(-0.08, 0.44),
        p(0.04, 0.46),
        p(0.06, 0.62),
        p(0.16, 0.62),
        p(0.24, 0.7),
        p(0.28, 0.7),
    ];
    b.paint(m.carved);
    b.at(moved(-near, EAVES, 0.0), |b| {
        moulding(b, 2.0 * near, [-1.0, -1.0], 2 * cells, &cornice);
    });
    dentils(b, near);
    b.paint(m.terracotta);
    strip(b, 4 * cells, [EAVES + 0.28, EAVES + 1.9], [0.7, -WALK - 0.4], [near - 0.7, far + 0.4], false);
}

/// Small blocks under the cornice.
fn dentils(b: &mut Builder, half: f32) {
    let full = half * 5.0 - 2.0;
    let count = b.steps(full, 4).min(full as usize);
    for i in 0..count {
        let x = (i as f32 + 0.5 - 0.5 * count as f32) * (2.0 * half - 0.8) / count as f32;
        let y = EAVES - 0.1;
        b.cuboid(Vec3::new(x - 0.07, y - 0.13, 0.35), Vec3::new(x + 0.07, y + 0.01, 0.45));
    }
}

/// Stone tiles: a frame of dark ones along the arcades, a chequer within, plain slabs under the vaults.
fn floor(b: &mut Builder, m: &Palette) {
    let half = COURT + Vec2::splat(WALK);
    let fine = b.steps(1.0, 1);
    // Tiles of 0.6 m, so that the arcades stand on a joint.
    let [nx, nz] = [half.x, half.y].map(|half| {
        let most = (half / 0.3).round();
        b.steps(most, 3).min(most as usize)
    });
    let size = 2.0 * half / Vec2::new(nx as f32, nz as f32);
    let paint = |i: usize, j: usize| {
        let (i, j) = (i / fine, j / fine);
        let centre = |k: usize, axis: usize| ((k as f32 + 0.5) * size[axis] - half[axis]).abs();
        let inside = COURT - Vec2::new(centre(i, 0), centre(j, 1));
        m.tile(inside.min_element(), i, j)
    };
    b.mosaic([nx * fine, nz * fine], false, paint, |u, v| {
        Vec3::new(half.x * (2.0 * u - 1.0), 0.0, half.y * (1.0 - 2.0 * v))
    });
}
