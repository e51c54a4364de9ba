//! Which effects a scene calls for, and why.

use super::{floor, matt, scene};
use glam::{Vec2, Vec3};
use irt::{
    effects::{Effect, EffectChoice, EffectSet, Reason, Reasons},
    scene::{AmbientOcclusion, AreaLight, Falloff, Light, Material, Scene, Texture, Wrap, procedural},
};

fn reason(scene: &Scene, effect: Effect) -> Reason {
    Reasons::new(scene)
        .iter()
        .find(|reason| reason.effect == effect)
        .expect("a reason for each effect")
        .clone()
}

#[track_caller]
fn says(scene: &Scene, effect: Effect, called: bool, why: &str) {
    let reason = reason(scene, effect);
    assert_eq!((reason.called, &*reason.why), (called, why), "{effect}");
    assert_eq!(Reasons::new(scene).set().has(effect), called);
}

#[test]
fn a_material_calls_for_something_only_where_a_triangle_has_it() {
    let mut scene = scene(&floor(), matt(0.5));
    assert_eq!(Reasons::new(&scene).set(), EffectSet::EMPTY);
    scene.materials.push(Material { name: "glass".into(), d: 0.1, ni: 1.5, illum: 7, ..Material::default() });
    says(
        &scene,
        Effect::Refraction,
        false,
        "material `glass` has Tr 0.9 and illum 7, but no triangle uses it",
    );
    says(&scene, Effect::Mirror, false, "material `glass` has illum 7 and Ni 1.5, but no triangle uses it");
    scene.mesh.materials[1] = 1;
    says(&scene, Effect::Refraction, true, "material `glass` has Tr 0.9 and illum 7, 1 triangle");
    says(&scene, Effect::Mirror, true, "material `glass` has illum 7 and Ni 1.5, 1 triangle");
    scene.materials[1].illum = 2;
    says(
        &scene,
        Effect::Refraction,
        false,
        "material `glass` has Tr 0.9, but illum 2 lets no light through; illum 4, 6, 7 and 9 do",
    );
    scene.materials[1] =
        Material { ks: Vec3::splat(0.3), illum: 3, roughness: Some(0.2), ..Material::default() };
    says(&scene, Effect::Glossy, true, "material `default` has illum 3 and roughness 0.2, 1 triangle");
    says(&scene, Effect::Mirror, false, "no material calls for mirror");
}

#[test]
fn light_calls_for_shadows_by_its_kind() {
    let mut scene = scene(&floor(), Material { ks: Vec3::ONE, ..matt(0.5) });
    says(&scene, Effect::HardShadows, false, "no point, directional or spot light");
    says(&scene, Effect::Highlights, false, "no light to be reflected");
    says(&scene, Effect::Highlights, false, "no light to be reflected");
    let light = Light::Point { position: Vec3::Y, intensity: Vec3::ONE, falloff: Falloff::None };
    scene.lights.push(light);
    says(&scene, Effect::HardShadows, true, "1 light without extent");
    says(&scene, Effect::Highlights, true, "material `default` has Ks 1, 2 triangles");
    says(&scene, Effect::SoftShadows, false, "no light with an extent");
    scene.area_lights.push(AreaLight::Sphere { center: Vec3::Y, radius: 0.1, radiance: Vec3::ONE });
    says(&scene, Effect::SoftShadows, true, "1 light with an extent");
    scene.area_lights.clear();
    scene.materials[0].ke = Vec3::X;
    says(
        &scene,
        Effect::SoftShadows,
        false,
        "material `default` has Ke (1 0 0), 2 triangles, which only glows: emitters are not switched on as lights",
    );
    scene.settings.emitters = true;
    says(&scene, Effect::SoftShadows, true, "material `default` has Ke (1 0 0), 2 triangles");
    scene.settings.without = EffectSet::of(&[Effect::SoftShadows]);
    says(&scene, Effect::SoftShadows, false, "left out by the scene's settings");
}

