//! Polygons to triangles: a fan where that is right, ear clipping where it is not.

use glam::{DVec2, DVec3, Vec3};

/// Beyond this many corners clipping ears takes too long (its time grows with the square).
const MAX_CLIPPED: usize = 4096;

/// Calls `emit` with the corner numbers of each triangle. False if the polygon could not be triangulated properly
/// (it crosses itself, say) and a fan was used instead.
pub(super) fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) -> bool {
    let n = corners.len();
    if n == 3 {
        emit([0, 1, 2]);
        return true;
    }
    let flat = flatten(corners);
    let fan_is_right = (1..n - 1).all(|i| turn(flat[0], flat[i], flat[i + 1]) >= 0.0)
        && (0..n).all(|i| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0);
    let triangles = if fan_is_right || n > MAX_CLIPPED { None } else { clip_ears(&flat) };
    match &triangles {
        Some(triangles) => triangles.iter().for_each(|&triangle| emit(triangle)),
        None => (1..n - 1).for_each(|i| emit([0, i, i + 1])),
    }
    fan_is_right || triangles.is_some()
}

/// The polygon seen along its normal (Newell's), so that it runs anticlockwise.
fn flatten(corners: &[Vec3]) -> Vec<DVec2> {
    let origin = corners[0].as_dvec3();
    let relative = |i: usize| corners[i % corners.len()].as_dvec3() - origin;
    let normal: DVec3 = (0..corners.len()).map(|i| relative(i).cross(relative(i + 1))).sum();
    let (drop, _) = normal
        .abs()
        .to_array()
        .into_iter()
        .enumerate()
        .fold((2, 0.0), |best, (axis, size)| if size > best.1 { (axis, size) } else { best });
    let (x, y) = ((drop + 1) % 3, (drop + 2) % 3);
    let mirror = if normal[drop] < 0.0 { -1.0 } else { 1.0 };
    (0..corners.len()).map(|i| DVec2::new(relative(i)[x] * mirror, relative(i)[y])).collect()
}

/// Twice the signed area: positive for a left turn.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Cuts off one ear after the other; none if at some point there is no ear.
fn clip_ears(flat: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut rest: Vec<usize> = (0..flat.len()).collect();
    let mut triangles = Vec::with_capacity(flat.len() - 2);
    while rest.len() > 3 {
        let n = rest.len();
        let ear = (0..n).find(|&i| is_ear(flat, &rest, i))?;
        triangles.push([rest[(ear + n - 1) % n], rest[ear], rest[(ear + 1) % n]]);
        rest.remove(ear);
    }
    triangles.push([rest[0], rest[1], rest[2]]);
    // What remains of a polygon that crosses itself may be turned over.
    (turn(flat[rest[0]], flat[rest[1]], flat[rest[2]]) >= 0.0).then_some(triangles)
}

/// True if corner `i` sticks out and no other corner of the rest lies in the triangle it makes with its neighbours.
fn is_ear(flat: &[DVec2], rest: &[usize], i: usize) -> bool {
    let n = rest.len();
    let [a, b, c] = [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]].map(|corner| flat[corner]);
    turn(a, b, c) > 0.0
        && rest.iter().map(|&corner| flat[corner]).all(|p| {
            // Corners repeated where a polygon touches itself (a bridge to a hole) do not block the ear.
            p == a || p == b || p == c || turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(corners: &[[f32; 2]], area: f64) {
        // In every plane, and both ways round.
        for (axes, reverse) in [([0, 1], false), ([1, 2], false), ([2, 0], true), ([0, 1], true)] {
            let mut placed: Vec<Vec3> = corners
                .iter()
                .map(|&[x, y]| {
                    let mut p = Vec3::splat(5.0);
                    (p[axes[0]], p[axes[1]]) = (x, y);
                    p
                })
                .collect();
            if reverse {
                placed.reverse();
            }
            let (mut sum, mut vector, mut count) = (0.0, DVec3::ZERO, 0);
            assert!(triangulate(&placed, |t| {
                let [a, b, c] = t.map(|i| placed[i].as_dvec3());
                let n = (b - a).cross(c - a) * 0.5;
                (sum, vector, count) = (sum + n.length(), vector + n, count + 1);
            }));
            assert_eq!(count, corners.len() - 2);
            // Equal sums of areas and of vectors: no triangle lies outside or is turned over.
            assert!((sum - area).abs() < 1.0e-6, "{sum} instead of {area}");
            assert!((vector.length() - area).abs() < 1.0e-6);
        }
    }

    #[test]
    fn convex_and_concave_polygons_keep_their_area() {
        check(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 2.0);
        check(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]], 3.0);
        // An arrow head whose fan from corner 0 leaves the polygon.
        check(&[[0.0, 0.0], [2.0, 2.0], [0.0, 1.0], [-2.0, 2.0]], 2.0);
        check(&[[2.0, 2.0], [0.0, 1.0], [-2.0, 2.0], [0.0, 0.0]], 2.0);
        // A star of five points.
        let star: Vec<[f32; 2]> = (0..10)
            .map(|i| {
                let (sin, cos) = (i as f32 * std::f32::consts::PI / 5.0).sin_cos();
                let radius = [2.0, 0.7][i % 2];
                [radius * cos, radius * sin]
            })
            .collect();
        let area = 10.0 * 0.5 * 2.0 * 0.7 * (std::f64::consts::PI / 5.0).sin();
        check(&star, area);
    }

    #[test]
    fn a_bow_tie_is_reported_and_still_gives_triangles() {
        let tie = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [-1.0, 1.0]];
        let placed: Vec<Vec3> = tie.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect();
        let mut count = 0;
        let proper = triangulate(&placed, |_| count += 1);
        assert_eq!((proper, count), (false, 3));
    }
}
