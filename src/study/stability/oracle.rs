//! What a ray hits, found another way than the kernels do: every triangle one by one, in f64 with error bounds, and
//! with twice that precision where f64 cannot decide.
//!
//! It decides by the contract: vertices relative to the origin are rounded once to f32, and from there on everything
//! is exact. Where even the doubled precision leaves a sign open (the ray passes exactly through an edge, perhaps),
//! either answer is right here; the tests decide those cases with rational numbers.

use super::double::Double;
use crate::{
    kernels::{Hit, MISS, Ray},
    scene::TriangleMesh,
};
use glam::Vec3;

type V = [f32; 3];

/// Whether a ray passes through a triangle, at whatever depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Met {
    No,
    /// Exactly through an edge, or too close to one to tell.
    Maybe,
    Yes,
}

/// A ray and the plane of a triangle.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    t: Double,
    u: Double,
    v: Double,
    /// What f64 may make of `t`, and of `u` and `v`: bounds of absolute errors.
    error: f64,
    weight_error: f64,
}

/// What is wrong with a hit, or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// The triangle is not where the hit says.
    Imagined,
    /// A nearer triangle, or any at all, was missed.
    Missed,
    /// Depth or weights are more than one unit in the last place off.
    Inaccurate,
}

/// The oracle's opinion of a hit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Opinion {
    pub(super) fault: Option<Fault>,
    /// Errors of t, u and v: t in units of its last place, u and v in units of 2^-24.
    pub(super) errors: Option<[f32; 3]>,
}

fn relative(corners: [Vec3; 3], ray: &Ray) -> [V; 3] {
    corners.map(|p| {
        let p = p.to_array();
        [p[0] - ray.org[0], p[1] - ray.org[1], p[2] - ray.org[2]]
    })
}

/// Sign of det(p, q, d), if it can be known.
fn sign(p: V, q: V, d: V) -> Option<i32> {
    let [p, q, d] = [p, q, d].map(|v| v.map(f64::from));
    let product = |i: usize, j: usize, k: usize| p[i] * q[j] * d[k];
    let terms = [
        product(1, 2, 0),
        -product(2, 1, 0),
        product(2, 0, 1),
        -product(0, 2, 1),
        product(0, 1, 2),
        -product(1, 0, 2),
    ];
    let (sum, magnitude) = terms.iter().fold((0.0, 0.0), |(sum, all), term| (sum + term, all + term.abs()));
    if sum.abs() > magnitude * 2.0f64.powi(-48) {
        return Some(if sum > 0.0 { 1 } else { -1 });
    }
    let exact = |i: usize, j: usize, k: usize| {
        Double::from(p[i]) * Double::from(q[j]) * Double::from(d[k])
            - Double::from(p[j]) * Double::from(q[i]) * Double::from(d[k])
    };
    let sum = (exact(1, 2, 0) + exact(2, 0, 1) + exact(0, 1, 2)).to_f64();
    if magnitude == 0.0 {
        return Some(0);
    }
    (sum.abs() > magnitude * 2.0f64.powi(-92)).then_some(if sum > 0.0 { 1 } else { -1 })
}

fn met([a, b, c]: [V; 3], d: V) -> Met {
    let signs = [sign(b, c, d), sign(c, a, d), sign(a, b, d)];
    let is = |sign: i32| signs.contains(&Some(sign));
    match (is(1), is(-1), signs.contains(&None)) {
        (true, true, _) | (false, false, false) => Met::No,
        (_, _, true) => Met::Maybe,
        _ => Met::Yes,
    }
}

/// A cross product and the sums of the magnitudes that went into it.
fn cross(a: [Double; 3], b: [Double; 3]) -> ([Double; 3], [f64; 3]) {
    let part = |i: usize, j: usize| {
        let (one, two) = (a[i] * b[j], a[j] * b[i]);
        (one - two, one.abs().to_f64() + two.abs().to_f64())
    };
    let [x, y, z] = [part(1, 2), part(2, 0), part(0, 1)];
    ([x.0, y.0, z.0], [x.1, y.1, z.1])
}

