//! Grows a mesh out of curved patches, boxes, lathed and extruded profiles.
//!
//! Everything is placed through [`Builder::at`], so that a chair is described once and set down many times. Smooth
//! shapes carry normals; flat ones carry the zero vector, which means "the triangle's own".

use crate::scene::{CameraDescription, Light, Material, Part, Scene, Texture, TriangleMesh};
use glam::{Affine3A, Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// A mesh under construction, with its materials.
pub(super) struct Builder {
    detail: f32,
    mesh: TriangleMesh,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    placement: Affine3A,
    material: u32,
    tiles: Option<Vec2>,
}

impl Builder {
    /// An empty mesh. `detail` multiplies every subdivision given through [`Builder::steps`].
    pub(super) fn new(detail: f32) -> Builder {
        Builder {
            detail,
            mesh: TriangleMesh::default(),
            materials: Vec::new(),
            textures: Vec::new(),
            placement: Affine3A::IDENTITY,
            material: 0,
            tiles: None,
        }
    }

    /// A subdivision count that is `base` at detail 1 and grows in proportion, never below `least`.
    pub(super) fn steps(&self, base: f32, least: usize) -> usize {
        ((base * self.detail).round() as usize).max(least)
    }

    /// Adds a material; the result selects it in [`Builder::paint`].
    pub(super) fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Adds a picture; the result is what maps of materials hold.
    pub(super) fn texture(&mut self, texture: Texture) -> Option<u32> {
        self.textures.push(texture);
        Some(self.textures.len() as u32 - 1)
    }

    /// The patches that `build` adds show so many tiles of a picture along u and v of each.
    pub(super) fn tiled(&mut self, tiles: Vec2, build: impl FnOnce(&mut Builder)) {
        let outer = self.tiles.replace(tiles);
        build(self);
        self.tiles = outer;
    }

    /// What follows has this material.
    pub(super) fn paint(&mut self, material: u32) {
        self.material = material;
    }

    /// What follows is counted under this name.
    pub(super) fn part(&mut self, name: &str) {
        self.close_part();
        self.mesh.parts.push(Part { name: name.into(), first: self.len() as u32, count: 0 });
    }

    /// What `build` adds is placed by `placement`, relative to the placement in force.
    pub(super) fn at(&mut self, placement: Affine3A, build: impl FnOnce(&mut Builder)) {
        let outer = self.placement;
        self.placement = outer * placement;
        build(self);
        self.placement = outer;
    }

    /// A surface `f(u, v)` over the unit square in `nu` x `nv` cells, front side where du x dv points. With `smooth`,
    /// normals are taken from the surface itself by differences, so that neighbouring patches of one curved form
    /// shade without a seam.
    pub(super) fn patch(&mut self, cells: [usize; 2], smooth: bool, f: impl Fn(f32, f32) -> Vec3) {
        let material = self.material;
        self.mosaic(cells, smooth, |_, _| material, f);
    }

    /// A patch whose cell (i, j) has the material `paint(i, j)`: stones and tiles that share their edges exactly.
    pub(super) fn mosaic(
        &mut self,
        [nu, nv]: [usize; 2],
        smooth: bool,
        paint: impl Fn(usize, usize) -> u32,
        f: impl Fn(f32, f32) -> Vec3,
    ) {
        let outer = self.material;
        let first = self.grid([nu, nv], smooth, f);
        let row = nu as u32 + 1;
        for j in 0..nv {
            for i in 0..nu {
                self.material = paint(i, j);
                let a = first + j as u32 * row + i as u32;
                // Alternating diagonals: no long folds along one direction.
                let (b, c, d) = (a + 1, a + row + 1, a + row);
                let [one, two] =
                    if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                self.triangle(one);
                self.triangle(two);
            }
        }
        self.material = outer;
    }

    /// Adds the vertices of a patch, row by row; the result is the index of the first.
    fn grid(&mut self, [nu, nv]: [usize; 2], smooth: bool, f: impl Fn(f32, f32) -> Vec3) -> u32 {
        let first = self.mesh.positions.len() as u32;
        let cofactor = Mat3::from(self.placement.matrix3).inverse().transpose();
        for j in 0..=nv {
            for i in 0..=nu {
                let (u, v) = (i as f32 / nu as f32, j as f32 / nv as f32);
                self.mesh.positions.push(self.placement.transform_point3(f(u, v)));
                let normal = if smooth { surface_normal(&f, u, v) } else { Vec3::ZERO };
                self.mesh.normals.push((cofactor * normal).normalize_or_zero());
                if let Some(tiles) = self.tiles {
                    self.mesh.uvs.resize(self.mesh.positions.len() - 1, Vec2::ZERO);
                    self.mesh.uvs.push(Vec2::new(u, v) * tiles);
                }
            }
        }
        first
    }

    /// A parallelogram from `corner` along `du` and `dv`, facing du x dv, in `cells`.
    pub(super) fn quad(&mut self, cells: [usize; 2], corner: Vec3, du: Vec3, dv: Vec3) {
        self.patch(cells, false, |u, v| corner + du * u + dv * v);
    }

    /// An axis-aligned box, every face one quad, facing outwards.
    pub(super) fn cuboid(&mut self, min: Vec3, max: Vec3) {
        let size = max - min;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
        for (corner, du, dv) in
            [(min, y, x), (min, z, y), (min, x, z), (max, -y, -z), (max, -z, -x), (max, -x, -y)]
        {
            self.quad([1, 1], corner, du, dv);
        }
    }

    /// A surface of revolution about the y axis. `profile` is (radius, height) from bottom to top, its straight
    /// pieces shaded smoothly around the axis and creased at every point of the profile.
    pub(super) fn lathe(&mut self, profile: &[Vec2], around: usize) {
        for piece in profile.windows(2) {
            let [low, high] = [piece[0], piece[1]];
            self.patch([around, 1], true, |u, v| {
                let p = low.lerp(high, v);
                let (sin, cos) = (-u * TAU).sin_cos();
                Vec3::new(p.x * cos, p.y, p.x * sin)
            });
        }
    }

    /// Sweeps a smooth curve of revolution `f(v) -> (radius, height)` about the y axis.
    pub(super) fn turned(&mut self, cells: [usize; 2], f: impl Fn(f32) -> Vec2) {
        self.patch(cells, true, |u, v| {
            let p = f(v);
            let (sin, cos) = (-u * TAU).sin_cos();
            Vec3::new(p.x * cos, p.y, p.x * sin)
        });
    }

    /// Adds vertices and triangles as they are (indices count from the first of `positions`), through the placement.
    pub(super) fn append(&mut self, positions: &[Vec3], normals: &[Vec3], triangles: &[[u32; 3]]) {
        let first = self.mesh.positions.len() as u32;
        let cofactor = Mat3::from(self.placement.matrix3).inverse().transpose();
        self.mesh.positions.extend(positions.iter().map(|&p| self.placement.transform_point3(p)));
        self.mesh.normals.extend(normals.iter().map(|&n| (cofactor * n).normalize_or_zero()));
        self.mesh.normals.resize(self.mesh.positions.len(), Vec3::ZERO);
        for triangle in triangles {
            self.triangle(triangle.map(|v| v + first));
        }
    }

    /// Number of triangles so far.
    pub(super) fn len(&self) -> usize {
        self.mesh.len()
    }

    /// The finished scene.
    pub(super) fn finish(
        mut self,
        name: &str,
        lights: Vec<Light>,
        camera: CameraDescription,
        ambient: Vec3,
        background: Vec3,
    ) -> Scene {
        self.close_part();
        if !self.mesh.uvs.is_empty() {
            self.mesh.uvs.resize(self.mesh.positions.len(), Vec2::ZERO);
        }
        Scene {
            name: name.into(),
            mesh: self.mesh,
            materials: self.materials,
            textures: self.textures,
            lights,
            camera,
            ambient,
            background,
            ..Scene::default()
        }
    }

    /// Triangles that a collapsed edge (a pole, a tip) leaves without area are not added. A normal that looks away
    /// from the triangle's front, as it may where a coarse mesh cuts off a bend, is not used for this triangle.
    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|v| self.mesh.positions[v as usize]);
        let face = (b - a).cross(c - a);
        if face.length_squared() > 0.0 {
            let corners = corners.map(|v| if self.looks_away(v, face) { self.creased(v) } else { v });
            self.mesh.triangles.push(corners);
            self.mesh.materials.push(self.material);
        }
    }

    fn looks_away(&self, vertex: u32, face: Vec3) -> bool {
        let normal = self.mesh.normals[vertex as usize];
        normal != Vec3::ZERO && normal.dot(face) <= 0.0
    }

    /// The same vertex without a normal of its own.
    fn creased(&mut self, vertex: u32) -> u32 {
        if let Some(&uv) = self.mesh.uvs.get(vertex as usize) {
            self.mesh.uvs.resize(self.mesh.positions.len(), Vec2::ZERO);
            self.mesh.uvs.push(uv);
        }
        self.mesh.positions.push(self.mesh.positions[vertex as usize]);
        self.mesh.normals.push(Vec3::ZERO);
        self.mesh.positions.len() as u32 - 1
    }

    fn close_part(&mut self) {
        let end = self.len() as u32;
        if let Some(part) = self.mesh.parts.last_mut() {
            part.count = end - part.first;
        }
    }
}

/// Normal of `f` at (u, v) by differences that stay inside the unit square; moved off a pole, where f does not
/// depend on one parameter, by looking a little further in.
fn surface_normal(f: &impl Fn(f32, f32) -> Vec3, u: f32, v: f32) -> Vec3 {
    const STEP: f32 = 1.0 / 1024.0;
    let inside = |x: f32| (x.clamp(STEP, 1.0 - STEP) - STEP, x.clamp(STEP, 1.0 - STEP) + STEP);
    let ((u0, u1), (v0, v1)) = (inside(u), inside(v));
    let at_v = v.clamp(STEP, 1.0 - STEP);
    let at_u = u.clamp(STEP, 1.0 - STEP);
    (f(u1, at_v) - f(u0, at_v)).cross(f(at_u, v1) - f(at_u, v0)).normalize_or_zero()
}
