//! The steps themselves.

use super::stage::Stage;
use crate::{
    kernels::{
        Kernels, Ray, SUB, TILE_RAYS, TileHits, TilePacket,
        micro::{Meeting, fold},
    },
    scene::Light,
    shade::{LightRays, Surfaces, add_light, light_rays},
    trace::{KernelChoice, NO_OCCLUDER, PacketScratch, PointShadows, RayStream, Traversal},
};
use std::hint::black_box;

/// Rays that are sorted together.
const STREAM: usize = 256;

/// One step, ready to be repeated.
pub struct Step<'a> {
    name: &'static str,
    unit: &'static str,
    units: u64,
    work: Work<'a>,
}

type Work<'a> = Box<dyn FnMut(&mut Sum) + 'a>;

impl Step<'_> {
    /// Name.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// What is counted.
    pub fn unit(&self) -> &'static str {
        self.unit
    }

    /// How many of them a pass has; never 0.
    pub fn units(&self) -> u64 {
        self.units
    }

    /// One pass.
    pub fn run(&mut self) {
        (self.work)(&mut Sum(None));
    }

    /// One pass that must be the first; returns a number that depends on every bit of its results.
    pub(super) fn check(&mut self) -> u64 {
        let mut sum = Sum(Some(0));
        (self.work)(&mut sum);
        sum.0.unwrap_or(0)
    }
}

/// Adds up results, if that is wanted. Otherwise they only seem to be looked at.
struct Sum(Option<u64>);

impl Sum {
    #[inline]
    fn words(&mut self, words: impl IntoIterator<Item = u32>) {
        let words = black_box(words);
        if let Some(sum) = &mut self.0 {
            *sum = words.into_iter().fold(*sum, fold);
        }
    }

    #[inline]
    fn floats(&mut self, floats: &[f32]) {
        self.words(floats.iter().map(|x| x.to_bits()));
    }

    fn hits(&mut self, hits: &TileHits) {
        self.words(hits.prim.iter().copied());
        [&hits.t, &hits.u, &hits.v].into_iter().for_each(|plane| self.floats(plane));
    }
}

/// All steps for which the scene has work.
pub fn steps(stage: &Stage, kernels: Kernels) -> Vec<Step<'_>> {
    let mut steps = vec![ray_generation(stage, kernels)];
    steps.extend(tile_steps(stage, kernels));
    steps.extend(primary(stage, kernels));
    if let Some((light, position)) = stage.light {
        steps.extend(shadow(stage, kernels, light, position));
    }
    steps.push(stream_sort(stage, Traversal::new(&stage.bvh, kernels, KernelChoice::Tile)));
    steps.retain(|step| step.units > 0);
    steps
}

fn step<'a>(name: &'static str, unit: &'static str, units: u64, work: impl FnMut(&mut Sum) + 'a) -> Step<'a> {
    Step { name, unit, units, work: Box::new(work) }
}

fn ray_generation(stage: &Stage, kernels: Kernels) -> Step<'_> {
    let mut six = Box::new(std::array::from_fn(|_| TilePacket::new()));
    step("ray generation", "ray", stage.pixels(), move |sum| {
        for (at, inside) in stage.corners() {
            let used = stage.camera.rays(&kernels, at, inside, &mut six);
            for packet in &six[..used] {
                sum.floats(&packet.u);
                sum.floats(&packet.v);
                sum.words(packet.active.iter().copied().map(u32::from));
            }
        }
    })
}

/// The steps of the tile kernel.
fn tile_steps(stage: &Stage, kernels: Kernels) -> [Step<'_>; 4] {
    let meetings = stage.meetings();
    let k = kernels;
    [
        tile_step(&meetings, "box test", "box", Meeting::boxes, move |m| m.test_boxes(&k)),
        tile_step(&meetings, "leaf set-up", "triangle", Meeting::triangles, move |m| m.set_up_leaves(&k)),
        tile_step(&meetings, "triangle test", "ray x triangle", Meeting::pairs, move |m| {
            m.test_triangles(&k);
        }),
        tile_step(&meetings, "finishing hits", "ray", Meeting::rays, move |m| m.finish(&k)),
    ]
}

