//! Rays that go on from a surface: mirrored, refracted, diffusely reflected.
//!
//! Fresnel's equations in full; reflection in rough surfaces by the visible normals of GGX (E. Heitz, "Sampling the GGX
//! Distribution of Visible Normals", JCGT 2018); Snell's law, with total reflection where it has no solution.

use super::{
    ground::{Ground, left_out, load3, store3},
    source::{Squares, cosine_weighted},
    table::PathTable,
    wide::{self, V3},
};
use crate::{
    kernels::{F32, Kernel, MISS, Mask, SUB, Simd},
    shade::{Surfaces, surface::Planes, trig::sin_cos},
};

/// Directions and weights of rays that go on; a weight of 0 is no ray.
#[derive(Clone, Debug, Default)]
pub(super) struct Scattered {
    pub(super) reflected: Planes,
    pub(super) reflectance: Planes,
    pub(super) refracted: Planes,
    pub(super) transmittance: Planes,
}

impl Scattered {
    pub(super) fn resize(&mut self, len: usize) {
        let Scattered { reflected, reflectance, refracted, transmittance } = self;
        for plane in [reflected, reflectance, refracted, transmittance].into_iter().flatten() {
            plane.resize(len, 0.0);
        }
    }
}

/// What the materials of sixteen surfaces do to light.
#[derive(Default)]
struct Lot {
    reflect: [[f32; SUB]; 3],
    through: [[f32; SUB]; 3],
    fresnel: [f32; SUB],
    ni: [f32; SUB],
    alpha: [f32; SUB],
    /// 1 where light goes through.
    clear: [f32; SUB],
}

/// `GLOSSY`: some surfaces may be rough; `CLEAR`: light may go through some.
pub(super) struct Scatter<'a, const GLOSSY: bool, const CLEAR: bool> {
    pub(super) table: &'a PathTable<'a>,
    pub(super) surfaces: &'a Surfaces,
    pub(super) ground: &'a Ground,
    /// For rough surfaces.
    pub(super) squares: &'a Squares,
    pub(super) out: &'a mut Scattered,
}

impl<const GLOSSY: bool, const CLEAR: bool> Kernel for Scatter<'_, GLOSSY, CLEAR> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Scatter { table, surfaces, ground, squares, out } = self;
        let (zero, one) = (F32::<S, 16>::splat(s, 0.0), F32::<S, 16>::splat(s, 1.0));
        for at in (0..surfaces.len()).step_by(SUB) {
            let lot = lot(table, surfaces, at);
            let (view, ns) = (load3(s, &surfaces.view, at), load3(s, &surfaces.ns, at));
            let (ng, none) = (load3(s, &surfaces.ng, at), [zero; 3]);
            let mut h = ns;
            let mut gain = one;
            if GLOSSY {
                let alpha = F32::load(s, &lot.alpha);
                let square = [F32::load_at(s, &squares[0], at), F32::load_at(s, &squares[1], at)];
                let micro = visible_normal(s, ns, view, alpha, square);
                let rough = zero.lt(alpha);
                h = wide::select(rough, micro, ns);
                gain = rough.select(masking(s, ns, view, h, alpha), one);
            }
            let cosine = wide::dot(h, view).max(zero).min(one);
            let clear = zero.lt(F32::load(s, &lot.clear));
            let outside = zero.lt(F32::load_at(s, &ground.side, at));
            // Opaque surfaces have air on both sides.
            let entering = if CLEAR { outside.select(one, clear.select(zero, one)) } else { one };
            let ni = F32::load(s, &lot.ni);
            let eta = zero.lt(entering).select(one / ni, ni);
            let k = one - eta * eta * (one - cosine * cosine);
            let total = k.lt(zero);
            let inner = k.max(zero).sqrt();
            let fresnel = total.select(one, fresnel(s, cosine, inner, eta));
            let is_fresnel = zero.lt(F32::load(s, &lot.fresnel));
            let reflect = wide::load(s, &lot.reflect);
            let through = wide::load(s, &lot.through);
            let transmitted = total.select(zero, is_fresnel.select(one - fresnel, one));
            let mut reflectance = reflect;
            for k in 0..3 {
                // Without Fresnel, a mirror image is seen from outside only; total reflection there is always.
                let plain = total.select(through[k], reflect[k] * entering);
                reflectance[k] = is_fresnel.select(reflect[k] * fresnel, plain) * gain;
            }
            let reflected = reflection(s, view, h, ng, zero.lt(F32::load(s, &lot.alpha)).bits());
            let up = zero.lt(wide::dot(reflected, ng));
            store3(reflected, &mut out.reflected, at);
            store3(wide::select(up, reflectance, none), &mut out.reflectance, at);
            if CLEAR {
                let refracted = refraction(s, view, ns, ng, eta);
                let down = wide::dot(refracted, ng).lt(zero);
                store3(refracted, &mut out.refracted, at);
                let transmittance = wide::select(down, wide::scale(through, transmitted), none);
                store3(transmittance, &mut out.transmittance, at);
            }
        }
    }
}

