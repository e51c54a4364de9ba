//! From a scene to its effects, with reasons.

use crate::scene::{Effect, EffectSet, Environment, Material, Scene, Sky};
use glam::Vec3;

/// Why an effect is called for, or why not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// The effect.
    pub effect: Effect,
    /// Whether the scene calls for it.
    pub called: bool,
    /// A sentence without a full stop.
    pub why: String,
}

/// A reason for each effect, in the order of [`Effect::ALL`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reasons(Vec<Reason>);

impl Reasons {
    /// What `scene` calls for.
    pub fn new(scene: &Scene) -> Reasons {
        let usage = Usage::new(scene);
        let reason = |effect: Effect| {
            let (called, why) = match usage.reason(effect) {
                Ok(_) if scene.settings.without.has(effect) => {
                    (false, "left out by the scene's settings".to_string())
                }
                Ok(why) => (true, why),
                Err(why) => (false, why),
            };
            Reason { effect, called, why }
        };
        Reasons(Effect::ALL.map(reason).to_vec())
    }

    /// The effects that are called for.
    pub fn set(&self) -> EffectSet {
        self.0.iter().filter(|reason| reason.called).map(|reason| reason.effect).collect()
    }

    /// All reasons, in the order of [`Effect::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = &Reason> {
        self.0.iter()
    }
}

/// A scene with the number of triangles of each material.
struct Usage<'a> {
    scene: &'a Scene,
    triangles: Vec<usize>,
}

