//! What following light needs to know of triangles and materials beyond [`crate::shade::SurfaceTable`], built once.

use super::bright::Bright;
use crate::{
    effects::{Effect, EffectSet},
    scene::{Bump, Material, Scene, Sky, TriangleMesh},
};
use glam::{Vec2, Vec3};

/// How light goes on from a material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Optics {
    /// Effects that surfaces of it need.
    pub(super) needs: EffectSet,
    /// Share of light that is reflected, or factor of Fresnel's reflectance.
    pub(super) reflect: [f32; 3],
    /// 1 if Fresnel's reflectance counts, else 0.
    pub(super) fresnel: f32,
    /// Index of refraction.
    pub(super) ni: f32,
    /// Share of light that goes through; zero for opaque materials.
    pub(super) through: [f32; 3],
    /// GGX alpha; 0 for a perfect mirror.
    pub(super) alpha: f32,
    /// Beer's absorption coefficient.
    pub(super) absorption: [f32; 3],
    /// Ambient light that is reflected, before textures and occlusion.
    pub(super) ambient: [f32; 3],
    /// Emission before textures.
    pub(super) ke: [f32; 3],
    /// Whether the ambient light has the colour of `map_kd`.
    pub(super) ambient_is_diffuse: bool,
    pub(super) map_kd: Option<u32>,
    pub(super) map_d: Option<u32>,
    pub(super) map_ke: Option<u32>,
    pub(super) bump: Option<Bump>,
}

impl Optics {
    /// Whether any texture counts.
    pub(super) fn is_textured(&self) -> bool {
        self.map_kd.is_some() || self.map_d.is_some() || self.map_ke.is_some() || self.bump.is_some()
    }

    /// What gets through on a straight line: shadows of glass are taken for unbent.
    pub(super) fn is_opaque(&self) -> bool {
        self.map_d.is_none() && self.through == [0.0; 3]
    }

    fn new(material: &Material, ambient: Vec3, set: EffectSet) -> Optics {
        let m = material;
        let kept = |effect: Effect, map: Option<u32>| map.filter(|_| set.has(effect));
        let rough = m.roughness.is_some();
        let reflects = m.reflects() && set.has(if rough { Effect::Glossy } else { Effect::Mirror });
        let refracts = m.refracts() && set.has(Effect::Refraction);
        let reflect = match m.illum {
            _ if !reflects => Vec3::ZERO,
            7 => Vec3::ONE,
            _ => m.ks,
        };
        let through = if refracts { (1.0 - m.d) * m.tf } else { Vec3::ZERO };
        let absorbs = refracts && set.has(Effect::Absorption);
        let reflectance = if m.ka == Vec3::ZERO { m.kd } else { m.ka };
        let mut optics = Optics {
            needs: EffectSet::EMPTY,
            reflect: reflect.to_array(),
            fresnel: if m.is_fresnel() { 1.0 } else { 0.0 },
            ni: m.ni,
            through: through.to_array(),
            alpha: m.roughness.filter(|_| reflects).map_or(0.0, |roughness| roughness * roughness),
            absorption: if absorbs { m.absorption.to_array() } else { [0.0; 3] },
            ambient: (reflectance * ambient).to_array(),
            ke: m.ke.to_array(),
            ambient_is_diffuse: m.ka == Vec3::ZERO,
            map_kd: kept(Effect::DiffuseTexture, m.map_kd),
            map_d: kept(Effect::AlphaCutout, m.map_d),
            map_ke: kept(Effect::EmissionTexture, m.map_ke),
            bump: m.bump.filter(|_| set.has(Effect::NormalMap)),
        };
        optics.needs = [
            (reflects && !rough, Effect::Mirror),
            (reflects && rough, Effect::Glossy),
            (refracts, Effect::Refraction),
            (absorbs, Effect::Absorption),
            (optics.map_kd.is_some(), Effect::DiffuseTexture),
            (optics.map_d.is_some(), Effect::AlphaCutout),
            (optics.map_ke.is_some(), Effect::EmissionTexture),
            (optics.bump.is_some(), Effect::NormalMap),
        ]
        .into_iter()
        .filter(|(needed, _)| *needed)
        .map(|(_, effect)| effect)
        .collect();
        optics
    }
}

/// How texture coordinates lie on a triangle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Chart {
    /// Coordinates of the corners.
    pub(super) uv: [Vec2; 3],
    /// Change of the coordinates per unit of length, about: root of the ratio of areas.
    pub(super) density: f32,
    /// Where a step of the point leads to greater u and to greater v; in the triangle's plane.
    pub(super) gradient: [Vec3; 2],
}

