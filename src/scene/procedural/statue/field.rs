//! A smooth solid: signed-distance primitives melted together, with exact gradients.

use glam::{Affine3A, Mat3, Vec3};

/// A field's value at a point (negative inside) and its gradient there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) value: f32,
    pub(super) gradient: Vec3,
}

/// One primitive in its own frame.
#[derive(Clone, Copy)]
pub(super) enum Shape {
    /// Half axes of an ellipsoid.
    Ellipsoid(Vec3),
    /// Sphere-swept segment from `a` to `b`, its radius easing from the first to the second.
    Limb { a: Vec3, b: Vec3, radii: [f32; 2] },
}

impl Shape {
    fn sample(&self, p: Vec3) -> Sample {
        match *self {
            Shape::Ellipsoid(axes) => ellipsoid(p, axes),
            Shape::Limb { a, b, radii } => limb(p, a, b, radii),
        }
    }
}

/// A distance bound that is exact on the surface: k0 (k0 - 1) / k1 with k0 = |p / r|, k1 = |p / r^2|.
fn ellipsoid(p: Vec3, axes: Vec3) -> Sample {
    let scaled = p / axes;
    let square = scaled / axes;
    let (k0, k1) = (scaled.length(), square.length());
    if k1 < 1e-6 {
        return Sample { value: -axes.min_element(), gradient: Vec3::ZERO };
    }
    let value = k0 * (k0 - 1.0) / k1;
    let dk1 = square / (axes * axes) / k1;
    let gradient = square * ((2.0 * k0 - 1.0) / (k0 * k1)) - dk1 * (value / k1);
    Sample { value, gradient }
}

fn limb(p: Vec3, a: Vec3, b: Vec3, radii: [f32; 2]) -> Sample {
    let (axis, from) = (b - a, p - a);
    let t = (from.dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    let away = from - axis * t;
    let distance = away.length().max(1e-9);
    let ease = t * t * (3.0 - 2.0 * t);
    let slope = 6.0 * t * (1.0 - t) * (radii[1] - radii[0]) / axis.length_squared();
    let value = distance - (radii[0] + (radii[1] - radii[0]) * ease);
    Sample { value, gradient: away / distance - axis * slope }
}

/// What a primitive does to the solid so far.
#[derive(Clone, Copy)]
pub(super) enum Join {
    /// Adds to it, melting over this width.
    Melt(f32),
    /// Takes away from it, rounding the rim over this width.
    Carve(f32),
}

struct Primitive {
    shape: Shape,
    join: Join,
    to_local: Affine3A,
    to_world: Mat3,
}

/// Primitives, joined in order.
#[derive(Default)]
pub(super) struct Field {
    primitives: Vec<Primitive>,
}

impl Field {
    /// Joins `shape`, placed by the rigid motion `placement`.
    pub(super) fn add(&mut self, placement: Affine3A, shape: Shape, join: Join) {
        let to_world = Mat3::from(placement.matrix3);
        self.primitives.push(Primitive { shape, join, to_local: placement.inverse(), to_world });
    }

    /// Value and gradient at `p`.
    pub(super) fn sample(&self, p: Vec3) -> Sample {
        let mut sum = Sample { value: 1e3, gradient: Vec3::ZERO };
        for primitive in &self.primitives {
            let local = primitive.shape.sample(primitive.to_local.transform_point3(p));
            let next = Sample { value: local.value, gradient: primitive.to_world * local.gradient };
            sum = match primitive.join {
                Join::Melt(width) => smooth_min(sum, next, width),
                Join::Carve(width) => {
                    let outside = Sample { value: -sum.value, gradient: -sum.gradient };
                    let rest = smooth_min(outside, next, width);
                    Sample { value: -rest.value, gradient: -rest.gradient }
                }
            };
        }
        sum
    }

    /// Moves `p`, near the surface, onto it by Newton steps along the gradient.
    pub(super) fn project(&self, p: Vec3) -> Vec3 {
        let mut p = p;
        for _ in 0..3 {
            let Sample { value, gradient } = self.sample(p);
            p -= gradient * (value / gradient.length_squared().max(1e-3));
        }
        p
    }

    /// Outward unit normal at `p` on the surface.
    pub(super) fn normal(&self, p: Vec3) -> Vec3 {
        self.sample(p).gradient.normalize_or_zero()
    }
}

/// The cubic smooth minimum: twice differentiable, so that highlights run over a joint without a line.
fn smooth_min(a: Sample, b: Sample, width: f32) -> Sample {
    let (near, far) = if a.value < b.value { (a, b) } else { (b, a) };
    let h = (1.0 - (far.value - near.value) / width).max(0.0);
    let weight = h * h / 2.0;
    Sample {
        value: near.value - h * h * h * width / 6.0,
        gradient: near.gradient * (1.0 - weight) + far.gradient * weight,
    }
}
