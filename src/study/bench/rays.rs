//! The rays to trace: primary rays of a camera, and the rays that start where those hit.
//!
//! All kinds come in the order of the image: tiles of 64x64 pixels along a Hilbert curve, packets of 16x16 pixels in
//! them, blocks of 4x4 pixels in those.

use crate::{
    bvh::Bvh,
    camera::Camera,
    kernels::{Face, Kernels, MISS, Ray, RayBlock, SUB, TILE_RAYS, TileHits, TilePacket},
    math::hash_unit,
    scene::{Light, Scene},
    tile::{Order, tiles},
    trace::{KernelChoice, PacketScratch, ShadowRays, Traversal},
};
use glam::Vec3;
use std::{fmt, str::FromStr};

/// Kinds of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From the camera.
    Primary,
    /// From each positional light to every hit point that faces it.
    Shadow,
    /// One mirror reflection of every primary hit.
    Mirror,
    /// One cosine-distributed bounce of every primary hit.
    Diffuse,
    /// From every hit point that faces it towards one directional light.
    CommonDirection,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 5] =
        [Kind::Primary, Kind::Shadow, Kind::Mirror, Kind::Diffuse, Kind::CommonDirection];

    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Primary => "primary",
            Kind::Shadow => "shadow",
            Kind::Mirror => "mirror",
            Kind::Diffuse => "diffuse",
            Kind::CommonDirection => "common-direction",
        }
    }

    /// True if only the existence of a hit is asked for.
    pub fn occlusion(self) -> bool {
        matches!(self, Kind::Shadow | Kind::CommonDirection)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Kind {
    type Err = String;

    fn from_str(text: &str) -> Result<Kind, String> {
        Kind::ALL.into_iter().find(|kind| kind.name() == text).ok_or_else(|| {
            format!("unknown kind of rays '{text}'; use primary, shadow, mirror, diffuse or common-direction")
        })
    }
}

/// Rays start this far above a surface and end this far below it, as a fraction of their length or of the distance
/// to the viewer: other engines cannot leave out the surface itself.
const OFFSET: f32 = 1.0e-4;

/// Pixels along one side of the tiles that shadow streams are made of.
const STREAM: u32 = 128;

/// What the camera sees.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    packets: Vec<TilePacket>,
    /// Hits of each packet.
    surfaces: Vec<Option<Surface>>,
}

#[derive(Clone, Copy, Debug)]
struct Surface {
    point: Vec3,
    /// Towards the viewer, unit length.
    normal: Vec3,
    /// From the viewer, unnormalised.
    direction: Vec3,
    /// To the viewer.
    distance: f32,
}

impl Seen {
    /// Traces the primary rays of the scene's camera.
    pub fn new(scene: &Scene, bvh: &Bvh, kernels: Kernels, [width, height]: [u32; 2]) -> Seen {
        let camera = Camera::new(&scene.camera, width, height);
        let traversal = Traversal::new(bvh, kernels, KernelChoice::Tile);
        let mut seen = Seen::default();
        let mut six = Box::new(std::array::from_fn(|_| TilePacket::new()));
        let mut hits = TileHits::new();
        let mut scratch = PacketScratch::new();
        for tile in tiles(width, height, STREAM, Order::Hilbert) {
            for y in (0..tile.height).step_by(16) {
                for x in (0..tile.width).step_by(16) {
                    let inside = [tile.width - x, tile.height - y];
                    let used = camera.rays(&kernels, [tile.x + x, tile.y + y], inside, &mut six);
                    for packet in &six[..used] {
                        traversal.intersect(packet, &mut scratch, &mut hits);
                        seen.packets.push(packet.clone());
                        seen.surfaces.extend((0..TILE_RAYS).map(|ray| surface(scene, packet, &hits, ray)));
                    }
                }
            }
        }
        seen
    }
}

fn active(packet: &TilePacket, ray: usize) -> bool {
    packet.active[ray / SUB] >> (ray % SUB) & 1 != 0
}

fn surface(scene: &Scene, packet: &TilePacket, hits: &TileHits, ray: usize) -> Option<Surface> {
    let prim = hits.prim[ray];
    if !active(packet, ray) || prim == MISS {
        return None;
    }
    let Ray { org, dir, .. } = packet.ray(ray);
    let direction = Vec3::from_array(dir);
    let point = Vec3::from_array(org) + hits.t[ray] * direction;
    let [a, b, c] = scene.mesh.corners(prim as usize);
    let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
    let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
    Some(Surface { point, normal, direction, distance: hits.t[ray] * direction.length() })
}

/// Rays of one kind, in the forms that engines take.
#[derive(Clone, Debug)]
pub struct RaySet {
    kind: Kind,
    /// All rays, one by one.
    rays: Vec<Ray>,
    /// All rays, 16 at a time.
    blocks: Vec<RayBlock>,
    /// Primary rays as packets.
    packets: Vec<TilePacket>,
    /// Shadow rays as streams.
    streams: Vec<Stream>,
}

/// Rays from one light to the points of one tile.
#[derive(Clone, Debug, Default)]
pub(super) struct Stream {
    pub(super) light: usize,
    pub(super) origin: [f32; 3],
    u: Vec<f32>,
    v: Vec<f32>,
    tfar: Vec<f32>,
    skip: Vec<u32>,
    face: Vec<u32>,
}

