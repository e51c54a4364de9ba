//! Rigid motion between keys: turned about the origin, then moved.

use glam::{DMat3, DQuat, DVec3};

/// How something is turned and moved at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Seconds, not negative.
    pub time: f64,
    /// About the origin; orthonormal.
    pub rotation: DMat3,
    /// After that.
    pub translation: DVec3,
}

/// Rotation and translation at `time`: of the only key before or after it, or between two: along the shorter way of the
/// rotation at constant speed (Shoemake's spherical interpolation of quaternions, 1985), and straight. `None` without keys.
pub(super) fn between(keys: &[Key], time: f64) -> Option<(DMat3, DVec3)> {
    let next = keys.partition_point(|key| key.time <= time);
    let Some(before) = next.checked_sub(1).map(|before| &keys[before]) else {
        return keys.first().map(|key| (key.rotation, key.translation));
    };
    let Some(after) = keys.get(next).filter(|_| time > before.time) else {
        return Some((before.rotation, before.translation));
    };
    let part = (time - before.time) / (after.time - before.time);
    // What does not turn keeps the exact matrix.
    let rotation = if before.rotation == after.rotation {
        before.rotation
    } else {
        let [from, to] = [before, after].map(|key| DQuat::from_mat3(&key.rotation));
        DMat3::from_quat(from.slerp(to, part).normalize())
    };
    Some((rotation, before.translation.lerp(after.translation, part)))
}