impl Chart {
    fn new(corners: [Vec3; 3], uv: [Vec2; 3]) -> Chart {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let [ua, ub, uc] = uv.map(Vec2::as_dvec2);
        let normal = (b - a).cross(c - a);
        let area = normal.length();
        let (u, v) = ((ub - ua), (uc - ua));
        // The gradient of the barycentric weight of b is n x (a - c) / n.n, that of c is n x (b - a) / n.n.
        let (gb, gc) = (normal.cross(a - c) / (area * area), normal.cross(b - a) / (area * area));
        let gradient = [gb * u.x + gc * v.x, gb * u.y + gc * v.y].map(|g| g.as_vec3());
        let gradient = gradient.map(|g| if g.is_finite() { g } else { Vec3::ZERO });
        let density = ((u.perp_dot(v)).abs() / area).sqrt() as f32;
        Chart { uv, density: if density.is_finite() { density } else { 0.0 }, gradient }
    }

    /// The coordinates at the barycentric weights of the second and third corner.
    pub(super) fn at(&self, b1: f32, b2: f32) -> Vec2 {
        let [a, b, c] = self.uv;
        a * (1.0 - b1 - b2) + b * b1 + c * b2
    }
}

/// A triangle that shines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shining {
    pub(super) prim: u32,
    pub(super) corner: Vec3,
    pub(super) edges: [Vec3; 2],
    pub(super) normal: Vec3,
    /// Its emission divided by the density with which a point of it is chosen.
    pub(super) value: Vec3,
}

/// Everything that following light needs of a scene.
#[derive(Debug)]
pub struct PathTable<'a> {
    pub(super) scene: &'a Scene,
    /// The effects that count.
    pub(super) set: EffectSet,
    pub(super) optics: Vec<Optics>,
    pub(super) corners: Vec<[[f32; 3]; 3]>,
    /// Empty if no texture counts.
    pub(super) charts: Vec<Chart>,
    /// Emitting triangles; empty if they do not light others.
    pub(super) shining: Vec<Shining>,
    /// Sums of the chances of the shining triangles up to and with each.
    pub(super) chances: Vec<f32>,
    /// Bright places of the sky, if it lights surfaces and has some.
    pub(super) bright: Option<Bright<'a>>,
    /// Whether shadow rays may go through something.
    pub(super) filters: bool,
}

impl<'a> PathTable<'a> {
    /// Collects what the effects of `set` need.
    pub fn new(scene: &'a Scene, set: EffectSet) -> PathTable<'a> {
        let mesh = &scene.mesh;
        let optics: Vec<Optics> =
            scene.materials.iter().map(|m| Optics::new(m, scene.ambient, set)).collect();
        let textured = !mesh.uvs.is_empty() && optics.iter().any(Optics::is_textured);
        let chart = |prim: usize| {
            Chart::new(mesh.corners(prim), mesh.triangles[prim].map(|vertex| mesh.uvs[vertex as usize]))
        };
        let lights = set.has(Effect::SoftShadows) && scene.settings.emitters;
        let (shining, chances) = if lights { shining(mesh, &scene.materials) } else { Default::default() };
        PathTable {
            corners: (0..mesh.len()).map(|prim| mesh.corners(prim).map(|corner| corner.to_array())).collect(),
            charts: if textured { (0..mesh.len()).map(chart).collect() } else { Vec::new() },
            filters: mesh.materials.iter().any(|&material| !optics[material as usize].is_opaque()),
            optics,
            scene,
            set,
            shining,
            chances,
            bright: match &scene.environment.sky {
                Sky::Map(map) if set.has(Effect::EnvironmentLight) => Bright::new(map),
                _ => None,
            },
        }
    }

    /// The effects that count.
    pub fn set(&self) -> EffectSet {
        self.set
    }

    /// The optics of a triangle's material.
    pub(super) fn optics(&self, prim: u32) -> &Optics {
        &self.optics[self.scene.mesh.materials[prim as usize] as usize]
    }
}

/// Emitting triangles and their cumulated chances, which go by the power that they send.
fn shining(mesh: &TriangleMesh, materials: &[Material]) -> (Vec<Shining>, Vec<f32>) {
    let mut all = Vec::new();
    let (mut powers, mut total) = (Vec::new(), 0.0f64);
    for prim in 0..mesh.len() {
        let ke = materials[mesh.materials[prim] as usize].ke;
        let [a, b, c] = mesh.corners(prim);
        let normal = (b - a).as_dvec3().cross((c - a).as_dvec3());
        let power = 0.5 * normal.length() * f64::from(ke.element_sum());
        if power > 0.0 {
            total += power;
            powers.push(total);
            let normal = normal.normalize().as_vec3();
            all.push(Shining { prim: prim as u32, corner: a, edges: [b - a, c - a], normal, value: ke });
        }
    }
    for light in &mut all {
        // emission / (power / total / area), in which the area cancels.
        light.value *= (total / f64::from(light.value.element_sum())) as f32;
    }
    (all, powers.iter().map(|power| (power / total) as f32).collect())
}
