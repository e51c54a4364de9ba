//! Axis-aligned bounding boxes.

use glam::Vec3;

/// Smallest axis-aligned box around a set of points; `min > max` while it is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box around nothing: growing it by a point gives that point.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box around `points`.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Aabb {
        let mut aabb = Aabb::EMPTY;
        for point in points {
            aabb.grow(point);
        }
        aabb
    }

    /// Makes the box include `point`.
    pub fn grow(&mut self, point: Vec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// Makes the box include all of `other`.
    pub fn union(&mut self, other: &Aabb) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// True if no point was ever added.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Edge lengths; zero for an empty box.
    pub fn extent(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// Midpoint; zero for an empty box.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.min + 0.5 * (self.max - self.min) }
    }

    /// Half of the surface area (the quantity the surface area heuristic compares).
    pub fn half_area(&self) -> f32 {
        let e = self.extent();
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}
