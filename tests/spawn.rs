//! Rays that start on surfaces: error bounds and sides against exact arithmetic, no self-hit, no lost neighbour.

use crate::support::{Random, kernels, mesh_of, sphere};
use dashu_ratio::RBig;
use glam::{DVec3, Vec3};
use irt::{
    bvh::{BuildPreset, Bvh},
    camera::Camera,
    kernels::{F32, Kernel, Kernels, MISS, Ray, SUB, Simd, TileHits, TilePacket},
    scene::{CameraDescription, Falloff, Light, Material, Scene, TriangleMesh},
    shade::{
        LightRays, SurfaceTable, Surfaces, light_rays,
        spawn::{Footing, Triple, bulge},
    },
    trace::{KernelChoice, NO_OCCLUDER, PacketScratch, PointShadows, ShadowRays, Traversal},
};

/// Sixteen points of triangles, and the normals of the sides that rays leave to.
struct Start<'a> {
    corners: &'a [[Vec3; 3]; SUB],
    uv: &'a [[f32; 2]; SUB],
    n: &'a [Vec3; SUB],
    /// The points are moved by this first.
    by: Option<&'a [Vec3; SUB]>,
}

/// Point, error and start of each.
struct Started {
    point: [Vec3; SUB],
    error: [Vec3; SUB],
    start: [Vec3; SUB],
}

/// Three planes of sixteen numbers.
fn planes(of: impl Fn(usize) -> Vec3) -> [[f32; SUB]; 3] {
    [0, 1, 2].map(|k| std::array::from_fn(|i| of(i)[k]))
}

fn vectors(of: [[f32; SUB]; 3]) -> [Vec3; SUB] {
    std::array::from_fn(|i| Vec3::new(of[0][i], of[1][i], of[2][i]))
}

#[inline(always)]
fn load<S: Simd>(s: S, of: &[[f32; SUB]; 3]) -> Triple<S, SUB> {
    [F32::load(s, &of[0]), F32::load(s, &of[1]), F32::load(s, &of[2])]
}

#[inline(always)]
fn store<S: Simd>(of: &Triple<S, SUB>) -> [[f32; SUB]; 3] {
    [of[0].to_array(), of[1].to_array(), of[2].to_array()]
}

/// What goes into the kernel and comes out of it.
struct Inside {
    corners: [[[f32; SUB]; 3]; 3],
    uv: [[f32; SUB]; 2],
    n: [[f32; SUB]; 3],
    by: Option<[[f32; SUB]; 3]>,
}

impl Kernel for Inside {
    type Output = [[[f32; SUB]; 3]; 3];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let [a, b, c] = &self.corners;
        let corners = [load(s, a), load(s, b), load(s, c)];
        let uv = [F32::load(s, &self.uv[0]), F32::load(s, &self.uv[1])];
        let mut footing = Footing::new(s, &corners, uv);
        if let Some(by) = &self.by {
            footing = footing.moved(s, &load(s, by));
        }
        let start = footing.start(s, &load(s, &self.n));
        [store(&footing.point), store(&footing.error), store(&start)]
    }
}

