//! The camera in the user's hands: it orbits around a point, or flies.

use crate::scene::CameraDescription;
use glam::{Quat, Vec3};

/// What moving the mouse does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RigMode {
    /// The camera goes around the point that it looks at.
    #[default]
    Orbit,
    /// The camera turns where it is.
    Fly,
}

/// Least angle between the view and the vector that points up, in radians.
const POLE: f32 = 0.02;
/// No coordinate of the camera becomes greater.
const REACH: f32 = 1.0e15;

/// A camera that can be moved. Until it is, it is exactly the one it was made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig {
    /// Where it is now.
    pub camera: CameraDescription,
    /// What turning does.
    pub mode: RigMode,
    /// World units per second.
    pub speed: f32,
    home: (CameraDescription, f32),
}

impl Rig {
    /// A rig at `camera`; in a scene of this diagonal it flies across in ten seconds.
    pub fn new(camera: CameraDescription, diagonal: f32) -> Rig {
        let speed = (0.1 * diagonal).clamp(1.0e-12, 1.0e12);
        Rig { camera, mode: RigMode::Orbit, speed, home: (camera, speed) }
    }

    /// Back to where it began.
    pub fn reset(&mut self) {
        (self.camera, self.speed) = self.home;
    }

    /// Turns by these angles in radians: to the right, and up. Orbiting, the scene follows the hand; flying, the view
    /// does.
    pub fn turn(&mut self, right: f32, up: f32) {
        match self.mode {
            RigMode::Orbit => {
                let to_eye = -self.turned(right, up);
                self.settle(self.camera.at + to_eye, self.camera.at);
            }
            RigMode::Fly => {
                let eye = self.camera.eye;
                self.settle(eye, eye + self.turned(right, up));
            }
        }
    }

    /// The vector from the eye to what it looks at, turned; it stays off the poles.
    fn turned(&self, right: f32, up: f32) -> Vec3 {
        let CameraDescription { eye, at, up: pole, .. } = self.camera;
        let (pole, ahead) = (pole.normalize(), at - eye);
        let now = ahead.angle_between(pole);
        let pitch = now - (now - up).clamp(POLE, std::f32::consts::PI - POLE);
        let side = ahead.cross(pole).normalize();
        Quat::from_axis_angle(pole, -right) * (Quat::from_axis_angle(side, pitch) * ahead)
    }

    /// Moves by world units: to the right, up, ahead.
    pub fn travel(&mut self, right: f32, up: f32, ahead: f32) {
        let CameraDescription { eye, at, up: pole, .. } = self.camera;
        let forward = (at - eye).normalize();
        let side = forward.cross(pole).normalize();
        let step = side * right + side.cross(forward) * up + forward * ahead;
        self.settle(eye + step, at + step);
    }

    /// Shifts by pixels of an image of this height, so that what is looked at follows the hand.
    pub fn pan(&mut self, right: f32, down: f32, height: u32) {
        let CameraDescription { eye, at, fov_deg, .. } = self.camera;
        let pixel = 2.0 * (at - eye).length() * (0.5 * fov_deg.to_radians()).tan() / height.max(1) as f32;
        self.travel(-right * pixel, down * pixel, 0.0);
    }

    /// Orbiting, goes nearer by `steps`; flying, becomes faster.
    pub fn wheel(&mut self, steps: f32) {
        let steps = steps.clamp(-50.0, 50.0);
        match self.mode {
            RigMode::Orbit => {
                let CameraDescription { eye, at, .. } = self.camera;
                self.settle(at + (eye - at) * 0.9f32.powf(steps), at);
            }
            RigMode::Fly => self.speed = (self.speed * 1.25f32.powf(steps)).clamp(1.0e-12, 1.0e12),
        }
    }