#[test]
fn what_is_not_switched_on_says_so() {
    let scene = scene(&floor(), matt(0.5));
    says(&scene, Effect::IndirectLight, false, "not switched on");
    says(&scene, Effect::AmbientOcclusion, false, "not switched on");
    says(&scene, Effect::DepthOfField, false, "the camera is a pinhole");
    says(&scene, Effect::Antialiasing, false, "one sample per pixel");
    says(&scene, Effect::Sky, false, "the background has one colour");
    says(&scene, Effect::DiffuseTexture, false, "no material calls for diffuse-texture");
    let reasons: Vec<Effect> = Reasons::new(&scene).iter().map(|reason| reason.effect).collect();
    assert_eq!(reasons, Effect::ALL);
}

#[test]
fn what_could_not_show_is_not_called_for() {
    let mut scene = scene(&floor(), Material { map_kd: Some(0), ..matt(0.5) });
    scene.settings.ambient_occlusion = Some(AmbientOcclusion { radius: 2.0, samples: 4 });
    says(&scene, Effect::AmbientOcclusion, false, "no ambient light to be occluded");
    scene.ambient = Vec3::X;
    says(&scene, Effect::AmbientOcclusion, true, "switched on, within 2 units");
    scene.textures.push(Texture::new("wood", [1, 1], vec![[1.0; 4]], Wrap::Repeat));
    let wood = "material `default` has map_Kd `wood`, 2 triangles";
    let missing = format!("{wood}, but the meshes have no texture coordinates");
    says(&scene, Effect::DiffuseTexture, false, &missing);
    scene.mesh.uvs = vec![Vec2::ZERO; scene.mesh.positions.len()];
    says(&scene, Effect::DiffuseTexture, true, wood);
    says(&scene, Effect::SmoothNormals, false, "no vertex has a normal of its own");
    scene.mesh.normals = vec![Vec3::ZERO; scene.mesh.positions.len()];
    says(&scene, Effect::SmoothNormals, false, "no triangle has a vertex with a normal of its own");
    scene.mesh.normals[3] = Vec3::Y;
    says(&scene, Effect::SmoothNormals, true, "1 triangle with normals of their vertices");
}

#[test]
fn the_material_of_most_triangles_is_named_and_the_others_are_counted() {
    let named = |name: &str| Material { name: name.into(), ks: Vec3::ONE, illum: 3, ..matt(0.5) };
    let mut scene = scene(&[floor(), floor(), floor()].concat(), named("a"));
    scene.materials.extend([named("b"), named("c"), named("unused")]);
    scene.mesh.materials = vec![0, 1, 1, 1, 2, 2];
    let why = "material `b` has illum 3 and Ks 1, 3 triangles; and 2 other materials";
    says(&scene, Effect::Mirror, true, why);
    scene.mesh.materials = vec![0, 0, 0, 2, 2, 2];
    let why = "material `a` has illum 3 and Ks 1, 3 triangles; and 1 other material";
    says(&scene, Effect::Mirror, true, why);
}

#[test]
fn a_choice_takes_away_from_what_is_called_for_and_adds_nothing() {
    let mut scene = scene(&floor(), Material { ks: Vec3::ONE, illum: 3, ..matt(0.5) });
    scene.settings.samples = 4;
    let reasons = Reasons::new(&scene);
    let set = |choice: &str| choice.parse::<EffectChoice>().expect("a choice").set(&reasons).to_string();
    assert_eq!([set("auto"), set("all")], ["mirror,antialiasing"; 2]);
    assert_eq!([set("mirror,sky"), set("without=antialiasing,sky")], ["mirror"; 2]);
    assert_eq!([set("none"), set("sky"), set("without=mirror,antialiasing")], ["none"; 3]);
}

#[test]
fn the_first_built_in_scene_calls_for_what_it_has() {
    let set = Reasons::new(&procedural::build("atrium", 0.3).expect("built in")).set();
    assert!(set.has(Effect::HardShadows) && !set.has(Effect::Refraction), "{set}");
}