impl Start<'_> {
    fn run(&self, kernels: &Kernels) -> Started {
        let corners = [0, 1, 2].map(|c| planes(|i| self.corners[i][c]));
        let uv = [0, 1].map(|k| std::array::from_fn(|i| self.uv[i][k]));
        let by = self.by.map(|by| planes(|i| by[i]));
        let [point, error, start] =
            kernels.run(Inside { corners, uv, n: planes(|i| self.n[i]), by }).map(vectors);
        Started { point, error, start }
    }
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = [a, b, c].map(|v| v.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

type Exact = [RBig; 3];

fn exact(v: Vec3) -> Exact {
    v.to_array().map(|x| RBig::try_from(x).expect("finite"))
}

fn minus(a: &Exact, b: &Exact) -> Exact {
    [0, 1, 2].map(|k| &a[k] - &b[k])
}

/// (b - a) x (c - a) . (p - a)
fn volume([a, b, c]: [Vec3; 3], p: Vec3) -> RBig {
    let [a, b, c, p] = [a, b, c, p].map(exact);
    let (b, c, p) = (minus(&b, &a), minus(&c, &a), minus(&p, &a));
    let cross = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
    cross(1, 2) * &p[0] + cross(2, 0) * &p[1] + cross(0, 1) * &p[2]
}

/// a + u (b - a) + v (c - a)
fn on_plane([a, b, c]: [Vec3; 3], [u, v]: [f32; 2]) -> Exact {
    let [a, b, c] = [a, b, c].map(exact);
    let [u, v] = [u, v].map(|x| RBig::try_from(x).expect("finite"));
    [0, 1, 2].map(|k| &a[k] + &u * (&b[k] - &a[k]) + &v * (&c[k] - &a[k]))
}

/// Sizes, and distances from the origin in sizes.
fn places() -> impl Iterator<Item = (f32, f32)> {
    let sizes = [1.0e-5, 1.0e-3, 1.0, 30.0, 1.0e3, 1.0e6];
    sizes.into_iter().flat_map(|size| [0.0, 1.0, 100.0, 1.0e4].map(|far| (size, far)))
}

/// A triangle of about this size at about this place: well-shaped ones, slivers, axis-aligned ones.
fn triangle(random: &mut Random, size: f32, far: f32) -> [Vec3; 3] {
    loop {
        let a = size * (far * Vec3::new(1.0, -0.6, 0.8) + random.vec());
        let mut b = a + size * random.vec();
        let mut c = a + size * random.vec();
        match random.below(4) {
            0 => c = a + (b - a) * 0.4 + 1.0e-3 * size * random.vec(),
            1 => (b.y, c.y) = (a.y, a.y),
            _ => {}
        }
        // Rounding far from the origin makes some of them degenerate.
        let (ab, ac) = ((b - a).as_dvec3(), (c - a).as_dvec3());
        if ab.cross(ac).length() > 1.0e-4 * ab.length() * ac.length() {
            return [a, b, c];
        }
    }
}

#[test]
fn points_are_within_their_bounds_and_starts_on_their_sides() {
    let mut random = Random(41);
    for (size, far) in places() {
        for _ in 0..20 {
            let corners: [[Vec3; 3]; SUB] = std::array::from_fn(|_| triangle(&mut random, size, far));
            let uv: [[f32; 2]; SUB] = std::array::from_fn(|i| {
                let [u, v] = [random.signed().abs(), random.signed().abs()];
                [[0.0, 0.0], [1.0, 0.0], [u, 1.0 - u], [u * 0.5, v * 0.5]][i % 4]
            });
            let sides: [f32; SUB] = std::array::from_fn(|_| [1.0, -1.0][random.below(2)]);
            let n: [Vec3; SUB] = std::array::from_fn(|i| sides[i] * normal(corners[i]));
            let away: [Vec3; SUB] = std::array::from_fn(|i| 0.1 * size * random.signed().abs() * n[i]);
            for by in [None, Some(&away)] {
                let start = || Start { corners: &corners, uv: &uv, n: &n, by };
                let got = start().run(&Kernels::detect());
                for kernels in kernels() {
                    let same = start().run(&kernels);
                    assert_eq!((same.point, same.start), (got.point, got.start), "{}", kernels.isa());
                }
                for i in 0..SUB {
                    let context = format!("size {size}, far {far}, by {by:?}: {:?} {:?}", corners[i], uv[i]);
                    let by = exact(by.map_or(Vec3::ZERO, |by| by[i]));
                    let off = minus(&minus(&exact(got.point[i]), &by), &on_plane(corners[i], uv[i]));
                    let bound = exact(got.error[i]);
                    for k in 0..3 {
                        assert!(off[k] <= bound[k] && -&off[k] <= bound[k], "{context}");
                    }
                    let side = volume(corners[i], got.start[i]);
                    let right = if sides[i] > 0.0 { side > RBig::ZERO } else { side < RBig::ZERO };
                    assert!(right, "{context}, {}", sides[i]);
                }
            }
        }
    }
}

fn build(mesh: &TriangleMesh) -> Bvh {
    Bvh::build(mesh, BuildPreset::Medium).expect("builds")
}

/// Rays from random points of triangles: to the side of the normal times `side`, at most 87 degrees from it.
fn rays(random: &mut Random, mesh: &TriangleMesh, prims: &[usize; SUB], side: f32) -> Vec<Ray> {
    let corners = prims.map(|prim| mesh.corners(prim));
    let uv = std::array::from_fn(|_| {
        let u = random.signed().abs();
        [u, (1.0 - u) * random.signed().abs()]
    });
    let n = corners.map(|corners| side * normal(corners));
    let started = Start { corners: &corners, uv: &uv, n: &n, by: None }.run(&Kernels::detect());
    (0..SUB)
        .map(|i| {
            loop {
                let dir = random.vec();
                if dir.dot(n[i]) > 0.05 * dir.length() {
                    let (org, skip) = (started.start[i].to_array(), prims[i] as u32);
                    break Ray { org, dir: dir.to_array(), tnear: 0.0, tfar: f32::INFINITY, skip };
                }
            }
        })
        .collect()
}

#[test]
fn no_ray_from_a_convex_surface_meets_it_again_and_none_gets_out() {
    let mut random = Random(43);
    for (size, far) in places() {
        let mesh = sphere(size * far * Vec3::new(1.0, -0.6, 0.8), size, 6);
        let bvh = build(&mesh);
        for _ in 0..40 {
            let prims = std::array::from_fn(|_| random.below(mesh.len()));
            // Which way the corners run round is up to the mesh: the middle is behind or in front of all triangles.
            let [a, b, c] = mesh.corners(0).map(|v| v.as_dvec3());
            let middle = (size * far * Vec3::new(1.0, -0.6, 0.8)).as_dvec3();
            let outward = if (b - a).cross(c - a).dot(a - middle) > 0.0 { 1.0 } else { -1.0 };
            for side in [1.0, -1.0] {
                for ray in rays(&mut random, &mesh, &prims, side * outward) {
                    for kernels in kernels() {
                        let hit = kernels.intersect(&bvh.view(), &ray).prim;
                        assert_eq!(hit == MISS, side > 0.0, "size {size}, far {far}, side {side}: {ray:?}");
                    }
                }
            }
        }
    }
}

/// How far apart two layers must be, in world units, to differ at all: 4e-5 sizes, or rounding.
fn gap(size: f32, far: f32) -> f32 {
    (4.0e-5 * size).max(size * far * 32.0 * f32::EPSILON)
}

#[test]
fn a_surface_close_by_is_seen() {
    let mut random = Random(47);
    for (size, far) in places() {
        for _ in 0..60 {
            let low = triangle(&mut random, size, far);
            let n = normal(low);
            // So large that all rays towards it meet it.
            let middle = ((low[0] + low[1] + low[2]) / 3.0).as_dvec3();
            let up = n.as_dvec3();
            let (x, y) = up.any_orthonormal_pair();
            let at =
                |i: f64, j: f64| middle + f64::from(gap(size, far)) * up + f64::from(size) * (i * x + j * y);
            let high = [at(-30.0, -15.0), at(30.0, -15.0), at(0.0, 30.0)].map(|v| v.as_vec3());
            let mesh = mesh_of(&[low, high]);
            let bvh = build(&mesh);
            let prims = [0; SUB];
            for mut ray in rays(&mut random, &mesh, &prims, 1.0) {
                ray.dir = n.to_array();
                assert_eq!(Kernels::detect().intersect(&bvh.view(), &ray).prim, 1, "size {size}, far {far}");
            }
        }
    }
}

/// Displacements by [`bulge`].
struct Bulge([[[f32; SUB]; 3]; 8], [f32; 2]);

impl Kernel for Bulge {
    type Output = [[f32; SUB]; 3];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let Bulge([a, b, c, na, nb, nc, ng, point], [u, v]) = &self;
        let corners = [load(s, a), load(s, b), load(s, c)];
        let normals = [load(s, na), load(s, nb), load(s, nc)];
        let uv = [F32::splat(s, *u), F32::splat(s, *v)];
        store(&bulge(s, &corners, &normals, &load(s, ng), &load(s, point), uv))
    }
}

