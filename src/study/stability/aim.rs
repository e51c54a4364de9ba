//! Rays aimed at where closed meshes could leak.

use super::{kernel::Batch, mesh::Closed, oracle, random::Random};
use crate::{
    bvh::{BuildPreset, Bvh},
    error::Result,
    kernels::{MISS, Ray},
    scene::TriangleMesh,
};
use glam::{DVec3, Vec3};
use std::{collections::HashMap, fmt};

/// What rays are aimed at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// Nothing: any direction, or any point of a triangle.
    Random,
    /// A vertex.
    Vertex,
    /// The middle of an edge.
    Edge,
    /// A point of an edge or a vertex, moved by up to three units in the last place.
    Near,
}

impl Aim {
    /// All of them, the aimed ones three times as often.
    const MIX: [Aim; 10] = {
        use Aim::{Edge, Near, Random, Vertex};
        [Vertex, Edge, Near, Random, Vertex, Edge, Near, Vertex, Edge, Near]
    };
}

/// What becomes of the vector from the origin to the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// It is the direction.
    Exact,
    /// It gets length 1, with rounding.
    Normalised,
    /// It is divided by its greatest component, with rounding: what packets of a common origin take.
    Slopes,
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Form::Exact => "exact",
            Form::Normalised => "normalised",
            Form::Slopes => "slopes",
        })
    }
}

/// Rays from outside meet triangles at this cosine at least, so that a target moved by a few units in the last place
/// moves the hit by no more than 32 units, and the wall behind is farther.
const STEEP: f64 = 0.3;

/// A closed mesh at a place, with its tree.
pub(super) struct Site {
    /// Which place: its number in the list of places.
    pub(super) place: usize,
    closed: Closed,
    center: Vec3,
    radius: f32,
    /// A unit in the last place of the greatest coordinate.
    unit: f32,
    step: f32,
    /// Its triangles.
    pub(super) mesh: TriangleMesh,
    /// The tree over them.
    pub(super) bvh: Bvh,
    /// The triangles about each corner of each triangle, by position.
    around: Vec<[u32; 3]>,
    stars: Vec<Vec<u32>>,
}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (center, radius) = (self.center, self.radius);
        write!(f, "{} of radius {radius:e} about {center}", self.closed)
    }
}

/// A unit in the last place of the greatest coordinate of a ball.
pub(super) fn last_place(center: Vec3, radius: f32) -> f32 {
    let most = center.abs().max_element() + radius;
    most.next_up() - most
}

impl Site {
    /// The mesh of radius `radius` about `center`.
    ///
    /// # Errors
    /// As [`Bvh::build`].
    pub(super) fn new(place: usize, closed: Closed, center: Vec3, radius: f32) -> Result<Site> {
        let unit = last_place(center, radius);
        // The smallest edges shall be several units long.
        let detail = ((radius / unit / 32.0) as usize).clamp(2, 12);
        let detail = if detail >= 8 { detail } else { detail.next_power_of_two() };
        let detail =
            if closed == Closed::Cube { (detail.next_power_of_two() / 2).clamp(2, 8) } else { detail };
        let preset = BuildPreset::ALL[closed as usize % BuildPreset::ALL.len()];
        let mesh = closed.mesh(center, radius, detail);
        let bvh = Bvh::build(&mesh, preset)?;
        let (around, stars) = stars(&mesh);
        let step = radius.log2().round().exp2() / detail as f32;
        Ok(Site { place, closed, center, radius, unit, step, mesh, bvh, around, stars })
    }

    fn origin(&self, inside: bool, random: &mut Random) -> Vec3 {
        if self.closed == Closed::Cube && random.below(2) == 0 {
            // On the lattice: whole multiples of its step, on planes of its triangles when outside.
            let reach = if inside { 0.6 } else { 3.0 } * self.radius / self.step;
            let whole = |random: &mut Random| (reach * random.signed()).trunc() * self.step;
            let mut at = Vec3::new(whole(random), whole(random), whole(random));
            if !inside {
                at[random.below(3)] = self.step * f32::trunc(4.0 * self.radius / self.step);
            }
            return self.center + at;
        }
        if inside {
            return self.center + 0.25 * self.radius * random.vec();
        }
        self.center + self.radius * (3.0 + 20.0 * random.unit()) * random.direction()
    }

    /// True if all triangles about this one's corners face `org`, and none of them nearly edge on.
    fn faces(&self, prim: usize, org: Vec3) -> bool {
        let about = self.around[prim].iter().flat_map(|&corner| &self.stars[corner as usize]);
        let cosines = about.map(|&triangle| {
            let [a, b, c] = self.mesh.corners(triangle as usize).map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            // Outwards: the center is behind every triangle.
            let outward = if normal.dot(a - self.center.as_dvec3()) < 0.0 { -normal } else { normal };
            outward.dot((org.as_dvec3() - a).normalize_or_zero())
        });
        cosines.fold(f64::INFINITY, f64::min) > STEEP
    }

