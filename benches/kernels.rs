//! `cargo bench`: the kernels of a frame one by one, for each instruction set of this machine, in less than a minute.
//! For quick comparisons of two versions; figures to publish come from `irt bench`.
//!
//! A 256x256 image of the built-in atrium; the last of the scene's positional lights casts the shadows. All threads
//! but one stay idle.

use criterion::{
    BenchmarkGroup, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
    measurement::WallTime,
};
use irt::{
    bvh::{BuildPreset, Bvh},
    camera::{Camera, PACKET_SIDE},
    kernels::{Isa, Kernels, Ray, SUB, TILE_RAYS, TileHits, TilePacket, TileScratch},
    scene::{Light, Part, Scene, TriangleMesh, procedural},
    shade::{LightRays, SurfaceTable, Surfaces, add_light, light_rays},
    tile::{Order, tiles},
    trace::{KernelChoice, NO_OCCLUDER, PointShadows, ShadowRays, Traversal},
};
use std::{hint::black_box, time::Duration};

const SIDE: u32 = 256;
/// Side of the tiles that shadow rays are regrouped in.
const TILE: u32 = 64;

/// What does not depend on the instruction set.
struct Setup {
    scene: Scene,
    bvh: Bvh,
    /// A tree in which no ray gets anywhere: what is left of shadows is their regrouping.
    nothing: Bvh,
    table: SurfaceTable,
    camera: Camera,
    light: Light,
    position: [f32; 3],
}

impl Setup {
    fn new() -> Setup {
        let scene = procedural::build("atrium", 1.0).expect("a built-in scene");
        let position = |light: &Light| match *light {
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                Some((*light, position.to_array()))
            }
            Light::Directional { .. } => None,
        };
        let (light, position) = scene.lights.iter().rev().find_map(position).expect("a light with a place");
        let far = glam::Vec3::splat(1.0e6);
        let mesh = TriangleMesh {
            positions: vec![far, far + glam::Vec3::X, far + glam::Vec3::Y],
            normals: Vec::new(),
            triangles: vec![[0, 1, 2]],
            materials: vec![0],
            parts: vec![Part { name: "far".into(), first: 0, count: 1 }],
        };
        Setup {
            bvh: Bvh::build(&scene.mesh, BuildPreset::default()).expect("a tree"),
            nothing: Bvh::build(&mesh, BuildPreset::Fast).expect("a tree"),
            table: SurfaceTable::new(&scene),
            camera: Camera::new(&scene.camera, SIDE, SIDE),
            light,
            position,
            scene,
        }
    }
}

/// One tile of the image: its packets, what they see, and the light's rays there.
struct Seen {
    packets: Vec<TilePacket>,
    surfaces: Surfaces,
    rays: LightRays,
}

impl Seen {
    fn shadow_rays(&self) -> ShadowRays<'_> {
        let LightRays { u, v, limit, face, .. } = &self.rays;
        ShadowRays { u, v, tfar: limit, skip: &self.surfaces.prim, face }
    }
}

/// Corners of the packets of a tile.
fn corners(left: u32, top: u32) -> impl Iterator<Item = [u32; 2]> {
    let step = PACKET_SIDE as usize;
    (0..TILE).step_by(step).flat_map(move |y| (0..TILE).step_by(step).map(move |x| [left + x, top + y]))
}

fn see(setup: &Setup, traversal: &Traversal) -> Vec<Seen> {
    let kernels = traversal.kernels();
    let mut six = Box::new(std::array::from_fn(|_| TilePacket::new()));
    let (mut hits, mut scratch) = (TileHits::new(), TileScratch::new());
    let see = |tile: irt::tile::Tile| {
        let (mut packets, mut surfaces, mut rays) = (Vec::new(), Surfaces::default(), LightRays::default());
        surfaces.reset((TILE * TILE) as usize / TILE_RAYS, setup.scene.background.to_array());
        for (index, at) in corners(tile.x, tile.y).enumerate() {
            let used = setup.camera.rays(kernels, at, [PACKET_SIDE; 2], &mut six);
            for packet in &six[..used] {
                traversal.intersect(packet, &mut scratch, &mut hits);
                surfaces.gather(&setup.table, index, packet, &hits);
                packets.push(packet.clone());
            }
        }
        surfaces.finish(kernels);
        light_rays(kernels, &setup.table, &surfaces, &setup.light, &mut rays);
        Seen { packets, surfaces, rays }
    };
    tiles(SIDE, SIDE, TILE, Order::Hilbert).into_iter().map(see).collect()
}

