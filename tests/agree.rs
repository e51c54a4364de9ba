//! Tile kernel = single-ray kernel = brute force over all triangles, bit for bit, on every instruction set.

use crate::support::{Random, brute_force, kernels, soup, sphere};
use glam::Vec3;
use irt::{
    bvh::{BuildPreset, Bvh},
    camera::Camera,
    kernels::{
        EMPTY_NODE, Face, Hit, Kernels, MISS, Ray, SUB, SUBS, TILE_RAYS, TileHits, TilePacket, TileScratch,
        micro::Meeting,
    },
    scene::{CameraDescription, TriangleMesh, procedural},
};
use std::cell::Cell;

fn build(mesh: &TriangleMesh) -> Bvh {
    let bvh = Bvh::build(mesh, BuildPreset::Medium).expect("builds");
    bvh.validate(mesh).unwrap_or_else(|violation| panic!("{violation}"));
    bvh
}

fn same(context: &str, kernels: &Kernels, ray: &Ray, got: Hit, want: Hit) {
    let bits = |h: Hit| (h.prim, h.t.to_bits(), h.u.to_bits(), h.v.to_bits());
    assert_eq!(bits(got), bits(want), "{context}, {}: {ray:?}\n got {got:?}\nwant {want:?}", kernels.isa());
}

thread_local! {
    /// One scratch for all trees, packets and kernels: what it remembers of one must not show in another.
    static SCRATCH: Cell<TileScratch> = Cell::default();
}

/// Traces the packet with every kernel and compares with the oracle.
fn check_packet(context: &str, mesh: &TriangleMesh, bvh: &Bvh, packet: &TilePacket) -> usize {
    let active = |ray: usize| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0;
    let wanted: Vec<Hit> = (0..TILE_RAYS)
        .map(|ray| if active(ray) { brute_force(mesh, &packet.ray(ray)) } else { Hit::MISS })
        .collect();
    let mut scratch = SCRATCH.take();
    for kernels in kernels() {
        let mut hits = TileHits::new();
        kernels.tile_intersect(&bvh.view(), packet, &mut scratch, &mut hits);
        let mut seed = EMPTY_NODE;
        for round in ["cold", "seeded"] {
            let mut blocked = [0; SUBS];
            kernels.tile_occluded(&bvh.view(), packet, &mut scratch, &mut seed, &mut blocked);
            for ray in 0..TILE_RAYS {
                let got = blocked[ray / SUB] >> (ray % SUB) & 1 != 0;
                let want = active(ray) && wanted[ray].prim != MISS;
                assert_eq!(
                    got,
                    want,
                    "{context}, {} {round}: occlusion of {:?}",
                    kernels.isa(),
                    packet.ray(ray)
                );
            }
        }
        for ray in (0..TILE_RAYS).filter(|&ray| active(ray)) {
            let single = packet.ray(ray);
            same(&format!("{context}, tile"), &kernels, &single, hits.hit(ray), wanted[ray]);
            same(
                &format!("{context}, single"),
                &kernels,
                &single,
                kernels.intersect(&bvh.view(), &single),
                wanted[ray],
            );
            let blocked = kernels.occluded(&bvh.view(), &single);
            assert_eq!(
                blocked,
                wanted[ray].prim != MISS,
                "{context}, {}: occlusion of {single:?}",
                kernels.isa()
            );
        }
    }
    SCRATCH.set(scratch);
    wanted.iter().filter(|hit| hit.prim != MISS).count()
}

/// A packet of slopes around (u, v), some rays inactive, some short.
fn random_packet(random: &mut Random, org: Vec3, spread: f32) -> TilePacket {
    let mut packet = TilePacket::new();
    packet.org = org.to_array();
    packet.face = Face::ALL[random.below(6)];
    let center = [random.signed(), random.signed()];
    for ray in 0..TILE_RAYS {
        packet.u[ray] = (center[0] + spread * random.signed()).clamp(-1.0, 1.0);
        packet.v[ray] = (center[1] + spread * random.signed()).clamp(-1.0, 1.0);
        packet.tfar[ray] = match random.below(4) {
            0 => 0.2 + random.signed().abs(),
            _ => f32::INFINITY,
        };
        packet.skip[ray] = if random.below(4) == 0 { random.below(8) as u32 } else { MISS };
    }
    for active in &mut packet.active {
        *active = match random.below(4) {
            0 => random.bits() as u16,
            1 if random.below(3) == 0 => 0,
            _ => u16::MAX,
        };
    }
    packet
}

