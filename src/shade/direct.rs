//! Direct light: which surfaces a light could reach, and what it adds to those it does.

use super::{
    surface::{NO_FACE, Planes, Surfaces, dot, load3, splat3, store3},
    table::{ROUNDING, SurfaceTable},
};
use crate::{
    camera::slopes,
    kernels::{F32, I32, Kernel, Kernels, MISS, Mask, NodeRef, Ray, RayBlock, SUB, Simd},
    scene::{Falloff, Light},
    shade::power::power,
    trace::{PointShadows, ShadowRays, Traced, Traversal, rays_in},
};
use glam::Vec3;

/// The shadow rays of one light for a stream of surfaces, and what came of them.
#[derive(Clone, Debug, Default)]
pub struct LightRays {
    /// Slopes from the light (positional lights).
    pub u: Vec<f32>,
    /// Slopes from the light (positional lights).
    pub v: Vec<f32>,
    /// Depth of the surface (positional lights).
    pub limit: Vec<f32>,
    /// How far the ray's end is moved off the surface along its normal (directional lights).
    lift: f32,
    /// Face as seen from the light; 6 where the surface cannot be lit.
    pub face: Vec<u32>,
    /// The triangle that the ray leaves out: the surface's, unless the light shines from below it.
    skip: Vec<u32>,
    /// 1 where the light may reach the surface, 0 where it cannot or is blocked.
    pub visible: Vec<f32>,
}

impl LightRays {
    fn resize(&mut self, len: usize) {
        for plane in [&mut self.u, &mut self.v, &mut self.limit, &mut self.visible] {
            plane.resize(len, 0.0);
        }
        self.face.resize(len, NO_FACE);
        self.skip.resize(len, MISS);
    }

    /// The ray from the surface of ray `i` towards a directional light that shines along `direction`.
    pub fn directional_ray(&self, surfaces: &Surfaces, i: usize, direction: Vec3) -> Ray {
        self.directional_ray_from(&surfaces.point, surfaces, i, direction)
    }

    fn directional_ray_from(&self, points: &Planes, surfaces: &Surfaces, i: usize, direction: Vec3) -> Ray {
        let org = [0, 1, 2].map(|k| points[k][i] + surfaces.ng[k][i] * self.lift);
        Ray { org, dir: (-direction).to_array(), tnear: 0.0, tfar: f32::INFINITY, skip: self.skip[i] }
    }

    /// The same for all surfaces that may be lit, sixteen to a block; lane = surface.
    pub fn directional_blocks(&self, surfaces: &Surfaces, direction: Vec3, blocks: &mut Vec<RayBlock>) {
        self.blocks(blocks, |i| self.directional_ray(surfaces, i, direction));
    }

    /// Traces the shadow rays of a light at `origin`, beginning with what blocked the last ones.
    pub fn trace_from(
        &mut self,
        traversal: &Traversal,
        origin: Vec3,
        shadows: &mut PointShadows,
        seed: &mut NodeRef,
    ) -> Traced {
        let LightRays { u, v, limit, face, skip, visible, .. } = self;
        let rays = ShadowRays { u, v, tfar: limit, skip, face };
        shadows.trace(traversal, origin.to_array(), &rays, seed, visible)
    }

    /// Traces rays to the light that [`LightRays::directional_blocks`] made, with `occluded`, which marks blocked rays in its
    /// second argument and returns how many pairs exact arithmetic decided.
    pub fn trace_blocks(
        &mut self,
        blocks: &[RayBlock],
        blocked: &mut Vec<u16>,
        occluded: impl FnOnce(&[RayBlock], &mut [u16]) -> u64,
    ) -> Traced {
        blocked.clear();
        blocked.resize(blocks.len(), 0);
        let doubts = occluded(blocks, blocked);
        self.block(blocked);
        Traced { rays: rays_in(blocks), doubts }
    }

