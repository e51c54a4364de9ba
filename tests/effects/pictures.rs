//! Textures, holes, bent normals, the lens, and several samples per pixel.

use super::{close, floor, matt, radiance, rectangle, scene};
use crate::support::RENDER;
use glam::{Vec2, Vec3};
use irt::{
    render::{RenderOptions, render},
    scene::{
        AreaLight, Bump, BumpKind, CameraDescription, DepthOfField, Falloff, Light, Material, Scene, Texture,
        Wrap,
    },
    schedule::Control,
};

/// Red to the left of u = 1/2, green to the right; opacity 0 and 1.
fn halves() -> Texture {
    Texture::new("halves", [2, 1], vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]], Wrap::Clamp)
}

/// A square of side 2 about the origin in z = 0 with u along x and v along y, seen from +z.
fn square(material: Material) -> Scene {
    let mut scene = scene(&rectangle(Vec3::new(-1.0, -1.0, 0.0), 2.0 * Vec3::X, 2.0 * Vec3::Y), material);
    scene.mesh.uvs =
        scene.mesh.positions.iter().map(|p| Vec2::new(0.5 * p.x + 0.5, 0.5 * p.y + 0.5)).collect();
    scene.textures.push(halves());
    scene
}

const EYE: Vec3 = Vec3::new(0.0, 0.0, 3.0);

#[test]
fn images_colour_reflection_ambient_light_and_emission() {
    let mut scene = square(Material { map_kd: Some(0), ..matt(0.5) });
    scene.ambient = Vec3::splat(0.4);
    assert_eq!(radiance(&scene, EYE, Vec3::new(-0.7, 0.1, 0.0)), Vec3::new(0.2, 0.0, 0.0));
    assert_eq!(radiance(&scene, EYE, Vec3::new(0.7, 0.1, 0.0)), Vec3::new(0.0, 0.2, 0.0));
    // Of other light, each pixel of the image takes its share.
    let grey = Texture::new("grey", [1, 1], vec![[0.5, 0.25, 0.75, 1.0]], Wrap::Repeat);
    let mut lit = Scene { textures: vec![grey], ambient: Vec3::ZERO, ..scene.clone() };
    lit.lights.push(Light::Directional { direction: -Vec3::Z, intensity: Vec3::ONE });
    assert_eq!(radiance(&lit, EYE, Vec3::new(-0.7, 0.1, 0.0)), Vec3::new(0.25, 0.125, 0.375));
    // Ambient reflectance of its own has its own colour.
    scene.materials[0].ka = Vec3::splat(0.75);
    assert_eq!(radiance(&scene, EYE, Vec3::new(-0.7, 0.1, 0.0)), Vec3::splat(0.4 * 0.75));
    let mut glowing = square(Material { map_ke: Some(0), ke: Vec3::splat(3.0), ..matt(0.5) });
    assert_eq!(radiance(&glowing, EYE, Vec3::new(0.7, 0.1, 0.0)), Vec3::new(0.0, 3.0, 0.0));
    // The image of a lamp also colours its light.
    glowing.settings.emitters = true;
    glowing.settings.light_samples = 256;
    for triangle in &rectangle(Vec3::new(-9.0, -2.0, -1.0), 20.0 * Vec3::X, 4.0 * Vec3::Z) {
        let at = glowing.mesh.positions.len() as u32;
        glowing.mesh.positions.extend(triangle);
        glowing.mesh.uvs.extend([Vec2::ZERO; 3]);
        glowing.mesh.triangles.push([at, at + 1, at + 2]);
        glowing.mesh.materials.push(1);
    }
    glowing.mesh.parts[0].count = 4;
    glowing.materials.push(matt(1.0));
    let lit = |x: f32| radiance(&glowing, Vec3::new(x, 0.0, 2.5), Vec3::new(x, -2.0, 0.5));
    let (left, right) = (lit(-3.0), lit(3.0));
    assert!(left.x > 1.2 * left.y && right.y > 1.2 * right.x, "{left} {right}");
}

