//! A small gallery: paintings, glass, a mirror, stone and plants on a polished floor under lamps with an extent. It calls
//! for nearly every effect there is.
//!
//! ```text
//!   z -3.5  +-- panes --- rings --- dusk --- bars --- julia --+
//!           | plant   stone    glass    chrome    vase  plant |
//!           |                                                 | mirror
//!   window  |                 bench                           |
//!           |        camera                                   |
//!   z  3.5  +-------------------------------------------------+
//!          x -4.6                                            4.6
//! ```

mod exhibits;
mod room;

use super::{builder::Builder, paint};
use crate::scene::{
    AmbientOcclusion, AreaLight, Bump, BumpKind, CameraDescription, Environment, Material, RenderSettings,
    Scene, Sky,
};
use glam::{Vec2, Vec3};

/// Half the width and depth of the room, and its height, in metres.
const HALF: Vec2 = Vec2::new(4.6, 3.5);
const HIGH: f32 = 3.4;
/// Where the lamps hang: x of their middles; each is 1.6 by 0.5.
const LAMPS: [f32; 3] = [-2.7, 0.0, 2.7];
const LAMP_HALF: Vec2 = Vec2::new(0.8, 0.25);
const LAMP_Z: f32 = -1.1;

/// Materials by use.
struct Palette {
    floor: u32,
    wall: u32,
    white: u32,
    dark: u32,
    oak: u32,
    glow: u32,
    mirror: u32,
    chrome: u32,
    glass: u32,
    bottle: u32,
    stone: u32,
    pot: u32,
    soil: u32,
    stem: u32,
    leaf: u32,
    panes: u32,
    pictures: [u32; 4],
}

/// Makes the scene.
pub(super) fn gallery(detail: f32) -> Scene {
    let mut b = Builder::new(detail);
    let m = palette(&mut b);
    room::build(&mut b, &m);
    exhibits::build(&mut b, &m);
    let camera = CameraDescription {
        eye: Vec3::new(-1.6, 1.62, 3.2),
        at: Vec3::new(0.35, 1.12, -1.6),
        up: Vec3::Y,
        fov_deg: 52.0,
    };
    let lamps = LAMPS.map(|x| AreaLight::Rectangle {
        corner: Vec3::new(x - LAMP_HALF.x, HIGH - 0.32, LAMP_Z - LAMP_HALF.y),
        edge_u: Vec3::X * 2.0 * LAMP_HALF.x,
        edge_v: Vec3::Z * 2.0 * LAMP_HALF.y,
        radiance: Vec3::new(5.2, 4.9, 4.4),
        two_sided: false,
    });
    Scene {
        size: [1200, 800],
        area_lights: lamps.to_vec(),
        environment: Environment {
            sky: Sky::Gradient {
                zenith: Vec3::new(0.16, 0.33, 0.75),
                horizon: Vec3::new(0.85, 0.92, 1.0),
                ground: Vec3::new(0.25, 0.28, 0.22),
            },
            light: false,
        },
        settings: RenderSettings {
            samples: 9,
            light_samples: 4,
            ambient_occlusion: Some(AmbientOcclusion { radius: 1.5, samples: 4 }),
            smooth_terminator: true,
            ..RenderSettings::default()
        },
        ..b.finish("gallery", Vec::new(), camera, Vec3::splat(0.34), Vec3::ZERO)
    }
}

fn palette(b: &mut Builder) -> Palette {
    let matt =
        |name: &str, kd: [f32; 3]| Material { name: name.into(), kd: kd.into(), ..Material::default() };
    let clear = |name: &str, absorption: Vec3| Material {
        illum: 7,
        ni: 1.5,
        d: 0.0,
        kd: Vec3::ZERO,
        absorption,
        ..matt(name, [0.0; 3])
    };
    let boards = b.texture(paint::boards(512));
    let floor = Material {
        illum: 5,
        ks: Vec3::ONE,
        ns: 400.0,
        ni: 1.5,
        roughness: Some(0.24),
        map_kd: boards,
        ..matt("floor", [1.0; 3])
    };
    let metal =
        |name: &str, ks: [f32; 3]| Material { illum: 3, ks: ks.into(), ns: 2000.0, ..matt(name, [0.02; 3]) };
    let hewn =
        b.texture(paint::hewn(256)).map(|texture| Bump { texture, kind: BumpKind::Height, strength: 0.03 });
    let stone = Material { bump: hewn, ..matt("stone", [0.46, 0.38, 0.30]) };
    let (green, opacity) = (b.texture(paint::leaf(256)), b.texture(paint::leaf_opacity(256)));
    let leaf =
        Material { map_kd: green, map_d: opacity, ks: Vec3::splat(0.12), ns: 30.0, ..matt("leaf", [1.0; 3]) };
    let lit = b.texture(paint::panes(512));
    let panes = Material { map_ke: lit, ke: Vec3::splat(1.6), ..matt("panes", [0.02; 3]) };
    let paintings = [paint::dusk(512), paint::bars(512), paint::julia(512), paint::rings(512)];
    let pictures = paintings.map(|painting| {
        let name = painting.name.clone();
        let map_kd = b.texture(painting);
        b.material(Material { map_kd, ..matt(&name, [1.0; 3]) })
    });
    let glow = Material { ke: Vec3::new(5.2, 4.9, 4.4), ..matt("lamp", [0.8; 3]) };
    let dark = Material { ks: Vec3::splat(0.2), ns: 60.0, ..matt("black lacquer", [0.025; 3]) };
    Palette {
        floor: b.material(floor),
        wall: b.material(matt("plaster", [0.74, 0.72, 0.68])),
        white: b.material(matt("white paint", [0.83; 3])),
        dark: b.material(dark),
        oak: b.material(matt("oak", [0.30, 0.17, 0.08])),
        glow: b.material(glow),
        mirror: b.material(metal("mirror", [0.93; 3])),
        chrome: b.material(metal("chrome", [0.80, 0.82, 0.84])),
        glass: b.material(clear("glass", Vec3::ZERO)),
        bottle: b.material(clear("bottle glass", Vec3::new(9.0, 1.6, 5.0))),
        stone: b.material(stone),
        pot: b.material(matt("pot", [0.47, 0.2, 0.11])),
        soil: b.material(matt("soil", [0.07, 0.045, 0.03])),
        stem: b.material(matt("stem", [0.07, 0.17, 0.04])),
        leaf: b.material(leaf),
        panes: b.material(panes),
        pictures,
    }
}
