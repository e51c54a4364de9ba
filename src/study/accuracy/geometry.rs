//! What a mode hits and lights, against the reference: pixel by pixel.
//!
//! * A *tie* is another triangle at the same point: beyond a shared edge, or of a surface that coincides.
//! * An *error* is a triangle elsewhere, or a hit where there is none, or none where there is one.
//! * *Depths* are compared where both hit the same triangle, in units in the last place of f32.
//! * A *shadow error* is a pixel that a light reaches and should not, or the other way about. It is read off the mode's own
//!   images: white surfaces, one light at a time.

use super::{
    modes::Mode,
    reference::{FirstHit, Line, Reference},
};
use crate::{
    bvh::Bvh,
    camera::{Camera, PACKET_SIDE, pixel_of},
    effects::{Effect, EffectChoice, EffectSet},
    error::Result,
    kernels::{Hit, Kernels, MISS, Ray, SUB, TILE_RAYS, TileHits, TilePacket},
    render::{RenderOptions, Stage},
    scene::{Material, Scene},
    schedule::{Control, Placement},
    study::stability::share,
    trace::{KernelChoice, PacketScratch, Traversal},
};
use glam::{DVec3, Vec3};

/// What a mode's first hits and shadows are worth.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Geometry {
    /// Primary rays.
    pub rays: u64,
    /// Another triangle at the same point.
    pub ties: u64,
    /// Another triangle elsewhere, or hit instead of miss, or miss instead of hit.
    pub errors: u64,
    /// Median error of the depth, in units in the last place; `None` if nothing is hit.
    pub depth_median: Option<f64>,
    /// Greatest error of the depth.
    pub depth_max: Option<f64>,
    /// NaN among depths and weights.
    pub nan: u64,
    /// Pixels times lights.
    pub shadows: u64,
    /// Those lit and dark the other way about.
    pub shadow_errors: u64,
}

/// Depths that differ by less of themselves are those of one point: 16 units in the last place of f32.
const SAME_POINT: f64 = 1.0 / (1 << 20) as f64;

/// All primary rays of a view, and what the reference says of them.
pub(super) struct View {
    size: [u32; 2],
    rays: Vec<Ray>,
    hits: Vec<Option<FirstHit>>,
    /// By light, then pixel.
    lit: Vec<Vec<bool>>,
}

impl View {
    /// Traces the rays of the scene's camera by the reference, on threads.
    pub(super) fn new(scene: &Scene, bvh: &Bvh, kernels: Kernels, size: [u32; 2], threads: usize) -> View {
        let (rays, _) = first_hits(scene, bvh, kernels, KernelChoice::Single, size);
        let reference = Reference::new(&scene.mesh);
        let row = size[0] as usize;
        type Found = (Vec<(usize, Option<FirstHit>, Vec<bool>)>,);
        let trace = |found: &mut Found, y: usize| {
            for pixel in y * row..(y + 1) * row {
                let line = line(&rays[pixel]);
                let hit = reference.intersect(&line);
                let lit = |light| hit.is_some_and(|hit| reference.lit(&line, &hit, light));
                found.0.push((pixel, hit, scene.lights.iter().map(lit).collect()));
            }
        };
        let mut hits = vec![None; rays.len()];
        let mut lit = vec![vec![false; rays.len()]; scene.lights.len()];
        for (found,) in share(threads, size[1] as usize, || (vec![],), trace) {
            for (pixel, hit, by_light) in found {
                hits[pixel] = hit;
                by_light.into_iter().zip(&mut lit).for_each(|(is, lit)| lit[pixel] = is);
            }
        }
        View { size, rays, hits, lit }
    }

