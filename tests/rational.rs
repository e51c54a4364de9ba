//! What a ray hits, in rational numbers: exact on the triangles as the contract gives them, their vertices relative to
//! the origin rounded once.

use dashu_ratio::RBig;
use glam::{DVec3, Vec3};
use irt::{
    kernels::{Hit, MISS, Ray},
    scene::TriangleMesh,
    study::stability::is_finite,
};

pub(crate) type Q = [RBig; 3];

pub(crate) fn exact(v: [f32; 3]) -> Q {
    v.map(|x| number(f64::from(x)))
}

fn number(x: f64) -> RBig {
    RBig::try_from(x).expect("a finite number")
}

fn rounded(x: &RBig) -> f64 {
    x.to_f64().value()
}

fn minus(a: &Q, b: &Q) -> Q {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn cross(a: &Q, b: &Q) -> Q {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn dot(a: &Q, b: &Q) -> RBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Sign of det(p, q, d).
pub(crate) fn sign(p: &Q, q: &Q, d: &Q) -> i32 {
    let det = dot(&cross(p, q), d);
    i32::from(det > RBig::ZERO) - i32::from(det < RBig::ZERO)
}

/// Where a ray passes through a triangle, at whatever depth.
struct Crossing {
    prim: usize,
    t: RBig,
    u: RBig,
    v: RBig,
    /// What f64 may make of t, and of u and v, by the formula that orders hits.
    error: RBig,
    weight_error: f64,
}

impl Crossing {
    fn new(mesh: &TriangleMesh, prim: usize, ray: &Ray) -> Option<Crossing> {
        let corners = mesh.corners(prim).map(|p| (p - Vec3::from(ray.org)).to_array());
        let ([a, b, c], d) = (corners.map(exact), exact(ray.dir));
        let signs = [sign(&b, &c, &d), sign(&c, &a, &d), sign(&a, &b, &d)];
        if signs.contains(&1) == signs.contains(&-1) {
            return None;
        }
        let n = cross(&minus(&b, &a), &minus(&c, &a));
        let nd = dot(&n, &d);
        let t = dot(&n, &a) / &nd;
        let (u, v) = (dot(&cross(&c, &a), &d) / &nd, dot(&cross(&a, &b), &d) / &nd);

        let [a, b, c] = corners.map(|p| Vec3::from(p).as_dvec3());
        let d = Vec3::from(ray.dir).as_dvec3().abs();
        let steep = rounded(&nd).abs();
        let normal = permanent(b - a, c - a);
        let unit = 16.0 * f64::EPSILON;
        let error = unit * (normal.dot(a.abs()) + rounded(&t).abs() * (normal.dot(d) + steep)) / steep;
        let weights = permanent(c, a).max(permanent(a, b)) + normal;
        let weight_error = unit * weights.dot(d) / steep;
        Some(Crossing { prim, t, u, v, error: number(error.min(f64::MAX)), weight_error })
    }

    /// Within the ray for sure, or perhaps.
    fn inside(&self, ray: &Ray, perhaps: bool) -> bool {
        let slack = if perhaps { self.error.clone() } else { -self.error.clone() };
        let begins = &self.t + &slack >= number(f64::from(ray.tnear.max(0.0)));
        begins && (ray.tfar == f32::INFINITY || &self.t - &slack <= number(f64::from(ray.tfar)))
    }
}

/// The cross product with all its products made positive.
fn permanent(a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = (a.abs(), b.abs());
    DVec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
}

/// Panics unless `hit` is what the ray hits.
pub(crate) fn check(context: &str, mesh: &TriangleMesh, ray: &Ray, hit: &Hit) {
    let context = format!("{context}: {ray:?} {hit:?}");
    if !is_finite(ray) {
        assert_eq!(*hit, Hit::MISS, "{context}");
        return;
    }
    let others = (0..mesh.len()).filter(|&prim| prim as u32 != ray.skip);
    let met: Vec<Crossing> = others.filter_map(|prim| Crossing::new(mesh, prim, ray)).collect();
    if hit.prim == MISS {
        let missed = met.iter().find(|at| at.inside(ray, false));
        assert!(missed.is_none(), "{context}: triangle {:?} is there", missed.map(|at| at.prim));
        return;
    }
    let own = met.iter().find(|at| at.prim == hit.prim as usize);
    let own = own.unwrap_or_else(|| panic!("{context}: the triangle is not there"));
    assert!(own.inside(ray, true), "{context}: out of the interval");
    for at in &met {
        let nearer = &at.t + &at.error < &own.t - &own.error && at.inside(ray, false);
        assert!(!nearer, "{context}: triangle {} is nearer", at.prim);
        let twin = mesh.corners(at.prim) == mesh.corners(own.prim);
        assert!(!twin || at.prim >= own.prim, "{context}: {} is the same and comes first", at.prim);
    }
    let close = |name: &str, got: f32, want: &RBig, room: f64| {
        let want = rounded(want);
        let off = (f64::from(got) - want).abs();
        assert!(off <= room, "{context}: {name} is {got}, not {want}");
    };
    let unit = f64::from(f32::EPSILON);
    let size = rounded(&own.t).abs().max(f64::from(f32::MIN_POSITIVE));
    close("t", hit.t, &own.t, size * unit + rounded(&own.error));
    close("u", hit.u, &own.u, unit + own.weight_error);
    close("v", hit.v, &own.v, unit + own.weight_error);
}
