//! Where a ray crosses a triangle.

use crate::study::stability::double::Double;
use glam::DVec3;

/// Depth and weights of a point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Depth along the ray.
    pub t: f64,
    /// Weight of the second corner.
    pub u: f64,
    /// Weight of the third corner.
    pub v: f64,
}

/// det(p, q, d) in f64, or of twice the precision where that cannot tell its sign; 0 if even that cannot.
fn det(p: DVec3, q: DVec3, d: DVec3) -> f64 {
    let terms = [
        [p.y, q.z, d.x],
        [-p.z, q.y, d.x],
        [p.z, q.x, d.y],
        [-p.x, q.z, d.y],
        [p.x, q.y, d.z],
        [-p.y, q.x, d.z],
    ];
    let sum: f64 = terms.iter().map(|[a, b, c]| a * b * c).sum();
    let size: f64 = terms.iter().map(|[a, b, c]| (a * b * c).abs()).sum();
    if sum.abs() > 16.0 * f64::EPSILON * size {
        return sum;
    }
    let product = |&[a, b, c]: &[f64; 3]| Double::from(a) * Double::from(b) * Double::from(c);
    let sum = terms.iter().map(product).reduce(|a, b| a + b).map_or(0.0, Double::to_f64);
    if sum.abs() > size * 2.0f64.powi(-90) { sum } else { 0.0 }
}

/// Where the ray from the origin along `d` passes through the triangle, edges included; `None` if it does not, or lies in
/// the triangle's plane.
pub(super) fn crossing([a, b, c]: [DVec3; 3], d: DVec3) -> Option<Crossing> {
    let (in_a, in_b, in_c) = (det(b, c, d), det(c, a, d), det(a, b, d));
    let any = |sign: f64| [in_a, in_b, in_c].iter().any(|x| x * sign > 0.0);
    if any(1.0) == any(-1.0) {
        return None;
    }
    let normal = (b - a).cross(c - a);
    let (height, slope) = (normal.dot(a), normal.dot(d));
    let sum = in_a + in_b + in_c;
    (slope != 0.0).then(|| Crossing { t: height / slope, u: in_b / sum, v: in_c / sum })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::exact;
    use crate::study::stability::Random;
    use glam::Vec3;

    #[test]
    fn it_agrees_with_exact_arithmetic_wherever_the_origin_rounds_nothing() {
        // From the origin, relative vertices are the vertices; whole numbers put rays on edges and corners.
        let mut random = Random::new(1, 2);
        let mut hits = 0;
        for i in 0..40_000 {
            let mut point = || {
                let p = random.vec();
                if i % 2 == 0 { (p * 3.0).round() } else { p }
            };
            let [a, b, c, d] = [point(), point(), point(), point()];
            if (b - a).cross(c - a) == Vec3::ZERO || d == Vec3::ZERO {
                continue;
            }
            let ours = crossing([a, b, c].map(|p| p.as_dvec3()), d.as_dvec3());
            let [ea, eb, ec, ed] = [a, b, c, d].map(|p| p.to_array());
            assert_eq!(ours.is_some(), exact::passes(ea, eb, ec, ed), "{a} {b} {c} {d}");
            if let Some(Crossing { t, u, v }) = ours {
                hits += 1;
                let on = a.as_dvec3() * (1.0 - u - v) + b.as_dvec3() * u + c.as_dvec3() * v;
                let size = t.abs().max(1.0);
                assert!((on - d.as_dvec3() * t).length() < 1e-9 * size, "{on} {t}");
            }
        }
        assert!(hits > 2000, "{hits}");
    }

    #[test]
    fn one_unit_in_the_last_place_is_seen() {
        let triangle = [DVec3::new(0.0, 0.0, 3.0), DVec3::new(1.0, 0.0, 3.0), DVec3::new(0.0, 1.0, 3.0)];
        let ray = |y: f32| DVec3::new(0.5, f64::from(y), 3.0);
        assert_eq!(crossing(triangle, ray(0.5)), Some(Crossing { t: 1.0, u: 0.5, v: 0.5 }));
        assert!(crossing(triangle, ray(0.5f32.next_up())).is_none());
        assert!(crossing(triangle, ray(0.5f32.next_down())).is_some());
    }
}