    /// Rays from all surfaces that may be lit to any light: from `points` to a directional light, which are lifted off the
    /// surface, or from `starts`, which are off it already, to another.
    pub(super) fn towards(
        &self,
        light: &Light,
        surfaces: &Surfaces,
        [points, starts]: [&Planes; 2],
        blocks: &mut Vec<RayBlock>,
    ) {
        self.blocks(blocks, |i| match *light {
            Light::Directional { direction, .. } => self.directional_ray_from(points, surfaces, i, direction),
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                let org = [0, 1, 2].map(|k| starts[k][i]);
                let dir = [0, 1, 2].map(|k| position[k] - org[k]);
                Ray { org, dir, tnear: 0.0, tfar: 1.0, skip: self.skip[i] }
            }
        });
    }

    fn blocks(&self, blocks: &mut Vec<RayBlock>, ray: impl Fn(usize) -> Ray) {
        blocks.resize(self.visible.len() / SUB, RayBlock::EMPTY);
        for (index, block) in blocks.iter_mut().enumerate() {
            block.active = 0;
            for lane in 0..SUB {
                let i = index * SUB + lane;
                if self.visible[i] > 0.0 {
                    block.set(lane, &ray(i));
                }
            }
        }
    }

    /// Takes note of surfaces that nothing reaches: bits by block of sixteen.
    fn block(&mut self, blocked: &[u16]) {
        for (index, blocked) in blocked.iter().enumerate().filter(|(_, blocked)| **blocked != 0) {
            for lane in (0..SUB).filter(|lane| blocked >> lane & 1 != 0) {
                self.visible[index * SUB + lane] = 0.0;
            }
        }
    }
}

/// Finds the surfaces that face the light and prepares their shadow rays; `visible` becomes 1 there and 0 elsewhere.
///
/// # Why a surface does not shadow itself
///
/// The triangle itself does not count for its own shadow rays. Its neighbours in the same plane do, and a hit point
/// lies off that plane by at most `point_error` in each coordinate: the rounding of the coordinates involved, not an
/// epsilon of scene size. So the ray ends at the point moved off the surface by `point_error * |n|` (|.| the 1-norm)
/// along the normal, however grazing the light; the error of a ray from a light grows with its length.
pub fn light_rays(
    kernels: &Kernels,
    table: &SurfaceTable,
    surfaces: &Surfaces,
    light: &Light,
    rays: &mut LightRays,
) {
    light_rays_to(kernels, table, surfaces, [&surfaces.point, &surfaces.ng], light, rays);
}

/// The same for rays that end at `points`, somewhere above the surfaces, from lights above the planes there that have the
/// normals `horizon`.
pub(super) fn light_rays_to(
    kernels: &Kernels,
    table: &SurfaceTable,
    surfaces: &Surfaces,
    [points, horizon]: [&Planes; 2],
    light: &Light,
    rays: &mut LightRays,
) {
    rays.resize(surfaces.len());
    match *light {
        Light::Point { position, .. } | Light::Spot { position, .. } => {
            let error = table.point_error + ROUNDING * position.abs().max_element();
            kernels.run(FromPoint { surfaces, points, horizon, position, error, rays });
        }
        Light::Directional { direction, .. } => {
            // The 1-norm of a unit vector is at most the square root of three.
            rays.lift = 1.75 * table.point_error;
            kernels.run(FromDirection { surfaces, horizon, direction, rays });
        }
    }
}

struct FromPoint<'a> {
    surfaces: &'a Surfaces,
    points: &'a Planes,
    horizon: &'a Planes,
    position: Vec3,
    error: f32,
    rays: &'a mut LightRays,
}

impl Kernel for FromPoint<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let (surfaces, rays) = (self.surfaces, self.rays);
        let light = splat3::<S>(s, self.position);
        let one = F32::splat(s, 1.0);
        let shorten = F32::splat(s, 1.0 - 2.0 * f32::EPSILON);
        for at in (0..surfaces.len()).step_by(16) {
            let point = load3(s, self.points, at);
            let ng = load3(s, &surfaces.ng, at);
            let d = [point[0] - light[0], point[1] - light[1], point[2] - light[2]];
            let facing = faces(s, surfaces, self.horizon, at, d, &mut rays.skip);
            let depth = d[0].abs().max(d[1].abs()).max(d[2].abs());
            let norm = ng[0].abs() + ng[1].abs() + ng[2].abs();
            let lift = (F32::splat(s, self.error) + F32::splat(s, ROUNDING) * depth) * norm;
            let d = [d[0] + ng[0] * lift, d[1] + ng[1] * lift, d[2] + ng[2] * lift];
            let (slopes, face) = slopes(s, d);
            let depth = d[0].abs().max(d[1].abs()).max(d[2].abs());
            (depth * shorten).store_at(&mut rays.limit, at);

            // u and v are the slopes along the two axes after the dominant one.
            let axis = face.shr::<1>();
            let is_x = axis.eq(I32::splat(s, 0));
            let is_y = axis.eq(I32::splat(s, 1));
            is_x.select(slopes[1], is_y.select(slopes[2], slopes[0])).store_at(&mut rays.u, at);
            is_x.select(slopes[2], is_y.select(slopes[0], slopes[1])).store_at(&mut rays.v, at);
            facing.select(one, F32::splat(s, 0.0)).store_at(&mut rays.visible, at);
            let faces: &mut [u32; 16] = (&mut rays.face[at..at + 16]).try_into().expect("16 lanes");
            facing.iselect(face, I32::splat(s, NO_FACE)).store(faces);
        }
    }
}

