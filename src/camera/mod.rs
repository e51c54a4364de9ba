//! The pinhole camera: from pixels to rays.
//!
//! A primary ray is the slopes of its direction about its own dominant axis: direction / (greatest component), so
//! that one component is exactly 1 or -1. Every kernel traces exactly that direction, which is why the image does not
//! depend on how pixels are grouped. The arithmetic is plain `*`, `+` and `/` in f32, in one order.

use crate::{
    kernels::{F32, Face, I32, Kernel, Kernels, Lanes, MISS, Ray, SUB, SUBS, Simd, TILE_RAYS, TilePacket},
    scene::CameraDescription,
};
use glam::Vec3;

/// A pinhole camera for one image size.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Position of the pinhole.
    pub eye: Vec3,
    /// Direction through the centre of pixel (0, 0), unnormalised.
    corner: Vec3,
    /// Change of direction per pixel to the right and per pixel down.
    step: [Vec3; 2],
    /// Which pixels of the image are asked for: see [`Camera::every`].
    first: [u32; 2],
    spacing: u32,
}

/// Pixels along one side of a tile packet.
pub const PACKET_SIDE: u32 = 16;
/// Pixels along one side of a sub-packet.
const SUB_SIDE: usize = 4;

/// Pixel offset of a ray within its packet: sub-packets are 4x4 pixels, row by row, and so are their rays.
///
/// ```text
///   sub-packets   0  1  2  3        rays of each    0  1  2  3
///                 4  5  6  7                        4  5  6  7
///                 8  9 10 11                        8  9 10 11
///                12 13 14 15                       12 13 14 15
/// ```
pub const fn pixel_of(ray: usize) -> (u32, u32) {
    let (sub, lane) = (ray / SUB, ray % SUB);
    let x = sub % SUB_SIDE * SUB_SIDE + lane % SUB_SIDE;
    let y = sub / SUB_SIDE * SUB_SIDE + lane / SUB_SIDE;
    (x as u32, y as u32)
}

/// Offsets of all rays of a packet, by ray.
const OFFSETS: [[f32; TILE_RAYS]; 2] = {
    let mut offsets = [[0.0; TILE_RAYS]; 2];
    let mut ray = 0;
    while ray < TILE_RAYS {
        let (x, y) = pixel_of(ray);
        offsets[0][ray] = x as f32;
        offsets[1][ray] = y as f32;
        ray += 1;
    }
    offsets
};

impl Camera {
    /// A camera for an image of `width` x `height` pixels. The description must be valid (see
    /// [`CameraDescription`]): eye and at differ, up is not parallel to the viewing direction.
    pub fn new(description: &CameraDescription, width: u32, height: u32) -> Camera {
        let forward = (description.at - description.eye).normalize();
        let right = forward.cross(description.up).normalize();
        let up = right.cross(forward);
        let half = (0.5 * description.fov_deg.to_radians()).tan();
        let pixel = 2.0 * half / height as f32;
        let step = [right * pixel, up * -pixel];
        let corner =
            forward - step[0] * (0.5 * (width as f32 - 1.0)) - step[1] * (0.5 * (height as f32 - 1.0));
        Camera { eye: description.eye, corner, step, first: [0; 2], spacing: 1 }
    }

    /// The camera that takes only every `spacing`-th pixel of the image in each direction, from `first` on: its pixel
    /// (x, y) is pixel `first + spacing * (x, y)` of this one, bit by bit the same ray. `spacing` >= 1.
    pub fn every(&self, first: [u32; 2], spacing: u32) -> Camera {
        Camera { first: self.image_pixel(first), spacing: self.spacing * spacing, ..*self }
    }

    /// The camera whose pixels lie half a pixel to the right and below: through the lower right corners of this one's.
    pub fn of_corners(&self) -> Camera {
        Camera { corner: self.corner + (self.step[0] + self.step[1]) * 0.5, ..*self }
    }

    /// Where a pixel that is asked for lies in the image.
    pub fn image_pixel(&self, [x, y]: [u32; 2]) -> [u32; 2] {
        [self.first[0] + self.spacing * x, self.first[1] + self.spacing * y]
    }

    /// Unnormalised direction through the centre of a pixel.
    pub fn direction(&self, x: u32, y: u32) -> Vec3 {
        let [x, y] = self.image_pixel([x, y]);
        self.corner + self.step[0] * x as f32 + self.step[1] * y as f32
    }

    /// Growth of the width of a pixel per unit of distance, in the middle of the image.
    pub fn spread(&self) -> f32 {
        self.step[0].length()
    }

    /// The ray through the place (x, y) of the image, in pixels from the centre of pixel (0, 0), that goes through `lens` (of
    /// the unit disc) of a lens of radius `aperture` that is in focus at the distance `focus`; of length 1.
    pub fn lens_ray(&self, [x, y]: [f32; 2], lens: [f32; 2], aperture: f32, focus: f32) -> Ray {
        let [right, up] = self.step.map(|step| step / step.length());
        let offset = (right * lens[0] + up * lens[1]) * aperture;
        let at = self.corner + self.step[0] * x + self.step[1] * y;
        let dir = (at * focus - offset).normalize();
        let org = (self.eye + offset).to_array();
        Ray { org, dir: dir.to_array(), tnear: 0.0, tfar: f32::INFINITY, skip: MISS }
    }

