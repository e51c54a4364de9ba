//! Numbers without a meaning: one answer each, and nothing else is disturbed.

use crate::support::{RENDER, Random, brute_force, kernels, mesh_of, soup, sphere};
use glam::Vec3;
use irt::{
    bvh::{BuildPreset, Bvh},
    camera::{Camera, pixel_of},
    kernels::{
        EMPTY_NODE, Face, Flight, Hit, HitBlock, Pick, Ray, RayBlock, SUB, SUBS, TILE_RAYS, TileHits,
        TilePacket, TileScratch, Visibility,
    },
    render::{Stage, render},
    scene::{CameraDescription, Falloff, Light, Scene, procedural},
    schedule::Control,
    study::{
        bench::{BenchOptions, Engine, Kind, bench, builds, micro},
        coherence::sweep,
    },
};

/// What was there before: no ray that takes part may keep it.
const UNTOUCHED: Hit = Hit { prim: 12_345, t: -1.0, u: -1.0, v: -1.0 };

const BAD: [f32; 4] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -f32::NAN];

/// A ray made meaningless in one of many ways.
fn spoil(random: &mut Random, ray: &mut Ray) {
    let (bad, axis) = (BAD[random.below(4)], random.below(3));
    match random.below(6) {
        0 => ray.org[axis] = bad,
        1 => ray.dir[axis] = bad,
        2 => ray.dir = [0.0, -0.0, 0.0],
        3 => ray.tnear = f32::NAN,
        4 => ray.tfar = f32::NAN,
        _ => (ray.tnear, ray.tfar) = (f32::INFINITY, 1.0),
    }
}

#[test]
fn a_ray_without_a_meaning_misses_and_leaves_its_neighbours_alone() {
    let mesh = soup(3, 300, 0.4);
    let bvh = Bvh::build(&mesh, BuildPreset::Medium).expect("builds");
    let view = bvh.view();
    let mut random = Random(61);
    let mut spoiled = 0;
    for _ in 0..60 {
        let (org, dir) = (1.5 * random.vec(), random.vec());
        let mut blocks = vec![RayBlock::EMPTY; SUBS];
        let mut wanted = vec![HitBlock::MISS; SUBS];
        for (block, wanted) in blocks.iter_mut().zip(&mut wanted) {
            for lane in 0..SUB {
                let mut ray = Ray {
                    org: (org + 0.05 * random.vec()).to_array(),
                    dir: (dir + 0.05 * random.vec()).to_array(),
                    tnear: 0.0,
                    tfar: f32::INFINITY,
                    skip: random.below(300) as u32,
                };
                wanted.set(lane, brute_force(&mesh, &ray));
                if random.below(4) == 0 {
                    spoil(&mut random, &mut ray);
                    wanted.set(lane, Hit::MISS);
                    spoiled += 1;
                }
                block.set(lane, &ray);
            }
        }
        let picks: Vec<Pick> = (0..SUBS as u32).map(|block| Pick { block, active: u16::MAX }).collect();
        let blocked: Vec<u16> =
            wanted.iter().map(|of| (0..SUB).map(|i| u16::from(of.prim[i] != u32::MAX) << i).sum()).collect();
        for kernels in kernels() {
            let untouched = vec![HitBlock::splat(UNTOUCHED); SUBS];
            let (mut beams, mut flown) = (untouched.clone(), untouched);
            let (mut stopped, mut grounded) = (vec![u16::MAX; SUBS], vec![u16::MAX; SUBS]);
            kernels.beam_intersect(&view, &blocks, &picks, &mut beams);
            kernels.beam_occluded(&view, &blocks, &picks, &mut EMPTY_NODE.clone(), &mut stopped);
            kernels.intersect_each(&view, &blocks, &picks, &mut Flight::default(), &mut flown);
            kernels.occluded_each(&view, &blocks, &picks, &mut Flight::default(), &mut grounded);
            assert_eq!((&beams, &stopped), (&wanted, &blocked), "beam, {}", kernels.isa());
            assert_eq!((&flown, &grounded), (&wanted, &blocked), "flight, {}", kernels.isa());
        }
    }
    assert!(spoiled > 1000);
}

