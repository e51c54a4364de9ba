//! Samples of sources with an extent: a point of a light or a direction of the sky for each surface, as shadow rays.

use super::{
    ground::{Ground, lanes_hit, left_out, load3},
    wide::{self, V3},
};
use crate::{
    kernels::{F32, Kernel, Mask, RayBlock, SUB, Simd},
    scene::AreaLight,
    shade::{Surfaces, surface::Planes, table::ROUNDING, trig::sin_cos},
};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Numbers in [0, 1), two for each surface.
pub(super) type Squares = [Vec<f32>; 2];

/// Points on emitting triangles that were chosen for each surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Chosen {
    pub(super) point: Planes,
    pub(super) normal: Planes,
    /// Emission divided by density.
    pub(super) value: Planes,
}

impl Chosen {
    pub(super) fn resize(&mut self, len: usize) {
        for plane in [&mut self.point, &mut self.normal, &mut self.value].into_iter().flatten() {
            plane.resize(len, 0.0);
        }
    }
}

/// What is sampled.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Area(AreaLight),
    Triangles(&'a Chosen),
}

/// Shadow rays to one point of a source for each surface, and what arrives if nothing is in the way: irradiance before the
/// cosine at the surface, divided by pi.
pub(super) struct Connect<'a> {
    pub(super) surfaces: &'a Surfaces,
    pub(super) ground: &'a Ground,
    pub(super) source: Source<'a>,
    pub(super) squares: &'a Squares,
    /// Bound of the rounding of points of the scene, in its units.
    pub(super) error: f32,
    /// 1 / number of samples.
    pub(super) share: f32,
    pub(super) blocks: &'a mut [RayBlock],
    pub(super) arriving: &'a mut Planes,
}

/// A point of a light as a surface sees it.
struct Point<S: Simd> {
    at: V3<S>,
    normal: V3<S>,
    /// Radiance times solid angle per pi.
    value: V3<S>,
    valid: Mask<S, 16>,
}

impl Kernel for Connect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Connect { surfaces, ground, source, squares, error, share, blocks, arriving } = self;
        let zero = F32::<S, 16>::splat(s, 0.0);
        for (index, block) in blocks.iter_mut().enumerate() {
            let at = index * SUB;
            block.active = 0;
            let hit = lanes_hit(s, surfaces, at);
            if hit.bits() == 0 {
                continue;
            }
            let start = load3(s, &ground.out, at);
            let square = [F32::load_at(s, &squares[0], at), F32::load_at(s, &squares[1], at)];
            let point = match source {
                Source::Area(AreaLight::Rectangle { corner, edge_u, edge_v, radiance, two_sided }) => {
                    let normal = edge_u.cross(edge_v);
                    let area = normal.length();
                    let at = wide::add(
                        wide::splat(s, corner.to_array()),
                        wide::add(
                            wide::scale(wide::splat(s, edge_u.to_array()), square[0]),
                            wide::scale(wide::splat(s, edge_v.to_array()), square[1]),
                        ),
                    );
                    let normal = wide::splat(s, (normal / area).to_array());
                    on_plane(s, start, at, normal, wide::splat(s, (radiance * area).to_array()), two_sided)
                }
                Source::Area(AreaLight::Sphere { center, radius, radiance }) => {
                    on_sphere(s, start, center.to_array(), radius, radiance.to_array(), square)
                }
                Source::Triangles(chosen) => on_plane(
                    s,
                    start,
                    load3(s, &chosen.point, at),
                    load3(s, &chosen.normal, at),
                    load3(s, &chosen.value, at),
                    true,
                ),
            };
            // The ray ends off the light, by what rounding can amount to, so that it does not meet what lies in its plane.
            let d = wide::sub(point.at, start);
            let size = d[0].abs().max(d[1].abs()).max(d[2].abs());
            let lift = F32::splat(s, 1.75 * error) + F32::splat(s, ROUNDING) * size;
            let dir = wide::add(d, wide::scale(point.normal, lift));
            let facing = zero.lt(wide::dot(load3(s, &ground.horizon, at), dir));
            block.active = (hit & facing & point.valid).bits() as u16;
            wide::store(start, &mut block.org);
            wide::store(dir, &mut block.dir);
            zero.store(&mut block.tnear);
            F32::splat(s, 1.0).store(&mut block.tfar);
            left_out(s, surfaces, at, dir).store(&mut block.skip);
            let share = F32::splat(s, share);
            for k in 0..3 {
                (point.value[k] * share).store_at(&mut arriving[k], at);
            }
        }
    }
}

