//! The kernel for just the effects of a scene gives the image of the kernel for all of them, on every instruction set; and so
//! does every other way to compute it.

use crate::support::{RENDER, mesh_of, sphere};
use glam::{Vec2, Vec3};
use irt::{
    effects::{Effect, EffectChoice, EffectSet, Reasons},
    kernels::Isa,
    render::{RenderOptions, render},
    scene::{
        AmbientOcclusion, AreaLight, Bump, BumpKind, CameraDescription, DepthOfField, Environment, Falloff,
        Light, Material, Scene, Sky, Texture, TriangleMesh, Wrap, load, procedural,
    },
    schedule::{Control, Schedule},
    tile::Order,
    trace::KernelChoice,
};

const SMALL: RenderOptions = RenderOptions { size: [45, 37], tile: 32, ..RENDER };

fn hash(scene: &Scene, options: &RenderOptions) -> String {
    let rendered = render(scene, options, &Control::unattended()).expect("renders");
    assert_eq!(rendered.nan, None, "{}", scene.name);
    rendered.frames[0].image_sha256.clone()
}

/// Auto and all, on every instruction set.
fn check(scene: &Scene) {
    let want = hash(scene, &RenderOptions { effects: EffectChoice::All, ..SMALL });
    for isa in Isa::available() {
        for effects in [EffectChoice::Auto, EffectChoice::All] {
            let options = RenderOptions { isa: Some(isa), effects, ..SMALL };
            assert_eq!(hash(scene, &options), want, "{}, {isa}, {effects}", scene.name);
        }
    }
}

fn add(mesh: &mut TriangleMesh, more: &TriangleMesh, material: u32, uv: impl Fn(Vec3) -> Vec2) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(&more.positions);
    mesh.uvs.extend(more.positions.iter().map(|&p| uv(p)));
    let normals =
        if more.normals.is_empty() { vec![Vec3::ZERO; more.positions.len()] } else { more.normals.clone() };
    mesh.normals.extend(normals);
    mesh.triangles.extend(more.triangles.iter().map(|t| t.map(|v| first + v)));
    mesh.materials.extend(vec![material; more.len()]);
    mesh.parts.push(irt::scene::Part {
        name: format!("part {material}"),
        first: (mesh.triangles.len() - more.len()) as u32,
        count: more.len() as u32,
    });
}

/// A scene that calls for every effect there is.
pub(super) fn everything() -> Scene {
    let mut mesh = TriangleMesh::default();
    let flat = |p: Vec3| Vec2::new(0.3 * p.x, 0.3 * p.z);
    add(&mut mesh, &mesh_of(&super::floor()), 0, flat);
    let ball = |x: f32, z: f32| {
        let center = Vec3::new(x, 0.8, z);
        let mut ball = sphere(center, 0.7, 8);
        ball.normals = ball.positions.iter().map(|&p| (p - center).normalize()).collect();
        ball
    };
    for (material, x, z) in [(1, -1.6, 0.0), (2, 0.0, 0.3), (3, 1.6, 0.0), (4, 0.8, 1.6)] {
        add(&mut mesh, &ball(x, z), material, flat);
    }
    let screen = super::rectangle(Vec3::new(-2.0, 0.0, 1.2), 1.2 * Vec3::X, 1.5 * Vec3::Y);
    add(&mut mesh, &mesh_of(&screen), 5, |p| Vec2::new(p.x, p.y));
    let lamp = super::rectangle(Vec3::new(-0.5, 3.0, -0.5), Vec3::X, Vec3::Z);
    add(&mut mesh, &mesh_of(&lamp), 6, flat);
    let checks = [[0.9, 0.4, 0.2, 1.0], [0.1, 0.6, 0.5, 1.0], [0.2, 0.2, 0.9, 1.0], [1.0; 4]];
    let texture = Texture::new("checks", [2, 2], checks.to_vec(), Wrap::Repeat);
    let materials = vec![
        Material {
            map_kd: Some(0),
            bump: Some(Bump { texture: 0, kind: BumpKind::Height, strength: 0.2 }),
            ..super::matt(0.7)
        },
        Material { ks: Vec3::splat(0.8), illum: 3, ns: 80.0, ..super::matt(0.1) },
        Material { ni: 1.5, d: 0.1, illum: 7, absorption: Vec3::new(0.2, 0.5, 0.1), ..super::matt(0.3) },
        Material { ks: Vec3::splat(0.7), illum: 3, roughness: Some(0.4), ..super::matt(0.2) },
        Material { ks: Vec3::splat(0.5), ns: 20.0, ..super::matt(0.5) },
        Material { map_d: Some(0), ..super::matt(0.6) },
        Material { ke: Vec3::splat(4.0), map_ke: Some(0), ..super::matt(0.0) },
    ];
    let mut scene = super::scene_of(mesh, materials);
    scene.name = "everything".into();
    scene.textures.push(texture);
    scene.camera = CameraDescription {
        eye: Vec3::new(0.5, 2.5, 6.0),
        at: Vec3::new(0.0, 0.6, 0.0),
        up: Vec3::Y,
        fov_deg: 40.0,
    };
    let intensity = Vec3::splat(0.4);
    scene.lights = vec![
        Light::Point { position: Vec3::new(3.0, 4.0, 2.0), intensity, falloff: Falloff::None },
        Light::Directional { direction: Vec3::new(0.3, -0.9, -0.2).normalize(), intensity },
    ];
    scene.area_lights = vec![
        AreaLight::Sphere { center: Vec3::new(-3.0, 3.0, 2.0), radius: 0.5, radiance: Vec3::splat(3.0) },
        AreaLight::Rectangle {
            corner: Vec3::new(2.0, 3.0, -1.0),
            edge_u: Vec3::X,
            edge_v: Vec3::Z,
            radiance: Vec3::splat(2.0),
            two_sided: true,
        },
    ];
    scene.environment = Environment {
        sky: Sky::Gradient { zenith: Vec3::splat(0.3), horizon: Vec3::splat(0.6), ground: Vec3::splat(0.1) },
        light: true,
    };
    scene.ambient = Vec3::splat(0.2);
    let settings = &mut scene.settings;
    (settings.samples, settings.light_samples, settings.bounces, settings.max_depth) = (3, 2, 1, 4);
    settings.cutoff = 1.0 / 512.0;
    settings.emitters = true;
    settings.smooth_terminator = true;
    settings.ambient_occlusion = Some(AmbientOcclusion { radius: 2.0, samples: 2 });
    settings.depth_of_field = Some(DepthOfField { aperture: 0.05, focus: 6.0 });
    scene
}