    /// Takes the new place, unless no picture could be made from there.
    fn settle(&mut self, eye: Vec3, at: Vec3) {
        let ahead = at - eye;
        let angle = ahead.angle_between(self.camera.up);
        let far = eye.abs().max(at.abs()).max_element();
        let apart = ahead.length() > 1.0e-6 * far && ahead.length() > 1.0e-15;
        let off_pole = angle > 0.1 * POLE && angle < std::f32::consts::PI - 0.1 * POLE;
        if apart && off_pole && far < REACH {
            (self.camera.eye, self.camera.at) = (eye, at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(mode: RigMode) -> Rig {
        let camera =
            CameraDescription { eye: Vec3::new(0.0, 1.0, 5.0), at: Vec3::Y, up: Vec3::Y, fov_deg: 90.0 };
        Rig { mode, ..Rig::new(camera, 20.0) }
    }

    #[test]
    fn orbiting_keeps_the_distance_and_flying_the_place() {
        let mut orbit = rig(RigMode::Orbit);
        // A quarter to the right: the scene turns to the right, the camera goes to the left.
        orbit.turn(std::f32::consts::FRAC_PI_2, 0.0);
        assert!(orbit.camera.eye.distance(Vec3::new(-5.0, 1.0, 0.0)) < 1e-5, "{orbit:?}");
        assert_eq!(orbit.camera.at, Vec3::Y);
        let mut fly = rig(RigMode::Fly);
        fly.turn(std::f32::consts::FRAC_PI_2, 0.0);
        assert_eq!(fly.camera.eye, Vec3::new(0.0, 1.0, 5.0));
        assert!(fly.camera.at.distance(Vec3::new(5.0, 1.0, 5.0)) < 1e-5, "{fly:?}");
        fly.turn(0.0, 0.5);
        assert!(fly.camera.at.y > 1.0, "up is up: {fly:?}");
    }

    #[test]
    fn nobody_turns_over_backwards() {
        for (up, pole) in [(2.5, Vec3::Y), (-2.5, -Vec3::Y)] {
            let mut fly = rig(RigMode::Fly);
            fly.turn(0.0, up);
            let ahead = fly.camera.at - fly.camera.eye;
            assert!((ahead.angle_between(pole) - POLE).abs() < 1e-3, "{ahead}");
            assert!(ahead.z < 0.0, "still the way it looked: {ahead}");
        }
    }

    #[test]
    fn a_rig_travels_along_its_own_axes() {
        let mut fly = rig(RigMode::Fly);
        fly.travel(1.0, 2.0, 3.0);
        assert!(fly.camera.eye.distance(Vec3::new(1.0, 3.0, 2.0)) < 1e-6, "{fly:?}");
        fly.reset();
        assert_eq!(fly.camera, rig(RigMode::Fly).camera);
    }

    #[test]
    fn what_is_looked_at_follows_the_hand() {
        // 90 degrees of 100 pixels show ten units at a distance of five.
        let mut orbit = rig(RigMode::Orbit);
        orbit.pan(10.0, 0.0, 100);
        assert!(orbit.camera.at.distance(Vec3::new(-1.0, 1.0, 0.0)) < 1e-5, "{orbit:?}");
        orbit.wheel(1.0);
        assert!((orbit.camera.eye.distance(orbit.camera.at) - 4.5).abs() < 1e-5, "{orbit:?}");
    }

    #[test]
    fn no_hand_moves_it_where_no_picture_can_be_made() {
        for mode in [RigMode::Orbit, RigMode::Fly] {
            let mut rig = rig(mode);
            for i in 0..3000u32 {
                let wild = [0.0, 1e3, -1e3, f32::NAN, f32::INFINITY, 1e-9, 3.0, -3.0][i as usize * 7 % 8];
                match i % 5 {
                    0 => rig.turn(wild, -wild),
                    1 => rig.travel(wild * 1e6, wild, 1.0),
                    2 => rig.pan(wild, wild, i % 3),
                    3 => rig.turn(0.1, 10.0),
                    _ => rig.wheel(wild),
                }
                let CameraDescription { eye, at, up, .. } = rig.camera;
                let side = (at - eye).normalize().cross(up);
                assert!(eye.is_finite() && side.is_finite() && side.length() > 1e-4, "{i}: {rig:?}");
            }
        }
    }
}