fn bulge_of(kernels: &Kernels, corners: &[Vec3; 3], normals: &[Vec3; 3], [u, v]: [f32; 2]) -> Vec3 {
    let ([a, b, c], [na, nb, nc]) = (*corners, *normals);
    let point = a + u * (b - a) + v * (c - a);
    let all = [a, b, c, na, nb, nc, normal(*corners), point].map(|vector| planes(|_| vector));
    vectors(kernels.run(Bulge(all, [u, v])))[0]
}

#[test]
fn smooth_normals_move_points_onto_the_surface_they_stand_for() {
    // A triangle of a sphere around the origin, its normals those of the sphere.
    let corners =
        [Vec3::new(0.1, -0.2, 1.0), Vec3::new(0.5, 0.1, 1.0), Vec3::new(0.0, 0.4, 1.0)].map(Vec3::normalize);
    let flat = normal(corners);
    for (u, v) in [(0.3, 0.3), (0.5, 0.1), (0.2, 0.6), (0.5, 0.5), (0.0, 0.4)] {
        let point = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
        for kernels in kernels() {
            let by = bulge_of(&kernels, &corners, &corners, [u, v]);
            let (before, after) = (1.0 - point.length(), ((point + by).length() - 1.0).abs());
            assert!(by.dot(flat) > 0.0 && after < before, "{u} {v}: {before} {after}");
            assert!(bulge_of(&kernels, &corners, &[flat; 3], [u, v]).length() < 1.0e-7);
            let from = corners.map(|corner| point - corner);
            let hollow = from.map(|from| (flat + from).normalize());
            for normals in [corners.map(|n| -n), hollow, from.map(|from| (-0.2 * flat - from).normalize())] {
                assert_eq!(bulge_of(&kernels, &corners, &normals, [u, v]), Vec3::ZERO);
            }
        }
    }
    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
        assert!(bulge_of(&Kernels::detect(), &corners, &corners, [u, v]).length() < 1.0e-6, "corners stay");
    }
}