#[test]
fn holes_show_what_is_behind_and_let_light_through() {
    let mut scene = square(Material { map_d: Some(0), ..matt(0.0) });
    scene.background = Vec3::ONE;
    // Channel 0 is 1 to the left: there the square is.
    assert_eq!(radiance(&scene, EYE, Vec3::new(-0.7, 0.1, 0.0)), Vec3::ZERO);
    assert_eq!(radiance(&scene, EYE, Vec3::new(0.7, 0.1, 0.0)), Vec3::ONE);
    close(radiance(&scene, EYE, Vec3::new(0.0, 0.1, 0.0)).x, 0.5, 1.0e-3, "half a hole");
    // A wall behind it, lit from the front: in the shadow of the left half only.
    for triangle in &rectangle(Vec3::new(-9.0, -9.0, -1.0), 18.0 * Vec3::X, 18.0 * Vec3::Y) {
        let at = scene.mesh.positions.len() as u32;
        scene.mesh.positions.extend(triangle);
        scene.mesh.uvs.extend([Vec2::ZERO; 3]);
        scene.mesh.triangles.push([at, at + 1, at + 2]);
        scene.mesh.materials.push(1);
    }
    scene.mesh.parts[0].count = 4;
    scene.materials.push(matt(0.8));
    let (position, intensity) = (Vec3::new(0.0, 0.0, 100.0), Vec3::ONE);
    scene.lights.push(Light::Point { position, intensity, falloff: Falloff::None });
    scene.lights.push(Light::Directional { direction: -Vec3::Z, intensity });
    let area = AreaLight::Sphere { center: position, radius: 1.0, radiance: Vec3::splat(10_000.0) };
    scene.area_lights.push(area);
    let behind = |x: f32| radiance(&scene, Vec3::new(x, 4.0, 0.0), Vec3::new(x, 0.1, -1.0)).x;
    assert_eq!(behind(-0.7), 0.0);
    close(behind(0.7), 0.8 * 3.0, 0.03, "through the hole");
    close(behind(3.0), 0.8 * 3.0, 0.03, "beside it");
}

#[test]
fn normals_from_images_bend_the_light() {
    // A normal that leans towards +x or +y by 45 degrees, and heights that fall in that direction with the same slope: u and
    // v go from 0 to 1 over 2 units, so that a height of 2 is a slope of 1.
    let lean = 0.5 + 0.5 * 0.5f32.sqrt();
    let normals = |r: f32, g: f32| Texture::new("normals", [1, 1], vec![[r, g, lean, 1.0]], Wrap::Repeat);
    let ramp = |size: [u32; 2], height: fn(u32) -> f32| {
        let pixels = (0..64).map(|i| [height(i) / 64.0; 4]).collect();
        Texture::new("heights", size, pixels, Wrap::Clamp)
    };
    for (axis, kind, texture, strength) in [
        (Vec3::X, BumpKind::Normal, normals(lean, 0.5), 1.0),
        (Vec3::Y, BumpKind::Normal, normals(0.5, lean), 1.0),
        (Vec3::X, BumpKind::Height, ramp([64, 1], |column| column as f32), -2.0),
        // Rows run down.
        (Vec3::Y, BumpKind::Height, ramp([1, 64], |row| 63.0 - row as f32), -2.0),
    ] {
        let mut scene = square(Material { bump: Some(Bump { texture: 1, kind, strength }), ..matt(0.5) });
        scene.textures.push(texture);
        for (toward, cosine) in [(1.0f32, 1.0f64), (-1.0, 0.0)] {
            let direction = -(toward * axis + Vec3::Z).normalize();
            scene.lights = vec![Light::Directional { direction, intensity: Vec3::ONE }];
            let got = radiance(&scene, EYE, Vec3::new(0.1, 0.2, 0.0)).x;
            assert!((f64::from(got) - 0.5 * cosine).abs() < 2.0e-3, "{kind:?} along {axis}, {toward}: {got}");
        }
    }
}

#[test]
fn normals_from_images_are_as_strong_as_told_and_the_same_from_behind() {
    let lean = 0.5 + 0.5 * 0.5f32.sqrt();
    for (strength, degrees) in [(1.0, 45.0f32), (0.5, 0.5f32.atan().to_degrees()), (-1.0, -45.0)] {
        let bump = Some(Bump { texture: 1, kind: BumpKind::Normal, strength });
        let mut scene = square(Material { bump, ..matt(0.5) });
        scene.textures.push(Texture::new("normals", [1, 1], vec![[lean, 0.5, lean, 1.0]], Wrap::Repeat));
        let (sin, cos) = degrees.to_radians().sin_cos();
        let normal = Vec3::new(sin, 0.0, cos);
        for side in [1.0, -1.0] {
            let direction = -side * normal;
            scene.lights = vec![Light::Directional { direction, intensity: Vec3::ONE }];
            let got = radiance(&scene, side * EYE, Vec3::ZERO).x;
            close(got, 0.5, 1.0e-3, &format!("strength {strength}, side {side}"));
        }
    }
}

#[test]
fn normals_from_images_do_not_bend_away_from_the_viewer() {
    let lean = 0.5 + 0.5 * 0.5f32.sqrt();
    let bump = Some(Bump { texture: 1, kind: BumpKind::Normal, strength: 1.0 });
    let mut scene = square(Material { bump, ..matt(0.5) });
    scene.textures.push(Texture::new("normals", [1, 1], vec![[lean, 0.5, lean, 1.0]], Wrap::Repeat));
    let direction = -Vec3::new(1.0, 0.0, 1.0).normalize();
    scene.lights.push(Light::Directional { direction, intensity: Vec3::ONE });
    for (x, cosine) in [(1.0, 1.0), (-0.9, 1.0), (-1.1, 0.5f64.sqrt()), (-3.0, 0.5f64.sqrt())] {
        close(
            radiance(&scene, Vec3::new(x, 0.0, 1.0), Vec3::ZERO).x,
            0.5 * cosine,
            1.0e-3,
            &format!("from {x}"),
        );
    }
}