#[test]
fn all_kernels_agree_on_random_triangles() {
    let mut random = Random(1);
    let mut hits = 0;
    for (count, size) in [(1, 1.0), (7, 1.0), (40, 0.5), (300, 0.3), (1500, 0.1)] {
        let mesh = soup(count as u64, count, size);
        let bvh = build(&mesh);
        for round in 0..12 {
            let spread = [0.002, 0.05, 0.4, 1.0][round % 4];
            let packet = random_packet(&mut random, 0.7 * random_vec(round), spread);
            hits += check_packet(&format!("{count} triangles, round {round}"), &mesh, &bvh, &packet);
        }
    }
    assert!(hits > 1000, "only {hits} rays hit anything: the test proves little");
}

#[test]
fn all_kernels_agree_on_triangles_that_have_moved() {
    let mut random = Random(9);
    let mut mesh = soup(3, 300, 0.3);
    let mut bvh = build(&mesh);
    // The same rays at every moment: what kernels remember of an origin must not outlive the triangles it was found with.
    let packets: Vec<TilePacket> =
        [0.05, 0.4].map(|spread| random_packet(&mut random, Vec3::ZERO, spread)).into();
    let mut hits = 0;
    for moment in 0..6 {
        for packet in &packets {
            hits += check_packet(&format!("moment {moment}"), &mesh, &bvh, packet);
        }
        mesh.positions.iter_mut().for_each(|position| *position += 0.1 * random.vec());
        bvh.refit(&mesh);
        bvh.validate(&mesh).unwrap_or_else(|violation| panic!("moment {moment}: {violation}"));
    }
    assert!(hits > 300, "only {hits} rays hit anything: the test proves little");
}

fn random_vec(seed: usize) -> Vec3 {
    Random(seed as u64 + 77).vec()
}

#[test]
fn all_kernels_agree_on_rays_aimed_at_vertices_and_edges() {
    for (center, radius) in [
        (Vec3::ZERO, 1.0),
        (Vec3::splat(100.0), 1.0),
        (Vec3::new(148_376.0, 1234.0, -223_423.0), 2.0),
        (Vec3::ZERO, 1.0e-5),
    ] {
        let mesh = sphere(center, radius, 12);
        let bvh = build(&mesh);
        let mut random = Random(5);
        for round in 0..6 {
            let org = (center + 0.3 * radius * random.vec()).to_array();
            let mut packets: Vec<TilePacket> = Face::ALL.iter().map(|_| TilePacket::new()).collect();
            let mut used = [0usize; 6];
            for i in 0..mesh.len() {
                let [a, b, c] = mesh.corners(i);
                let target = [a, b, c, a + 0.5 * (b - a), b + 0.5 * (c - b)][(round + i) % 5].to_array();
                let d = [target[0] - org[0], target[1] - org[1], target[2] - org[2]];
                let greatest = d.iter().fold(0.0f32, |m, x| m.max(x.abs()));
                let slopes = d.map(|x| x / greatest);
                let face = Face::of(slopes);
                let packet = &mut packets[face.index()];
                let ray = used[face.index()];
                if ray < TILE_RAYS {
                    let [iu, iv, _] = face.axes();
                    (packet.u[ray], packet.v[ray]) = (slopes[iu], slopes[iv]);
                    packet.active[ray / SUB] |= 1 << (ray % SUB);
                    (packet.org, packet.face) = (org, face);
                    used[face.index()] += 1;
                }
            }
            for (packet, used) in packets.iter().zip(used) {
                let hits = check_packet("aimed", &mesh, &bvh, packet);
                assert_eq!(
                    hits, used,
                    "a ray from inside leaks out of a closed sphere of radius {radius} at {center}"
                );
            }
        }
    }
}

