//! The edge of light on coarse meshes that stand for smooth surfaces.

use super::{matt, radiance, scene_of};
use crate::support::{RENDER, brute_force, mesh_of};
use glam::{DVec3, Vec3};
use irt::{
    camera::Camera,
    effects::EffectChoice,
    kernels::{MISS, Ray},
    render::{RenderOptions, render},
    scene::{
        AmbientOcclusion, AreaLight, CameraDescription, DepthOfField, Environment, Falloff, Light, Material,
        Scene, TriangleMesh,
    },
    schedule::Control,
};

const SIZE: [u32; 2] = [121, 121];
/// The ball is seen from the side, so that the edge of light runs through the middle of its image.
const EYE: Vec3 = Vec3::new(0.0, 0.0, 30.0);
const LAMP: Vec3 = Vec3::new(5.0, 1.0, 0.0);
/// Lights with an extent are this many times as far away.
const FAR: f32 = 100.0;

/// An icosahedron whose triangles were quartered `times` times, with corners on the unit sphere and its normals; shaken, so
/// that no symmetry hides anything.
fn ball(times: u32) -> TriangleMesh {
    let g = f32::midpoint(1.0, 5.0f32.sqrt());
    let corner = |i: usize| {
        let (a, b) = ([1.0, -1.0][i % 2], [g, -g][i / 2 % 2]);
        let corner = [Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a), Vec3::new(a, b, 0.0)][i / 4];
        (glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.9) * corner).normalize()
    };
    let near = |i: usize, j: usize| i != j && corner(i).distance(corner(j)) < 1.1;
    let all = (0..12).flat_map(|i| (i + 1..12).flat_map(move |j| (j + 1..12).map(move |k| [i, j, k])));
    let faces = all.filter(|&[i, j, k]| near(i, j) && near(j, k) && near(k, i));
    let mut triangles: Vec<[Vec3; 3]> = faces.map(|face| face.map(corner)).collect();
    assert_eq!(triangles.len(), 20);
    for _ in 0..times {
        let quarter = |[a, b, c]: [Vec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(quarter).collect();
    }
    for [a, b, c] in &mut triangles {
        if (*b - *a).cross(*c - *a).dot(*a) < 0.0 {
            std::mem::swap(b, c);
        }
    }
    let mut mesh = mesh_of(&triangles);
    mesh.normals = mesh.positions.clone();
    mesh
}

fn lit_by(light: Light) -> Scene {
    let mut scene = scene_of(ball(1), vec![matt(1.0)]);
    scene.lights.push(light);
    scene.settings.smooth_terminator = true;
    scene.camera = CameraDescription { eye: EYE, at: Vec3::ZERO, up: Vec3::Y, fov_deg: 4.2 };
    scene
}

fn point() -> Light {
    Light::Point { position: LAMP, intensity: Vec3::ONE, falloff: Falloff::None }
}

/// What the pixels show, with the kernel for just these effects and with that for all.
fn image(scene: &Scene) -> Vec<f32> {
    let one = |effects| {
        let options = RenderOptions { size: SIZE, effects, ..RENDER };
        let rendered = render(scene, &options, &Control::unattended()).expect("renders");
        assert_eq!(rendered.nan, None);
        rendered.film.pixels().map(|pixel| pixel[0]).collect::<Vec<f32>>()
    };
    let auto = one(EffectChoice::Auto);
    assert!(auto == one(EffectChoice::All), "one image");
    auto
}

/// The point of the triangles that each pixel shows.
fn points(scene: &Scene) -> Vec<Option<DVec3>> {
    let camera = Camera::new(&scene.camera, SIZE[0], SIZE[1]);
    let eye = scene.camera.eye;
    let see = |i: u32| {
        let dir = camera.direction(i % SIZE[0], i / SIZE[0]);
        let ray =
            Ray { org: eye.to_array(), dir: dir.to_array(), tnear: 0.0, tfar: f32::INFINITY, skip: MISS };
        let hit = brute_force(&scene.mesh, &ray);
        (hit.prim != MISS).then(|| eye.as_dvec3() + f64::from(hit.t) * dir.as_dvec3())
    };
    (0..SIZE[0] * SIZE[1]).map(see).collect()
}

