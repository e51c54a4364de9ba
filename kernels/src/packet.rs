//! Rays and hits, one by one and 256 at a time.

/// Rays in a sub-packet.
pub const SUB: usize = 16;
/// Sub-packets in a tile packet.
pub const SUBS: usize = 16;
/// Rays in a tile packet.
pub const TILE_RAYS: usize = SUB * SUBS;
/// Primitive id of a ray that hit nothing.
pub const MISS: u32 = u32::MAX;

/// A single ray; `t` counts in lengths of `dir`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin.
    pub org: [f32; 3],
    /// Direction, any length but zero. A ray with a zero or non-finite direction or origin hits nothing.
    pub dir: [f32; 3],
    /// Least depth that counts as a hit (inclusive); values below zero mean zero.
    pub tnear: f32,
    /// Greatest depth that counts as a hit (inclusive).
    pub tfar: f32,
    /// A primitive that does not count, typically the one that the ray starts or ends on; [`MISS`] for none.
    pub skip: u32,
}

/// Where a ray hits first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Primitive id, or [`MISS`].
    pub prim: u32,
    /// Depth along the ray.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner.
    pub v: f32,
}

impl Hit {
    /// No hit.
    pub const MISS: Hit = Hit { prim: MISS, t: f32::INFINITY, u: 0.0, v: 0.0 };
}

/// One of the six axis directions: the dominant one of a ray.
///
/// The face of a direction is the *first* axis of greatest magnitude; it is a property of the ray, never of the
/// packet that it happens to be traced in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// 0 = x, 1 = y, 2 = z.
    pub axis: usize,
    /// True if the direction points to the negative side.
    pub negative: bool,
}

impl Face {
    /// All faces, by [`Face::index`].
    pub const ALL: [Face; 6] = [
        Face { axis: 0, negative: false },
        Face { axis: 0, negative: true },
        Face { axis: 1, negative: false },
        Face { axis: 1, negative: true },
        Face { axis: 2, negative: false },
        Face { axis: 2, negative: true },
    ];

    /// The face of a direction, none of whose components is NaN.
    #[inline(always)]
    pub fn of(dir: [f32; 3]) -> Face {
        let [x, y, z] = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let axis = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        Face { axis, negative: dir[axis] < 0.0 }
    }

    /// 0 to 5: axis * 2, plus 1 for the negative side.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.axis * 2 + usize::from(self.negative)
    }

    /// The world axes that carry u, v and depth.
    #[inline(always)]
    pub fn axes(self) -> [usize; 3] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3, self.axis]
    }

    /// The world direction of slopes (u, v): the dominant component is exactly 1 or -1.
    #[inline(always)]
    pub fn direction(self, u: f32, v: f32) -> [f32; 3] {
        let [iu, iv, iz] = self.axes();
        let mut dir = [0.0; 3];
        dir[iu] = u;
        dir[iv] = v;
        dir[iz] = if self.negative { -1.0 } else { 1.0 };
        dir
    }
}

/// 256 rays from one origin whose directions share a face, as slopes: at depth t ray i passes through
/// `org + t * face.direction(u[i], v[i])`.
///
/// Rays `16 s .. 16 s + 16` form sub-packet `s`; the closer their slopes, the faster the packet. A ray whose slopes or
/// `tfar` are NaN or out of range hits nothing and disturbs no other ray; the origin must be finite.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct TilePacket {
    /// Slopes along the first axis of the face, each in [-1, 1].
    pub u: [f32; TILE_RAYS],
    /// Slopes along the second axis of the face, each in [-1, 1].
    pub v: [f32; TILE_RAYS],
    /// Greatest depth that counts as a hit (inclusive), > 0; infinity is fine.
    pub tfar: [f32; TILE_RAYS],
    /// A primitive that does not count for this ray, typically the one that it ends on; [`MISS`] for none.
    pub skip: [u32; TILE_RAYS],
    /// Bit `i` of `active[s]`: ray `16 s + i` takes part. The values of the others do not matter.
    pub active: [u16; SUBS],
    /// False if `tfar` and `skip` do not matter: the rays reach to infinity, and any primitive counts.
    pub bounded: bool,
    /// Common origin.
    pub org: [f32; 3],
    /// Common face.
    pub face: Face,
}

impl TilePacket {
    /// A packet without active rays.
    pub fn new() -> TilePacket {
        TilePacket {
            u: [0.0; TILE_RAYS],
            v: [0.0; TILE_RAYS],
            tfar: [f32::INFINITY; TILE_RAYS],
            skip: [MISS; TILE_RAYS],
            active: [0; SUBS],
            bounded: true,
            org: [0.0; 3],
            face: Face::ALL[0],
        }
    }

    /// Ray `i` as a single ray: exactly the one that the tile kernel traces.
    pub fn ray(&self, i: usize) -> Ray {
        let dir = self.face.direction(self.u[i], self.v[i]);
        let skip = if self.bounded { self.skip[i] } else { MISS };
        Ray { org: self.org, dir, tnear: 0.0, tfar: self.tfar(i), skip }
    }

    /// Where ray `i` ends.
    #[inline(always)]
    pub(crate) fn tfar(&self, i: usize) -> f32 {
        if self.bounded { self.tfar[i] } else { f32::INFINITY }
    }
}

