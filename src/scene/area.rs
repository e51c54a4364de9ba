//! Which triangles have exactly zero area, decided without rounding.
//!
//! The tree and the kernels are promised triangles with an area, so this must not guess: a sliver that floating-point
//! arithmetic takes for zero would be a hole in a wall.

use super::{Shape, TriangleMesh};
use glam::Vec3;

/// True if and only if the three points lie on one line (or coincide).
pub(super) fn is_degenerate([a, b, c]: [Vec3; 3]) -> bool {
    a == b
        || b == c
        || c == a
        || [(0, 1), (1, 2), (2, 0)].into_iter().all(|(x, y)| {
            // Twice the signed area of the shadow on one coordinate plane. Products of two f32 are exact in f64.
            let product = |p: Vec3, q: Vec3| f64::from(p[x]) * f64::from(q[y]);
            sums_to_zero([
                product(a, b),
                -product(b, a),
                product(b, c),
                -product(c, b),
                product(c, a),
                -product(a, c),
            ])
        })
}

/// True if the exact sum of the terms is zero.
fn sums_to_zero(terms: [f64; 6]) -> bool {
    let sum: f64 = terms.iter().sum();
    let magnitude: f64 = terms.iter().map(|term| term.abs()).sum();
    // Five additions, each off by at most half an ulp of a partial sum: far outside that, the sign is certain.
    if sum.abs() > 8.0 * f64::EPSILON * magnitude {
        return false;
    }
    // A sum kept as several doubles that do not overlap (Shewchuk's expansion); it is zero when all of them are.
    let mut expansion = [0.0; 6];
    for (n, &term) in terms.iter().enumerate() {
        let mut carry = term;
        for part in &mut expansion[..n] {
            let high = carry + *part;
            let virtual_part = high - carry;
            *part = (carry - (high - virtual_part)) + (*part - virtual_part);
            carry = high;
        }
        expansion[n] = carry;
    }
    expansion == [0.0; 6]
}

/// Removes the triangles that have exactly zero area, with the vertices of `others`, too, and gives back how many there were.
pub(super) fn drop_degenerate(mesh: &mut TriangleMesh, others: &[Shape]) -> usize {
    let (before, mut kept) = (mesh.len(), 0);
    for part in &mut mesh.parts {
        let range = part.first as usize..(part.first + part.count) as usize;
        part.first = kept as u32;
        for from in range {
            let corners = mesh.triangles[from];
            let mut shapes = others.iter().map(|shape| &shape.positions).chain([&mesh.positions]);
            if !shapes.all(|shape| is_degenerate(corners.map(|v| shape[v as usize]))) {
                mesh.triangles[kept] = corners;
                mesh.materials[kept] = mesh.materials[from];
                kept += 1;
            }
        }
        part.count = kept as u32 - part.first;
    }
    mesh.triangles.truncate(kept);
    mesh.materials.truncate(kept);
    mesh.parts.retain(|part| part.count > 0);
    before - kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Part;

    #[test]
    fn collinear_points_are_degenerate_and_the_thinnest_sliver_is_not() {
        let line = |k: f32| Vec3::new(0.1, 0.2, 0.3) * k;
        assert!(is_degenerate([line(1.0), line(2.0), line(4.0)]));
        assert!(is_degenerate([Vec3::ZERO, Vec3::ZERO, Vec3::ONE]));
        let far = Vec3::new(457_604.6, 78_248.66, 2.5);
        assert!(is_degenerate([far, far + Vec3::X, far + 2.0 * Vec3::X]));
        // One ulp off the line, where f32 and f64 cross products both give zero or noise.
        let off = Vec3::new(f32::from_bits(far.x.to_bits() + 1), far.y, far.z);
        assert!(!is_degenerate([far, off, Vec3::new(far.x, f32::from_bits(far.y.to_bits() + 1), far.z)]));
        let tiny = f32::from_bits(1);
        assert!(!is_degenerate([Vec3::ZERO, Vec3::X * tiny, Vec3::Y * tiny]));
        assert!(!is_degenerate([Vec3::ONE * 1.0e30, Vec3::X * tiny, Vec3::ZERO]));
        assert!(!is_degenerate([Vec3::ZERO, Vec3::ONE, Vec3::new(2.0, 2.0, 2.000_000_2)]));
    }

    #[test]
    fn the_triangles_that_stay_keep_their_materials_and_parts() {
        let part = |first, count| Part { name: format!("{first}"), first, count };
        let mut mesh = TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 0, 1], [0, 1, 2], [1, 1, 2], [2, 0, 1]],
            materials: vec![4, 5, 6, 7],
            parts: vec![part(0, 2), part(2, 1), part(3, 1)],
            ..TriangleMesh::default()
        };
        assert_eq!(drop_degenerate(&mut mesh, &[]), 2);
        assert_eq!((mesh.triangles, mesh.materials), (vec![[0, 1, 2], [2, 0, 1]], vec![5, 7]));
        let parts: Vec<_> = mesh.parts.iter().map(|part| (&*part.name, part.first, part.count)).collect();
        assert_eq!(parts, [("0", 0, 1), ("3", 1, 1)]);
    }

    #[test]
    fn sums_are_exact() {
        let tiny = 2.0f64.powi(-200);
        // The last step leaves the rest in a low part, with a zero above it.
        assert!(!sums_to_zero([0.0, 0.0, 0.0, 1.0, tiny, -1.0]));
        assert!(!sums_to_zero([1.0, 1.0, -tiny, 1.0, -3.0, 0.0]));
        assert!(sums_to_zero([1.0, tiny, -1.0, 0.5 * tiny, 0.5 * tiny, -2.0 * tiny]));
    }
}
