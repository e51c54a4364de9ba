//! Exact visibility of one ray and one triangle: what every fast filter must agree with.
//!
//! Vertices `a`, `b`, `c` are relative to the ray's origin, rounded once to f32 (the same for every triangle that
//! shares the vertex). The ray hits if and only if the signs of det(b, c, d), det(c, a, d) and det(a, b, d) agree in
//! exact arithmetic, where zero agrees with both and three zeros (a ray in the triangle's plane, or a degenerate
//! triangle) are a miss. Neighbours that share an edge evaluate the same determinant with swapped arguments, so a
//! closed fan cannot leak (Woop, Benthin, Wald 2013; here without their fallback's rounding).
//!
//! The *canonical depth* is evaluated in f64 by one fixed sequence of operations; it orders hits and gives t, u, v.

/// A vertex, direction or normal.
type V = [f32; 3];

/// True if the ray from the origin along `d` passes through the triangle, at whatever depth.
pub fn passes(a: V, b: V, c: V, d: V) -> bool {
    let signs = [det_sign(b, c, d), det_sign(c, a, d), det_sign(a, b, d)];
    let positive = signs.iter().any(|&s| s > 0);
    let negative = signs.iter().any(|&s| s < 0);
    positive != negative
}

/// Sign of det(p, q, d) = (p x q) . d, exact for all finite arguments: -1, 0 or 1.
pub fn det_sign(p: V, q: V, d: V) -> i32 {
    let [px, py, pz] = wide(p);
    let [qx, qy, qz] = wide(q);
    let [dx, dy, dz] = wide(d);
    // Products of two floats are exact in f64.
    let terms =
        [(py * qz, dx), (-(pz * qy), dx), (pz * qx, dy), (-(px * qz), dy), (px * qy, dz), (-(py * qx), dz)];
    let mut sum = 0.0;
    let mut magnitude = 0.0;
    for (pq, k) in terms {
        sum += pq * k;
        magnitude += (pq * k).abs();
    }
    // Six rounded products and five sums: well below 16 units of 2^-53.
    if f64::abs(sum) > 16.0 * f64::EPSILON * magnitude {
        return if sum > 0.0 { 1 } else { -1 };
    }
    expansion_sign(&terms)
}

/// Sign of the sum of `pq * k`, where `pq` has at most 48 and `k` at most 24 significant bits.
#[cold]
fn expansion_sign(terms: &[(f64, f64); 6]) -> i32 {
    // A non-overlapping expansion, least component first (Shewchuk 1997, Grow-Expansion).
    let mut expansion = [0.0f64; 12];
    let mut len = 0;
    for &(pq, k) in terms {
        // Cutting pq after 26 bits makes both partial products exact.
        let high = f64::from_bits(pq.to_bits() & !((1 << 27) - 1));
        for mut q in [(pq - high) * k, high * k] {
            for component in &mut expansion[..len] {
                let sum = q + *component;
                let virtual_part = sum - q;
                *component = (q - (sum - virtual_part)) + (*component - virtual_part);
                q = sum;
            }
            expansion[len] = q;
            len += 1;
        }
    }
    // The most significant non-zero component has the sign of the sum.
    for &component in expansion.iter().rev() {
        if component != 0.0 {
            return if component > 0.0 { 1 } else { -1 };
        }
    }
    0
}

/// The same numbers in f64.
#[inline(always)]
pub(crate) fn wide(v: V) -> [f64; 3] {
    [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]
}

/// The plane and the edge functions of a triangle in f64, for canonical depth and barycentric coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Canonical {
    n: [f64; 3],
    na: f64,
    ca: [f64; 3],
    ab: [f64; 3],
    z0: f64,
    z1: f64,
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Canonical {
    /// Of a triangle relative to the ray's origin, its axes permuted so that the last one is the ray's dominant one.
    #[inline(always)]
    pub fn new(a: V, b: V, c: V) -> Canonical {
        let (a, b, c) = (wide(a), wide(b), wide(c));
        let n = cross([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let na = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
        let z0 = a[2].min(b[2]).min(c[2]);
        let z1 = a[2].max(b[2]).max(c[2]);
        Canonical { n, na, ca: cross(c, a), ab: cross(a, b), z0, z1 }
    }

    /// Depth t along `d` = (x, y, z), |z| >= |x|, |y| > 0, of the plane; kept within the triangle's extent in z, so
    /// that a sliver cannot be hit where it is not.
    #[inline(always)]
    pub fn depth(&self, d: [f64; 3]) -> f64 {
        let r = 1.0 / (self.n[0] * d[0] + self.n[1] * d[1] + self.n[2] * d[2]);
        self.clamp(self.na * r, d[2])
    }

    /// Depth and the barycentric coordinates of the second and third corner, each in [0, 1].
    #[inline(always)]
    pub fn hit(&self, d: [f64; 3]) -> [f32; 3] {
        let r = 1.0 / (self.n[0] * d[0] + self.n[1] * d[1] + self.n[2] * d[2]);
        let u = (self.ca[0] * d[0] + self.ca[1] * d[1] + self.ca[2] * d[2]) * r;
        let v = (self.ab[0] * d[0] + self.ab[1] * d[1] + self.ab[2] * d[2]) * r;
        [self.clamp(self.na * r, d[2]) as f32, unit(u) as f32, unit(v) as f32]
    }

    #[inline(always)]
    fn clamp(&self, t: f64, dz: f64) -> f64 {
        let inverse = 1.0 / dz;
        let (first, second) = if dz > 0.0 { (self.z0, self.z1) } else { (self.z1, self.z0) };
        let (near, far) = (first * inverse, second * inverse);
        let t = if t > near { t } else { near };
        if t < far { t } else { far }
    }
}

#[inline(always)]
fn unit(x: f64) -> f64 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn det_sign_sees_one_unit_in_the_last_place() {
        // Coplanar up to the last bit of one coordinate.
        let p = [1.0, 2.0, 3.0];
        let q = [4.0, 5.0, 6.0];
        let d = [7.0, 8.0, 9.0];
        assert_eq!(det_sign(p, q, d), 0);
        let up = |x: f32| f32::from_bits(x.to_bits() + 1);
        // (p x q) = (-3, 6, -3)
        assert_eq!(det_sign(p, q, [up(7.0), 8.0, 9.0]), -1);
        assert_eq!(det_sign(p, q, [7.0, up(8.0), 9.0]), 1);
    }

    #[test]
    fn det_sign_is_antisymmetric_for_hard_arguments() {
        let p = [1.0e-20, 3.0e15, -7.0];
        let q = [2.5e18, -1.0e-10, 3.3];
        let d = [1.0, -1.0e-30, 0.25];
        assert_eq!(det_sign(p, q, d), -det_sign(q, p, d));
        assert_ne!(det_sign(p, q, d), 0);
    }

    #[test]
    fn a_ray_in_the_plane_misses_and_a_ray_through_a_vertex_hits() {
        let (a, b, c) = ([0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]);
        assert!(passes(a, b, c, a));
        assert!(passes(a, b, c, [0.5, 0.5, 1.0]));
        assert!(!passes(a, b, c, [0.5, f32::from_bits(0.5f32.to_bits() + 1), 1.0]));
        assert!(!passes([-1.0, 0.5, 0.0], [1.0, 0.5, 0.0], [0.0, 2.0, 0.0], [1.0, 0.5, 0.0]));
    }
}
