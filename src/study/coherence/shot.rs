//! A picture about to be taken: all primary rays, what they hit, and all shadow rays, so that passes over them differ
//! in nothing but order and early termination.

use crate::{
    bvh::Bvh,
    camera::{Camera, PACKET_SIDE, pixel_of},
    film::Film,
    kernels::{BvhView, Face, Hit, Kernels, MISS, Ray, SUB, TILE_RAYS, TileHits, TilePacket},
    scene::{CameraDescription, Light, Scene},
    shade::{LightRays, SurfaceTable, Surfaces, add_light, light_rays},
    tile::Tile,
    trace::{KernelChoice, PacketScratch, Traversal},
};
use glam::Vec3;

/// Which shadow rays there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadowRays {
    /// From each surface to each light, as in the thesis.
    #[default]
    Every,
    /// From each surface to the lights that it faces, as `irt render` does.
    Facing,
}

impl ShadowRays {
    /// All choices.
    pub const ALL: [ShadowRays; 2] = [ShadowRays::Every, ShadowRays::Facing];

    /// Name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            ShadowRays::Every => "every",
            ShadowRays::Facing => "facing",
        }
    }
}

/// A scene seen by a camera, ready to be traced.
pub struct Shot<'a> {
    scene: &'a Scene,
    pub(super) kernels: Kernels,
    pub(super) tree: BvhView<'a>,
    pub(super) size: [u32; 2],
    /// By pixel, row by row.
    pub(super) primary: Vec<Ray>,
    /// What the tile kernel finds, by pixel.
    pub(super) hits: Vec<Hit>,
    /// By light, then pixel; `None` where there is no ray.
    shadow: Vec<LightRays>,
    which: ShadowRays,
    surfaces: Surfaces,
}

