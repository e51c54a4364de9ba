//! What a scene holds, counted: the figures of `irt inspect`.

use super::{
    AreaLight, Falloff, Light, Motion, Scene, Sky, Track, TriangleMesh,
    tally::{DEGENERATE, total},
};
use std::collections::HashSet;

/// What a scene holds.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SceneReport {
    /// The scene's name.
    pub name: String,
    /// Triangles that are rendered.
    pub triangles: usize,
    /// Vertices, also those that no triangle uses.
    pub vertices: usize,
    /// Vertices with a normal of their own.
    pub normals: usize,
    /// Triangles that have the same three positions as an earlier one, in any order.
    pub duplicates: usize,
    /// Triangles of exactly zero area that the files have and that were dropped.
    pub degenerate_dropped: usize,
    /// Smallest coordinates of the triangles.
    pub bounds_min: [f32; 3],
    /// Greatest coordinates of the triangles.
    pub bounds_max: [f32; 3],
    /// Where the triangles come from, in order.
    pub parts: Vec<Share>,
    /// Materials, with the triangles that have them.
    pub materials: Vec<Share>,
    /// Textures, in order.
    pub textures: Vec<TextureReport>,
    /// Lights without extent in order, then those with one.
    pub lights: Vec<LightReport>,
    /// What surrounds the scene: `background`, `gradient` or `map`.
    pub sky: &'static str,
    /// It lights the scene.
    pub sky_light: bool,
    /// How it moves, if it does.
    pub motion: Option<MotionReport>,
    /// The camera.
    pub camera: CameraReport,
    /// What was repaired, dropped or ignored while loading.
    pub warnings: Vec<String>,
}

/// Something that has a number of the triangles.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Share {
    /// Its name.
    pub name: String,
    /// Its triangles.
    pub triangles: usize,
}

/// A light; what its kind does not have is left out.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LightReport {
    /// `point`, `directional`, `spot`, `rectangle` or `sphere`.
    pub kind: &'static str,
    /// Where it is: its place, middle or corner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f32; 3]>,
    /// Where its light travels to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f32; 3]>,
    /// Edges of a rectangle, from the corner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edges: Option<[[f32; 3]; 2]>,
    /// Radius of a sphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f32>,
    /// Linear colour times strength; of lights with an extent, their radiance.
    pub intensity: [f32; 3],
    /// `none` or `inverse-square`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub falloff: Option<&'static str>,
    /// Half angles of the inner and the whole cone, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone_deg: Option<[f32; 2]>,
}

/// A texture.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct TextureReport {
    /// Its name, mostly that of its file.
    pub name: String,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Memory of all its versions.
    pub bytes: usize,
}

/// How a scene moves.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MotionReport {
    /// Seconds from the first moment to the last.
    pub length: f64,
    /// Images per second that show each shape of the fastest sequence.
    pub rate: f64,
    /// What moves: vertices, shapes, shapes per second, and keys.
    pub tracks: Vec<TrackReport>,
}

/// Vertices that move together.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TrackReport {
    /// How many.
    pub vertices: usize,
    /// Meshes of a sequence, or one.
    pub shapes: usize,
    /// Shapes per second.
    pub rate: f64,
    /// Keys between which it is turned and moved as a whole.
    pub keys: usize,
}

/// The camera.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct CameraReport {
    /// Position of the pinhole.
    pub eye: [f32; 3],
    /// The point in the middle of the image.
    pub at: [f32; 3],
    /// Up in the image.
    pub up: [f32; 3],
    /// Vertical field of view, degrees.
    pub fov_deg: f32,
}

