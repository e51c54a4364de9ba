//! What a scene promises, checked: for scenes that a program builds without the readers, which check with line numbers.

use super::{CameraDescription, Light, MAX_COORDINATE, Scene, TriangleMesh};
use crate::error::{Error, Result};
use glam::Vec3;

impl Scene {
    /// Makes sure that rendering this scene cannot meet numbers or indices without a meaning.
    ///
    /// Triangles without area are no fault: no ray hits them.
    ///
    /// # Errors
    /// [`Error::Failed`] with the first of these: a vertex or normal that is not finite, a coordinate beyond
    /// [`MAX_COORDINATE`], an index out of range, a light without a finite place, unit direction, cone or strength, a
    /// camera that sees nothing (eye and at coincide, up along the view, fov not between 0 and 180), ambient light or
    /// a background that is not finite.
    pub fn check(&self) -> Result<()> {
        let fault = mesh(&self.mesh, self.materials.len())
            .or_else(|| self.lights.iter().enumerate().find_map(|(index, of)| light(index, of)))
            .or_else(|| camera(&self.camera))
            .or_else(|| (!self.ambient.is_finite()).then(|| "the ambient light is not finite".into()))
            .or_else(|| (!self.background.is_finite()).then(|| "the background is not finite".into()));
        match fault {
            None => Ok(()),
            Some(fault) => {
                Err(Error::Failed(format!("scene {}: {fault}; correct it before it is used", self.name)))
            }
        }
    }
}

/// False for NaN, too.
fn in_range(v: Vec3) -> bool {
    v.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()
}

fn mesh(mesh: &TriangleMesh, materials: usize) -> Option<String> {
    if let Some(vertex) = mesh.positions.iter().position(|&v| !in_range(v)) {
        let at = mesh.positions[vertex];
        return Some(format!("vertex {vertex} is at {at}, which is not within {MAX_COORDINATE:e}"));
    }
    if !mesh.normals.is_empty() && mesh.normals.len() != mesh.positions.len() {
        return Some(format!("{} normals belong to {} vertices", mesh.normals.len(), mesh.positions.len()));
    }
    if let Some(vertex) = mesh.normals.iter().position(|n| !n.is_finite()) {
        return Some(format!("the normal of vertex {vertex} is not finite"));
    }
    if let Some(prim) =
        mesh.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= mesh.positions.len()))
    {
        return Some(format!("triangle {prim} has a vertex that does not exist"));
    }
    if mesh.materials.len() != mesh.triangles.len() {
        return Some(format!(
            "{} materials belong to {} triangles",
            mesh.materials.len(),
            mesh.triangles.len()
        ));
    }
    let prim = mesh.materials.iter().position(|&material| material as usize >= materials)?;
    Some(format!("triangle {prim} has a material that does not exist"))
}

fn light(index: usize, light: &Light) -> Option<String> {
    let is_unit = |v: Vec3| (v.length() - 1.0).abs() < 1.0e-3;
    let (place, intensity) = match *light {
        Light::Point { position, intensity, .. } => (in_range(position), intensity),
        Light::Directional { direction, intensity } => (is_unit(direction), intensity),
        Light::Spot { position, direction, intensity, inner, outer, .. } => {
            // Written so that NaN fails.
            let cone = 0.0 <= inner && inner < outer && outer <= 1.001 * std::f32::consts::FRAC_PI_2;
            (in_range(position) && is_unit(direction) && cone, intensity)
        }
    };
    if !place {
        return Some(format!("light {index} has a position, direction or cone without a meaning"));
    }
    let strong = intensity.is_finite() && intensity.min_element() >= 0.0;
    (!strong).then(|| format!("light {index} has the strength {intensity}"))
}

fn camera(camera: &CameraDescription) -> Option<String> {
    let CameraDescription { eye, at, up, fov_deg } = *camera;
    if !in_range(eye) || !in_range(at) || !up.is_finite() {
        return Some(format!("the camera's numbers are not within {MAX_COORDINATE:e}"));
    }
    let Some(forward) = (at - eye).try_normalize() else {
        return Some("the camera is where it looks".into());
    };
    let across = up.try_normalize().map_or(0.0, |up| forward.cross(up).length());
    if across < 1.0e-7 {
        return Some("the camera's vector that points up has no length or points along the view".into());
    }
    let valid = fov_deg > 0.0 && fov_deg < 180.0;
    (!valid).then(|| format!("the camera's angle of view is {fov_deg} degrees, not between 0 and 180"))
}