#[test]
fn a_slope_without_a_meaning_misses_and_leaves_its_neighbours_alone() {
    let mesh = sphere(Vec3::ZERO, 1.0, 12);
    let bvh = Bvh::build(&mesh, BuildPreset::Medium).expect("builds");
    let mut random = Random(67);
    for round in 0..60 {
        let mut packet = TilePacket::new();
        packet.face = Face::ALL[round % 6];
        packet.active = [u16::MAX; SUBS];
        let mut bad = [false; TILE_RAYS];
        for ray in 0..TILE_RAYS {
            (packet.u[ray], packet.v[ray]) = (0.3 * random.signed(), 0.3 * random.signed());
            bad[ray] = random.below(8) == 0;
            if bad[ray] {
                let slope = BAD[random.below(4)];
                match random.below(3) {
                    0 => packet.u[ray] = slope,
                    1 => packet.v[ray] = slope,
                    _ => packet.tfar[ray] = f32::NAN,
                }
            }
        }
        for kernels in kernels() {
            let (mut hits, mut scratch) = (TileHits::new(), TileScratch::new());
            hits.prim.fill(UNTOUCHED.prim);
            hits.t.fill(UNTOUCHED.t);
            let (mut seed, mut blocked) = (EMPTY_NODE, [u16::MAX; SUBS]);
            kernels.tile_intersect(&bvh.view(), &packet, &mut scratch, &mut hits);
            kernels.tile_occluded(&bvh.view(), &packet, &mut scratch, &mut seed, &mut blocked);
            for ray in 0..TILE_RAYS {
                let want = if bad[ray] { Hit::MISS } else { brute_force(&mesh, &packet.ray(ray)) };
                assert_eq!(hits.hit(ray), want, "{}, ray {ray}: {:?}", kernels.isa(), packet.ray(ray));
                assert_eq!(blocked[ray / SUB] >> (ray % SUB) & 1 != 0, !bad[ray], "{}", kernels.isa());
            }
        }
    }
}

#[test]
fn a_scene_built_by_a_program_is_checked() {
    let good = procedural::build("atrium", 0.1).expect("a built-in scene");
    for name in procedural::NAMES {
        procedural::build(name, 0.1)
            .expect("a built-in scene")
            .check()
            .expect("built-in scenes keep their promises");
    }
    let point = |position, intensity| Light::Point { position, intensity, falloff: Falloff::None };
    let spot = |direction, inner, outer| Light::Spot {
        position: Vec3::ZERO,
        direction,
        intensity: Vec3::ONE,
        falloff: Falloff::None,
        inner,
        outer,
    };
    type Spoil = Box<dyn Fn(&mut Scene)>;
    let mut cases: Vec<(&str, Spoil)> = vec![
        ("normals belong to", Box::new(|scene| scene.mesh.normals = vec![Vec3::Y])),
        ("does not exist", Box::new(|scene| scene.mesh.triangles[5][2] = u32::MAX)),
        ("a material that does not exist", Box::new(|scene| scene.mesh.materials[5] = 10_000)),
        ("materials belong to", Box::new(|scene| scene.mesh.materials.truncate(3))),
        ("camera is where it looks", Box::new(|scene| scene.camera.at = scene.camera.eye)),
        ("points along the view", Box::new(|scene| scene.camera.up = scene.camera.at - scene.camera.eye)),
        ("points along the view", Box::new(|scene| scene.camera.up = Vec3::ZERO)),
        ("light 0 has a position", Box::new(move |scene| scene.lights = vec![spot(Vec3::Y * 2.0, 0.1, 0.2)])),
        ("light 0 has a position", Box::new(move |scene| scene.lights = vec![spot(Vec3::Y, 0.3, 0.2)])),
        ("light 0 has a position", Box::new(move |scene| scene.lights = vec![spot(Vec3::Y, f32::NAN, 0.2)])),
        (
            "light 0 has the strength",
            Box::new(move |scene| scene.lights = vec![point(Vec3::ONE, -Vec3::ONE)]),
        ),
    ];
    for fov in [0.0, 180.0, -10.0, 400.0, f32::NAN, f32::INFINITY] {
        cases.push(("angle of view", Box::new(move |scene| scene.camera.fov_deg = fov)));
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0e18] {
        cases.push(("vertex 7 is at", Box::new(move |scene| scene.mesh.positions[7].y = bad)));
        cases.push((
            "light 0 has a position",
            Box::new(move |scene| {
                scene.lights = vec![point(Vec3::new(bad, 0.0, 0.0), Vec3::ONE)];
            }),
        ));
        cases.push(("camera's numbers", Box::new(move |scene| scene.camera.eye.z = bad)));
        cases.push(("camera's numbers", Box::new(move |scene| scene.camera.at.z = bad)));
    }
    for bad in [f32::NAN, f32::INFINITY] {
        cases.push((
            "normal of vertex 7",
            Box::new(move |scene| {
                scene.mesh.normals = vec![Vec3::Y; scene.mesh.positions.len()];
                scene.mesh.normals[7].x = bad;
            }),
        ));
        cases.push((
            "light 0 has a position",
            Box::new(move |scene| {
                scene.lights =
                    vec![Light::Directional { direction: Vec3::new(bad, 0.0, 0.0), intensity: Vec3::ONE }];
            }),
        ));
        cases.push((
            "light 0 has the strength",
            Box::new(move |scene| {
                scene.lights = vec![point(Vec3::ZERO, Vec3::splat(bad))];
            }),
        ));
        cases.push(("camera's numbers", Box::new(move |scene| scene.camera.up.z = bad)));
        cases.push(("ambient", Box::new(move |scene| scene.ambient.x = bad)));
        cases.push(("background", Box::new(move |scene| scene.background.x = bad)));
    }
    for (what, spoil) in cases {
        let mut scene = good.clone();
        spoil(&mut scene);
        let message = scene.check().expect_err(what).to_string();
        assert!(message.contains(what) && message.contains("; "), "{what}: {message}");
    }
}