fn dot((n, size): ([Double; 3], [f64; 3]), d: [Double; 3]) -> (Double, f64) {
    let value = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
    (value, (0..3).map(|i| size[i] * d[i].abs().to_f64()).sum())
}

/// The depth of a wall across the axis along which the ray advances by one: a difference of two coordinates, which
/// every formula must tell exactly, so that a ray may end or begin right there.
fn wall(corners: [V; 3], d: V) -> Option<f32> {
    let [a, b, c] = corners;
    let along = |k: &usize| d[*k].abs() == 1.0 && d.iter().all(|x| x.abs() <= 1.0);
    (0..3).find(|k| along(k) && a[*k] == b[*k] && b[*k] == c[*k]).map(|k| a[k] * d[k])
}

fn crossing(corners: [V; 3], d: V) -> Crossing {
    let wall = wall(corners, d);
    let [a, b, c] = corners.map(|v| v.map(Double::from));
    let d = d.map(Double::from);
    let minus = |p: [Double; 3], q: [Double; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let normal = cross(minus(b, a), minus(c, a));
    let ((na, na_size), (nd, nd_size)) = (dot(normal, a), dot(normal, d));
    let ((cad, cad_size), (abd, abd_size)) = (dot(cross(c, a), d), dot(cross(a, b), d));
    let t = na.divided_by(nd);
    let (u, v) = (cad.divided_by(nd), abd.divided_by(nd));
    let steep = nd.abs().to_f64();
    let unit = 16.0 * f64::EPSILON;
    let error = unit * (na_size / steep + t.abs().to_f64() * (nd_size / steep + 1.0));
    let (t, error) = wall.map_or((t, error), |depth| (Double::from(depth), 0.0));
    let weight_error = unit * (cad_size.max(abd_size) / steep + nd_size / steep);
    Crossing { t, u, v, error, weight_error }
}

/// The greatest depth at which `ray` meets the triangle for sure, if it does.
pub(super) fn depth_of(corners: [Vec3; 3], ray: &Ray) -> Option<f64> {
    let corners = relative(corners, ray);
    if met(corners, ray.dir) != Met::Yes {
        return None;
    }
    let crossing = crossing(corners, ray.dir);
    let (t, error) = (crossing.t.to_f64(), crossing.error);
    let inside = t - error >= f64::from(ray.tnear.max(0.0)) && t + error <= f64::from(ray.tfar);
    inside.then_some(t + error)
}

/// What the oracle thinks of `hit`, found for a ray of finite numbers.
pub(super) fn judge(mesh: &TriangleMesh, ray: &Ray, hit: &Hit) -> Opinion {
    let nearest = (0..mesh.len())
        .filter(|&prim| prim as u32 != ray.skip)
        .filter_map(|prim| depth_of(mesh.corners(prim), ray))
        .fold(f64::INFINITY, f64::min);
    if hit.prim == MISS {
        return Opinion { fault: nearest.is_finite().then_some(Fault::Missed), errors: None };
    }
    let fault = |fault: Fault| Opinion { fault: Some(fault), errors: None };
    if hit.prim == ray.skip || hit.prim as usize >= mesh.len() {
        return fault(Fault::Imagined);
    }
    let corners = relative(mesh.corners(hit.prim as usize), ray);
    let met = met(corners, ray.dir);
    let at = crossing(corners, ray.dir);
    let t = at.t.to_f64();
    let outside = t + at.error < f64::from(ray.tnear.max(0.0)) || t - at.error > f64::from(ray.tfar);
    if met == Met::No || outside {
        return fault(Fault::Imagined);
    }
    if nearest < t - at.error {
        return fault(Fault::Missed);
    }
    accuracy(hit, &at)
}

/// Compares numbers where f64 can know them to a fraction of a unit, and f32 can hold them.
fn accuracy(hit: &Hit, at: &Crossing) -> Opinion {
    let t = at.t.to_f64();
    let last_place = f64::from((t as f32).abs().next_up()) - f64::from((t as f32).abs());
    let knowable = at.error < 0.01 * last_place && at.weight_error < 0.01 * 2.0f64.powi(-24);
    if !knowable || !(1.0e-30..1.0e30).contains(&t.abs()) {
        return Opinion::default();
    }
    let off = |got: f32, want: Double| (Double::from(got) - want).abs().to_f64();
    let unit = 2.0f64.powi(24);
    let errors = [off(hit.t, at.t) / last_place, off(hit.u, at.u) * unit, off(hit.v, at.v) * unit];
    let fault = errors.iter().any(|&error| error.is_nan() || error > 1.0).then_some(Fault::Inaccurate);
    Opinion { fault, errors: Some(errors.map(|error| error as f32)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> [Vec3; 3] {
        [Vec3::new(0.0, 0.0, 3.0), Vec3::new(1.0, 0.0, 3.0), Vec3::new(0.0, 1.0, 3.0)]
    }

    fn ray(dir: V) -> Ray {
        Ray { org: [0.0; 3], dir, tnear: 0.0, tfar: f32::INFINITY, skip: MISS }
    }

    #[test]
    fn sure_signs_are_right_and_unsure_ones_are_told() {
        assert_eq!(met(triangle().map(|p| p.to_array()), [0.25, 0.25, 3.0]), Met::Yes);
        assert_eq!(met(triangle().map(|p| p.to_array()), [0.5, 0.5, 3.0]), Met::Maybe);
        assert_eq!(met(triangle().map(|p| p.to_array()), [0.5, 0.5f32.next_up(), 3.0]), Met::No);
        assert_eq!(met(triangle().map(|p| p.to_array()), [0.5, 0.5f32.next_down(), 3.0]), Met::Yes);
    }

    #[test]
    fn ends_of_rays_are_inside_and_what_is_beyond_them_is_not() {
        let mesh = super::super::mesh::mesh_of(&[triangle()]);
        let ray = ray([0.0625, 0.125, 1.0]);
        let hit = Hit { prim: 0, t: 3.0, u: 0.1875, v: 0.375 };
        let fault = |tnear: f32, tfar: f32, hit: Hit| judge(&mesh, &Ray { tnear, tfar, ..ray }, &hit).fault;
        assert_eq!(fault(3.0, 3.0, hit), None);
        assert_eq!(fault(3.0, f32::INFINITY, Hit::MISS), Some(Fault::Missed));
        assert_eq!(fault(0.0, 3.0, Hit::MISS), Some(Fault::Missed));
        assert_eq!(fault(0.0, 3.0f32.next_down(), hit), Some(Fault::Imagined));
        assert_eq!(fault(3.0f32.next_up(), f32::INFINITY, hit), Some(Fault::Imagined));
    }

    #[test]
    fn wrong_hits_are_faults() {
        let mut triangles = vec![triangle(), triangle().map(|p| p - Vec3::Z)];
        let ray = ray([0.25, 0.25, 2.0]);
        let mesh = super::super::mesh::mesh_of(&triangles);
        let good = Hit { prim: 1, t: 1.0, u: 0.25, v: 0.25 };
        let opinion = judge(&mesh, &ray, &good);
        assert_eq!((opinion.fault, opinion.errors), (None, Some([0.0; 3])));
        let fault = |hit: Hit| judge(&mesh, &ray, &hit).fault;
        assert_eq!(fault(Hit { t: 1.000_000_3, ..good }), Some(Fault::Inaccurate));
        assert_eq!(fault(Hit { u: f32::NAN, ..good }), Some(Fault::Inaccurate));
        assert_eq!(fault(Hit { prim: 0, t: 1.5, ..good }), Some(Fault::Missed));
        assert_eq!(fault(Hit::MISS), Some(Fault::Missed));
        triangles[1] = triangles[1].map(|p| p + Vec3::X);
        let moved = super::super::mesh::mesh_of(&triangles);
        assert_eq!(judge(&moved, &ray, &good).fault, Some(Fault::Imagined));
        assert_eq!(judge(&mesh, &Ray { tfar: 0.5, ..ray }, &good).fault, Some(Fault::Imagined));
    }
}
