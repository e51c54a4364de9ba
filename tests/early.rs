//! Early terminations and orders change the work, never the image; and the study of coherence counts right.

use crate::support::{RENDER, brute_force};
use irt::{
    bvh::BuildPreset,
    camera::{Camera, pixel_of},
    kernels::{Isa, Kernels, MISS, SUB, TILE_RAYS, TilePacket},
    render::{RenderOptions, render},
    scene::{Light, Scene, procedural},
    schedule::Control,
    study::coherence::{CoherenceOptions, SceneCoherence, ShadowRays, coherence},
    tile::{Order, pixels},
    trace::EarlyTermination,
};

const SIZE: [u32; 2] = [70, 51];

fn image(scene: &Scene, early: EarlyTermination, isa: Option<Isa>, order: Order) -> String {
    // The second frame begins with what the first remembers.
    let options = RenderOptions { isa, order, tile: 32, size: SIZE, frames: 2, early, ..RENDER };
    let rendered = render(scene, &options, &Control::unattended()).expect("renders");
    let [first, second] = &rendered.frames[..] else { panic!("two frames") };
    assert_eq!(first.image_sha256, second.image_sha256, "{early}, {order}");
    first.image_sha256.clone()
}

fn study(scene: &Scene, change: impl FnOnce(&mut CoherenceOptions)) -> SceneCoherence {
    let mut options = CoherenceOptions {
        isa: None,
        build: BuildPreset::Fast,
        size: SIZE,
        orders: Order::ALL.to_vec(),
        tile: None,
        rounds: 0,
        shadow_rays: ShadowRays::Every,
        end_at_light: false,
        caches: true,
    };
    change(&mut options);
    // It fails if any pass gives other hits or another image than the first.
    coherence(scene, &options, |_| {}).expect("every pass gives the same image")
}

#[test]
fn packets_give_one_image_with_every_combination_and_order() {
    let scene = procedural::build("atrium", 0.2).unwrap();
    let want = image(&scene, EarlyTermination::NONE, None, Order::Scanline);
    for early in EarlyTermination::all() {
        let order = Order::ALL[early.area % Order::ALL.len()];
        assert_eq!(image(&scene, early, None, order), want, "{early}, {order}");
    }
    for isa in Isa::available() {
        for early in EarlyTermination::all().filter(|early| early.pet_seed && early.area % 4 == 0) {
            assert_eq!(image(&scene, early, Some(isa), Order::Peano), want, "{early}, {isa}");
        }
    }
}

#[test]
fn single_rays_give_the_image_of_packets_with_every_technique_cache_and_order() {
    for name in ["office", "statue"] {
        let mut scene = procedural::build(name, 0.2).unwrap();
        let intensity = glam::Vec3::splat(0.2);
        // A kind of light whose shadow rays start at the surface.
        scene.lights.push(Light::Directional { direction: glam::Vec3::new(0.6, -0.8, 0.0), intensity });
        let want = image(&scene, EarlyTermination::FASTEST, None, Order::Hilbert);
        for (shadow_rays, end_at_light, tile) in
            [(ShadowRays::Every, false, None), (ShadowRays::Facing, true, Some(16))]
        {
            let result = study(&scene, |options| {
                options.shadow_rays = shadow_rays;
                options.end_at_light = end_at_light;
                options.tile = tile;
            });
            assert_eq!(result.image_sha256, want, "{name}");
            assert_eq!(result.walks.len(), Order::ALL.len());
        }
    }
}

