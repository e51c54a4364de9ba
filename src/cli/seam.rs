//! Stands in for the scene readers until they are merged.

use crate::{
    error::{Error, Result},
    scene::{CameraDescription, Falloff, Light, Material, Part, Scene, TriangleMesh},
};
use glam::Vec3;

pub(super) fn load(spec: &str) -> Result<Scene> {
    if spec != super::DEFAULT_SCENE {
        return Err(Error::file(spec, "there is no such scene", "see irt scenes"));
    }
    let mut positions = vec![];
    let mut triangles = vec![];
    let mut quad = |corner: Vec3, du: Vec3, dv: Vec3| {
        let first = positions.len() as u32;
        positions.extend([corner, corner + du, corner + du + dv, corner + dv]);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, Vec3::Z * -10.0);
    for x in 0..5 {
        for z in 0..5 {
            let c = Vec3::new(x as f32 * 2.0 - 4.5, 0.2, z as f32 * 2.0 - 4.0);
            quad(c, Vec3::X, Vec3::new(0.0, 1.0, -0.5));
        }
    }
    let count = triangles.len();
    let mesh = TriangleMesh {
        positions,
        normals: vec![],
        triangles,
        materials: vec![0; count],
        parts: vec![Part { name: "all".into(), first: 0, count: count as u32 }],
    };
    let light = |x: f32| Light::Point {
        position: Vec3::new(x, 6.0, 3.0),
        intensity: Vec3::splat(0.5),
        falloff: Falloff::None,
    };
    Ok(Scene {
        name: spec.into(),
        mesh,
        materials: vec![Material::default()],
        lights: vec![light(-3.0), light(3.0)],
        camera: CameraDescription {
            eye: Vec3::new(0.0, 4.0, 9.0),
            at: Vec3::ZERO,
            up: Vec3::Y,
            fov_deg: 50.0,
        },
        ambient: Vec3::splat(0.1),
        background: Vec3::splat(0.2),
        size: [1024, 1024],
        warnings: vec![],
    })
}