/// A point of a plane light whose radiance times area is `value`.
#[inline(always)]
fn on_plane<S: Simd>(s: S, from: V3<S>, at: V3<S>, normal: V3<S>, value: V3<S>, two_sided: bool) -> Point<S> {
    let d = wide::sub(from, at);
    let square = wide::dot(d, d);
    let cosine = wide::dot(normal, d) / square.sqrt();
    // The normal on the surface's side.
    let normal = wide::flip(normal, cosine.sign());
    let cosine = if two_sided { cosine.abs() } else { cosine };
    let factor = cosine / square * F32::splat(s, FRAC_1_PI);
    Point { at, normal, value: wide::scale(value, factor), valid: F32::splat(s, 0.0).lt(factor) }
}

/// A direction of the cone in which a sphere is seen, uniformly (P. Shirley and C. Wang, "Direct Lighting Calculation by
/// Monte Carlo Integration", 1991), as the nearer point of the sphere in it.
#[inline(always)]
fn on_sphere<S: Simd>(
    s: S,
    from: V3<S>,
    center: [f32; 3],
    radius: f32,
    radiance: [f32; 3],
    square: [F32<S, 16>; 2],
) -> Point<S> {
    let (zero, one) = (F32::splat(s, 0.0), F32::splat(s, 1.0));
    let to = wide::sub(wide::splat(s, center), from);
    let distance2 = wide::dot(to, to);
    let r2 = F32::splat(s, radius * radius);
    let sine2 = r2 / distance2;
    let outside = r2.lt(distance2);
    // 1 - cos without cancellation.
    let cone = sine2 / (one + (one - sine2).max(zero).sqrt());
    let rise = square[0] * cone;
    let cosine = one - rise;
    let sine = (rise * (one + cosine)).max(zero).sqrt();
    let [sin, cos] = sin_cos(s, square[1]);
    let axis = wide::scale(to, one / distance2.sqrt());
    let dir = wide::about(s, axis, [sine * cos, sine * sin, cosine]);
    let along = wide::dot(to, dir);
    let inside = (r2 - (distance2 - along * along)).max(zero).sqrt();
    let at = wide::add(from, wide::scale(dir, along - inside));
    let normal = wide::scale(wide::sub(at, wide::splat(s, center)), F32::splat(s, 1.0 / radius));
    let solid = cone * F32::splat(s, TAU * FRAC_1_PI);
    Point { at, normal, value: wide::scale(wide::splat(s, radiance), solid), valid: outside }
}

/// Rays in directions about the shading normals, cosine-weighted, that end at `reach`.
pub(super) struct Around<'a> {
    pub(super) surfaces: &'a Surfaces,
    pub(super) ground: &'a Ground,
    pub(super) squares: &'a Squares,
    pub(super) reach: f32,
    pub(super) blocks: &'a mut [RayBlock],
}

impl Kernel for Around<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Around { surfaces, ground, squares, reach, blocks } = self;
        for (index, block) in blocks.iter_mut().enumerate() {
            let at = index * SUB;
            let square = [F32::load_at(s, &squares[0], at), F32::load_at(s, &squares[1], at)];
            let dir = cosine_weighted(s, surfaces, square, at);
            outward(s, surfaces, ground, at, dir, reach, block);
        }
    }
}

