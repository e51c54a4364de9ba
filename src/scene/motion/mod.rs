//! Triangles that move: which vertices, and where each is when.
//!
//! ```text
//!   shapes, so many per second --between two of them--> positions --turned and moved as keys say--> the mesh at a time
//! ```
//!
//! What is joined to triangles stays: vertex numbers, materials, texture coordinates. Places are computed in f64 from what
//! the files say and rounded once, so that a moment has one image, whatever was shown before it.

mod key;

pub use key::Key;

use super::{MAX_COORDINATE, Scene, TriangleMesh};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Vertices at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Position of each.
    pub positions: Vec<Vec3>,
    /// Unit normal of each, or zero; empty if there are none.
    pub normals: Vec<Vec3>,
}

/// Vertices that move together.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Which vertices of the mesh.
    pub vertices: Range<usize>,
    /// What they look like, at equal distances in time; at least one.
    pub shapes: Vec<Shape>,
    /// Shapes per second, > 0.
    pub rate: f64,
    /// How they are turned and moved as a whole, by time; none if they are not.
    pub keys: Vec<Key>,
}

/// How the triangles of a scene move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// What moves; tracks share no vertex.
    pub tracks: Vec<Track>,
}

/// Shapes per second where nothing says how many.
pub const DEFAULT_RATE: f64 = 24.0;

impl Motion {
    /// Seconds from the first moment to the last; from then on nothing moves.
    pub fn length(&self) -> f64 {
        self.tracks.iter().map(Track::length).fold(0.0, f64::max)
    }

    /// Shapes per second of the fastest sequence, or [`DEFAULT_RATE`] if there is none.
    pub fn rate(&self) -> f64 {
        let rates = self.tracks.iter().filter(|track| track.shapes.len() > 1).map(|track| track.rate);
        rates.reduce(f64::max).unwrap_or(DEFAULT_RATE)
    }

    /// Moments from 0 to the end, `rate` a second.
    pub fn moments(&self, rate: f64) -> Vec<f64> {
        // A thousandth of a moment is rounding.
        let last = (self.length() * rate + 1.0e-3).floor() as u64;
        (0..=last).map(|number| number as f64 / rate).collect()
    }

    /// What is wrong with it, for a mesh of so many vertices.
    pub(super) fn fault(&self, vertices: usize) -> Option<String> {
        let mut taken = vec![false; vertices];
        for (number, track) in self.tracks.iter().enumerate() {
            let fault = match taken.get_mut(track.vertices.clone()) {
                None => Some("has vertices that do not exist".into()),
                Some(own) if own.contains(&true) => Some("has vertices of another one".into()),
                Some(own) => {
                    own.fill(true);
                    track.fault()
                }
            };
            if let Some(fault) = fault {
                return Some(format!("track {number} of its motion {fault}"));
            }
        }
        None
    }
}

impl Track {
    /// Seconds from the first moment to the last.
    pub fn length(&self) -> f64 {
        let shapes = self.shapes.len().saturating_sub(1) as f64 / self.rate;
        shapes.max(self.keys.last().map_or(0.0, |key| key.time))
    }

    /// Greatest coordinate that any vertex can reach.
    pub(super) fn reach(&self) -> f64 {
        let longest = |points: &[Vec3]| points.iter().map(|p| p.as_dvec3().length()).fold(0.0, f64::max);
        let shape = self.shapes.iter().map(|shape| longest(&shape.positions)).fold(0.0, f64::max);
        let moved = self.keys.iter().map(|key| key.translation.length()).fold(0.0, f64::max);
        shape + moved
    }

    fn fault(&self) -> Option<String> {
        let count = self.vertices.len();
        let sound = |shape: &Shape| {
            shape.positions.len() == count
                && (shape.normals.is_empty() || shape.normals.len() == count)
                && shape.positions.iter().chain(&shape.normals).all(|v| v.is_finite())
        };
        let ordered = self.keys.is_sorted_by(|a, b| a.time < b.time);
        let timed = self.keys.iter().all(|key| key.time.is_finite() && key.time >= 0.0);
        // False for NaN, too.
        let within = self.reach() <= f64::from(MAX_COORDINATE);
        let faults = [
            (self.shapes.is_empty(), "has no shape"),
            (
                !self.shapes.iter().all(sound),
                "has a shape with other vertices, or with some that are not finite",
            ),
            (!(self.rate > 0.0 && self.rate.is_finite()), "has a rate that is not positive"),
            (!ordered || !timed, "has keys that are not in the order of time"),
            (!within, "leaves the range of coordinates"),
        ];
        faults.into_iter().find(|(wrong, _)| *wrong).map(|(_, fault)| fault.into())
    }

    /// The shape before `time`, and the share of the way to the next one.
    fn place(&self, time: f64) -> (usize, f64) {
        let at = (time * self.rate).clamp(0.0, self.shapes.len().saturating_sub(1) as f64);
        // What is a rounding away from a shape is that shape, as its file has it.
        let at = if (at - at.round()).abs() < 1.0e-9 { at.round() } else { at };
        (at as usize, at.fract())
    }

    /// Puts the vertices where they are at `time`.
    fn pose(&self, time: f64, mesh: &mut TriangleMesh) {
        let (number, part) = self.place(time);
        let before = &self.shapes[number];
        let after = if part > 0.0 { &self.shapes[number + 1] } else { before };
        let turned = key::between(&self.keys, time);
        let mix =
            |a: Vec3, b: Vec3| if part > 0.0 { a.as_dvec3().lerp(b.as_dvec3(), part) } else { a.as_dvec3() };
        for (to, (&a, &b)) in mesh.positions[self.vertices.clone()]
            .iter_mut()
            .zip(before.positions.iter().zip(&after.positions))
        {
            let place: DVec3 = mix(a, b);
            *to = turned.map_or(place, |(rotation, offset)| rotation * place + offset).as_vec3();
        }
        let Some(normals) = mesh.normals.get_mut(self.vertices.clone()) else { return };
        for (to, (&a, &b)) in normals.iter_mut().zip(before.normals.iter().zip(&after.normals)) {
            *to = match (part > 0.0, turned) {
                (false, None) => a,
                (_, turned) => {
                    let normal: DVec3 =
                        if a == Vec3::ZERO || b == Vec3::ZERO { DVec3::ZERO } else { mix(a, b) };
                    let normal = turned.map_or(normal, |(rotation, _)| rotation * normal);
                    normal.normalize_or_zero().as_vec3()
                }
            };
        }
    }
}

impl Scene {
    /// Puts everything that moves where it is at `time`, in seconds; before the first moment as at it, and after the last
    /// as at that. A scene without motion stays as it is.
    ///
    /// # Panics
    /// If the motion does not fit the mesh, which [`Scene::check`] finds.
    pub fn pose(&mut self, time: f64) {
        let Some(motion) = &self.motion else { return };
        for track in &motion.tracks {
            track.pose(time, &mut self.mesh);
        }
    }
}

#[cfg(test)]
mod tests;
