//! Pictures made by this project: paintings, wood, stone, a leaf.

use super::hash::{between, unit};
use crate::scene::{Texture, Wrap};
use glam::{Vec2, Vec3};

/// A square picture; `color` gives red, green, blue and opacity at (x, y) in the unit square, y running up.
fn picture(name: &str, side: u32, wrap: Wrap, color: impl Fn(Vec2) -> [f32; 4]) -> Texture {
    let at = |i: u32| {
        let (x, row) = (i % side, i / side);
        color(Vec2::new(x as f32 + 0.5, (side - 1 - row) as f32 + 0.5) / side as f32)
    };
    Texture::new(name, [side; 2], (0..side * side).map(at).collect(), wrap)
}

fn opaque(color: Vec3) -> [f32; 4] {
    color.extend(1.0).to_array()
}

/// Smooth noise in [0, 1] that repeats after `period` units in both directions; `kind` makes each its own.
fn noise(at: Vec2, period: u32, kind: u32) -> f32 {
    let cell = at.floor();
    let f = at - cell;
    let f = f * f * (3.0 - 2.0 * f);
    let wrap = |c: f32| c.rem_euclid(period as f32) as u32 % period;
    let corner = |dx: f32, dy: f32| unit(wrap(cell.x + dx) * 1031 + wrap(cell.y + dy), kind);
    let row = |dy: f32| corner(0.0, dy) + (corner(1.0, dy) - corner(0.0, dy)) * f.x;
    row(0.0) + (row(1.0) - row(0.0)) * f.y
}

/// Noise of several sizes, in [0, 1], with the period 1.
fn fractal(at: Vec2, coarsest: u32, octaves: u32, kind: u32) -> f32 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let period = coarsest << octave;
        sum += weight * noise(at * period as f32, period, kind + octave);
        total += weight;
        weight *= 0.5;
    }
    sum / total
}

/// The sun over the sea at dusk.
pub(super) fn dusk(side: u32) -> Texture {
    let sun = Vec2::new(0.62, 0.55);
    picture("dusk", side, Wrap::Clamp, |at| {
        let (low, high) = (Vec3::new(0.95, 0.42, 0.13), Vec3::new(0.05, 0.09, 0.28));
        let sky = |y: f32| low.lerp(high, ((y - 0.42) / 0.58).clamp(0.0, 1.0).sqrt());
        let glow = |d: f32| Vec3::new(1.0, 0.75, 0.35) * (-9.0 * d).exp();
        if at.y > 0.42 {
            let distance = at.distance(sun);
            let cloud = (fractal(at * Vec2::new(1.0, 3.0), 4, 4, 11) - 0.55).max(0.0) * 1.6;
            let disc = if distance < 0.07 { Vec3::new(0.7, 0.5, 0.25) } else { Vec3::ZERO };
            return opaque((sky(at.y) + glow(distance) + disc).lerp(Vec3::new(0.35, 0.10, 0.16), cloud));
        }
        // The sky upside down, broken by waves that shrink towards the horizon.
        let depth = 0.42 - at.y;
        let wave = noise(Vec2::new(at.x * 14.0, (depth + 0.03).ln() * 16.0 + 64.0), 4096, 5) - 0.5;
        let mirrored = 0.42 + depth * 1.1 + 0.3 * wave * depth;
        let streak = ((at.x - sun.x + 0.16 * wave).abs() * 6.0 / (0.25 + depth)).min(4.0);
        opaque(0.55 * sky(mirrored) + 0.9 * Vec3::new(1.0, 0.6, 0.25) * (-streak * streak).exp())
    })
}