/// A directional light, a point, a spot, and far lights with an extent, that all come from where [`LAMP`] is, with strength 1
/// at the ball; and how well a formula for a point in that direction describes them.
fn lamps() -> [(&'static str, Scene, f64); 5] {
    let direction = -LAMP.normalize();
    let (intensity, falloff) = (Vec3::ONE, Falloff::None);
    let spot = Light::Spot { position: LAMP, direction, intensity, falloff, inner: 0.5, outer: 0.6 };
    let far = |light| {
        let mut scene = lit_by(point());
        (scene.lights, scene.area_lights) = (vec![], vec![light]);
        scene
    };
    let (center, distance) = (FAR * LAMP, FAR * LAMP.length());
    let sphere = AreaLight::Sphere { center, radius: 1.0, radiance: Vec3::splat(distance * distance) };
    let edge_u = LAMP.cross(Vec3::Z).normalize();
    let edge_v = edge_u.cross(direction);
    let corner = center - 0.5 * (edge_u + edge_v);
    let radiance = Vec3::splat(distance * distance * std::f32::consts::PI);
    let rectangle = AreaLight::Rectangle { corner, edge_u, edge_v, radiance, two_sided: true };
    [
        ("point", lit_by(point()), 1.0e-4),
        ("directional", lit_by(Light::Directional { direction, intensity }), 1.0e-4),
        ("spot", lit_by(spot), 1.0e-4),
        // The ball is 1 in `distance` nearer in the middle than its centre, and light comes from its half off at most.
        ("sphere", far(sphere), 8.0e-3),
        ("rectangle", far(rectangle), 8.0e-3),
    ]
}

/// Every pixel that shows the ball is what Lambert says of the radial normal, everywhere that this looks towards the light.
fn check(name: &str, scene: &Scene, within: f64) {
    let (got, at) = (image(scene), points(scene));
    let (mut lit, mut dark) = (0, 0);
    for (i, (got, at)) in got.iter().zip(at).enumerate() {
        let Some(at) = at else { continue };
        let to = match scene.lights.first() {
            Some(Light::Point { position, .. } | Light::Spot { position, .. }) => position.as_dvec3() - at,
            _ => LAMP.as_dvec3(),
        };
        let want = at.normalize().dot(to.normalize()).max(0.0);
        let off = (f64::from(*got) - want).abs();
        // The end of the shadow ray is about as far above the perfect ball as the triangle is below it: light of a lamp nearby
        // that just grazes the triangle may pass below the end.
        let near = matches!(scene.lights.first(), Some(Light::Point { .. } | Light::Spot { .. }));
        let grazes = near && *got == 0.0 && want * to.length() < 2.2 * (1.0 - at.length());
        assert!(
            off < within || grazes,
            "{name}, pixel {} {}: {got}, not {want}",
            i as u32 % SIZE[0],
            i as u32 / SIZE[0]
        );
        (lit, dark) = (lit + u32::from(want > 0.0), dark + u32::from(want == 0.0));
    }
    assert!(lit > 2000 && dark > 2000, "{name}: {lit} lit, {dark} dark");
}

#[test]
fn light_fades_over_a_coarse_ball_as_over_a_smooth_one() {
    for (name, scene, within) in lamps() {
        check(name, &scene, within);
        // Shadow rays that may go through something, here through a pane that is nowhere near.
        let mut filtered = scene.clone();
        let pane = [Vec3::ZERO, Vec3::X, Vec3::Z].map(|v| v - 50.0 * Vec3::Y);
        add(&mut filtered, pane, Material { d: 0.0, illum: 6, ..matt(0.0) });
        check(&format!("{name}, glass somewhere"), &filtered, within);
        // Rays that are no packets.
        let mut lens = scene.clone();
        lens.settings.depth_of_field = Some(DepthOfField { aperture: 1.0e-7, focus: 30.0 });
        check(&format!("{name}, through a lens"), &lens, within);
        // Triangles in the other order: their normals still say which side is outside.
        let mut turned = scene.clone();
        turned.mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        check(&format!("{name}, triangles turned round"), &turned, within);
    }
}

#[test]
fn light_inside_of_a_coarse_ball_reaches_all_that_faces_it() {
    // Seen from inside, the ball is hollow: the smooth surface lies below its triangles, which is no reason to start there.
    let position = Vec3::new(0.3, 0.2, -0.1);
    let mut scene = lit_by(Light::Point { position, intensity: Vec3::ONE, falloff: Falloff::None });
    let triangles: Vec<[Vec3; 3]> = (0..scene.mesh.len()).map(|prim| scene.mesh.corners(prim)).collect();
    let cup: Vec<_> = triangles.into_iter().filter(|t| t.iter().all(|p| p.z < 0.35)).collect();
    scene.mesh = mesh_of(&cup);
    scene.mesh.normals = scene.mesh.positions.clone();
    let (got, at) = (image(&scene), points(&scene));
    let mut seen = 0;
    for (got, at) in got.iter().zip(at) {
        let Some(at) = at else { continue };
        let want = -at.normalize().dot((position.as_dvec3() - at).normalize());
        assert!(want > 0.0 && (f64::from(*got) - want).abs() < 1.0e-4, "{at}: {got}, not {want}");
        seen += 1;
    }
    assert!(seen > 4000, "{seen}");
}

#[test]
fn along_a_great_circle_light_falls_to_zero_and_stays_there() {
    let scene = lit_by(Light::Directional { direction: -Vec3::X, intensity: Vec3::ONE });
    let row = |scene: &Scene| {
        let image = image(scene);
        let middle = (SIZE[1] / 2 * SIZE[0]) as usize;
        image[middle..middle + SIZE[0] as usize].to_vec()
    };
    // Seen from far away, x of the perfect ball is the brightness. Triangles lie up to `sagitta` below it, where their
    // points are seen that much nearer to the middle, but for the perspective of 1 in 30.
    let sagitta = scene.mesh.corners(0).map(|c| c.as_dvec3()).iter().sum::<DVec3>().length() / 3.0;
    let sagitta = 1.0 - sagitta;
    let smooth = row(&scene);
    let pixel = 30.0 * (2.1f64).to_radians().tan() / f64::from(SIZE[0]) * 2.0;
    for (column, got) in smooth.iter().enumerate() {
        let x = (column as f64 - f64::from(SIZE[0] / 2)) * pixel;
        if x.abs() < 1.0 - 2.0 * sagitta {
            let off = (f64::from(*got) - x.max(0.0)).abs();
            assert!(off < sagitta + 1.0 / 30.0, "{x}: {got}");
        }
    }
    let ends = smooth.iter().rposition(|&got| got > 0.0).expect("light") + 1;
    assert!(ends > 100 && smooth[..ends].is_sorted(), "no step back: {smooth:?}");
    let steps = |row: &[f32]| row.windows(2).map(|two| (two[1] - two[0]).abs()).fold(0.0, f32::max);
    let middle = 30..91;
    assert!(steps(&smooth[middle.clone()]) < 0.05, "no edge: {smooth:?}");
    // The same mesh shows its edges without normals, and where shadow rays start on its triangles.
    let mut flat = scene.clone();
    flat.mesh.normals.clear();
    assert!(steps(&row(&flat)[middle.clone()]) > 0.1, "flat triangles have edges");
    let mut hard = scene.clone();
    hard.settings.smooth_terminator = false;
    assert!(steps(&row(&hard)[middle]) > 0.05, "and so have their shadows");
}

/// Adds a triangle of a material of its own.
fn add(scene: &mut Scene, triangle: [Vec3; 3], material: Material) {
    let at = scene.mesh.positions.len() as u32;
    scene.mesh.positions.extend(triangle);
    scene.mesh.normals.extend([Vec3::ZERO; 3]);
    scene.mesh.triangles.push([at, at + 1, at + 2]);
    scene.mesh.materials.push(scene.materials.len() as u32);
    scene.mesh.parts[0].count += 1;
    scene.materials.push(material);
}

#[test]
fn shadow_rays_end_on_the_surface_that_the_normals_stand_for() {
    // The middle p of a triangle, and the mean m of its projections onto the tangent planes of the corners.
    let corners = ball(1).corners(0).map(|c| c.as_dvec3());
    let p = corners.iter().sum::<DVec3>() / 3.0;
    let m = p + corners.iter().map(|&c| (1.0 - p.dot(c)) * c / 3.0).sum::<DVec3>();
    let up = p.normalize().as_vec3();
    let (x, y) = up.any_orthonormal_pair();
    let position = 5.0 * up;
    for (height, open) in [(0.75, true), (1.4, false), (3.0, false)] {
        let at = p.lerp(m, height).as_vec3();
        for (name, mut scene, _) in lamps() {
            // As above, but from straight above the triangle, and with a small plate in the way.
            let turn = glam::Quat::from_rotation_arc(LAMP.normalize(), up);
            for light in &mut scene.lights {
                match light {
                    Light::Directional { direction, .. } => *direction = -up,
                    Light::Point { position: place, .. } => *place = position,
                    Light::Spot { position: place, direction, .. } => (*place, *direction) = (position, -up),
                }
            }
            for light in &mut scene.area_lights {
                match light {
                    AreaLight::Sphere { center, .. } => *center = turn * *center,
                    AreaLight::Rectangle { corner, edge_u, edge_v, .. } => {
                        (*corner, *edge_u, *edge_v) = (turn * *corner, turn * *edge_u, turn * *edge_v);
                    }
                }
            }
            add(&mut scene, [x, -0.5 * x + 0.9 * y, -0.5 * x - 0.9 * y].map(|v| at + 0.03 * v), matt(0.0));
            for glass in [false, true] {
                if glass {
                    let pane = [Vec3::ZERO, Vec3::X, Vec3::Z].map(|v| v - 50.0 * Vec3::Y);
                    add(&mut scene, pane, Material { d: 0.0, illum: 6, ..matt(0.0) });
                }
                let p = p.as_vec3();
                let got = radiance(&scene, p + 2.0 * up + 3.0 * x, p).x;
                let want = f32::from(open);
                assert!((got - want).abs() < 0.01, "{name}, glass {glass}, plate at {height}: {got}");
            }
        }
    }
}

#[test]
fn a_triangle_does_not_let_light_through_from_below() {
    // All normals lean to +x, so that the light is above the horizon that they tell, but it is below the triangle.
    let lean = Vec3::new(0.75f32.sqrt(), 0.0, 0.5);
    let corners = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)];
    let mut scene = scene_of(mesh_of(&[corners]), vec![matt(1.0)]);
    scene.mesh.normals = vec![lean; 3];
    scene.settings.smooth_terminator = true;
    let position = Vec3::new(3.0, 0.0, -1.0);
    scene.lights = vec![Light::Point { position, intensity: Vec3::ONE, falloff: Falloff::None }];
    let center = FAR * position;
    let area = AreaLight::Sphere { center, radius: 1.0, radiance: Vec3::splat(center.length_squared()) };
    let see = |scene: &Scene, x: f32| radiance(scene, Vec3::new(x, 0.0, 3.0), Vec3::new(x, 0.0, 0.0)).x;
    let far = Scene { lights: vec![], area_lights: vec![area], ..scene.clone() };
    let away = Light::Directional { direction: -position.normalize(), intensity: Vec3::ONE };
    let directional = Scene { lights: vec![away], ..scene.clone() };
    for scene in [&scene, &directional, &far] {
        // The end is 0.16 above the triangle there, and light comes up by 1 in 3 at the most.
        assert_eq!(see(scene, -0.5), 0.0, "{:?} {:?}", scene.lights, scene.area_lights);
        assert!(see(scene, 0.9) > 0.5, "near its end it passes: {:?} {:?}", scene.lights, scene.area_lights);
    }
}

#[test]
fn a_coarse_ball_in_a_furnace_shows_its_albedo() {
    let mut scene = lit_by(point());
    (scene.lights, scene.materials) = (vec![], vec![matt(0.5)]);
    (scene.background, scene.ambient) = (Vec3::ONE, Vec3::ONE);
    scene.environment = Environment { light: true, ..Environment::default() };
    scene.settings.ambient_occlusion = Some(AmbientOcclusion { radius: f32::INFINITY, samples: 16 });
    scene.settings.light_samples = 16;
    scene.settings.bounces = 2;
    let (got, at) = (image(&scene), points(&scene));
    for (got, _) in got.iter().zip(at).filter(|(_, at)| at.is_some()) {
        assert!((got - 1.0).abs() < 1.0e-5, "half from the sky, half ambient: {got}");
    }
}
