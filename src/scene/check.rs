//! What a scene promises, checked: for scenes that a program builds without the readers, which check with line numbers.

use super::{
    AreaLight, CameraDescription, Light, MAX_COORDINATE, Material, RenderSettings, Scene, Sky, TriangleMesh,
};
use crate::error::{Error, Result};
use glam::Vec3;

impl Scene {
    /// Makes sure that rendering this scene cannot meet numbers or indices without a meaning.
    ///
    /// Triangles without area are no fault: no ray hits them.
    ///
    /// # Errors
    /// [`Error::Failed`] with the first of these: a vertex or normal that is not finite, a coordinate beyond
    /// [`MAX_COORDINATE`], an index out of range, motion that does not fit the mesh, a light without a finite place, unit direction, cone or strength, a
    /// camera that sees nothing (eye and at coincide, up along the view, fov not between 0 and 180), ambient light or
    /// a background that is not finite, and what [`Material`], [`AreaLight`], [`super::SkyMap`] and [`RenderSettings`] do not
    /// allow.
    pub fn check(&self) -> Result<()> {
        let fault = mesh(&self.mesh, self.materials.len())
            .or_else(|| self.motion.as_ref()?.fault(self.mesh.positions.len()))
            .or_else(|| self.materials.iter().find_map(|of| material(of, self.textures.len())))
            .or_else(|| self.lights.iter().enumerate().find_map(|(index, of)| light(index, of)))
            .or_else(|| self.area_lights.iter().enumerate().find_map(|(index, of)| area_light(index, of)))
            .or_else(|| sky(&self.environment.sky))
            .or_else(|| settings(&self.settings))
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
    if !mesh.uvs.is_empty() && mesh.uvs.len() != mesh.positions.len() {
        return Some(format!(
            "{} texture coordinates belong to {} vertices",
            mesh.uvs.len(),
            mesh.positions.len()
        ));
    }
    if let Some(vertex) = mesh.uvs.iter().position(|uv| !uv.is_finite()) {
        return Some(format!("the texture coordinates of vertex {vertex} are not finite"));
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

/// False for NaN, too.
fn is_color(color: Vec3) -> bool {
    color.is_finite() && color.min_element() >= 0.0
}

fn material(of: &Material, textures: usize) -> Option<String> {
    let name = of.name.escape_debug();
    let colors = [("ka", of.ka), ("kd", of.kd), ("ks", of.ks), ("ke", of.ke), ("absorption", of.absorption)];
    if let Some((key, value)) = colors.into_iter().find(|&(_, value)| !is_color(value)) {
        return Some(format!("material {name} has the {key} {value}"));
    }
    let unit = |x: f32| (0.0..=1.0).contains(&x);
    let rough = of.roughness.is_none_or(|roughness| roughness > 0.0 && roughness <= 1.0);
    let bumpy = of.bump.is_none_or(|bump| bump.strength.is_finite());
    let numbers = [
        ("ns", of.ns >= 0.0 && of.ns.is_finite()),
        ("ni", of.ni > 0.0 && of.ni.is_finite()),
        ("d", unit(of.d)),
        ("tf", is_color(of.tf) && of.tf.max_element() <= 1.0),
        ("roughness", rough),
        ("strength of its bumps", bumpy),
    ];
    if let Some((key, _)) = numbers.into_iter().find(|&(_, valid)| !valid) {
        return Some(format!("the {key} of material {name} is out of range"));
    }
    let maps = [of.map_kd, of.map_d, of.map_ke, of.bump.map(|bump| bump.texture)];
    let missing = maps.into_iter().flatten().any(|map| map as usize >= textures);
    missing.then(|| format!("material {name} has a texture that does not exist"))
}

fn area_light(index: usize, light: &AreaLight) -> Option<String> {
    let (place, radiance) = match *light {
        AreaLight::Rectangle { corner, edge_u, edge_v, radiance, .. } => {
            let area = edge_u.cross(edge_v).length();
            let valid = in_range(corner) && in_range(edge_u) && in_range(edge_v) && area > 0.0;
            (valid && area.is_finite(), radiance)
        }
        AreaLight::Sphere { center, radius, radiance } => {
            (in_range(center) && radius > 0.0 && radius <= MAX_COORDINATE, radiance)
        }
    };
    if !place {
        return Some(format!("area light {index} has no area or is out of range"));
    }
    (!is_color(radiance)).then(|| format!("area light {index} has the radiance {radiance}"))
}

fn sky(sky: &Sky) -> Option<String> {
    match sky {
        Sky::Background => None,
        Sky::Gradient { zenith, horizon, ground } => {
            let valid = [zenith, horizon, ground].into_iter().all(|&color| is_color(color));
            (!valid).then(|| "the colours of the sky are not finite or negative".into())
        }
        Sky::Map(map) => {
            let pixels = u64::from(map.size[0]) * u64::from(map.size[1]);
            let valid = pixels > 0
                && pixels == map.pixels.len() as u64
                && map.rotation.is_finite()
                && map.strength.is_finite()
                && map.strength >= 0.0
                && map.pixels.iter().all(|&pixel| is_color(pixel.into()));
            (!valid).then(|| "the image of the sky lacks pixels, or some are not finite or negative".into())
        }
    }
}

fn settings(settings: &RenderSettings) -> Option<String> {
    let ambient = settings.ambient_occlusion.is_none_or(|of| of.radius > 0.0 && of.samples > 0);
    let lens = settings.depth_of_field.is_none_or(|of| {
        let valid = |length: f32| length > 0.0 && length <= MAX_COORDINATE;
        valid(of.aperture) && valid(of.focus)
    });
    let numbers = [
        ("samples", settings.samples > 0),
        ("adaptive threshold", settings.adaptive.is_none_or(|least| least > 0.0 && least.is_finite())),
        ("light samples", settings.light_samples > 0),
        ("ambient occlusion", ambient),
        ("depth of field", lens),
        ("cut-off", settings.cutoff >= 0.0 && settings.cutoff.is_finite()),
    ];
    let (key, _) = numbers.into_iter().find(|&(_, valid)| !valid)?;
    Some(format!("the {key} of its settings must be greater than 0 and finite"))
}