#[inline(always)]
fn lot(table: &PathTable, surfaces: &Surfaces, at: usize) -> Lot {
    let mut lot = Lot { ni: [1.0; SUB], ..Lot::default() };
    for lane in 0..SUB {
        let prim = surfaces.prim[at + lane];
        if prim == MISS {
            continue;
        }
        let optics = table.optics(prim);
        for k in 0..3 {
            lot.reflect[k][lane] = optics.reflect[k];
            lot.through[k][lane] = optics.through[k];
        }
        lot.fresnel[lane] = optics.fresnel;
        lot.ni[lane] = optics.ni;
        lot.alpha[lane] = optics.alpha;
        lot.clear[lane] = if optics.through == [0.0; 3] { 0.0 } else { 1.0 };
    }
    lot
}

/// The mean of the reflectances of both polarisations; `inner` is the cosine on the other side, `eta` the index on this side
/// divided by that on the other.
#[inline(always)]
fn fresnel<S: Simd>(s: S, cosine: F32<S, 16>, inner: F32<S, 16>, eta: F32<S, 16>) -> F32<S, 16> {
    let tiny = F32::splat(s, 1.0e-30);
    let vertical = (eta * cosine - inner) / (eta * cosine + inner).max(tiny);
    let parallel = (eta * inner - cosine) / (eta * inner + cosine).max(tiny);
    F32::splat(s, 0.5) * (vertical * vertical + parallel * parallel)
}

/// The mirrored view about `h`; where that leads below the triangle of a smooth surface, about its own normal.
#[inline(always)]
fn reflection<S: Simd>(s: S, view: V3<S>, h: V3<S>, ng: V3<S>, rough: u32) -> V3<S> {
    let first = mirrored(view, h);
    let below = wide::dot(first, ng).le(F32::splat(s, 0.0)).bits() & !rough;
    let below = Mask::from_bits(s, below);
    wide::normalize(s, wide::select(below, mirrored(view, ng), first))
}

#[inline(always)]
fn mirrored<S: Simd>(view: V3<S>, n: V3<S>) -> V3<S> {
    let cosine = wide::dot(n, view);
    wide::sub(wide::scale(n, cosine + cosine), view)
}

/// The refracted direction about the shading normal; where that leads above the triangle, about its own.
#[inline(always)]
fn refraction<S: Simd>(s: S, view: V3<S>, ns: V3<S>, ng: V3<S>, eta: F32<S, 16>) -> V3<S> {
    let (first, flat) = (bent(s, view, ns, eta), bent(s, view, ng, eta));
    let below = wide::dot(first, ng).lt(F32::splat(s, 0.0));
    wide::normalize(s, wide::select(below, first, flat))
}

/// Snell's law about `n`.
#[inline(always)]
fn bent<S: Simd>(s: S, view: V3<S>, n: V3<S>, eta: F32<S, 16>) -> V3<S> {
    let (zero, one) = (F32::splat(s, 0.0), F32::splat(s, 1.0));
    let cosine = wide::dot(n, view);
    let inner = (one - eta * eta * (one - cosine * cosine)).max(zero).sqrt();
    wide::sub(wide::scale(n, eta * cosine - inner), wide::scale(view, eta))
}

