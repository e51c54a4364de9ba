//! Surface materials, in the vocabulary of Wavefront MTL.

use glam::Vec3;

/// A surface material. All MTL quantities are kept, also those that no effect uses yet.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name as the source gave it.
    pub name: String,
    /// `Ka`: ambient reflectance.
    pub ka: Vec3,
    /// `Kd`: diffuse reflectance.
    pub kd: Vec3,
    /// `Ks`: specular reflectance.
    pub ks: Vec3,
    /// `Ke`: emitted radiance.
    pub ke: Vec3,
    /// `Ns`: Blinn-Phong exponent, >= 0.
    pub ns: f32,
    /// `Ni`: index of refraction, > 0.
    pub ni: f32,
    /// `d` (= 1 - `Tr`): opacity in [0, 1].
    pub d: f32,
    /// `illum`: the MTL illumination model, 0 to 10.
    pub illum: u8,
}

impl Default for Material {
    /// The grey that is used where a source names no material.
    fn default() -> Material {
        Material {
            name: "default".into(),
            ka: Vec3::ZERO,
            kd: Vec3::splat(0.7),
            ks: Vec3::ZERO,
            ke: Vec3::ZERO,
            ns: 1.0,
            ni: 1.0,
            d: 1.0,
            illum: 2,
        }
    }
}
