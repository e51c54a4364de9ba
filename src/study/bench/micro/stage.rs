//! What the steps work on: a scene, its tree, and what the camera sees of it, tile by tile.

use super::super::rays::{Kind, RaySet, Seen};
use crate::{
    bvh::{BuildPreset, Bvh},
    camera::{Camera, PACKET_SIDE},
    error::Result,
    kernels::{Kernels, TILE_RAYS, TileHits, TilePacket, micro::Meeting},
    scene::{Light, Scene, TriangleMesh},
    shade::{LightRays, SurfaceTable, Surfaces, light_rays},
    tile::{Order, Tile, tiles},
    trace::{KernelChoice, PacketScratch, ShadowRays, Traversal},
};

/// Side of the tiles that shadow rays are regrouped in.
const TILE: u32 = 64;
/// Packets whose meetings with the tree are taken apart: few, so that what they meet stays in the cache.
const MEETINGS: usize = 16;

/// A scene prepared for [`super::steps`]; does not depend on the instruction set.
#[derive(Debug)]
pub struct Stage {
    name: String,
    pub(super) bvh: Bvh,
    /// A tree without triangles: what is left of shadows is their regrouping.
    pub(super) nothing: Bvh,
    pub(super) table: SurfaceTable,
    pub(super) camera: Camera,
    size: [u32; 2],
    /// The last positional light and its place.
    pub(super) light: Option<(Light, [f32; 3])>,
    pub(super) patches: Vec<Patch>,
    /// A diffuse bounce of every primary ray.
    pub(super) bounces: RaySet,
}

/// A tile of the image: its packets, what they see, and the light's rays there.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    pub(super) packets: Vec<TilePacket>,
    pub(super) surfaces: Surfaces,
    pub(super) rays: LightRays,
}

impl Patch {
    pub(super) fn shadow_rays(&self) -> ShadowRays<'_> {
        let LightRays { u, v, limit, face, .. } = &self.rays;
        ShadowRays { u, v, tfar: limit, skip: &self.surfaces.prim, face }
    }

    /// Number of rays that the light may reach.
    pub(super) fn wanted(&self) -> u64 {
        self.rays.visible.iter().filter(|&&visible| visible > 0.0).count() as u64
    }
}

impl Stage {
    /// Builds the tree and looks at the scene once.
    ///
    /// # Errors
    /// [`crate::error::Error::Failed`] if the scene breaks a promise (see [`Scene::check`]) or the tree cannot be built.
    pub fn new(scene: &Scene, build: BuildPreset, size: [u32; 2]) -> Result<Stage> {
        scene.check()?;
        let place = |light: &Light| match *light {
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                Some((*light, position.to_array()))
            }
            Light::Directional { .. } => None,
        };
        let kernels = Kernels::detect();
        let bvh = Bvh::build(&scene.mesh, build)?;
        let seen = Seen::new(scene, &bvh, kernels, size);
        let mut stage = Stage {
            name: scene.name.clone(),
            bounces: RaySet::new(Kind::Diffuse, scene, &seen),
            bvh,
            nothing: Bvh::build(&TriangleMesh::default(), BuildPreset::Fast)?,
            table: SurfaceTable::new(scene),
            camera: Camera::new(&scene.camera, size[0], size[1]),
            size,
            light: scene.lights.iter().rev().find_map(place),
            patches: Vec::new(),
        };
        let [width, height] = size;
        stage.patches = tiles(width, height, TILE, Order::Hilbert)
            .into_iter()
            .map(|tile| stage.see(&kernels, tile, scene.background.to_array()))
            .collect();
        Ok(stage)
    }

    /// Name of the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Corners of the packets of the image, and how much of the image lies to the right and below.
    pub(super) fn corners(&self) -> impl Iterator<Item = ([u32; 2], [u32; 2])> {
        let [width, height] = self.size;
        corners(Tile { x: 0, y: 0, width, height })
    }

    /// Evenly spread packets and what they meet.
    pub(super) fn meetings(&self) -> Vec<Meeting<'_>> {
        let packets: Vec<&TilePacket> = self.patches.iter().flat_map(|patch| &patch.packets).collect();
        let step = packets.len().div_ceil(MEETINGS).max(1);
        let packets = packets.into_iter().skip(step / 2).step_by(step);
        packets.map(|packet| Meeting::new(self.bvh.view(), packet.clone())).collect()
    }

    fn see(&self, kernels: &Kernels, tile: Tile, background: [f32; 3]) -> Patch {
        let traversal = Traversal::new(&self.bvh, *kernels, KernelChoice::Tile);
        let mut six = Box::new(std::array::from_fn(|_| TilePacket::new()));
        let (mut hits, mut scratch) = (TileHits::new(), PacketScratch::new());
        let (mut packets, mut surfaces, mut rays) = (Vec::new(), Surfaces::default(), LightRays::default());
        surfaces.reset((TILE * TILE) as usize / TILE_RAYS, background);
        for (index, (at, inside)) in corners(tile).enumerate() {
            let used = self.camera.rays(kernels, at, inside, &mut six);
            for packet in &six[..used] {
                traversal.intersect(packet, &mut scratch, &mut hits);
                surfaces.gather(kernels, &self.table, index, packet, &hits);
                packets.push(packet.clone());
            }
        }
        surfaces.finish(kernels);
        if let Some((light, _)) = &self.light {
            light_rays(kernels, &self.table, &surfaces, light, &mut rays);
        }
        Patch { packets, surfaces, rays }
    }
}

fn corners(tile: Tile) -> impl Iterator<Item = ([u32; 2], [u32; 2])> {
    let along = |length: u32| (0..length).step_by(PACKET_SIDE as usize);
    along(tile.height).flat_map(move |y| {
        along(tile.width).map(move |x| ([tile.x + x, tile.y + y], [tile.width - x, tile.height - y]))
    })
}