    /// Compares first hits.
    pub(super) fn judge(&self, hits: &[Hit], scene: &Scene) -> Geometry {
        let reference = |prim, ray: &Ray| {
            let corners = scene.mesh.corners(prim as usize).map(Vec3::as_dvec3);
            plane_depth(corners, &line(ray))
        };
        let mut sum = Geometry { rays: hits.len() as u64, ..Geometry::default() };
        let mut depths = vec![];
        for ((hit, right), ray) in hits.iter().zip(&self.hits).zip(&self.rays) {
            sum.nan += u64::from([hit.t, hit.u, hit.v].iter().any(|x| x.is_nan()) && hit.prim != MISS);
            match right {
                None => sum.errors += u64::from(hit.prim != MISS),
                Some(_) if hit.prim == MISS => sum.errors += 1,
                Some(right) if right.prim == hit.prim => {
                    depths.push((f64::from(hit.t) - right.at.t).abs() / last_place(right.at.t));
                }
                Some(right) => {
                    let there = reference(hit.prim, ray);
                    let tie = (there - right.at.t).abs() <= SAME_POINT * right.at.t;
                    sum.ties += u64::from(tie);
                    sum.errors += u64::from(!tie);
                }
            }
        }
        depths.sort_by(f64::total_cmp);
        sum.depth_median = (!depths.is_empty()).then(|| depths[depths.len() / 2]);
        sum.depth_max = depths.last().copied();
        sum
    }

    /// Judges how a stage of `mode` hits and lights the scene.
    ///
    /// # Errors
    /// As [`crate::render::render`].
    pub(super) fn measure(
        &self,
        stage: &Stage,
        scene: &Scene,
        mode: Mode,
        options: &RenderOptions,
        control: &Control,
    ) -> Result<Geometry> {
        let options = RenderOptions { size: self.size, ..mode.options(options) };
        let kernels = stage.kernels();
        let (_, hits) = first_hits(scene, stage.bvh(), kernels, options.kernel, self.size);
        let mut sum = self.judge(&hits, scene);
        for (index, lit) in self.lit.iter().enumerate() {
            let seen = lit_by(stage, scene, index, &options, control)?;
            sum.shadows += lit.len() as u64;
            sum.shadow_errors += lit.iter().zip(&seen).filter(|(right, seen)| right != seen).count() as u64;
        }
        Ok(sum)
    }
}

/// Which pixels one of the lights reaches, by the image of a scene that is white and has no other light.
fn lit_by(
    stage: &Stage,
    scene: &Scene,
    light: usize,
    options: &RenderOptions,
    control: &Control,
) -> Result<Vec<bool>> {
    let white = Material { kd: Vec3::ONE, ..Material::default() };
    let materials = scene.materials.iter().map(|_| white.clone()).collect();
    let one = Scene {
        mesh: scene.mesh.clone(),
        materials,
        lights: vec![scene.lights[light]],
        camera: scene.camera,
        ..Scene::default()
    };
    let effects = EffectChoice::Only(EffectSet::of(&[Effect::HardShadows]));
    let stage = stage.beside(&one, &RenderOptions { effects, ..*options })?;
    let placement = Placement::new(crate::schedule::Machine::get(), options.threads, options.pin);
    let tiles = stage.tiles(options.tile);
    stage.with_session(&placement, |session| {
        session.frame(options.schedule, &tiles, control)?;
        Ok(session.film().pixels().map(|[r, ..]| r > 0.0).collect())
    })
}

/// All primary rays and what a kernel finds, by pixel.
pub(super) fn first_hits(
    scene: &Scene,
    bvh: &Bvh,
    kernels: Kernels,
    kernel: KernelChoice,
    [width, height]: [u32; 2],
) -> (Vec<Ray>, Vec<Hit>) {
    let camera = Camera::new(&scene.camera, width, height);
    let traversal = Traversal::new(bvh, kernels, kernel);
    let pixels = width as usize * height as usize;
    let nothing = Ray { org: [0.0; 3], dir: [0.0; 3], tnear: 0.0, tfar: 0.0, skip: MISS };
    let (mut rays, mut hits) = (vec![nothing; pixels], vec![Hit::MISS; pixels]);
    let mut packets = Box::new(std::array::from_fn(|_| TilePacket::new()));
    let (mut found, mut scratch) = (TileHits::new(), PacketScratch::new());
    for (top, left) in (0..height)
        .step_by(PACKET_SIDE as usize)
        .flat_map(|y| (0..width).step_by(PACKET_SIDE as usize).map(move |x| (y, x)))
    {
        scratch.begin();
        let used = camera.rays(&kernels, [left, top], [width - left, height - top], &mut packets);
        for packet in &packets[..used] {
            traversal.intersect(packet, &mut scratch, &mut found);
            for ray in (0..TILE_RAYS).filter(|ray| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0) {
                let (x, y) = pixel_of(ray);
                let pixel = ((top + y) * width + left + x) as usize;
                (rays[pixel], hits[pixel]) = (packet.ray(ray), found.hit(ray));
            }
        }
    }
    (rays, hits)
}