    /// A triangle and a point on it, or nearly so.
    fn target(&self, aim: Aim, random: &mut Random) -> (usize, Vec3) {
        let prim = random.below(self.mesh.len());
        let mut corners = self.mesh.corners(prim);
        corners.rotate_left(random.below(3));
        let [a, b, c] = corners;
        let target = match aim {
            Aim::Random => {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                a + u * (b - a) + v * (c - a)
            }
            Aim::Vertex => a,
            Aim::Edge => 0.5 * (a + b),
            Aim::Near => {
                let on = if random.below(2) == 0 { a } else { a + random.unit() * (b - a) };
                on + self.unit * Vec3::from([0; 3].map(|_: i32| random.below(7) as f32 - 3.0))
            }
        };
        (prim, target)
    }

    /// The next rays: all from one origin.
    pub(super) fn shots(&self, random: &mut Random, count: usize) -> Shots {
        let form = random.of(&[Form::Exact, Form::Normalised, Form::Slopes, Form::Slopes]);
        let inside = random.below(2) == 0;
        let org = self.origin(inside, random);
        let mut shots =
            Shots { form, inside, batch: Batch::default(), limits: Vec::new(), sure: Vec::new(), aimed: 0 };
        let mut rays = Vec::new();
        let mut tries = 0;
        while rays.len() < count && tries < 40 * count {
            tries += 1;
            let aim = Aim::MIX[tries % Aim::MIX.len()];
            let (prim, target) = self.target(aim, random);
            if !inside && !self.faces(prim, org) {
                continue;
            }
            let exact = if inside && aim == Aim::Random { random.direction() } else { target - org };
            let Some(dir) = direction(exact, form) else { continue };
            let ray = Ray { org: org.to_array(), dir, tnear: 0.0, tfar: f32::INFINITY, skip: MISS };
            let wild = inside && aim == Aim::Random;
            shots.limits.push(if wild { f64::INFINITY } else { self.limit(&ray, target) });
            let sure = if wild { None } else { oracle::depth_of(self.mesh.corners(prim), &ray) };
            shots.sure.push(sure.map_or(f64::INFINITY, |t| t * (1.0 + 1.0e-6)));
            shots.aimed += u64::from(aim != Aim::Random);
            rays.push(ray);
        }
        shots.batch = if form == Form::Slopes { Batch::slopes(rays) } else { Batch::general(rays) };
        shots
    }

    /// A hit beyond this depth is one of the wall behind the target. Rounded vertices and targets move a little.
    fn limit(&self, ray: &Ray, target: Vec3) -> f64 {
        let dir = DVec3::from(ray.dir.map(f64::from));
        let way = target.as_dvec3() - DVec3::from(ray.org.map(f64::from));
        (way.dot(dir) + (1.0e-3 * way.length() + 32.0 * f64::from(self.unit)) * dir.length())
            / dir.length_squared()
    }
}

/// The triangles about each position, and for each triangle the numbers of its corners' positions.
fn stars(mesh: &TriangleMesh) -> (Vec<[u32; 3]>, Vec<Vec<u32>>) {
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let mut stars: Vec<Vec<u32>> = Vec::new();
    let around = (0..mesh.len()).map(|prim| {
        mesh.corners(prim).map(|corner| {
            let bits = corner.to_array().map(|x| (x + 0.0).to_bits());
            let number = *numbers.entry(bits).or_insert(stars.len() as u32);
            if number as usize == stars.len() {
                stars.push(Vec::new());
            }
            stars[number as usize].push(prim as u32);
            number
        })
    });
    let around = around.collect();
    (around, stars)
}

/// The direction of a ray, if it has one.
pub fn direction(exact: Vec3, form: Form) -> Option<[f32; 3]> {
    if exact == Vec3::ZERO || !exact.is_finite() {
        return None;
    }
    match form {
        Form::Exact => Some(exact.to_array()),
        Form::Normalised => exact.try_normalize().map(|dir| dir.to_array()),
        Form::Slopes => {
            let most = exact.abs().max_element();
            Some(exact.to_array().map(|x| x / most))
        }
    }
}

/// Rays from one origin, and what is known about them.
pub(super) struct Shots {
    /// How their directions were rounded.
    pub(super) form: Form,
    /// Whether they start inside.
    pub(super) inside: bool,
    /// The rays.
    pub(super) batch: Batch,
    /// Each ray hits something before this depth, because the mesh is closed.
    pub(super) limits: Vec<f64>,
    /// Each ray hits something before this depth, because the oracle says so of one triangle. Infinity if it does not.
    pub(super) sure: Vec<f64>,
    /// How many are aimed at a vertex or an edge.
    pub(super) aimed: u64,
}