#[test]
fn primary_rays_of_a_camera_agree_across_faces_and_partial_tiles() {
    let mesh = soup(9, 400, 0.4);
    let bvh = build(&mesh);
    let description =
        CameraDescription { eye: Vec3::new(1.5, 1.4, 1.6), at: Vec3::ZERO, up: Vec3::Y, fov_deg: 70.0 };
    let camera = Camera::new(&description, 50, 37);
    let mut packets = std::array::from_fn(|_| TilePacket::new());
    let mut straddling = 0;
    for (x, y) in (0..37).step_by(16).flat_map(|y| (0..50).step_by(16).map(move |x| (x, y))) {
        for kernels in kernels() {
            let used = camera.rays(&kernels, [x, y], [50 - x, 37 - y], &mut packets);
            straddling += usize::from(used > 1);
            let pixels: u32 = packets[..used].iter().flat_map(|p| p.active).map(u16::count_ones).sum();
            assert_eq!(pixels, (50 - x).min(16) * (37 - y).min(16));
            for packet in &packets[..used] {
                check_packet("camera", &mesh, &bvh, packet);
            }
        }
    }
    assert!(straddling > 0, "no tile straddles two faces: the test proves little");
}

#[test]
fn single_rays_in_any_direction_agree_with_brute_force() {
    let mut random = Random(3);
    let mesh = soup(11, 500, 0.3);
    let bvh = build(&mesh);
    for round in 0..3000 {
        let org = 1.5 * random.vec();
        let mut dir = random.vec() * [1.0e-6, 1.0, 1.0e6][round % 3];
        match random.below(8) {
            0 => dir.x = 0.0,
            1 => (dir.x, dir.y) = (-0.0, 0.0),
            2 => (dir.y, dir.z) = (0.0, -0.0),
            _ => {}
        }
        let tnear = if random.below(3) == 0 { 0.3 / dir.length() } else { 0.0 };
        let tfar = if random.below(3) == 0 { 1.0 / dir.length() } else { f32::INFINITY };
        let ray = Ray {
            org: org.to_array(),
            dir: dir.to_array(),
            tnear,
            tfar,
            skip: random.below(mesh.len()) as u32,
        };
        let want = if dir == Vec3::ZERO { Hit::MISS } else { brute_force(&mesh, &ray) };
        for kernels in kernels() {
            same("single", &kernels, &ray, kernels.intersect(&bvh.view(), &ray), want);
            assert_eq!(kernels.occluded(&bvh.view(), &ray), want.prim != MISS, "{ray:?}");
        }
    }
}

#[test]
fn rays_without_a_meaning_miss() {
    let mesh = sphere(Vec3::ZERO, 1.0, 8);
    let bvh = build(&mesh);
    let good = Ray { org: [0.0; 3], dir: [0.0, 0.0, 1.0], tnear: 0.0, tfar: f32::INFINITY, skip: MISS };
    let bad = [
        Ray { dir: [0.0; 3], ..good },
        Ray { dir: [f32::NAN, 0.0, 1.0], ..good },
        Ray { dir: [f32::INFINITY, 0.0, 1.0], ..good },
        Ray { org: [f32::NAN, 0.0, 0.0], ..good },
        Ray { org: [f32::INFINITY, 0.0, 0.0], ..good },
        Ray { tnear: f32::NAN, ..good },
        Ray { tfar: f32::NAN, ..good },
        Ray { tnear: 2.0, tfar: 1.0, ..good },
        Ray { tfar: -1.0, ..good },
    ];
    for kernels in kernels() {
        assert_ne!(kernels.intersect(&bvh.view(), &good).prim, MISS);
        for ray in &bad {
            assert_eq!(kernels.intersect(&bvh.view(), ray), Hit::MISS, "{ray:?}");
            assert!(!kernels.occluded(&bvh.view(), ray), "{ray:?}");
        }
    }
}

