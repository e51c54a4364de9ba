//! What the material makes of a surface before light is added: textures, bent normals, emission, ambient light.

use super::{
    ground::Ground,
    queue::State,
    table::{Optics, PathTable},
};
use crate::{
    kernels::MISS,
    scene::{BumpKind, Texture},
    shade::Surfaces,
};
use glam::{Vec2, Vec3};

/// Fills emission, ambient light, alpha and which surfaces have highlights; with `TEXTURES`, also looks at the images.
/// Colours become emission alone: ambient light is added when its occlusion is known.
pub(super) fn dress<const TEXTURES: bool>(
    table: &PathTable,
    surfaces: &mut Surfaces,
    ground: &mut Ground,
    states: &[State],
    sampled: bool,
) {
    for ray in 0..surfaces.len() {
        let prim = surfaces.prim[ray];
        if prim == MISS {
            continue;
        }
        let optics = table.optics(prim);
        let (mut ke, mut ambient, mut alpha) = (optics.ke, optics.ambient, 1.0);
        if TEXTURES && optics.is_textured() && !table.charts.is_empty() {
            let look = Look::new(table, surfaces, ground, &states[ray], ray);
            if let Some(texture) = look.texture(optics.map_kd) {
                for k in 0..3 {
                    surfaces.kd[k][ray] *= texture[k];
                    ambient[k] *= if optics.ambient_is_diffuse { texture[k] } else { 1.0 };
                }
            }
            if let Some(texture) = look.texture(optics.map_ke) {
                ke = std::array::from_fn(|k| ke[k] * texture[k]);
            }
            alpha = look.texture(optics.map_d).map_or(1.0, |texture| texture[0].clamp(0.0, 1.0));
            look.bend(optics, surfaces, ground.side[ray], ray);
        }
        // Light that was sampled where the ray starts must not be seen again.
        if states[ray].unlit && sampled {
            ke = [0.0; 3];
        }
        ground.alpha[ray] = alpha;
        ground.highlight[ray] = if optics.reflect == [0.0; 3] { 1.0 } else { 0.0 };
        for k in 0..3 {
            ground.ke[k][ray] = ke[k];
            ground.ambient[k][ray] = ambient[k];
        }
    }
}

/// A place on a textured triangle.
struct Look<'a> {
    textures: &'a [Texture],
    uv: Vec2,
    /// Width of the ray's cone on the surface, in texture coordinates.
    footprint: f32,
    /// See [`super::table::Chart`].
    gradient: [Vec3; 2],
}

impl<'a> Look<'a> {
    fn new(
        table: &'a PathTable,
        surfaces: &Surfaces,
        ground: &Ground,
        state: &State,
        ray: usize,
    ) -> Look<'a> {
        let chart = &table.charts[surfaces.prim[ray] as usize];
        let width = state.width + state.spread * ground.distance[ray];
        let [n, v] = [&surfaces.ng, &surfaces.view].map(|planes| planes.each_ref().map(|plane| plane[ray]));
        // The cone's cross-section is stretched where it grazes; as a square of the same area.
        let cosine = (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]).abs().max(0.05);
        Look {
            textures: &table.scene.textures,
            uv: chart.at(ground.b[0][ray], ground.b[1][ray]),
            footprint: width * chart.density / cosine.sqrt(),
            gradient: chart.gradient,
        }
    }

    fn texture(&self, map: Option<u32>) -> Option<[f32; 4]> {
        map.map(|map| self.textures[map as usize].sample(self.uv, self.footprint))
    }

    /// Bends the shading normal; `side` as in [`Ground`].
    fn bend(&self, optics: &Optics, surfaces: &mut Surfaces, side: f32, ray: usize) {
        let Some(bump) = optics.bump else { return };
        let texture = &self.textures[bump.texture as usize];
        let of = |planes: &[Vec<f32>; 3]| Vec3::from(planes.each_ref().map(|plane| plane[ray]));
        let outward = side * of(&surfaces.ns);
        let [gu, gv] = self.gradient;
        let bent = match bump.kind {
            BumpKind::Height => {
                // Central differences a pixel wide, or as wide as what is seen.
                let size = texture.size().map(|side| side as f32);
                let step = (0.5 / size[0].max(size[1])).max(0.5 * self.footprint);
                let height =
                    |du: f32, dv: f32| texture.sample(self.uv + Vec2::new(du, dv), self.footprint)[0];
                let slope = |du: f32, dv: f32| (height(du, dv) - height(-du, -dv)) / (2.0 * step);
                outward - bump.strength * (slope(step, 0.0) * gu + slope(0.0, step) * gv)
            }
            BumpKind::Normal => {
                let [x, y, z, _] = texture.sample(self.uv, self.footprint).map(|value| 2.0 * value - 1.0);
                let along = |g: Vec3| (g - g.dot(outward) * outward).normalize_or_zero();
                (x * along(gu) + y * along(gv)) * bump.strength + z.max(0.01) * outward
            }
        };
        let bent = side * bent.normalize_or_zero();
        // A normal that looks away from the viewer would be lit from behind.
        if bent.dot(of(&surfaces.view)) > 0.0 && bent.is_finite() {
            for k in 0..3 {
                surfaces.ns[k][ray] = bent[k];
            }
        }
    }
}
