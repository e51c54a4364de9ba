//! What several test modules share: instruction sets, random numbers, meshes, and the brute-force oracle.

use glam::Vec3;
use irt::{
    bvh::BuildPreset,
    effects::EffectChoice,
    kernels::{Face, Hit, Isa, Kernels, MISS, Ray, Visibility, exact},
    render::RenderOptions,
    scene::{Part, TriangleMesh},
    schedule::{FilmMode, Schedule, Strategy},
    tile::Order,
    trace::{EarlyTermination, KernelChoice},
};

/// A small image, the plainest way: what tests of images change a little.
pub(crate) const RENDER: RenderOptions = RenderOptions {
    isa: None,
    kernel: KernelChoice::Auto,
    visibility: Visibility::Exact,
    threads: Some(1),
    pin: false,
    order: Order::Hilbert,
    schedule: Schedule { strategy: Strategy::Dynamic, film: FilmMode::Shared },
    tile: 64,
    // Not a multiple of packet or tile size.
    size: [150, 101],
    frames: 1,
    build: BuildPreset::Fast,
    seed: 0,
    early: EarlyTermination::FASTEST,
    effects: EffectChoice::Auto,
};

/// The kernels of every instruction set of this machine.
pub(crate) fn kernels() -> Vec<Kernels> {
    Isa::available().filter_map(Kernels::for_isa).collect()
}

/// A small counter-based generator (SplitMix64), so that every run tests the same cases.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// In [-1, 1).
    pub(crate) fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 23) as f32 - 1.0
    }
    pub(crate) fn vec(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
}

/// A mesh of these triangles.
pub(crate) fn mesh_of(triangles: &[[Vec3; 3]]) -> TriangleMesh {
    TriangleMesh {
        positions: triangles.iter().flatten().copied().collect(),
        normals: Vec::new(),
        uvs: Vec::new(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        materials: vec![0; triangles.len()],
        parts: vec![Part { name: "soup".into(), first: 0, count: triangles.len() as u32 }],
    }
}

/// Random triangles in [-1, 1]^3 of about the given size, with duplicates, slivers and axis-aligned ones among them.
pub(crate) fn soup(seed: u64, count: usize, size: f32) -> TriangleMesh {
    let mut random = Random(seed);
    let mut triangles: Vec<[Vec3; 3]> = Vec::new();
    while triangles.len() < count {
        let a = random.vec();
        let mut b = a + size * random.vec();
        let mut c = a + size * random.vec();
        match random.below(10) {
            0 if !triangles.is_empty() => {
                let copy = triangles[random.below(triangles.len())];
                triangles.push(copy);
                continue;
            }
            1 => c = a + (b - a) * 0.5 + 1.0e-4 * size * random.vec(),
            2 => (b.z, c.z) = (a.z, a.z),
            3 => (b.x, c.x) = (a.x, a.x),
            _ => {}
        }
        if (b - a).cross(c - a).length() > 0.0 {
            triangles.push([a, b, c]);
        }
    }
    mesh_of(&triangles)
}

/// A closed sphere of `2 * rings * rings` or so triangles that share vertices exactly.
pub(crate) fn sphere(center: Vec3, radius: f32, rings: usize) -> TriangleMesh {
    use std::f32::consts::PI;
    let (rows, columns) = (rings, 2 * rings);
    let point = |row: usize, column: usize| {
        let (theta, phi) =
            (PI * row as f32 / rows as f32, 2.0 * PI * (column % columns) as f32 / columns as f32);
        let r = if row == 0 || row == rows { 0.0 } else { theta.sin() };
        center + radius * Vec3::new(r * phi.cos(), theta.cos(), r * phi.sin())
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let (a, b) = (point(row, column), point(row, column + 1));
            let (c, d) = (point(row + 1, column), point(row + 1, column + 1));
            if row > 0 {
                triangles.push([a, b, c]);
            }
            if row + 1 < rows {
                triangles.push([b, d, c]);
            }
        }
    }
    mesh_of(&triangles)
}

/// Every triangle, one after the other: the oracle.
pub(crate) fn brute_force(mesh: &TriangleMesh, ray: &Ray) -> Hit {
    let face = Face::of(ray.dir);
    let axes = face.axes();
    let sign = if face.negative { -1.0 } else { 1.0 };
    let permute = |v: [f32; 3]| [v[axes[0]], v[axes[1]], v[axes[2]] * sign];
    let d = permute(ray.dir);
    let mut best = Hit::MISS;
    let mut best_t = f64::INFINITY;
    for prim in (0..mesh.len()).filter(|&prim| prim as u32 != ray.skip) {
        let relative = |p: Vec3| {
            let p = p.to_array();
            permute([p[0] - ray.org[0], p[1] - ray.org[1], p[2] - ray.org[2]])
        };
        let [a, b, c] = mesh.corners(prim).map(relative);
        if !exact::passes(a, b, c, d) {
            continue;
        }
        let canonical = exact::Canonical::new(a, b, c);
        let t = canonical.depth(d.map(f64::from));
        let within = t >= f64::from(ray.tnear.max(0.0)) && t <= f64::from(ray.tfar);
        if within && (t < best_t || best.prim == MISS) {
            let [t32, u, v] = canonical.hit(d.map(f64::from));
            best = Hit { prim: prim as u32, t: t32, u, v };
            best_t = t;
        }
    }
    best
}