impl<'a> Shot<'a> {
    /// Prepares a view of the scene.
    pub fn new(
        scene: &'a Scene,
        camera: &CameraDescription,
        bvh: &'a Bvh,
        table: &SurfaceTable,
        kernels: Kernels,
        size: [u32; 2],
        which: ShadowRays,
    ) -> Shot<'a> {
        let [width, height] = size;
        let camera = Camera::new(camera, width, height);
        let traversal = Traversal::new(bvh, kernels, KernelChoice::Tile);
        let nothing = Ray { org: [0.0; 3], dir: [0.0; 3], tnear: 0.0, tfar: 0.0, skip: MISS };
        let pixels = width as usize * height as usize;
        let (mut primary, mut hits) = (vec![nothing; pixels], vec![Hit::MISS; pixels]);
        let mut surfaces = Surfaces::default();
        let packets = width.div_ceil(PACKET_SIDE) * height.div_ceil(PACKET_SIDE);
        surfaces.reset(packets as usize, scene.background.to_array());
        let mut six = Box::new(std::array::from_fn(|_| TilePacket::new()));
        let (mut found, mut scratch) = (TileHits::new(), PacketScratch::new());
        for index in 0..packets {
            let columns = width.div_ceil(PACKET_SIDE);
            let at = [index % columns * PACKET_SIDE, index / columns * PACKET_SIDE];
            let used = camera.rays(&kernels, at, [width - at[0], height - at[1]], &mut six);
            for packet in &six[..used] {
                traversal.intersect(packet, &mut scratch, &mut found);
                surfaces.gather(&kernels, table, index as usize, packet, &found);
                for ray in (0..TILE_RAYS).filter(|ray| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0) {
                    let (x, y) = pixel_of(ray);
                    let pixel = ((at[1] + y) * width + at[0] + x) as usize;
                    (primary[pixel], hits[pixel]) = (packet.ray(ray), found.hit(ray));
                }
            }
        }
        surfaces.finish(&kernels);
        let rays = |light| {
            let mut rays = LightRays::default();
            light_rays(&kernels, table, &surfaces, light, &mut rays);
            rays
        };
        let shadow = scene.lights.iter().map(rays).collect();
        Shot { scene, kernels, tree: bvh.view(), size, primary, hits, shadow, which, surfaces }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.primary.len()
    }

    /// Number of lights.
    pub fn lights(&self) -> usize {
        self.shadow.len()
    }

    /// Whether shadow rays of a light start at the surface.
    pub(super) fn from_surface(&self, light: usize) -> bool {
        matches!(self.scene.lights[light], Light::Directional { .. })
    }

    /// The shadow ray between a pixel's surface and a light; `None` if there is none.
    pub(super) fn shadow_ray(&self, pixel: usize, light: usize) -> Option<Ray> {
        let hit = &self.hits[pixel];
        if hit.prim == MISS {
            return None;
        }
        let (rays, i) = (&self.shadow[light], self.stream(pixel));
        let facing = rays.visible[i] > 0.0;
        match self.scene.lights[light] {
            Light::Directional { direction, .. } if facing || self.which == ShadowRays::Every => {
                Some(rays.directional_ray(&self.surfaces, i, direction))
            }
            Light::Point { position, .. } | Light::Spot { position, .. } if facing => {
                let face = Face::ALL[rays.face[i] as usize % 6];
                let dir = face.direction(rays.u[i], rays.v[i]);
                Some(Ray { org: position.to_array(), dir, tnear: 0.0, tfar: rays.limit[i], skip: hit.prim })
            }
            Light::Point { position, .. } | Light::Spot { position, .. }
                if self.which == ShadowRays::Every =>
            {
                Some(self.ray_behind(pixel, position))
            }
            _ => None,
        }
    }

    /// The ray from a light to a surface that turns its back on it. It decides nothing, so that its rounding does not
    /// matter.
    fn ray_behind(&self, pixel: usize, light: Vec3) -> Ray {
        let (ray, hit) = (&self.primary[pixel], &self.hits[pixel]);
        let point = Vec3::from(ray.org) + Vec3::from(ray.dir) * hit.t;
        let d = point - light;
        let depth = d.abs().max_element();
        let tfar = depth * (1.0 - 4.0 * f32::EPSILON);
        Ray { org: light.to_array(), dir: (d / depth).to_array(), tnear: 0.0, tfar, skip: hit.prim }
    }

    /// Index of a pixel among the surfaces: packets of 16x16 pixels row by row.
    fn stream(&self, pixel: usize) -> usize {
        let [width, _] = self.size;
        let (x, y) = (pixel as u32 % width, pixel as u32 / width);
        let packet = y / PACKET_SIDE * width.div_ceil(PACKET_SIDE) + x / PACKET_SIDE;
        packet as usize * TILE_RAYS + RAY_OF[(y % PACKET_SIDE) as usize][(x % PACKET_SIDE) as usize]
    }

    /// The image if these shadow rays are blocked: by pixel, then light.
    ///
    /// # Panics
    /// If there are not as many as pixels times lights.
    pub fn image(&self, blocked: &[bool]) -> Film {
        let lights = self.lights();
        assert_eq!(blocked.len(), self.pixels() * lights, "one truth for each pixel and light");
        let mut surfaces = self.surfaces.clone();
        for (index, light) in self.scene.lights.iter().enumerate() {
            let mut rays = self.shadow[index].clone();
            for pixel in (0..self.pixels()).filter(|pixel| blocked[pixel * lights + index]) {
                rays.visible[self.stream(pixel)] = 0.0;
            }
            add_light(&self.kernels, light, &rays, &mut surfaces);
        }
        let [width, height] = self.size;
        let film = Film::new(width, height);
        let planes = surfaces
            .color
            .each_ref()
            .map(|plane| (0..self.pixels()).map(|pixel| plane[self.stream(pixel)]).collect::<Vec<f32>>());
        film.write_tile(Tile { x: 0, y: 0, width, height }, &planes[0], &planes[1], &planes[2]);
        film
    }
}

/// The ray of a packet that belongs to each of its pixels, by row and column.
const RAY_OF: [[usize; PACKET_SIDE as usize]; PACKET_SIDE as usize] = {
    let mut rays = [[0; PACKET_SIDE as usize]; PACKET_SIDE as usize];
    let mut ray = 0;
    while ray < TILE_RAYS {
        let (x, y) = pixel_of(ray);
        rays[y as usize][x as usize] = ray;
        ray += 1;
    }
    rays
};