    /// The primary rays of the 16x16 pixels at (x, y); only the first `width` x `height` of them take part. Rays are
    /// grouped by face: nearly always all go into `packets[0]`, and the number of packets used is returned.
    pub fn rays(
        &self,
        kernels: &Kernels,
        [x, y]: [u32; 2],
        [width, height]: [u32; 2],
        packets: &mut [TilePacket; 6],
    ) -> usize {
        let wanted = within(width, height);
        if self.spacing == 1 {
            return self.jittered_rays(kernels, self.image_pixel([x, y]), wanted, &OFFSETS, packets);
        }
        // Whole numbers far below 2^24: exact, so that these are the rays of the whole image.
        let places = OFFSETS.map(|axis| axis.map(|offset| offset * self.spacing as f32));
        self.jittered_rays(kernels, self.image_pixel([x, y]), wanted, &places, packets)
    }

    /// Rays through any places of the image: `places` has them, by axis and ray, in pixels from the centre of pixel (x, y); see
    /// [`pixel_of`]. Only those that are `wanted` take part: a bit for each ray of a sub-packet.
    pub fn jittered_rays(
        &self,
        kernels: &Kernels,
        [x, y]: [u32; 2],
        wanted: [u16; SUBS],
        places: &[[f32; TILE_RAYS]; 2],
        packets: &mut [TilePacket; 6],
    ) -> usize {
        let at = [x as f32, y as f32];
        let mut left = wanted;
        let mut used = 0;
        // The face of the first ray first: mostly it is that of all.
        let first = self.face([0, 1].map(|axis| at[axis] + places[axis][0]));
        let mut others = Face::ALL.into_iter().filter(|&other| other != first);
        let mut face = first;
        while left != [0; SUBS] {
            let packet = &mut packets[used];
            kernels.run(Directions { camera: self, places, at, face, packet });
            let mut any = 0;
            for ((active, wanted), left) in packet.active.iter_mut().zip(&wanted).zip(&mut left) {
                *active &= wanted;
                *left &= !*active;
                any |= *active;
            }
            if any != 0 {
                packet.bounded = false;
                packet.org = self.eye.to_array();
                packet.face = face;
                used += 1;
            }
            match others.next() {
                Some(other) => face = other,
                None => break,
            }
        }
        used
    }

    /// The face of the ray through one pixel; rounding may make it a neighbouring one.
    fn face(&self, [x, y]: [f32; 2]) -> Face {
        Face::of((self.corner + self.step[0] * x + self.step[1] * y).to_array())
    }
}

/// Rays whose pixels lie within the first `width` x `height` of the packet.
fn within(width: u32, height: u32) -> [u16; SUBS] {
    let mut active = [0; SUBS];
    if width >= PACKET_SIDE && height >= PACKET_SIDE {
        return [u16::MAX; SUBS];
    }
    for ray in 0..TILE_RAYS {
        let (x, y) = pixel_of(ray);
        if x < width && y < height {
            active[ray / SUB] |= 1 << (ray % SUB);
        }
    }
    active
}

/// Puts the slopes of 256 pixels into a packet, and which of them are of one face into its active rays.
struct Directions<'a> {
    camera: &'a Camera,
    places: &'a [[f32; TILE_RAYS]; 2],
    at: [f32; 2],
    face: Face,
    packet: &'a mut TilePacket,
}

impl Kernel for Directions<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Directions { camera, places, at, face, packet } = self;
        let [iu, iv, _] = face.axes();
        let wanted = I32::splat(s, face.index() as u32);
        for sub in 0..SUBS {
            let first = sub * SUB;
            let x = F32::<S, 16>::load_at(s, &places[0], first) + F32::splat(s, at[0]);
            let y = F32::load_at(s, &places[1], first) + F32::splat(s, at[1]);
            let mut dir = [x; 3];
            for k in 0..3 {
                dir[k] = F32::splat(s, camera.corner[k])
                    + F32::splat(s, camera.step[0][k]) * x
                    + F32::splat(s, camera.step[1][k]) * y;
            }
            let (slopes, faces) = slopes(s, dir);
            slopes[iu].store_at(&mut packet.u, first);
            slopes[iv].store_at(&mut packet.v, first);
            packet.active[sub] = faces.eq(wanted).bits() as u16;
        }
    }
}

/// Directions divided by their component of greatest magnitude, which becomes exactly 1 or -1, and the index of their
/// [`Face`], which is judged after the division: another component may have become 1 as well.
#[inline(always)]
pub(crate) fn slopes<S: Lanes<W>, const W: usize>(s: S, dir: [F32<S, W>; 3]) -> ([F32<S, W>; 3], I32<S, W>) {
    let greatest = dir[0].abs().max(dir[1].abs()).max(dir[2].abs());
    let slopes = [dir[0] / greatest, dir[1] / greatest, dir[2] / greatest];
    let one = I32::splat(s, 1.0f32.to_bits());
    let is_x = slopes[0].abs().bits().eq(one);
    let is_y = slopes[1].abs().bits().eq(one);
    let dominant = is_x.select(slopes[0], is_y.select(slopes[1], slopes[2]));
    let axis = is_x.iselect(I32::splat(s, 0), is_y.iselect(I32::splat(s, 2), I32::splat(s, 4)));
    (slopes, axis + dominant.bits().shr::<31>())
}