/// A normal of the rough surface that is seen from `view`.
#[inline(always)]
fn visible_normal<S: Simd>(
    s: S,
    ns: V3<S>,
    view: V3<S>,
    alpha: F32<S, 16>,
    [u, v]: [F32<S, 16>; 2],
) -> V3<S> {
    let (zero, one) = (F32::splat(s, 0.0), F32::splat(s, 1.0));
    let [t, b] = wide::basis(s, ns);
    let local = [wide::dot(view, t), wide::dot(view, b), wide::dot(view, ns).max(zero)];
    let stretched = wide::normalize(s, [alpha * local[0], alpha * local[1], local[2]]);
    let [t1, t2] = across(s, stretched);
    let radius = u.sqrt();
    let [sin, cos] = sin_cos(s, v);
    let (p1, p2) = (radius * cos, radius * sin);
    let half = F32::splat(s, 0.5) * (one + stretched[2]);
    let p2 = (one - half) * (one - p1 * p1).max(zero).sqrt() + half * p2;
    let p3 = (one - p1 * p1 - p2 * p2).max(zero).sqrt();
    let n = wide::add(wide::add(wide::scale(t1, p1), wide::scale(t2, p2)), wide::scale(stretched, p3));
    let micro = wide::normalize(s, [alpha * n[0], alpha * n[1], n[2].max(F32::splat(s, 1.0e-6))]);
    wide::add(wide::add(wide::scale(t, micro[0]), wide::scale(b, micro[1])), wide::scale(ns, micro[2]))
}

/// Two unit vectors that stand on the unit vector `n` and on each other, the first one level in its local coordinates: the disc
/// of visible normals is cut along it.
#[inline(always)]
fn across<S: Simd>(s: S, n: V3<S>) -> [V3<S>; 2] {
    let (zero, one) = (F32::splat(s, 0.0), F32::splat(s, 1.0));
    let square = n[0] * n[0] + n[1] * n[1];
    let tiny = F32::splat(s, 1.0e-20);
    let by = one / square.max(tiny).sqrt();
    let slanted = tiny.lt(square);
    let (x, y) = (slanted.select(-n[1] * by, one), slanted.select(n[0] * by, zero));
    [[x, y, zero], [-n[2] * y, n[2] * x, n[0] * y - n[1] * x]]
}

/// Smith's masking-shadowing over masking: what a sampled reflection counts.
#[inline(always)]
fn masking<S: Simd>(s: S, ns: V3<S>, view: V3<S>, h: V3<S>, alpha: F32<S, 16>) -> F32<S, 16> {
    let (zero, one) = (F32::splat(s, 0.0), F32::splat(s, 1.0));
    let out = mirrored(view, h);
    let (n_out, n_view) = (wide::dot(ns, out), wide::dot(ns, view).max(zero));
    let (a, b) = (lambda(s, n_view, alpha), lambda(s, n_out, alpha));
    zero.lt(n_out).select((one + a) / (one + a + b), zero)
}

/// Smith's function of the height-correlated masking of GGX.
#[inline(always)]
fn lambda<S: Simd>(s: S, cosine: F32<S, 16>, alpha: F32<S, 16>) -> F32<S, 16> {
    let (zero, one, half) = (F32::splat(s, 0.0), F32::splat(s, 1.0), F32::splat(s, 0.5));
    let c2 = (cosine * cosine).max(F32::splat(s, 1.0e-12));
    let tan2 = (one - c2).max(zero) / c2;
    half * ((one + alpha * alpha * tan2).sqrt() - one)
}

/// Directions of diffuse reflection.
pub(super) struct Bounce<'a> {
    pub(super) surfaces: &'a Surfaces,
    pub(super) ground: &'a Ground,
    pub(super) squares: &'a Squares,
    pub(super) dir: &'a mut Planes,
    /// What the rays leave out.
    pub(super) skip: &'a mut [u32],
}

impl Kernel for Bounce<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Bounce { surfaces, ground, squares, dir: dirs, skip } = self;
        for at in (0..surfaces.len()).step_by(SUB) {
            let square = [F32::load_at(s, &squares[0], at), F32::load_at(s, &squares[1], at)];
            let dir = cosine_weighted(s, surfaces, square, at);
            // Below the surface there is nothing: no ray.
            let up = F32::splat(s, 0.0).lt(wide::dot(dir, load3(s, &ground.horizon, at)));
            store3(wide::select(up, dir, [F32::splat(s, 0.0); 3]), dirs, at);
            let skip: &mut [u32; SUB] = (&mut skip[at..at + SUB]).try_into().expect("16 lanes");
            left_out(s, surfaces, at, dir).store(skip);
        }
    }
}