#[test]
fn whatever_renders_or_studies_a_scene_checks_it_first() {
    let mut scene = procedural::build("atrium", 0.1).expect("a built-in scene");
    scene.mesh.triangles[5][2] = u32::MAX;
    let bench_options = BenchOptions {
        kinds: vec![Kind::Primary],
        engines: vec![Engine::Irt],
        isa: None,
        visibility: vec![Visibility::Exact],
        rounds: 1,
        threads: 1,
        pin: false,
        size: RENDER.size,
        build: BuildPreset::Fast,
    };
    let refused = [
        render(&scene, &RENDER, &Control::unattended()).map(drop),
        Stage::new(&scene, &RENDER).map(drop),
        sweep(&scene, "atrium", RENDER.size, None, BuildPreset::Fast).map(drop),
        bench(&scene, &bench_options, |_| {}).map(drop),
        builds(&scene, &bench_options, |_| {}).map(drop),
        micro(&scene, &bench_options).map(drop),
    ];
    for error in refused {
        let message = error.expect_err("triangle 5 has no such vertex").to_string();
        assert!(message.contains("triangle 5 has a vertex that does not exist"), "{message}");
    }
}

#[test]
fn cameras_at_the_ends_of_what_is_allowed_see() {
    let up = Vec3::new(1.0, 1.0e-3, 0.0);
    for fov_deg in [f32::MIN_POSITIVE, 1.0e-20, 179.99998] {
        for (eye, at) in [
            (Vec3::ZERO, Vec3::Y),
            (Vec3::splat(-1.0e18), Vec3::splat(1.0e18)),
            (Vec3::ZERO, 1.0e-15 * Vec3::Z),
        ] {
            let camera = Camera::new(&CameraDescription { eye, at, up, fov_deg }, 32, 16);
            let mut packets: [TilePacket; 6] = std::array::from_fn(|_| TilePacket::new());
            for kernels in kernels() {
                let used = camera.rays(&kernels, [16, 0], [16, 16], &mut packets);
                let active: u32 = packets[..used].iter().flat_map(|p| p.active).map(u16::count_ones).sum();
                assert_eq!(active, 256, "{fov_deg} {eye} {at}");
                for packet in &packets[..used] {
                    for ray in (0..TILE_RAYS).filter(|ray| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0) {
                        assert!(
                            packet.u[ray].abs() <= 1.0 && packet.v[ray].abs() <= 1.0,
                            "{fov_deg} {eye} {at}"
                        );
                        let (x, y) = pixel_of(ray);
                        let along = camera.direction(16 + x, y).as_dvec3();
                        let off =
                            Vec3::from(packet.ray(ray).dir).as_dvec3() - along / along.abs().max_element();
                        assert!(off.length() < 1.0e-6, "{fov_deg} {eye} {at}: another direction, {off}");
                    }
                }
            }
        }
    }
}

#[test]
fn triangles_without_area_or_with_enormous_corners_are_no_trouble() {
    let big = 1.0e18;
    let good = [Vec3::new(-1.0, -1.0, 3.0), Vec3::new(1.0, -1.0, 3.0), Vec3::new(0.0, 1.0, 3.0)];
    let mesh = mesh_of(&[
        [Vec3::ZERO; 3],
        [Vec3::Z, Vec3::Z, 2.0 * Vec3::Z],
        [Vec3::new(-0.5, 0.0, 1.0), Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.5, 0.0, 1.0)],
        good,
        [Vec3::new(-big, -big, big), Vec3::new(big, -big, big), Vec3::new(0.0, big, big)],
        [Vec3::splat(1.0e-40), Vec3::splat(2.0e-40), Vec3::new(1.0e-40, 0.0, 2.0e-40)],
    ]);
    for preset in BuildPreset::ALL {
        let bvh = Bvh::build(&mesh, preset).expect("builds");
        for kernels in kernels() {
            let ray = |dir: [f32; 3], skip| Ray {
                org: [0.0, 0.0, 0.5],
                dir,
                tnear: 0.0,
                tfar: f32::INFINITY,
                skip,
            };
            assert_eq!(kernels.intersect(&bvh.view(), &ray([0.0, 0.0, 1.0], u32::MAX)).prim, 3);
            assert_eq!(kernels.intersect(&bvh.view(), &ray([0.0, 0.0, 1.0], 3)).prim, 4);
            assert_eq!(kernels.intersect(&bvh.view(), &ray([0.0, 0.0, 1.0e-30], 3)).prim, 4);
            assert_eq!(
                kernels.intersect(&bvh.view(), &ray([0.0, 0.0, -1.0], u32::MAX)),
                brute_force(&mesh, &ray([0.0, 0.0, -1.0], u32::MAX))
            );
        }
    }
}