impl Scene {
    /// Counts what is in the scene.
    pub fn report(&self) -> SceneReport {
        let bounds = self.mesh.bounds();
        let share = |name: &String, triangles| Share { name: name.clone(), triangles };
        let mut by_material = vec![0; self.materials.len()];
        for &material in &self.mesh.materials {
            by_material[material as usize] += 1;
        }
        SceneReport {
            name: self.name.clone(),
            triangles: self.mesh.len(),
            vertices: self.mesh.positions.len(),
            normals: self.mesh.normals.iter().filter(|&&n| n != glam::Vec3::ZERO).count(),
            duplicates: self.mesh.duplicates(),
            degenerate_dropped: total(&self.warnings, DEGENERATE),
            bounds_min: bounds.min.to_array(),
            bounds_max: bounds.max.to_array(),
            parts: self.mesh.parts.iter().map(|part| share(&part.name, part.count as usize)).collect(),
            materials: self.materials.iter().zip(by_material).map(|(m, n)| share(&m.name, n)).collect(),
            textures: self.textures.iter().map(TextureReport::new).collect(),
            lights: {
                let with_extent = self.area_lights.iter().map(LightReport::with_extent);
                self.lights.iter().map(LightReport::new).chain(with_extent).collect()
            },
            sky: match self.environment.sky {
                Sky::Background => "background",
                Sky::Gradient { .. } => "gradient",
                Sky::Map(_) => "map",
            },
            sky_light: self.environment.light,
            motion: self.motion.as_ref().map(MotionReport::new),
            camera: CameraReport {
                eye: self.camera.eye.to_array(),
                at: self.camera.at.to_array(),
                up: self.camera.up.to_array(),
                fov_deg: self.camera.fov_deg,
            },
            warnings: self.warnings.clone(),
        }
    }
}

impl MotionReport {
    fn new(of: &Motion) -> MotionReport {
        let track = |track: &Track| TrackReport {
            vertices: track.vertices.len(),
            shapes: track.shapes.len(),
            rate: track.rate,
            keys: track.keys.len(),
        };
        MotionReport { length: of.length(), rate: of.rate(), tracks: of.tracks.iter().map(track).collect() }
    }
}

impl TextureReport {
    fn new(of: &super::Texture) -> TextureReport {
        TextureReport { name: of.name.clone(), size: of.size(), bytes: of.bytes() }
    }
}

impl LightReport {
    const DARK: LightReport = LightReport {
        kind: "point",
        position: None,
        direction: None,
        edges: None,
        radius: None,
        intensity: [0.0; 3],
        falloff: None,
        cone_deg: None,
    };

    fn with_extent(light: &AreaLight) -> LightReport {
        match *light {
            AreaLight::Rectangle { corner, edge_u, edge_v, radiance, two_sided: _ } => LightReport {
                kind: "rectangle",
                position: Some(corner.to_array()),
                edges: Some([edge_u.to_array(), edge_v.to_array()]),
                intensity: radiance.to_array(),
                ..LightReport::DARK
            },
            AreaLight::Sphere { center, radius, radiance } => LightReport {
                kind: "sphere",
                position: Some(center.to_array()),
                radius: Some(radius),
                intensity: radiance.to_array(),
                ..LightReport::DARK
            },
        }
    }

    fn new(light: &Light) -> LightReport {
        let name = |falloff| match falloff {
            Falloff::None => "none",
            Falloff::InverseSquare => "inverse-square",
        };
        match *light {
            Light::Point { position, intensity, falloff } => LightReport {
                position: Some(position.to_array()),
                intensity: intensity.to_array(),
                falloff: Some(name(falloff)),
                ..LightReport::DARK
            },
            Light::Directional { direction, intensity } => LightReport {
                kind: "directional",
                direction: Some(direction.to_array()),
                intensity: intensity.to_array(),
                ..LightReport::DARK
            },
            Light::Spot { position, direction, intensity, falloff, inner, outer } => LightReport {
                kind: "spot",
                position: Some(position.to_array()),
                direction: Some(direction.to_array()),
                intensity: intensity.to_array(),
                falloff: Some(name(falloff)),
                cone_deg: Some([inner.to_degrees(), outer.to_degrees()]),
                ..LightReport::DARK
            },
        }
    }
}

impl TriangleMesh {
    /// Number of triangles that have the same three positions as an earlier one, in any order.
    pub fn duplicates(&self) -> usize {
        let mut seen = HashSet::with_capacity(self.len());
        // Adding zero makes -0.0 and 0.0, which are the same place, the same bits.
        let key = |prim: usize| {
            let mut corners = self.corners(prim).map(|p| p.to_array().map(|c| (c + 0.0).to_bits()));
            corners.sort_unstable();
            corners
        };
        (0..self.len()).filter(|&prim| !seen.insert(key(prim))).count()
    }
}