fn primary(group: &mut BenchmarkGroup<'_, WallTime>, setup: &Setup, traversal: &Traversal, seen: &[Seen]) {
    group.throughput(Throughput::Elements(u64::from(SIDE * SIDE)));
    let mut six = Box::new(std::array::from_fn(|_| TilePacket::new()));
    group.bench_function("ray generation", |bencher| {
        bencher.iter(|| {
            for tile in tiles(SIDE, SIDE, PACKET_SIDE, Order::Scanline) {
                let at = [tile.x, tile.y];
                black_box(setup.camera.rays(traversal.kernels(), at, [PACKET_SIDE; 2], &mut six));
            }
        });
    });
    let (mut hits, mut scratch) = (TileHits::new(), TileScratch::new());
    group.bench_function("primary packets", |bencher| {
        bencher.iter(|| {
            for packet in seen.iter().flat_map(|seen| &seen.packets) {
                traversal.intersect(packet, &mut scratch, &mut hits);
                black_box(&hits);
            }
        });
    });
    let active = |packet: &TilePacket, ray: usize| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0;
    let rays: Vec<Ray> = seen
        .iter()
        .flat_map(|seen| &seen.packets)
        .flat_map(|packet| (0..TILE_RAYS).filter(|&i| active(packet, i)).map(|i| packet.ray(i)))
        .collect();
    group.bench_function("primary, single rays", |bencher| {
        bencher.iter(|| rays.iter().filter(|ray| traversal.intersect_ray(ray).t < 1.0).count());
    });
}

fn shadow(group: &mut BenchmarkGroup<'_, WallTime>, setup: &Setup, traversal: &Traversal, seen: &mut [Seen]) {
    let wanted = |seen: &Seen| seen.rays.visible.iter().filter(|&&visible| visible > 0.0).count() as u64;
    group.throughput(Throughput::Elements(seen.iter().map(wanted).sum()));
    let kernels = *traversal.kernels();
    group.bench_function("shadow ray generation", |bencher| {
        let mut rays = LightRays::default();
        bencher.iter(|| {
            for seen in &*seen {
                light_rays(&kernels, &setup.table, &seen.surfaces, &setup.light, &mut rays);
                black_box(&rays);
            }
        });
    });
    let nothing = Traversal::new(&setup.nothing, kernels, KernelChoice::Tile);
    for (name, traversal) in [("shadow regrouping", &nothing), ("shadow streams", traversal)] {
        let (mut shadows, mut visible) = (PointShadows::default(), vec![1.0; (TILE * TILE) as usize]);
        group.bench_function(name, |bencher| {
            let mut seed = NO_OCCLUDER;
            bencher.iter(|| {
                for seen in &*seen {
                    let rays = seen.shadow_rays();
                    black_box(shadows.trace(traversal, setup.position, &rays, &mut seed, &mut visible));
                }
            });
        });
    }
    group.bench_function("adding light", |bencher| {
        bencher.iter(|| {
            for Seen { surfaces, rays, .. } in &mut *seen {
                add_light(&kernels, &setup.light, rays, surfaces);
            }
        });
    });
}

fn kernels(criterion: &mut Criterion) {
    let setup = Setup::new();
    for kernels in Isa::available().filter_map(Kernels::for_isa) {
        let traversal = Traversal::new(&setup.bvh, kernels, KernelChoice::Tile);
        let mut seen = see(&setup, &traversal);
        let mut group = criterion.benchmark_group(kernels.isa().name());
        group.sampling_mode(SamplingMode::Flat);
        primary(&mut group, &setup, &traversal, &seen);
        shadow(&mut group, &setup, &traversal, &mut seen);
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .nresamples(10_000)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600));
    targets = kernels
}
criterion_main!(benches);
