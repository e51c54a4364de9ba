//! How high the hills of a bump map are.
//!
//! MTL gives heights no unit. Here, white stands `-bm` texels above black, as wide as texels are on the surfaces that
//! have the material, in the mean: then a map looks the same on a cup and on a house.

use crate::scene::{BumpKind, Material, Texture, TriangleMesh};

/// Turns strengths from texels into units of the mesh.
pub(super) fn settle(mesh: &TriangleMesh, materials: &mut [Material], textures: &[Texture]) {
    if mesh.uvs.is_empty() {
        return;
    }
    for (index, material) in materials.iter_mut().enumerate() {
        if let Some(bump) = material.bump.as_mut().filter(|bump| bump.kind == BumpKind::Height) {
            bump.strength *= texel(mesh, index as u32, &textures[bump.texture as usize]);
        }
    }
}

/// Mean width of a texel on the triangles of a material; 0 if they show none of the picture.
fn texel(mesh: &TriangleMesh, material: u32, texture: &Texture) -> f32 {
    let (mut in_space, mut in_texels) = (0.0, 0.0);
    for prim in (0..mesh.len()).filter(|&prim| mesh.materials[prim] == material) {
        let [a, b, c] = mesh.corners(prim).map(|p| p.as_dvec3());
        let [s, t, u] = mesh.triangles[prim].map(|v| mesh.uvs[v as usize].as_dvec2());
        in_space += (b - a).cross(c - a).length();
        in_texels += (t - s).perp_dot(u - s).abs() * f64::from(texture.density()).powi(2);
    }
    let width = (in_space / in_texels).sqrt() as f32;
    if width.is_finite() { width } else { 0.0 }
}
