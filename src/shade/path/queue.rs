//! Rays that wait to be traced, and what is known of each.

use crate::{
    kernels::{Ray, RayBlock, SUB},
    shade::surface::Planes,
};

/// What kind of ray it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Camera,
    Reflection,
    Refraction,
    /// Goes on through a hole.
    Through,
    /// A diffuse reflection.
    Diffuse,
}

/// How a ray came about.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub(super) kind: Kind,
    /// Sees no light that was sampled where it starts, nor the sky.
    pub(super) unlit: bool,
    /// Reflections and refractions in a row.
    pub(super) depth: u32,
    /// Diffuse reflections.
    pub(super) bounces: u32,
    /// Holes in a row.
    pub(super) layers: u32,
    /// Material that it travels in, plus 1; 0 for none.
    pub(super) medium: u32,
    /// Pixel that it belongs to.
    pub(super) pixel: u32,
    /// Of its samples.
    pub(super) key: u32,
    /// Which of them it is.
    pub(super) number: u32,
    /// Width of the cone around it where it starts.
    pub(super) width: f32,
    /// Growth of the width per unit of length.
    pub(super) spread: f32,
}

/// Rays in order, sixteen to a block.
#[derive(Clone, Debug, Default)]
pub(super) struct Queue {
    pub(super) blocks: Vec<RayBlock>,
    pub(super) states: Vec<State>,
    /// What a ray's colour counts in its pixel.
    pub(super) weight: Planes,
}

impl Queue {
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.states.clear();
        self.weight.iter_mut().for_each(Vec::clear);
    }

    pub(super) fn len(&self) -> usize {
        self.states.len()
    }

    pub(super) fn push(&mut self, ray: &Ray, state: State, weight: [f32; 3]) {
        let lane = self.states.len() % SUB;
        if lane == 0 {
            self.blocks.push(RayBlock::EMPTY);
        }
        if let Some(block) = self.blocks.last_mut() {
            block.set(lane, ray);
        }
        self.states.push(state);
        for (plane, weight) in self.weight.iter_mut().zip(weight) {
            plane.push(weight);
        }
    }
}
