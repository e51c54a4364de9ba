//! Putting a mesh in its place: scale, then rotation about x, y and z, then translation.

use crate::scene::{BumpKind, MAX_COORDINATE, Material, TriangleMesh};
use glam::{DMat3, DVec3, Vec3};

/// Where a scene file puts a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    /// Factor per axis, none zero.
    pub(super) scale: [f64; 3],
    /// Degrees about x, then y, then z.
    pub(super) rotate: [f64; 3],
    /// Offset.
    pub(super) translate: [f64; 3],
}

impl Default for Placement {
    fn default() -> Placement {
        Placement { scale: [1.0; 3], rotate: [0.0; 3], translate: [0.0; 3] }
    }
}

impl Placement {
    /// Moves the vertices, computed in f64 and rounded once. False if one of them gets out of range.
    pub(super) fn apply(&self, mesh: &mut TriangleMesh) -> bool {
        // A mirror image runs the other way round: turn every triangle, so that its front stays in front.
        if self.scale.iter().product::<f64>() < 0.0 {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        self.move_vertices(&mut mesh.positions, &mut mesh.normals)
    }

    /// The same without the triangles.
    pub(super) fn move_vertices(&self, positions: &mut [Vec3], normals: &mut [Vec3]) -> bool {
        if *self == Placement::default() {
            return true;
        }
        let rotation = rotation(self.rotate);
        let linear = rotation * DMat3::from_diagonal(DVec3::from_array(self.scale));
        let translate = DVec3::from_array(self.translate);
        for position in &mut *positions {
            *position = (linear * position.as_dvec3() + translate).as_vec3();
        }
        let inverse = DVec3::from_array(self.scale).recip();
        for normal in normals {
            *normal = (rotation * (normal.as_dvec3() * inverse)).normalize_or_zero().as_vec3();
        }
        // False for NaN, too.
        positions.iter().all(|position| position.abs().cmple(Vec3::splat(MAX_COORDINATE)).all())
    }
}

impl Placement {
    /// Hills grow with the mesh, by the mean of the factors.
    pub(super) fn apply_to_bumps(&self, materials: &mut [Material]) {
        let factor = self.scale.iter().product::<f64>().abs().cbrt() as f32;
        let bumps = materials.iter_mut().filter_map(|material| material.bump.as_mut());
        for bump in bumps.filter(|bump| bump.kind == BumpKind::Height) {
            bump.strength *= factor;
        }
    }
}

/// Rotation by degrees about x, then y, then z.
pub(super) fn rotation([x, y, z]: [f64; 3]) -> DMat3 {
    about(2, z) * about(1, y) * about(0, x)
}

/// Rotation about a coordinate axis; exact for quarter turns, so that walls stay axis-aligned.
fn about(axis: usize, degrees: f64) -> DMat3 {
    let degrees = degrees % 360.0;
    let quarters = degrees / 90.0;
    let (sin, cos) = match quarters.fract() == 0.0 {
        true => [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(quarters as i32).rem_euclid(4) as usize],
        false => degrees.to_radians().sin_cos(),
    };
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut matrix = DMat3::IDENTITY;
    let columns = [&mut matrix.x_axis, &mut matrix.y_axis, &mut matrix.z_axis];
    for (index, column) in columns.into_iter().enumerate() {
        if index == next {
            (column[next], column[last]) = (cos, sin);
        } else if index == last {
            (column[next], column[last]) = (-sin, cos);
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Part;

    fn corner() -> TriangleMesh {
        TriangleMesh {
            positions: vec![Vec3::X, Vec3::Y, Vec3::Z],
            normals: vec![Vec3::X; 3],
            uvs: Vec::new(),
            triangles: vec![[0, 1, 2]],
            materials: vec![0],
            parts: vec![Part { name: "corner".into(), first: 0, count: 1 }],
        }
    }

    fn placed(scale: [f64; 3], rotate: [f64; 3], translate: [f64; 3]) -> TriangleMesh {
        let mut mesh = corner();
        assert!(Placement { scale, rotate, translate }.apply(&mut mesh));
        mesh
    }

    #[test]
    fn scales_then_rotates_about_x_y_z_then_translates() {
        let turned = placed([2.0, 1.0, 1.0], [90.0, 0.0, 0.0], [0.0, 0.0, 5.0]);
        assert_eq!(
            turned.positions,
            [Vec3::new(2.0, 0.0, 5.0), Vec3::new(0.0, 0.0, 6.0), Vec3::new(0.0, -1.0, 5.0)]
        );
        // x to z first would give another result than z to x first.
        let twice = placed([1.0; 3], [90.0, 0.0, 90.0], [0.0; 3]);
        assert_eq!(twice.positions, [Vec3::Y, Vec3::Z, Vec3::X]);
        assert_eq!(placed([1.0; 3], [0.0, -270.0, 0.0], [0.0; 3]).positions[0], -Vec3::Z);
        let eighth = placed([1.0; 3], [0.0, 45.0, 0.0], [0.0; 3]).positions[0];
        assert!((eighth - Vec3::new(0.5f32.sqrt(), 0.0, -(0.5f32.sqrt()))).length() < 1.0e-7, "{eighth}");
    }

    #[test]
    fn a_mirror_image_keeps_its_front() {
        let mirrored = placed([-1.0, 1.0, 1.0], [0.0; 3], [0.0; 3]);
        assert_eq!(mirrored.triangles, [[0, 2, 1]]);
        assert_eq!(mirrored.normals[0], -Vec3::X);
        assert!(
            !Placement { scale: [1.0e38; 3], rotate: [45.0; 3], translate: [3.4e38; 3] }.apply(&mut corner())
        );
    }
}
