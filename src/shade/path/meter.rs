//! What following light takes: rays by kind, and the time that tracing and shading take.

use std::time::{Duration, Instant};

/// A number for each kind of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayTally {
    /// From the camera.
    pub primary: u64,
    /// Between lights and surfaces.
    pub shadow: u64,
    /// Mirrored, sharply or not.
    pub reflection: u64,
    /// Refracted, or on their way through holes.
    pub refraction: u64,
    /// Diffusely reflected, for indirect light.
    pub indirect: u64,
    /// That look whether ambient light gets to a surface.
    pub ambient: u64,
}

impl RayTally {
    /// Adds others.
    pub fn add(&mut self, other: &RayTally) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.reflection += other.reflection;
        self.refraction += other.refraction;
        self.indirect += other.indirect;
        self.ambient += other.ambient;
    }

    /// Rays of all kinds.
    pub fn total(&self) -> u64 {
        let RayTally { primary, shadow, reflection, refraction, indirect, ambient } = *self;
        primary + shadow + reflection + refraction + indirect + ambient
    }
}

/// Splits a tile's time into tracing and the rest, and counts its rays.
#[derive(Clone, Copy, Debug)]
pub struct Meter {
    /// Rays traced.
    pub rays: RayTally,
    /// Pairs of a ray and a triangle that exact arithmetic decided.
    pub doubts: RayTally,
    /// Time spent tracing.
    pub trace: Duration,
    /// Time spent on everything else.
    pub shade: Duration,
    last: Instant,
}

impl Meter {
    /// Begins now.
    pub fn start() -> Meter {
        let (rays, none) = (RayTally::default(), Duration::ZERO);
        Meter { rays, doubts: rays, trace: none, shade: none, last: Instant::now() }
    }

    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.last, now)
    }

    /// What happened since the last call was tracing.
    pub fn trace(&mut self) {
        let lap = self.lap();
        self.trace += lap;
    }

    /// What happened since the last call was anything else.
    pub fn shade(&mut self) {
        let lap = self.lap();
        self.shade += lap;
    }
}