impl<'a> Usage<'a> {
    fn new(scene: &'a Scene) -> Usage<'a> {
        let mut triangles = vec![0; scene.materials.len()];
        for &material in &scene.mesh.materials {
            if let Some(count) = triangles.get_mut(material as usize) {
                *count += 1;
            }
        }
        Usage { scene, triangles }
    }

    /// Why an effect is called for, or else why it is not.
    fn reason(&self, effect: Effect) -> Result<String, String> {
        let settings = &self.scene.settings;
        match effect {
            Effect::HardShadows => match self.scene.lights.len() {
                0 => Err("no point, directional or spot light".into()),
                count => Ok(counted(count, "light without extent", "lights without extent")),
            },
            Effect::Highlights if !self.has_sources() => Err("no light to be reflected".into()),
            Effect::Highlights => {
                self.material(effect, |m| m.ks != Vec3::ZERO, |m| format!("Ks {}", rgb(m.ks)))
            }
            Effect::SmoothNormals => self.smooth_normals(),
            Effect::SoftShadows => self.soft_shadows(),
            Effect::Mirror => self.mirror(effect, |m| m.roughness.is_none()),
            Effect::Glossy => self.mirror(effect, |m| m.roughness.is_some()),
            Effect::Refraction => self.refraction(),
            Effect::Absorption => self.material(
                effect,
                |m| m.refracts() && m.absorption != Vec3::ZERO,
                |m| format!("absorption {}", rgb(m.absorption)),
            ),
            Effect::DiffuseTexture => self.map(effect, "map_Kd", |m| m.map_kd),
            Effect::AlphaCutout => self.map(effect, "map_d", |m| m.map_d),
            Effect::NormalMap => self.map(effect, "map_Bump or norm", |m| m.bump.map(|bump| bump.texture)),
            Effect::EmissionTexture => self.map(effect, "map_Ke", |m| m.map_ke),
            Effect::Sky => match self.scene.environment.sky {
                Sky::Background => Err("the background has one colour".into()),
                Sky::Gradient { .. } => Ok("the sky is a gradient".into()),
                Sky::Map(_) => Ok("the sky is an image".into()),
            },
            Effect::EnvironmentLight => match self.scene.environment {
                Environment { light: false, .. } => Err("the environment is not a light".into()),
                _ => Ok("the environment is a light".into()),
            },
            Effect::AmbientOcclusion => match settings.ambient_occlusion {
                None => Err("not switched on".into()),
                Some(_) if self.scene.ambient == Vec3::ZERO => Err("no ambient light to be occluded".into()),
                Some(of) => Ok(format!("switched on, within {} units", of.radius)),
            },
            Effect::IndirectLight => match settings.bounces {
                0 => Err("not switched on".into()),
                bounces => Ok(format!("switched on, {}", counted(bounces as usize, "bounce", "bounces"))),
            },
            Effect::DepthOfField => match settings.depth_of_field {
                None => Err("the camera is a pinhole".into()),
                Some(of) => Ok(format!("a lens of radius {}, in focus at {}", of.aperture, of.focus)),
            },
            Effect::Antialiasing => match settings.samples {
                1 => Err("one sample per pixel".into()),
                samples => match settings.adaptive {
                    None => Ok(format!("{samples} samples per pixel")),
                    Some(least) => {
                        Ok(format!("{samples} samples per pixel that differs by {least} from another"))
                    }
                },
            },
        }
    }

    fn has_sources(&self) -> bool {
        !self.scene.lights.is_empty() || self.soft_shadows().is_ok()
    }

    /// The most used material that fits, with what `tell` tells of it.
    fn material(
        &self,
        effect: Effect,
        fits: impl Fn(&Material) -> bool,
        tell: impl Fn(&Material) -> String,
    ) -> Result<String, String> {
        let fitting = || self.scene.materials.iter().zip(&self.triangles).filter(|(m, _)| fits(m));
        let used = || fitting().filter(|(_, triangles)| **triangles > 0);
        let name = |material: &Material| material.name.escape_debug().to_string();
        // The first of the most used ones.
        let most = used().rev().max_by_key(|(_, triangles)| **triangles);
        match (most, fitting().next()) {
            (Some((material, &triangles)), _) => {
                let others = match used().count() - 1 {
                    0 => String::new(),
                    count => format!("; and {}", counted(count, "other material", "other materials")),
                };
                let triangles = counted(triangles, "triangle", "triangles");
                Ok(format!("material `{}` has {}, {triangles}{others}", name(material), tell(material)))
            }
            (None, Some((material, _))) => {
                Err(format!("material `{}` has {}, but no triangle uses it", name(material), tell(material)))
            }
            (None, None) => Err(format!("no material calls for {effect}")),
        }
    }

    fn mirror(&self, effect: Effect, fits: impl Fn(&Material) -> bool) -> Result<String, String> {
        let tell = |m: &Material| match (m.is_fresnel(), m.roughness) {
            (true, None) => format!("illum {} and Ni {}", m.illum, m.ni),
            (false, None) => format!("illum {} and Ks {}", m.illum, rgb(m.ks)),
            (_, Some(roughness)) => format!("illum {} and roughness {roughness}", m.illum),
        };
        self.material(effect, |m| m.reflects() && fits(m), tell)
    }

    fn refraction(&self) -> Result<String, String> {
        let found = self.material(Effect::Refraction, Material::refracts, |m| {
            format!("Tr {} and illum {}", 1.0 - m.d, m.illum)
        });
        let opaque = |m: &Material| m.d < 1.0 && !m.refracts();
        let mut used =
            self.scene.materials.iter().zip(&self.triangles).filter(|(_, triangles)| **triangles > 0);
        match used.find(|(material, _)| opaque(material)) {
            Some((material, _)) if found.is_err() => Err(format!(
                "material `{}` has Tr {}, but illum {} lets no light through; illum 4, 6, 7 and 9 do",
                material.name.escape_debug(),
                1.0 - material.d,
                material.illum
            )),
            _ => found,
        }
    }

    fn map(
        &self,
        effect: Effect,
        key: &str,
        map: impl Fn(&Material) -> Option<u32>,
    ) -> Result<String, String> {
        let tell = |m: &Material| {
            let texture = map(m).and_then(|texture| self.scene.textures.get(texture as usize));
            format!("{key} `{}`", texture.map_or("", |texture| &texture.name).escape_debug())
        };
        let found = self.material(effect, |m| map(m).is_some(), tell);
        match found {
            Ok(why) if self.scene.mesh.uvs.is_empty() => {
                Err(format!("{why}, but the meshes have no texture coordinates"))
            }
            found => found,
        }
    }

    fn smooth_normals(&self) -> Result<String, String> {
        let mesh = &self.scene.mesh;
        if mesh.normals.is_empty() {
            return Err("no vertex has a normal of its own".into());
        }
        let smooth = |corners: &&[u32; 3]| corners.iter().any(|&v| mesh.normals[v as usize] != Vec3::ZERO);
        match mesh.triangles.iter().filter(smooth).count() {
            0 => Err("no triangle has a vertex with a normal of its own".into()),
            count => {
                Ok(format!("{} with normals of their vertices", counted(count, "triangle", "triangles")))
            }
        }
    }

    fn soft_shadows(&self) -> Result<String, String> {
        let emission = |m: &Material| format!("Ke {}", rgb(m.ke));
        let emitters = self.material(Effect::SoftShadows, |m| m.ke != Vec3::ZERO, emission);
        match (self.scene.area_lights.len(), emitters) {
            (0, Ok(why)) if self.scene.settings.emitters => Ok(why),
            (0, Ok(why)) => Err(format!("{why}, which only glows: emitters are not switched on as lights")),
            (0, Err(_)) => Err("no light with an extent".into()),
            (count, _) => Ok(counted(count, "light with an extent", "lights with an extent")),
        }
    }
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// One number where all three are equal.
fn rgb(color: Vec3) -> String {
    let [r, g, b] = color.to_array();
    if r == g && g == b { r.to_string() } else { format!("({r} {g} {b})") }
}