struct FromDirection<'a> {
    surfaces: &'a Surfaces,
    horizon: &'a Planes,
    direction: Vec3,
    rays: &'a mut LightRays,
}

impl Kernel for FromDirection<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let (surfaces, rays) = (self.surfaces, self.rays);
        let d = splat3::<S>(s, self.direction);
        for at in (0..surfaces.len()).step_by(16) {
            let facing = faces(s, surfaces, self.horizon, at, d, &mut rays.skip);
            facing.select(F32::splat(s, 1.0), F32::splat(s, 0.0)).store_at(&mut rays.visible, at);
        }
    }
}

/// Lanes whose surfaces face light that shines along `d`, and what its rays leave out there.
#[inline(always)]
fn faces<S: Simd>(
    s: S,
    surfaces: &Surfaces,
    horizon: &Planes,
    at: usize,
    d: [F32<S, 16>; 3],
    skip: &mut [u32],
) -> Mask<S, 16> {
    let zero = F32::splat(s, 0.0);
    let prims: &[u32; 16] = surfaces.prim[at..at + 16].try_into().expect("16 lanes");
    let facing = hit_lanes(s, surfaces, at) & zero.lt(-dot(load3(s, horizon, at), d));
    // On a smooth surface, light may come from below the triangle, which is in its way unless it passes beside it.
    let below = facing & zero.le(dot(load3(s, &surfaces.ng, at), d));
    let skip: &mut [u32; 16] = (&mut skip[at..at + 16]).try_into().expect("16 lanes");
    below.iselect(I32::splat(s, MISS), I32::load(s, prims)).store(skip);
    facing
}

/// Lanes whose ray hit something.
#[inline(always)]
fn hit_lanes<S: Simd>(s: S, surfaces: &Surfaces, at: usize) -> Mask<S, 16> {
    let prim: &[u32; 16] = surfaces.prim[at..at + 16].try_into().expect("16 lanes");
    let missed = I32::<S, 16>::load(s, prim).eq(I32::splat(s, MISS));
    Mask::from_bits(s, !missed.bits() & 0xffff)
}

/// Adds the light to all surfaces it reaches.
pub fn add_light(kernels: &Kernels, light: &Light, rays: &LightRays, surfaces: &mut Surfaces) {
    let light = Emitter::new(light);
    kernels.run(AddLight::<false> { light, visible: &rays.visible, tint: None, surfaces });
}

/// The same for light of which `tint` is left.
pub(super) fn add_tinted_light(
    kernels: &Kernels,
    light: &Light,
    rays: &LightRays,
    tint: &Planes,
    surfaces: &mut Surfaces,
) {
    let light = Emitter::new(light);
    kernels.run(AddLight::<true> { light, visible: &rays.visible, tint: Some(tint), surfaces });
}

/// A light with everything per-frame worked out.
#[derive(Clone, Copy)]
struct Emitter {
    intensity: [f32; 3],
    /// Position, or the direction to a directional light.
    place: Vec3,
    directional: bool,
    inverse_square: bool,
    /// Axis, cosine where the cone starts to fade, cosine where it ends.
    spot: Option<(Vec3, f32, f32)>,
}

