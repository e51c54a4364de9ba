//! What a ray hits, in rational numbers: exact on the triangles as the contract gives them, their vertices relative to
//! the origin rounded once.

use dashu_ratio::RBig;
use glam::Vec3;
use irt::{
    kernels::{Hit, MISS, Ray},
    scene::TriangleMesh,
    study::stability::is_finite,
};

pub(crate) type Q = [RBig; 3];

pub(crate) fn exact(v: [f32; 3]) -> Q {
    v.map(|x| RBig::try_from(x).expect("a finite number"))
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

/// Depth and weights of the crossing, if the ray passes through the triangle at whatever depth.
fn crossing(corners: [Vec3; 3], ray: &Ray) -> Option<[RBig; 3]> {
    let relative = |p: Vec3| {
        let p = p.to_array();
        exact([0, 1, 2].map(|axis| p[axis] - ray.org[axis]))
    };
    let [a, b, c] = corners.map(relative);
    let d = exact(ray.dir);
    let signs = [sign(&b, &c, &d), sign(&c, &a, &d), sign(&a, &b, &d)];
    if signs.contains(&1) == signs.contains(&-1) {
        return None;
    }
    let n = cross(&minus(&b, &a), &minus(&c, &a));
    let nd = dot(&n, &d);
    Some([dot(&n, &a) / &nd, dot(&cross(&c, &a), &d) / &nd, dot(&cross(&a, &b), &d) / &nd])
}

/// Panics unless `hit` is what the ray hits. Depths count as equal when they agree to 40 bits, since the order of hits
/// is that of depths in f64.
pub(crate) fn check(context: &str, mesh: &TriangleMesh, ray: &Ray, hit: &Hit) {
    let context = format!("{context}: {ray:?} {hit:?}");
    if !is_finite(ray) {
        assert_eq!(*hit, Hit::MISS, "{context}");
        return;
    }
    let near = RBig::try_from(1.0 - 2.0f64.powi(-40)).expect("finite");
    let far = RBig::try_from(1.0 + 2.0f64.powi(-40)).expect("finite");
    let end = |t: f32| RBig::try_from(t).unwrap_or(RBig::try_from(f64::MAX).expect("finite"));
    let (tnear, tfar) = (end(ray.tnear.max(0.0)), end(ray.tfar));
    let inside = |t: &RBig, slack: bool| {
        let (shrunk, grown) = (t * &near, t * &far);
        if slack { grown >= tnear && shrunk <= tfar } else { shrunk >= tnear && grown <= tfar }
    };
    let met: Vec<(usize, [RBig; 3])> = (0..mesh.len())
        .filter(|&prim| prim as u32 != ray.skip)
        .filter_map(|prim| Some((prim, crossing(mesh.corners(prim), ray)?)))
        .collect();
    if hit.prim == MISS {
        let missed = met.iter().find(|(_, at)| inside(&at[0], false));
        assert!(missed.is_none(), "{context}: triangle {:?} is there", missed.map(|(prim, _)| prim));
        return;
    }
    let own = met.iter().find(|(prim, _)| *prim == hit.prim as usize);
    let (_, [t, u, v]) = own.unwrap_or_else(|| panic!("{context}: the triangle is not there"));
    assert!(inside(t, true), "{context}: out of the interval");
    for (other, at) in &met {
        let nearer = &at[0] * &far < t * &near && inside(&at[0], false);
        assert!(!nearer, "{context}: triangle {other} is nearer");
        let twin = mesh.corners(*other) == mesh.corners(hit.prim as usize);
        assert!(!twin || *other >= hit.prim as usize, "{context}: {other} is the same and comes first");
    }
    let close = |name: &str, got: f32, want: &RBig, unit: f64| {
        let off = (f64::from(got) - want.to_f64().value()).abs();
        assert!(off <= unit, "{context}: {name} is {got}, not {}", want.to_f64().value());
    };
    let size = t.to_f64().value().abs().max(f64::from(f32::MIN_POSITIVE));
    close("t", hit.t, t, size * f64::from(f32::EPSILON));
    close("u", hit.u, u, f64::from(f32::EPSILON));
    close("v", hit.v, v, f64::from(f32::EPSILON));
}