/// A tilted square of `n` x `n` pairs of triangles, lifted by `lift` along its normal.
fn floor(size: f32, far: f32, n: u32, lift: f32) -> (Vec<[Vec3; 3]>, Vec3, Vec3) {
    let middle = (size * far * Vec3::new(1.0, -0.6, 0.8)).as_dvec3();
    let (x, z) = (DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.1, 0.3, 1.0));
    let up = z.cross(x).normalize();
    let at = |i: u32, j: u32| {
        let [i, j] = [i, j].map(|i| f64::from(size) * (2.0 * f64::from(i) / f64::from(n) - 1.0));
        (middle + i * x + j * z + f64::from(lift) * up).as_vec3()
    };
    let cell = |i: u32, j: u32| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, c, b], [a, d, c]]
    };
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    (cells.flat_map(|(i, j)| cell(i, j)).collect(), middle.as_vec3(), up.as_vec3())
}

/// The share of lit points of a floor, with something above it or not.
fn lit(
    floor_mesh: &TriangleMesh,
    all: &TriangleMesh,
    camera: CameraDescription,
    position: Vec3,
) -> [usize; 2] {
    let kernels = Kernels::detect();
    let light = Light::Point { position, intensity: Vec3::ONE, falloff: Falloff::None };
    let scene = Scene {
        name: "floor".into(),
        mesh: floor_mesh.clone(),
        materials: vec![Material::default()],
        camera,
        lights: vec![light],
        size: [64, 64],
        ..Scene::default()
    };
    let (below, above) = (build(floor_mesh), build(all));
    let (seeing, shadowing) = (
        Traversal::new(&below, kernels, KernelChoice::Tile),
        Traversal::new(&above, kernels, KernelChoice::Tile),
    );
    let table = SurfaceTable::new(&scene);
    let camera = Camera::new(&scene.camera, 64, 64);
    let mut packets: Box<[TilePacket; 6]> = Box::new(std::array::from_fn(|_| TilePacket::new()));
    let (mut hits, mut scratch) = (TileHits::new(), PacketScratch::new());
    let mut surfaces = Surfaces::default();
    surfaces.reset(16, [0.0; 3]);
    for index in 0..16 {
        let at = [16 * (index as u32 % 4), 16 * (index as u32 / 4)];
        let used = camera.rays(&kernels, at, [16, 16], &mut packets);
        for packet in &packets[..used] {
            seeing.intersect(packet, &mut scratch, &mut hits);
            surfaces.gather(&kernels, &table, index, packet, &hits);
        }
    }
    surfaces.finish(&kernels);
    let mut rays = LightRays::default();
    light_rays(&kernels, &table, &surfaces, &scene.lights[0], &mut rays);
    let stream =
        ShadowRays { u: &rays.u, v: &rays.v, tfar: &rays.limit, skip: &surfaces.prim, face: &rays.face };
    let (mut seed, mut visible) = (NO_OCCLUDER, rays.visible.clone());
    PointShadows::default().trace(&shadowing, position.to_array(), &stream, &mut seed, &mut visible);
    [&rays.visible, &visible].map(|visible| visible.iter().filter(|&&visible| visible > 0.0).count())
}

#[test]
fn a_floor_of_many_triangles_does_not_shade_itself_and_what_lies_close_above_does() {
    for (size, far) in places() {
        let (floor_triangles, middle, up) = floor(size, far, 12, 0.0);
        let camera = CameraDescription {
            eye: middle + size * (3.0 * up + Vec3::new(0.3, 0.0, 0.2)),
            at: middle,
            up: Vec3::X,
            fov_deg: 30.0,
        };
        // Overhead, aslant and grazing.
        for across in [0.1, 2.0, 8.0] {
            let light = middle + size * (up + across * Vec3::new(-0.1, 0.3, 1.0).normalize());
            let alone = mesh_of(&floor_triangles);
            let [facing, reached] = lit(&alone, &alone, camera, light);
            assert!(facing > 3000, "size {size}, far {far}: only {facing} points face the light");
            assert_eq!(reached, facing, "size {size}, far {far}, light {across}: points in their own shadow");
        }
        // Grazing light slips in from the side, and a light far away rounds like what is far away.
        let light = middle + size * (up + 0.1 * Vec3::X);
        let (plate, _, _) = floor(size * 1.2, far / 1.2, 1, 2.0 * gap(size, far));
        let both = mesh_of(&[floor_triangles.clone(), plate].concat());
        let [_, reached] = lit(&mesh_of(&floor_triangles), &both, camera, light);
        assert_eq!(reached, 0, "size {size}, far {far}: light gets through what lies close above");
    }
}