#[test]
fn the_depth_interval_is_closed_at_both_ends() {
    let mesh = crate::support::mesh_of(&[[
        Vec3::new(-1.0, -1.0, 2.0),
        Vec3::new(3.0, -1.0, 2.0),
        Vec3::new(-1.0, 3.0, 2.0),
    ]]);
    let bvh = build(&mesh);
    let ray = Ray { org: [0.0; 3], dir: [0.0, 0.0, 1.0], tnear: 2.0, tfar: 2.0, skip: MISS };
    for kernels in kernels() {
        assert_eq!(kernels.intersect(&bvh.view(), &ray).t, 2.0);
        assert!(kernels.occluded(&bvh.view(), &ray));
        let mut packet = TilePacket::new();
        packet.face = Face::ALL[4];
        packet.tfar = [2.0; TILE_RAYS];
        packet.active = [u16::MAX; SUBS];
        let (mut hits, mut scratch) = (TileHits::new(), TileScratch::new());
        kernels.tile_intersect(&bvh.view(), &packet, &mut scratch, &mut hits);
        assert_eq!(hits.t, [2.0; TILE_RAYS]);
        packet.tfar = [2.0f32.next_down(); TILE_RAYS];
        kernels.tile_intersect(&bvh.view(), &packet, &mut scratch, &mut hits);
        assert_eq!(hits.prim, [MISS; TILE_RAYS]);
    }
}

#[test]
fn an_empty_scene_is_missed_by_everything() {
    let bvh = build(&TriangleMesh::default());
    let packet = random_packet(&mut Random(8), Vec3::ZERO, 1.0);
    check_packet("empty", &TriangleMesh::default(), &bvh, &packet);
}

#[test]
fn all_kernels_agree_on_the_built_in_scenes() {
    let mut random = Random(21);
    for name in procedural::NAMES {
        let scene = procedural::build(name, 0.2).expect("a built-in scene");
        let bvh = build(&scene.mesh);
        let camera = Camera::new(&scene.camera, 512, 512);
        let mut packets: Box<[TilePacket; 6]> = Box::new(std::array::from_fn(|_| TilePacket::new()));
        let mut hits = 0;
        for _ in 0..4 {
            let at = [0, 1].map(|_| 16 * random.below(32) as u32);
            let used = camera.rays(&kernels()[0], at, [16, 16], &mut packets);
            for packet in &mut packets[..used] {
                // Brute force looks at every triangle: a few rays of each sub-packet must do.
                for active in &mut packet.active {
                    *active &= 1 << random.below(16);
                }
                hits += check_packet(name, &scene.mesh, &bvh, packet);
            }
        }
        // A packet of rays in all directions, from a light.
        let mut packet = random_packet(&mut random, scene.camera.at, 1.0);
        for active in &mut packet.active {
            *active &= 1 << random.below(16);
        }
        hits += check_packet(name, &scene.mesh, &bvh, &packet);
        assert!(hits > 20, "{name}: only {hits} rays hit");
    }
}

#[test]
fn the_kernels_steps_find_what_the_kernel_finds() {
    let scene = procedural::build("atrium", 0.1).expect("a built-in scene");
    let bvh = build(&scene.mesh);
    let camera = Camera::new(&scene.camera, 64, 64);
    let mut six = std::array::from_fn(|_| TilePacket::new());
    let used = camera.rays(&Kernels::detect(), [16, 32], [16, 9], &mut six);
    for packet in &six[..used] {
        let meeting = Meeting::new(bvh.view(), packet.clone());
        assert!(meeting.boxes() > 0 && meeting.triangles() > 0 && meeting.pairs() > 0);
        for kernels in kernels() {
            let mut steps = meeting.clone();
            for step in
                [Meeting::test_boxes, Meeting::set_up_leaves, Meeting::test_triangles, Meeting::finish]
            {
                step(&mut steps, &kernels);
                assert_eq!(steps.checksum(), meeting.checksum(), "{}", kernels.isa());
            }
        }
    }
}