impl RaySet {
    /// The rays of `kind` for what the camera sees.
    pub fn new(kind: Kind, scene: &Scene, seen: &Seen) -> RaySet {
        let mut set =
            RaySet { kind, rays: Vec::new(), blocks: Vec::new(), packets: Vec::new(), streams: Vec::new() };
        match kind {
            Kind::Primary => {
                set.packets = seen.packets.clone();
                set.rays = seen.packets.iter().flat_map(packet_rays).collect();
            }
            Kind::Shadow => {
                set.streams = streams(scene, seen);
                set.rays = set.streams.iter().flat_map(Stream::rays).collect();
            }
            Kind::Mirror => set.rays = bounces(seen, |surface, _| mirror(surface)),
            Kind::Diffuse => set.rays = bounces(seen, cosine),
            Kind::CommonDirection => {
                let light = Vec3::new(0.3, 0.9, 0.2).normalize();
                set.rays = bounces(
                    seen,
                    |surface, _| if surface.normal.dot(light) > 0.0 { light } else { Vec3::ZERO },
                );
            }
        }
        RayBlock::pack(set.rays.iter(), &mut set.blocks);
        set
    }

    /// Kind of the rays.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Number of rays.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    /// True if there is no ray.
    pub fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// The rays one by one.
    pub fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// The rays 16 at a time, in the same order.
    pub fn blocks(&self) -> &[RayBlock] {
        &self.blocks
    }

    pub(super) fn packets(&self) -> &[TilePacket] {
        &self.packets
    }

    pub(super) fn streams(&self) -> &[Stream] {
        &self.streams
    }
}

fn packet_rays(packet: &TilePacket) -> impl Iterator<Item = Ray> + '_ {
    (0..TILE_RAYS).filter(|&ray| active(packet, ray)).map(|ray| packet.ray(ray))
}

/// One ray for each surface, in a direction that may depend on a counter; none where that is zero.
fn bounces(seen: &Seen, direction: impl Fn(&Surface, u64) -> Vec3) -> Vec<Ray> {
    let ray = |(index, surface): (usize, &Option<Surface>)| {
        let surface = surface.as_ref()?;
        let dir = direction(surface, index as u64);
        let org = surface.point + surface.normal * (OFFSET * surface.distance);
        (dir != Vec3::ZERO).then(|| Ray {
            org: org.to_array(),
            dir: dir.to_array(),
            tnear: 0.0,
            tfar: f32::INFINITY,
            skip: MISS,
        })
    };
    seen.surfaces.iter().enumerate().filter_map(ray).collect()
}

fn mirror(surface: &Surface) -> Vec3 {
    let d = surface.direction.normalize();
    d - 2.0 * d.dot(surface.normal) * surface.normal
}

fn cosine(surface: &Surface, index: u64) -> Vec3 {
    // A point on the unit sphere, moved by the normal, is cosine-distributed around it.
    let z = 2.0 * hash_unit(index, 0) - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * hash_unit(index, 1)).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    (surface.normal + 0.999 * Vec3::new(r * cos, r * sin, z)).normalize_or_zero()
}

fn streams(scene: &Scene, seen: &Seen) -> Vec<Stream> {
    let mut streams = Vec::new();
    let tile = (STREAM * STREAM) as usize;
    for (index, light) in scene.lights.iter().enumerate() {
        let (Light::Point { position, .. } | Light::Spot { position, .. }) = *light else { continue };
        for surfaces in seen.surfaces.chunks(tile) {
            let mut stream = Stream { light: index, origin: position.to_array(), ..Stream::default() };
            for surface in surfaces {
                stream.push(surface.as_ref(), position);
            }
            streams.push(stream);
        }
    }
    streams
}

impl Stream {
    fn push(&mut self, surface: Option<&Surface>, light: Vec3) {
        let wanted = surface.map(|s| (s.point - light, s.normal)).filter(|(d, n)| d.dot(*n) < 0.0);
        let (u, v, tfar, face) = match wanted {
            None => (0.0, 0.0, 1.0, 6),
            Some((d, _)) => {
                let depth = d.abs().max_element();
                let slopes = (d / depth).to_array();
                let face = Face::of(slopes);
                let [iu, iv, _] = face.axes();
                (slopes[iu], slopes[iv], depth * (1.0 - OFFSET), face.index() as u32)
            }
        };
        self.u.push(u);
        self.v.push(v);
        self.tfar.push(tfar);
        self.skip.push(MISS);
        self.face.push(face);
    }

    pub(super) fn len(&self) -> usize {
        self.u.len()
    }

    pub(super) fn view(&self) -> ShadowRays<'_> {
        ShadowRays { u: &self.u, v: &self.v, tfar: &self.tfar, skip: &self.skip, face: &self.face }
    }

    fn rays(&self) -> impl Iterator<Item = Ray> + '_ {
        (0..self.len()).filter(|&i| self.face[i] < 6).map(|i| Ray {
            org: self.origin,
            dir: Face::ALL[self.face[i] as usize].direction(self.u[i], self.v[i]),
            tnear: 0.0,
            tfar: self.tfar[i],
            skip: MISS,
        })
    }
}
