//! A sitting rabbit, one metre from paws to ear tips, looking along +z.

use super::field::{
    Field,
    Join::{self, Carve, Melt},
    Shape,
};
use glam::{Affine3A, Quat, Vec3};

/// Corners of a box around the rabbit.
pub(super) const BOUNDS: [Vec3; 2] = [Vec3::new(-0.5, -0.1, -0.75), Vec3::new(0.5, 1.15, 0.65)];
/// Where the eyeballs sit, in the frame of the head, and their radius; the other one is mirrored.
const EYE: Vec3 = Vec3::new(0.098, 0.045, 0.075);
const EYE_RADIUS: f32 = 0.03;

const SIDES: [f32; 2] = [-1.0, 1.0];

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Places at `at`, turned by degrees about x, then y, then z.
fn posed(at: Vec3, degrees: Vec3) -> Affine3A {
    let [x, y, z] = (degrees * (std::f32::consts::PI / 180.0)).to_array();
    let turn = Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x);
    Affine3A::from_rotation_translation(turn, at)
}

/// The head looks a little aside and up.
fn head_frame() -> Affine3A {
    posed(v(0.0, 0.66, 0.27), v(-4.0, 16.0, -5.0))
}

/// Centres and radius of the eyeballs.
pub(super) fn eyes() -> [(Vec3, f32); 2] {
    SIDES.map(|side| (head_frame().transform_point3(EYE * v(side, 1.0, 1.0)), EYE_RADIUS))
}

/// The whole animal but the eyeballs.
pub(super) fn rabbit() -> Field {
    let mut field = Field::default();
    body(&mut field);
    for side in SIDES {
        legs(&mut field, side);
    }
    head(&mut field);
    field
}

fn body(field: &mut Field) {
    let mut blob =
        |at, degrees, axes, width| field.add(posed(at, degrees), Shape::Ellipsoid(axes), Melt(width));
    blob(v(0.0, 0.33, -0.1), v(-26.0, 0.0, 0.0), v(0.225, 0.235, 0.36), 0.1);
    blob(v(0.0, 0.28, -0.26), Vec3::ZERO, v(0.25, 0.25, 0.24), 0.16);
    blob(v(0.0, 0.40, 0.14), v(12.0, 0.0, 0.0), v(0.165, 0.21, 0.155), 0.16);
    blob(v(0.0, 0.24, -0.51), v(25.0, 0.0, 0.0), v(0.085, 0.095, 0.08), 0.05);
    let neck = Shape::Limb { a: v(0.0, 0.46, 0.12), b: v(0.0, 0.63, 0.23), radii: [0.15, 0.1] };
    field.add(Affine3A::IDENTITY, neck, Melt(0.12));
}

fn legs(field: &mut Field, side: f32) {
    let mirror = v(side, 1.0, 1.0);
    let mut limb = |a: Vec3, b: Vec3, radii, width| {
        let shape = Shape::Limb { a: a * mirror, b: b * mirror, radii };
        field.add(Affine3A::IDENTITY, shape, Melt(width));
    };
    // Front: shoulder to wrist, then the paw.
    limb(v(0.1, 0.36, 0.15), v(0.085, 0.09, 0.245), [0.095, 0.052], 0.1);
    limb(v(0.085, 0.055, 0.25), v(0.085, 0.045, 0.335), [0.052, 0.045], 0.05);
    // Hind foot, flat on the ground.
    limb(v(0.21, 0.06, -0.22), v(0.215, 0.05, 0.1), [0.065, 0.052], 0.04);
    let thigh = Shape::Ellipsoid(v(0.095, 0.17, 0.2));
    field.add(posed(v(0.185 * side, 0.235, -0.17), v(-24.0, 8.0 * side, 10.0 * side)), thigh, Melt(0.06));
    // Grooves between the toes.
    for (x, top, tip) in [(0.085, 0.096, 0.372), (0.215, 0.108, 0.142)] {
        for offset in [-0.017, 0.017] {
            let toe = |y: f32, z: f32| v(side * x + offset, y, z);
            let shape = Shape::Limb {
                a: toe(top + 0.004, tip - 0.035),
                b: toe(0.03, tip + 0.03),
                radii: [0.005, 0.011],
            };
            field.add(Affine3A::IDENTITY, shape, Carve(0.032));
        }
    }
}

fn head(field: &mut Field) {
    let frame = head_frame();
    let mut add = |placement: Affine3A, shape, join| field.add(frame * placement, shape, join);
    let ball = |x, y, z| Shape::Ellipsoid(v(x, y, z));
    let at = |p: Vec3| posed(p, Vec3::ZERO);
    add(at(v(0.0, 0.0, 0.0)), ball(0.125, 0.135, 0.17), Melt(0.1));
    add(posed(v(0.0, -0.035, 0.135), v(14.0, 0.0, 0.0)), ball(0.075, 0.075, 0.1), Melt(0.07));
    for side in SIDES {
        let m = v(side, 1.0, 1.0);
        add(at(v(0.068, -0.055, 0.06) * m), ball(0.07, 0.065, 0.08), Melt(0.06));
        // Muzzle pads; a mound that the eyeball looks out of. No detail is thinner than two cells of the grid: the mesh
        // would tear it to shreds.
        add(at(v(0.027, -0.062, 0.2) * m), ball(0.038, 0.034, 0.034), Melt(0.025));
        add(at((EYE - v(0.013, 0.0, 0.006)) * m), Shape::Ellipsoid(v(0.034, 0.036, 0.04)), Melt(0.03));
        ear(&mut add, side);
    }
    add(at(v(0.0, -0.03, 0.226)), ball(0.03, 0.021, 0.021), Melt(0.022));
    let lip = Shape::Limb { a: v(0.0, -0.056, 0.246), b: v(0.0, -0.105, 0.226), radii: [0.005, 0.011] };
    add(Affine3A::IDENTITY, lip, Carve(0.03));
}

/// A spoon: a flat ellipsoid on a stalk, hollowed from the front.
fn ear(add: &mut impl FnMut(Affine3A, Shape, Join), side: f32) {
    let frame = posed(v(0.062 * side, 0.1, -0.045), v(-28.0, 10.0 * side, -13.0 * side));
    let place = |p: Vec3| frame * posed(p, Vec3::ZERO);
    let stalk = Shape::Limb { a: v(0.0, -0.03, 0.0), b: v(0.0, 0.1, 0.0), radii: [0.05, 0.036] };
    add(frame, stalk, Melt(0.05));
    add(place(v(0.0, 0.22, 0.0)), Shape::Ellipsoid(v(0.066, 0.19, 0.044)), Melt(0.03));
    add(place(v(0.0, 0.215, 0.06)), Shape::Ellipsoid(v(0.042, 0.155, 0.044)), Carve(0.03));
}