fn line(ray: &Ray) -> Line {
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    Line { org: wide(ray.org), dir: wide(ray.dir), end: f64::from(ray.tfar), skip: None }
}

/// Where a ray meets the plane of a triangle.
fn plane_depth([a, b, c]: [DVec3; 3], line: &Line) -> f64 {
    let normal = (b - a).cross(c - a);
    normal.dot(a - line.org) / normal.dot(line.dir)
}

/// Distance of neighbouring f32 at `t`.
fn last_place(t: f64) -> f64 {
    let t = (t as f32).abs();
    f64::from(t.next_up()) - f64::from(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(scene: &Scene) -> (View, Vec<Hit>, Bvh) {
        let bvh = Bvh::build(&scene.mesh, crate::bvh::BuildPreset::Fast).unwrap();
        let kernels = Kernels::detect();
        let view = View::new(scene, &bvh, kernels, [61, 47], 2);
        let (_, hits) = first_hits(scene, &bvh, kernels, KernelChoice::Tile, [61, 47]);
        (view, hits, bvh)
    }

    #[test]
    fn exact_hits_are_right_and_injected_errors_are_counted_for_what_they_are() {
        let scene = crate::scene::load("atrium@0.2").unwrap();
        let (view, mut hits, _) = view(&scene);
        let clean = view.judge(&hits, &scene);
        assert_eq!((clean.errors, clean.nan), (0, 0), "{clean:?}");
        assert!(clean.depth_median.unwrap() < 1.0, "{clean:?}");
        let hit: Vec<usize> = (0..hits.len()).filter(|&i| hits[i].prim != MISS).collect();
        // A miss, a triangle elsewhere, a depth 8 units off, a NaN.
        hits[hit[0]] = Hit::MISS;
        let far = hits.iter().filter(|h| h.prim != MISS).max_by(|a, b| a.t.total_cmp(&b.t)).unwrap().prim;
        hits[hit[1]].prim = far;
        hits[hit[2]].t = f32::from_bits(hits[hit[2]].t.to_bits() + 800);
        hits[hit[3]].u = f32::NAN;
        let injected = view.judge(&hits, &scene);
        assert_eq!((injected.errors, injected.nan, injected.ties), (2, 1, clean.ties), "{injected:?}");
        assert!((injected.depth_max.unwrap() - 800.0).abs() < 2.0, "{injected:?}");
        // A hit where nothing is.
        let sky = hits.iter().zip(&view.hits).position(|(hit, right)| hit.prim == MISS && right.is_none());
        hits[sky.expect("the atrium is open above")].prim = 0;
        assert_eq!(view.judge(&hits, &scene).errors, 3);
    }

    #[test]
    fn the_same_triangle_twice_is_a_tie() {
        let mut scene = crate::scene::load("atrium@0.1").unwrap();
        let (_, before, _) = view(&scene);
        // All triangles again: of two at one depth, the first one is right, and the second a tie.
        let count = scene.mesh.len() as u32;
        let (triangles, materials) = (scene.mesh.triangles.clone(), scene.mesh.materials.clone());
        scene.mesh.triangles.extend(triangles);
        scene.mesh.materials.extend(materials);
        scene.mesh.parts[0].count += count;
        let (view, mut hits, _) = view(&scene);
        assert_eq!(view.judge(&hits, &scene).errors, 0);
        assert_eq!(hits[0].prim, before[0].prim);
        let ties = view.judge(&hits, &scene).ties;
        let moved =
            hits.iter_mut().filter(|hit| hit.prim < count).take(5).map(|hit| hit.prim += count).count();
        let judged = view.judge(&hits, &scene);
        assert_eq!((judged.ties - ties, judged.errors), (moved as u64, 0));
    }
}