/// Rectangles of clear colours between black bars, after Mondrian.
pub(super) fn bars(side: u32) -> Texture {
    // Left, bottom, right, top, and a colour; the ground is off-white.
    const FIELDS: [([f32; 4], [f32; 3]); 5] = [
        ([0.28, 0.36, 1.0, 1.0], [0.78, 0.05, 0.03]),
        ([0.0, 0.0, 0.28, 0.36], [0.02, 0.07, 0.36]),
        ([0.80, 0.0, 1.0, 0.17], [0.90, 0.66, 0.04]),
        ([0.0, 0.70, 0.28, 1.0], [0.82, 0.80, 0.74]),
        ([0.28, 0.0, 0.80, 0.36], [0.86, 0.84, 0.79]),
    ];
    picture("bars", side, Wrap::Clamp, |at| {
        let bar = |value: f32, line: f32, half: f32| (value - line).abs() < half;
        let vertical = bar(at.x, 0.28, 0.014) || at.y < 0.36 && bar(at.x, 0.80, 0.014);
        let level = bar(at.y, 0.36, 0.014)
            || at.x < 0.28 && bar(at.y, 0.70, 0.02)
            || at.x > 0.80 && bar(at.y, 0.17, 0.02);
        if vertical || level {
            return opaque(Vec3::splat(0.012));
        }
        let inside =
            |&&([l, b, r, t], _): &&([f32; 4], [f32; 3])| at.x > l && at.x < r && at.y > b && at.y < t;
        let field = FIELDS.iter().find(inside).map_or([0.84, 0.82, 0.76], |&(_, color)| color);
        opaque(Vec3::from(field) * (0.94 + 0.06 * fractal(at, 32, 3, 17)))
    })
}

/// A Julia set, coloured by how fast points escape.
pub(super) fn julia(side: u32) -> Texture {
    let c = Vec2::new(-0.743_6, 0.131_8);
    let tone = |t: f32| {
        let wave = |phase: f32| 0.5 - 0.5 * (std::f32::consts::TAU * (0.9 * t + phase)).cos();
        Vec3::new(wave(0.02) * 0.9, wave(0.10) * 0.75, 0.08 + wave(0.22) * 0.8)
    };
    picture("julia", side, Wrap::Clamp, |at| {
        let mut z = (at - 0.5) * Vec2::new(2.1, 2.1);
        for step in 0..220 {
            if z.length_squared() > 64.0 {
                let smooth = step as f32 - z.length().ln().log2() + 1.585;
                return opaque(tone((smooth / 40.0).max(0.0).sqrt()));
            }
            z = Vec2::new(z.x * z.x - z.y * z.y, 2.0 * z.x * z.y) + c;
        }
        opaque(Vec3::new(0.01, 0.01, 0.03))
    })
}

/// Squares of rings in all colours, after Kandinsky.
pub(super) fn rings(side: u32) -> Texture {
    picture("rings", side, Wrap::Clamp, |at| {
        let cell = (at * 4.0).floor();
        let (index, inside) = ((cell.x + 4.0 * cell.y) as u32, at * 4.0 - cell - 0.5);
        let wobble = 0.035 * (noise(at * 40.0, 40, 23) - 0.5);
        let ring = (5.0 * (2.0 * inside.length() + wobble)).min(5.0) as u32;
        let hue = |shift: f32| {
            let h = unit(index * 8 + ring, 31) + shift;
            0.5 + 0.5 * (std::f32::consts::TAU * h).cos()
        };
        let color = Vec3::new(hue(0.0), hue(0.67), hue(0.33)) * between(0.35, 1.0, index * 8 + ring, 37);
        opaque(color * (0.85 + 0.15 * fractal(at, 24, 3, 41)))
    })
}