impl Emitter {
    fn new(light: &Light) -> Emitter {
        match *light {
            Light::Point { position, intensity, falloff } => Emitter {
                intensity: intensity.to_array(),
                place: position,
                directional: false,
                inverse_square: falloff == Falloff::InverseSquare,
                spot: None,
            },
            Light::Directional { direction, intensity } => Emitter {
                intensity: intensity.to_array(),
                place: -direction,
                directional: true,
                inverse_square: false,
                spot: None,
            },
            Light::Spot { position, direction, intensity, falloff, inner, outer } => Emitter {
                intensity: intensity.to_array(),
                place: position,
                directional: false,
                inverse_square: falloff == Falloff::InverseSquare,
                spot: Some((direction, inner.cos(), outer.cos())),
            },
        }
    }
}

struct AddLight<'a, const TINTED: bool> {
    light: Emitter,
    visible: &'a [f32],
    tint: Option<&'a Planes>,
    surfaces: &'a mut Surfaces,
}

impl<const TINTED: bool> Kernel for AddLight<'_, TINTED> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let AddLight { light, visible, tint, surfaces } = self;
        let zero = F32::<S, 16>::splat(s, 0.0);
        for at in (0..surfaces.len()).step_by(16) {
            let visible = F32::<S, 16>::load_at(s, visible, at);
            if zero.lt(visible).bits() == 0 {
                continue;
            }
            let (l, strength) = arriving(s, &light, surfaces, at);
            let n = load3(s, &surfaces.ns, at);
            let cosine = dot(n, l).max(zero);
            let strength = visible * strength;
            let ks = load3(s, &surfaces.ks, at);
            let kd = load3(s, &surfaces.kd, at);
            let diffuse = cosine * strength;
            let shiny = zero.lt(ks[0].max(ks[1]).max(ks[2]));
            let glossy = if shiny.bits() == 0 {
                zero
            } else {
                let lobe = highlight(s, surfaces, at, l, n);
                zero.lt(cosine).select(lobe * strength, zero)
            };
            let mut color = load3(s, &surfaces.color, at);
            for k in 0..3 {
                let mut reflected = kd[k] * diffuse + ks[k] * glossy;
                if TINTED && let Some(tint) = tint {
                    reflected = reflected * F32::load_at(s, &tint[k], at);
                }
                color[k] = color[k] + F32::splat(s, light.intensity[k]) * reflected;
            }
            store3(color, &mut surfaces.color, at);
        }
    }
}

/// Unit direction to the light and the strength with which it arrives.
#[inline(always)]
fn arriving<S: Simd>(s: S, light: &Emitter, surfaces: &Surfaces, at: usize) -> ([F32<S, 16>; 3], F32<S, 16>) {
    let place = splat3::<S>(s, light.place);
    let one = F32::splat(s, 1.0);
    if light.directional {
        return (place, one);
    }
    let point = load3(s, &surfaces.point, at);
    let d = [place[0] - point[0], place[1] - point[1], place[2] - point[2]];
    let squared = dot(d, d);
    let inverse = one / squared.sqrt();
    let l = [d[0] * inverse, d[1] * inverse, d[2] * inverse];
    let mut strength = if light.inverse_square { one / squared } else { one };
    if let Some((axis, inner, outer)) = light.spot {
        let axis = splat3::<S>(s, -axis);
        // Smoothstep from the outer to the inner angle.
        let ramp = (dot(axis, l) - F32::splat(s, outer)) / F32::splat(s, (inner - outer).max(1.0e-6));
        let ramp = ramp.max(F32::splat(s, 0.0)).min(one);
        strength = strength * ramp * ramp * (F32::splat(s, 3.0) - (ramp + ramp));
    }
    (l, strength)
}

/// The Blinn-Phong lobe: (n . h)^ns.
#[inline(always)]
pub(super) fn highlight<S: Simd>(
    s: S,
    surfaces: &Surfaces,
    at: usize,
    l: [F32<S, 16>; 3],
    n: [F32<S, 16>; 3],
) -> F32<S, 16> {
    let view = load3(s, &surfaces.view, at);
    let h = [l[0] + view[0], l[1] + view[1], l[2] + view[2]];
    let (zero, one) = (F32::splat(s, 0.0), F32::splat(s, 1.0));
    let cosine = (dot(n, h) / dot(h, h).sqrt()).max(zero).min(one);
    power(s, cosine, F32::load_at(s, &surfaces.exponent, at))
}