#[test]
fn built_in_scenes_have_the_same_image_with_the_kernel_for_all_effects() {
    for name in procedural::NAMES {
        let mut scene = procedural::build(name, 0.3).expect("a built-in scene");
        scene.settings.samples = scene.settings.samples.min(2);
        scene.settings.light_samples = scene.settings.light_samples.min(2);
        check(&scene);
    }
}

#[test]
fn thesis_scenes_have_the_same_image_with_the_kernel_for_all_effects() {
    if std::env::var_os("IRT_SCENES").is_none() {
        return;
    }
    for name in ["bunny", "office", "sibenik", "sponza", "conference"] {
        check(&load(&format!("thesis/{name}")).expect("a scene of the thesis"));
    }
}

#[test]
fn each_effect_alone_and_all_but_each_have_the_same_image() {
    let full = everything();
    assert_eq!(Reasons::new(&full).set(), EffectSet::ALL);
    check(&full);
    for effect in Effect::ALL {
        for without in [EffectSet::of(&[effect]), EffectSet::ALL.without(EffectSet::of(&[effect]))] {
            let mut scene = full.clone();
            scene.settings.without = without;
            let auto = hash(&scene, &SMALL);
            assert_eq!(
                auto,
                hash(&scene, &RenderOptions { effects: EffectChoice::All, ..SMALL }),
                "{without}"
            );
            // Leaving it out by the command line is the same thing.
            let only = EffectChoice::Only(EffectSet::ALL.without(without));
            assert_eq!(auto, hash(&full, &RenderOptions { effects: only, ..SMALL }), "{without}");
        }
        let without = EffectSet::of(&[effect]);
        let mut scene = full.clone();
        scene.settings.without = without;
        assert_ne!(hash(&scene, &SMALL), hash(&full, &SMALL), "{effect} shows in the image");
    }
}

#[test]
fn nothing_but_scene_and_seed_changes_an_image_with_every_effect() {
    let scene = everything();
    let want = hash(&scene, &SMALL);
    for tile in [1, 7, 16, 33, 64] {
        for order in [Order::Hilbert, Order::Scanline] {
            let options = RenderOptions { tile, order, threads: Some(2), ..SMALL };
            assert_eq!(hash(&scene, &options), want, "tiles of {tile}, {order}");
        }
    }
    for schedule in Schedule::all().take(6) {
        let options = RenderOptions { schedule, threads: Some(3), tile: 16, ..SMALL };
        assert_eq!(hash(&scene, &options), want, "{schedule:?}");
    }
    for kernel in KernelChoice::ALL {
        assert_eq!(hash(&scene, &RenderOptions { kernel, ..SMALL }), want, "{kernel}");
    }
    assert_ne!(hash(&scene, &RenderOptions { seed: 1, ..SMALL }), want);
}