/// Panes of coloured glass in lead: what it emits.
pub(super) fn panes(side: u32) -> Texture {
    picture("panes", side, Wrap::Clamp, |at| {
        let polar = (at - 0.5) * 2.0;
        let (radius, angle) = (polar.length(), polar.y.atan2(polar.x) / std::f32::consts::TAU + 0.5);
        let ring = (radius * 4.0).floor().min(4.0);
        let count = [1.0, 6.0, 12.0, 18.0, 8.0][ring as usize];
        let (sector, across) = ((angle * count).floor() as u32, (angle * count).fract());
        let along = (radius * 4.0).fract();
        let lead = 0.07;
        let edge = across.min(1.0 - across) * radius * std::f32::consts::TAU / count;
        if along < lead || count > 1.0 && edge < 0.25 * lead {
            return opaque(Vec3::ZERO);
        }
        let kind = ring as u32 * 32 + sector % count as u32;
        let palette: [[f32; 3]; 5] =
            [[0.9, 0.12, 0.05], [0.05, 0.2, 0.85], [0.95, 0.7, 0.1], [0.05, 0.6, 0.25], [0.6, 0.15, 0.7]];
        let color = Vec3::from(palette[(unit(kind, 43) * 5.0) as usize]);
        opaque(color * (0.55 + 0.45 * fractal(at, 16, 3, 47)))
    })
}

/// Eight boards of oak beside each other, along v.
pub(super) fn boards(side: u32) -> Texture {
    picture("boards", side, Wrap::Repeat, |at| {
        let board = (at.x * 8.0).floor();
        // Joints are at another height on each board.
        let shifted = at.y + unit(board as u32, 53);
        let piece = board as u32 * 4 + (shifted * 2.0).floor().rem_euclid(2.0) as u32;
        let joint = (shifted * 2.0).fract().min(1.0 - (shifted * 2.0).fract()) < 0.0025;
        let seam = (at.x * 8.0).fract().min(1.0 - (at.x * 8.0).fract()) < 0.012;
        let grain = fractal(Vec2::new(at.x, at.y) + unit(piece, 59), 8, 3, 61);
        let fibre = noise(Vec2::new(at.x * 256.0, at.y * 8.0), 256, 67);
        let tone = between(0.7, 1.1, piece, 71) * (0.72 + 0.3 * (9.0 * grain).fract() + 0.2 * fibre);
        let wood = Vec3::new(0.27, 0.145, 0.062) * tone;
        opaque(if seam || joint { 0.25 * wood } else { wood })
    })
}

/// Heights of hewn stone.
pub(super) fn hewn(side: u32) -> Texture {
    picture("hewn", side, Wrap::Repeat, |at| {
        let rough = fractal(at, 8, 5, 73);
        let dents = (noise(at * 24.0, 24, 79) - 0.35).max(0.0);
        opaque(Vec3::splat((0.25 + 0.6 * rough - 0.45 * dents).clamp(0.0, 1.0)))
    })
}

/// A leaf with holes: its blade is opaque, the rest of the square is not.
pub(super) fn leaf(side: u32) -> Texture {
    picture("leaf", side, Wrap::Clamp, |at| {
        let (along, across) = (at.y, 2.0 * at.x - 1.0);
        // A heart that narrows to its tip.
        let half = 0.95 * (std::f32::consts::PI * along.powf(0.62)).sin().max(0.0).powf(0.8);
        // Slits between the ribs, as of a Swiss cheese plant.
        let rib = along * 7.0 - 2.4 * across.abs();
        let slit = across.abs() > 0.42 && (rib - rib.floor() - 0.5).abs() < 0.10 && along < 0.86;
        let hole = (Vec2::new(across.abs() - 0.26, (rib - rib.floor() - 0.5) * 0.14)).length() < 0.045;
        let inside = across.abs() < half && !slit && !(hole && along > 0.2 && along < 0.75);
        let vein = across.abs() < 0.02 || (rib - rib.floor()).min(1.0 - rib + rib.floor()) < 0.05;
        let green = Vec3::new(0.055, 0.20, 0.04) * (0.7 + 0.5 * fractal(at, 12, 3, 83));
        let color = if vein { green * 1.7 } else { green };
        color.extend(if inside { 1.0 } else { 0.0 }).to_array()
    })
}

/// The opacity of [`leaf`] in all channels, as maps of opacities have it.
pub(super) fn leaf_opacity(side: u32) -> Texture {
    let leaf = leaf(side);
    picture("leaf opacity", side, Wrap::Clamp, |at| [leaf.sample(at, 0.0)[3]; 4])
}