impl Default for TilePacket {
    fn default() -> TilePacket {
        TilePacket::new()
    }
}

/// First hits of the rays of a [`TilePacket`]; inactive rays keep what was there.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct TileHits {
    /// Primitive ids, [`MISS`] where nothing was hit.
    pub prim: [u32; TILE_RAYS],
    /// Depths; infinity for a miss.
    pub t: [f32; TILE_RAYS],
    /// Barycentric weights of the second corner.
    pub u: [f32; TILE_RAYS],
    /// Barycentric weights of the third corner.
    pub v: [f32; TILE_RAYS],
}

impl TileHits {
    /// All misses.
    pub fn new() -> TileHits {
        TileHits {
            prim: [MISS; TILE_RAYS],
            t: [f32::INFINITY; TILE_RAYS],
            u: [0.0; TILE_RAYS],
            v: [0.0; TILE_RAYS],
        }
    }

    /// Hit of ray `i`.
    pub fn hit(&self, i: usize) -> Hit {
        Hit { prim: self.prim[i], t: self.t[i], u: self.u[i], v: self.v[i] }
    }

    /// Replaces the hit of ray `i`.
    pub fn set(&mut self, i: usize, hit: Hit) {
        (self.prim[i], self.t[i], self.u[i], self.v[i]) = (hit.prim, hit.t, hit.u, hit.v);
    }
}

impl Default for TileHits {
    fn default() -> TileHits {
        TileHits::new()
    }
}

/// Sixteen general rays side by side: the form in which all kernels but those for a common origin take rays.
///
/// The closer their origins and directions, the faster; they need have nothing in common.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct RayBlock {
    /// Origins by axis.
    pub org: [[f32; SUB]; 3],
    /// Directions by axis, as in [`Ray`].
    pub dir: [[f32; SUB]; 3],
    /// Least depths that count, as in [`Ray`].
    pub tnear: [f32; SUB],
    /// Greatest depths that count, as in [`Ray`].
    pub tfar: [f32; SUB],
    /// Primitives that do not count, as in [`Ray`].
    pub skip: [u32; SUB],
    /// Bit = the ray takes part. The values of the others do not matter.
    pub active: u16,
}

impl RayBlock {
    /// A block without active rays.
    pub const EMPTY: RayBlock = RayBlock {
        org: [[0.0; SUB]; 3],
        dir: [[0.0; SUB]; 3],
        tnear: [0.0; SUB],
        tfar: [0.0; SUB],
        skip: [MISS; SUB],
        active: 0,
    };

    /// Replaces `blocks` by rays, 16 in a block; lanes of the last one may stay inactive.
    pub fn pack<'a>(rays: impl ExactSizeIterator<Item = &'a Ray>, blocks: &mut Vec<RayBlock>) {
        blocks.resize(rays.len().div_ceil(SUB), RayBlock::EMPTY);
        blocks.iter_mut().for_each(|block| block.active = 0);
        for (i, ray) in rays.enumerate() {
            blocks[i / SUB].set(i % SUB, ray);
        }
    }

    /// Puts a ray into lane `lane` and activates it.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: &Ray) {
        for axis in 0..3 {
            self.org[axis][lane] = ray.org[axis];
            self.dir[axis][lane] = ray.dir[axis];
        }
        self.tnear[lane] = ray.tnear;
        self.tfar[lane] = ray.tfar;
        self.skip[lane] = ray.skip;
        self.active |= 1 << lane;
    }

    /// The ray of lane `lane`.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Ray {
        Ray {
            org: [self.org[0][lane], self.org[1][lane], self.org[2][lane]],
            dir: [self.dir[0][lane], self.dir[1][lane], self.dir[2][lane]],
            tnear: self.tnear[lane],
            tfar: self.tfar[lane],
            skip: self.skip[lane],
        }
    }
}

/// First hits of the rays of a [`RayBlock`]; those of rays that are not traced keep what was there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct HitBlock {
    /// Primitive ids, [`MISS`] where nothing was hit.
    pub prim: [u32; SUB],
    /// Depths along the rays; infinity for a miss.
    pub t: [f32; SUB],
    /// Barycentric weights of the second corner.
    pub u: [f32; SUB],
    /// Barycentric weights of the third corner.
    pub v: [f32; SUB],
}

impl HitBlock {
    /// All misses.
    pub const MISS: HitBlock = HitBlock::splat(Hit::MISS);

    /// The same hit for all rays.
    pub const fn splat(hit: Hit) -> HitBlock {
        HitBlock { prim: [hit.prim; SUB], t: [hit.t; SUB], u: [hit.u; SUB], v: [hit.v; SUB] }
    }

    /// The hit of ray `lane`.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Hit {
        Hit { prim: self.prim[lane], t: self.t[lane], u: self.u[lane], v: self.v[lane] }
    }

    /// Replaces the hit of ray `lane`.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, hit: Hit) {
        (self.prim[lane], self.t[lane], self.u[lane], self.v[lane]) = (hit.prim, hit.t, hit.u, hit.v);
    }
}

/// Rays of one block that are to be traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pick {
    /// Index of the block.
    pub block: u32,
    /// Bit = ray; only those that the block has active count.
    pub active: u16,
}