/// Sixteen rays from surfaces, those that would leave to the other side inactive.
#[inline(always)]
pub(super) fn outward<S: Simd>(
    s: S,
    surfaces: &Surfaces,
    ground: &Ground,
    at: usize,
    dir: V3<S>,
    reach: f32,
    block: &mut RayBlock,
) {
    let up = F32::splat(s, 0.0).lt(wide::dot(load3(s, &ground.horizon, at), dir));
    block.active = (lanes_hit(s, surfaces, at) & up).bits() as u16;
    wide::store(load3(s, &ground.out, at), &mut block.org);
    wide::store(dir, &mut block.dir);
    F32::splat(s, 0.0).store(&mut block.tnear);
    F32::splat(s, reach).store(&mut block.tfar);
    left_out(s, surfaces, at, dir).store(&mut block.skip);
}

/// Unit directions about the shading normals with a density of cosine / pi, by two numbers in [0, 1).
#[inline(always)]
pub(super) fn cosine_weighted<S: Simd>(
    s: S,
    surfaces: &Surfaces,
    [u, v]: [F32<S, 16>; 2],
    at: usize,
) -> V3<S> {
    let one = F32::<S, 16>::splat(s, 1.0);
    let [sin, cos] = sin_cos(s, v);
    let radius = u.sqrt();
    wide::about(s, load3(s, &surfaces.ns, at), [radius * cos, radius * sin, (one - u).sqrt()])
}

/// Adds what arrives along shadow rays to the colours of surfaces. `LAMBERT`: it arrives from the ray's direction, with the
/// cosine to be applied and highlights; otherwise it is reflected by `kd` as it is.
pub(super) struct Arrive<'a, const LAMBERT: bool> {
    pub(super) surfaces: &'a mut Surfaces,
    /// Factor of highlights, by surface.
    pub(super) highlight: Option<&'a [f32]>,
    pub(super) blocks: &'a [RayBlock],
    pub(super) blocked: &'a [u16],
    pub(super) arriving: &'a Planes,
    /// What shadow rays keep on their way, if they go through things.
    pub(super) tint: Option<&'a Planes>,
}

impl<const LAMBERT: bool> Kernel for Arrive<'_, LAMBERT> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Arrive { surfaces, highlight, blocks, blocked, arriving, tint } = self;
        let (zero, one) = (F32::<S, 16>::splat(s, 0.0), F32::<S, 16>::splat(s, 1.0));
        for (index, (block, blocked)) in blocks.iter().zip(blocked).enumerate() {
            let lit = block.active & !blocked;
            if lit == 0 {
                continue;
            }
            let at = index * SUB;
            let lit = Mask::from_bits(s, u32::from(lit));
            let mut light = load3(s, arriving, at);
            if let Some(tint) = tint {
                for k in 0..3 {
                    light[k] = light[k] * F32::load_at(s, &tint[k], at);
                }
            }
            let kd = load3(s, &surfaces.kd, at);
            let mut reflected = kd;
            if LAMBERT {
                let l = wide::normalize(s, wide::load(s, &block.dir));
                let n = load3(s, &surfaces.ns, at);
                let cosine = wide::dot(n, l).max(zero);
                let ks = load3(s, &surfaces.ks, at);
                let lobe = crate::shade::direct::highlight(s, surfaces, at, l, n);
                let lobe = zero.lt(cosine).select(lobe, zero);
                let factor = match highlight {
                    Some(factor) => F32::load_at(s, factor, at),
                    None => one,
                };
                for k in 0..3 {
                    reflected[k] = kd[k] * cosine + ks[k] * lobe * factor;
                }
            }
            for k in 0..3 {
                let color = F32::load_at(s, &surfaces.color[k], at);
                lit.select(color + light[k] * reflected[k], color).store_at(&mut surfaces.color[k], at);
            }
        }
    }
}

/// Points of the unit disc, from `squares`, uniformly.
pub(crate) struct Disc<'a>(pub(crate) &'a [[f32; SUB]; 2]);

impl Kernel for Disc<'_> {
    type Output = [[f32; SUB]; 2];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [[f32; SUB]; 2] {
        let radius = F32::<S, 16>::load(s, &self.0[0]).sqrt();
        let [sin, cos] = sin_cos(s, F32::load(s, &self.0[1]));
        [(radius * cos).to_array(), (radius * sin).to_array()]
    }
}