#[test]
fn counters_satisfy_their_identities() {
    let scene = procedural::build("nave", 0.2).unwrap();
    let result = study(&scene, |_| {});
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    let hit = result.walks[0].primary.hit;
    assert_eq!(result.shadow_rays, hit * scene.lights.len() as u64, "a ray to each light");
    assert!(result.blocked > 0 && result.blocked < result.shadow_rays);
    for walk in &result.walks {
        let [base, .., all] = &walk.techniques[..] else { panic!("techniques") };
        assert_eq!((base.technique.name, all.technique.name), ("base", "SET-OCC-PET"));
        assert_eq!((base.primary.seeded, base.shadow.seeded), (0, 0));
        for row in walk.techniques.iter().chain(&walk.caches) {
            assert_eq!(row.shadow.seeded + row.shadow.traversals, row.shadow.rays, "OCC or traversal");
            assert_eq!((row.primary.rays, row.primary.traversals), (pixels, pixels));
            assert_eq!(row.shadow.rays, result.shadow_rays);
            // Each ray that enters the tree visits its root, and seeds are tested before.
            assert!(row.shadow.counts.steps >= row.shadow.traversals);
            assert!(row.shadow.counts.triangles >= row.shadow.seeded);
            assert!(row.shadow.counts.steps <= base.shadow.counts.steps);
            assert!(row.primary.counts.boxes <= base.primary.counts.boxes);
            assert!(row.shadow.seeded <= result.blocked);
        }
        assert_eq!(base.shadow.traversals, result.shadow_rays);
        assert_eq!(walk.shadow.total, all.shadow.seeded, "tables 6 and 7 count the successes of OCC");
        let by_row: u64 = walk.shadow.pixels.iter().zip(1..).map(|(count, lights)| count * lights).sum();
        assert_eq!(by_row, walk.shadow.total, "four lights fill no row for many");
        assert!(walk.primary.same <= all.primary.seeded, "whoever hits the same meets the seed");
        assert_eq!(base.primary.counts, result.walks[0].techniques[0].primary.counts, "base knows no order");
        assert_eq!(walk.caches[0].shadow, all.shadow, "one entry for all rays is the thesis' cache");
    }
}

#[test]
fn table_1_is_what_brute_force_counts() {
    let scene = procedural::build("office", 0.1).unwrap();
    let [width, height] = [37, 26];
    let result = study(&scene, |options| (options.size, options.caches) = ([width, height], false));
    let kernels = Kernels::detect();
    let camera = Camera::new(&scene.camera, width, height);
    let mut packets = Box::new(std::array::from_fn(|_| TilePacket::new()));
    let mut prims = vec![MISS; (width * height) as usize];
    for (x, y) in (0..height).step_by(16).flat_map(|y| (0..width).step_by(16).map(move |x| (x, y))) {
        let used = camera.rays(&kernels, [x, y], [width - x, height - y], &mut packets);
        for packet in &packets[..used] {
            for ray in (0..TILE_RAYS).filter(|ray| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0) {
                let (dx, dy) = pixel_of(ray);
                let prim = brute_force(&scene.mesh, &packet.ray(ray)).prim;
                prims[((y + dy) * width + x + dx) as usize] = prim;
            }
        }
    }
    for walk in &result.walks {
        let order: Vec<u32> = pixels(width, height, walk.order, None)
            .into_iter()
            .map(|(x, y)| prims[(y * width + x) as usize])
            .collect();
        let pairs = || order.windows(2).filter(|pair| pair[0] == pair[1]);
        let same = pairs().filter(|pair| pair[0] != MISS).count() as u64;
        assert_eq!(walk.primary.same, same, "{}", walk.order);
        assert_eq!(walk.primary.both_missed, pairs().count() as u64 - same);
        // Voorhies' measure: runs of one triangle along the order.
        let runs = order.chunk_by(|a, b| a == b).filter(|run| run[0] != MISS).count() as f64;
        let mut triangles: Vec<u32> = order.iter().copied().filter(|&prim| prim != MISS).collect();
        triangles.sort_unstable();
        triangles.dedup();
        assert_eq!(walk.primary.entries_per_triangle(), runs / triangles.len() as f64);
    }
    let same: Vec<u64> = result.walks.iter().map(|walk| walk.primary.same).collect();
    assert!(same.iter().any(|&count| count != same[0]), "orders differ: {same:?}");
}