fn tile_step<'a>(
    meetings: &[Meeting<'a>],
    name: &'static str,
    unit: &'static str,
    units: impl Fn(&Meeting<'a>) -> u64,
    run: impl Fn(&mut Meeting<'a>) + 'a,
) -> Step<'a> {
    let mut meetings = meetings.to_vec();
    step(name, unit, meetings.iter().map(units).sum(), move |sum| {
        for meeting in &mut meetings {
            run(meeting);
            let checksum = sum.0.is_some().then(|| meeting.checksum());
            sum.words(checksum.into_iter().flat_map(|sum| [sum as u32, (sum >> 32) as u32]));
        }
    })
}

/// The whole traversal of primary rays.
fn primary(stage: &Stage, kernels: Kernels) -> [Step<'_>; 2] {
    let traversal = Traversal::new(&stage.bvh, kernels, KernelChoice::Tile);
    let packets = || stage.patches.iter().flat_map(|patch| &patch.packets);
    let active = |packet: &TilePacket, ray: usize| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0;
    let rays: Vec<Ray> = packets()
        .flat_map(|packet| (0..TILE_RAYS).filter(move |&i| active(packet, i)).map(|i| packet.ray(i)))
        .collect();
    let (mut hits, mut scratch) = (TileHits::new(), PacketScratch::new());
    [
        step("primary packets", "ray", stage.pixels(), move |sum| {
            for packet in packets() {
                traversal.intersect(packet, &mut scratch, &mut hits);
                sum.hits(&hits);
            }
        }),
        step("primary, single rays", "ray", stage.pixels(), move |sum| {
            for ray in &rays {
                let hit = traversal.intersect_ray(ray);
                sum.words([hit.prim, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()]);
            }
        }),
    ]
}

/// From the surfaces that a light may reach to its light there.
fn shadow(stage: &Stage, kernels: Kernels, light: Light, position: [f32; 3]) -> [Step<'_>; 4] {
    let wanted = stage.patches.iter().map(|patch| patch.wanted()).sum();
    let surfaces = stage.patches.iter().map(|patch| patch.surfaces.len() as u64).sum();
    let mut rays = LightRays::default();
    let mut lit: Vec<Surfaces> = stage.patches.iter().map(|patch| patch.surfaces.clone()).collect();
    let traversal = |bvh| Traversal::new(bvh, kernels, KernelChoice::Tile);
    [
        step("shadow ray generation", "surface", surfaces, move |sum| {
            for patch in &stage.patches {
                light_rays(&kernels, &stage.table, &patch.surfaces, &light, &mut rays);
                [&rays.u, &rays.v, &rays.limit].into_iter().for_each(|plane| sum.floats(plane));
                sum.words(rays.face.iter().copied());
            }
        }),
        shadow_streams("shadow regrouping", wanted, stage, traversal(&stage.nothing), position),
        shadow_streams("shadow streams", wanted, stage, traversal(&stage.bvh), position),
        step("adding light", "ray", wanted, move |sum| {
            for (patch, surfaces) in stage.patches.iter().zip(&mut lit) {
                add_light(&kernels, &light, &patch.rays, surfaces);
                surfaces.color.iter().for_each(|plane| sum.floats(plane));
            }
        }),
    ]
}

/// Shadow rays regrouped and traced.
fn shadow_streams<'a>(
    name: &'static str,
    wanted: u64,
    stage: &'a Stage,
    traversal: Traversal<'a>,
    position: [f32; 3],
) -> Step<'a> {
    let (mut shadows, mut visible, mut seed) = (PointShadows::default(), Vec::new(), NO_OCCLUDER);
    step(name, "ray", wanted, move |sum| {
        for patch in &stage.patches {
            visible.clone_from(&patch.rays.visible);
            let traced = shadows.trace(&traversal, position, &patch.shadow_rays(), &mut seed, &mut visible);
            sum.words([traced.rays as u32]);
            sum.floats(&visible);
        }
    })
}

/// What a stream does with rays before it traces them: find company, sort.
fn stream_sort<'a>(stage: &'a Stage, traversal: Traversal<'a>) -> Step<'a> {
    let mut stream = RayStream::default();
    step("stream sort", "ray", stage.bounces.len() as u64, move |sum| {
        for blocks in stage.bounces.blocks().chunks(STREAM) {
            sum.words(
                stream
                    .regroup(&traversal, blocks)
                    .iter()
                    .map(|pick| pick.block << 16 | u32::from(pick.active)),
            );
        }
    })
}