#[test]
fn through_many_holes_one_sees_what_is_behind() {
    // Five panes before a mirror.
    let panes: Vec<_> = (0..6)
        .flat_map(|i| rectangle(Vec3::new(-9.0, -9.0, -(i as f32)), 18.0 * Vec3::X, 18.0 * Vec3::Y))
        .collect();
    let mut scene = scene(&panes, Material { map_d: Some(0), ke: Vec3::ONE, ..matt(0.0) });
    scene.mesh.uvs = vec![Vec2::ZERO; scene.mesh.positions.len()];
    scene.textures.push(Texture::new("half", [1, 1], vec![[0.5; 4]], Wrap::Repeat));
    scene.background = Vec3::splat(9.0);
    scene.materials.push(Material { ks: Vec3::ONE, illum: 3, ..matt(0.0) });
    scene.mesh.materials = vec![0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1];
    // Holes are no reflections: no depth limits them.
    scene.settings.max_depth = 1;
    // Half of each pane shines, and of what is behind all, 1 in 32 is left: the panes again, and the sky.
    let want = |behind: f64| (31.0 + behind) / 32.0;
    close(radiance(&scene, EYE, Vec3::ZERO).x, want(want(9.0)), 1.0e-5, "five panes");
}

fn column(scene: &Scene, size: [u32; 2]) -> Vec<f32> {
    let options = RenderOptions { size, ..RENDER };
    let rendered = render(scene, &options, &Control::unattended()).expect("renders");
    rendered.film.row(size[1] / 2).map(|pixel| pixel[0]).collect()
}

#[test]
fn a_lens_blurs_what_is_out_of_focus_by_the_width_of_its_cone() {
    // The edge of a black half-plane before white, at distance 4.
    let mut scene =
        scene(&rectangle(Vec3::new(-500.0, -500.0, 0.0), 500.0 * Vec3::X, 1000.0 * Vec3::Y), matt(0.0));
    scene.background = Vec3::ONE;
    scene.camera = CameraDescription { eye: 4.0 * Vec3::Z, at: Vec3::ZERO, up: Vec3::Y, fov_deg: 30.0 };
    scene.settings.samples = 256;
    let blurred =
        |scene: &Scene| column(scene, [201, 3]).iter().filter(|x| **x > 0.002 && **x < 0.998).count();
    let pixel = 2.0 * 15f32.to_radians().tan() / 3.0 * 4.0;
    // One pixel is 3 rows high: 4 * 2 tan 15 / 3 units; make the lens many times as wide.
    assert!(blurred(&scene) <= 2, "a pinhole is sharp");
    let aperture = 10.0 * pixel;
    scene.settings.depth_of_field = Some(DepthOfField { aperture, focus: 4.0 });
    assert!(blurred(&scene) <= 2, "what is in focus is sharp");
    // In focus at 8: at distance 4 the cone is as wide as half the lens, as seen from the plane: 20 / 2 pixels.
    scene.settings.depth_of_field = Some(DepthOfField { aperture, focus: 8.0 });
    let width = blurred(&scene) as f32;
    assert!((width - 10.0).abs() <= 2.0, "{width} pixels");
    // The share of a disc of radius 5 pixels on one side of the edge, over the width of a pixel.
    let share = |x: f64| {
        let t = (x / 5.0).clamp(-1.0, 1.0);
        0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / std::f64::consts::PI
    };
    for (at, got) in column(&scene, [201, 3]).into_iter().enumerate() {
        let x = at as f64 - 100.0;
        let want = (0..10).map(|i| share(x + (f64::from(i) - 4.5) / 10.0) / 10.0).sum::<f64>();
        assert!((f64::from(got) - want).abs() < 0.02, "{x}: {got}, not {want}");
    }
}

#[test]
fn samples_of_a_pixel_show_how_much_of_it_is_covered() {
    // An edge through the middle column at a third of its width.
    let mut scene = scene(&floor(), matt(0.0));
    scene.background = Vec3::ONE;
    let edge = 1.0 / 6.0;
    scene.mesh = crate::support::mesh_of(&rectangle(
        Vec3::new(-50.0, -50.0, 0.0),
        (50.0 + edge) * Vec3::X,
        100.0 * Vec3::Y,
    ));
    let half = 1.5f32;
    let fov_deg = 2.0 * (half / 4.0).atan().to_degrees();
    scene.camera = CameraDescription { eye: 4.0 * Vec3::Z, at: Vec3::ZERO, up: Vec3::Y, fov_deg };
    scene.settings.samples = 256;
    let row = column(&scene, [3, 3]);
    assert_eq!([row[0], row[2]], [0.0, 1.0]);
    close(row[1], 1.0 / 3.0, 0.02, "a third is left free");
}
