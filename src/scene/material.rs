//! Surface materials, in the vocabulary of Wavefront MTL.

use glam::Vec3;

/// A surface material. Which of its quantities count is up to `illum`, as MTL has it:
///
/// | `illum` | what light does there |
/// | --- | --- |
/// | 0, 1, 2, 8, 10 | diffuse reflection `kd` and, with lights, a highlight `ks`, `ns`; opaque whatever `d` says |
/// | 3 | the same, and a mirror image weighted by `ks` (blurred where there is a `roughness`) |
/// | 4, 6 | as 3, and what `d` lets through is refracted by `ni` and filtered by `tf` |
/// | 5 | as 3, with `ks` times Fresnel's reflectance of a surface with index `ni` in place of `ks` |
/// | 7 | as 6, with Fresnel's reflectance in place of `ks`, taken off what is refracted |
/// | 9 | as 6 without reflection, save where refraction is impossible |
///
/// A mesh that refracts should be closed, with its triangles counter-clockwise as seen from outside: that tells rays that
/// enter from rays that leave.
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
    /// `Tf`: what is left of light that goes through the surface, each in [0, 1].
    pub tf: Vec3,
    /// Beer's law: light that travels a length `s` inside is weakened by exp(-`absorption` s); >= 0, per unit of the scene.
    pub absorption: Vec3,
    /// `Pr`: how rough the surface is, in (0, 1]; its square is alpha of the GGX distribution. `None` for a perfect mirror.
    pub roughness: Option<f32>,
    /// `map_Kd`: its colour multiplies `kd` (and the ambient reflectance, where `ka` is zero). Index into
    /// [`super::Scene::textures`], as all maps.
    pub map_kd: Option<u32>,
    /// `map_d`: the first channel is the share of the surface that is there, for cut-outs such as leaves.
    pub map_d: Option<u32>,
    /// `map_Ke`: its colour multiplies `ke`.
    pub map_ke: Option<u32>,
    /// `map_Bump` or `norm`: bends the shading normal.
    pub bump: Option<Bump>,
}

impl Material {
    /// Whether it has a mirror image in it: `illum` 3 to 7.
    pub fn reflects(&self) -> bool {
        match self.illum {
            3 | 4 | 6 => self.ks != Vec3::ZERO,
            5 => self.ks != Vec3::ZERO && self.ni != 1.0,
            7 => self.ni != 1.0,
            _ => false,
        }
    }

    /// Whether light goes through it: `illum` 4, 6, 7 or 9, and `d` below 1.
    pub fn refracts(&self) -> bool {
        matches!(self.illum, 4 | 6 | 7 | 9) && self.d < 1.0
    }

    /// Whether what it reflects follows from Fresnel's equations: `illum` 5 or 7.
    pub fn is_fresnel(&self) -> bool {
        matches!(self.illum, 5 | 7)
    }
}

/// A texture that bends shading normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Index into [`super::Scene::textures`].
    pub texture: u32,
    /// What its values mean.
    pub kind: BumpKind,
    /// For heights: the height of value 1 in units of the scene. For normals: factor of the slopes, 1 as they are.
    pub strength: f32,
}

/// What the values of a [`Bump`] mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BumpKind {
    /// Heights, in the first channel.
    Height,
    /// Normals n in the tangent frame (along u, along v, outwards), stored as (n + 1) / 2.
    Normal,
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
            tf: Vec3::ONE,
            absorption: Vec3::ZERO,
            roughness: None,
            map_kd: None,
            map_d: None,
            map_ke: None,
            bump: None,
        }
    }
}
