//! Embree 4 beside irt: opened at run time, the few functions and structures declared here.
//!
//! The module is included by path from several places, so not everything in it is used everywhere.
//!
//! Layouts follow `rtcore_ray.h` and `rtcore_scene.h` of Embree 4.4 (built with instance arrays, as released).

#![allow(dead_code, unreachable_pub)]

use libloading::{Library, Symbol};
use std::{
    ffi::{CString, c_char, c_void},
    path::{Path, PathBuf},
    sync::atomic::{AtomicI64, Ordering},
};

type Handle = *mut c_void;
type TraceOne = unsafe extern "C" fn(Handle, *mut c_void, *const Arguments);
type TraceMany = unsafe extern "C" fn(*const i32, Handle, *mut c_void, *const Arguments);

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which agree in layout.
#[repr(C)]
struct Arguments {
    flags: u32,
    feature_mask: u32,
    context: *mut c_void,
    filter: *mut c_void,
    intersect: *mut c_void,
}

const COHERENT: u32 = 1 << 16;
const ROBUST: u32 = 1 << 2;
const INVALID: u32 = u32::MAX;

/// `RTCRayHit1/4/8/16`: `W` rays side by side, and room for their hits.
#[derive(Clone)]
#[repr(C, align(64))]
pub struct Rays<const W: usize> {
    org: [[f32; W]; 3],
    tnear: [f32; W],
    dir: [[f32; W]; 3],
    time: [f32; W],
    tfar: [f32; W],
    mask: [u32; W],
    id: [u32; W],
    flags: [u32; W],
    ng: [[f32; W]; 3],
    u: [f32; W],
    v: [f32; W],
    prim: [u32; W],
    geom: [u32; W],
    inst: [u32; W],
    inst_prim: [u32; W],
    /// Not seen by Embree: -1 for rays that take part.
    valid: [i32; W],
}

/// A ray: origin, direction, tnear, tfar.
pub type Ray = ([f32; 3], [f32; 3], f32, f32);

impl<const W: usize> Rays<W> {
    /// Consecutive rays side by side; the last group is filled up with rays that take no part.
    pub fn pack(rays: &[Ray]) -> Vec<Rays<W>> {
        rays.chunks(W).map(Rays::group).collect()
    }

    fn group(rays: &[Ray]) -> Rays<W> {
        let get = |i: usize| rays.get(i).copied().unwrap_or(([0.0; 3], [0.0, 0.0, 1.0], 0.0, -1.0));
        let plane = |f: &dyn Fn(Ray) -> f32| std::array::from_fn(|i| f(get(i)));
        Rays {
            org: [plane(&|r| r.0[0]), plane(&|r| r.0[1]), plane(&|r| r.0[2])],
            tnear: plane(&|r| r.2),
            dir: [plane(&|r| r.1[0]), plane(&|r| r.1[1]), plane(&|r| r.1[2])],
            time: [0.0; W],
            tfar: plane(&|r| r.3),
            mask: [u32::MAX; W],
            id: [0; W],
            flags: [0; W],
            ng: [[0.0; W]; 3],
            u: [0.0; W],
            v: [0.0; W],
            prim: [INVALID; W],
            geom: [INVALID; W],
            inst: [INVALID; W],
            inst_prim: [INVALID; W],
            valid: std::array::from_fn(|i| if i < rays.len() { -1 } else { 0 }),
        }
    }

    /// Primitive hit by ray `i` of the group after [`Scene::intersect`]; `None` for a miss.
    pub fn prim(&self, i: usize) -> Option<u32> {
        (self.geom[i] != INVALID).then_some(self.prim[i])
    }

    /// Depth of ray `i`'s hit after [`Scene::intersect`].
    pub fn depth(&self, i: usize) -> f32 {
        self.tfar[i]
    }

    /// Whether ray `i` of the group was found blocked by [`Scene::occluded`].
    pub fn blocked(&self, i: usize) -> bool {
        self.valid[i] != 0 && self.tfar[i] == f32::NEG_INFINITY
    }
}

/// An opened library with a device.
pub struct Embree {
    library: Library,
    device: Handle,
    /// Bytes that the device holds.
    bytes: Box<AtomicI64>,
}

/// How well Embree builds its tree: `RTCBuildQuality`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// The default.
    Medium = 1,
    /// With spatial splits.
    High = 2,
}

impl Embree {
    /// Opens the library at `IRT_EMBREE`, or where the system's loader finds it. `config` is Embree's device
    /// configuration, for example "threads=2,isa=avx2".
    ///
    /// # Errors
    /// A sentence that says what was tried.
    pub fn open(config: &str) -> Result<Embree, String> {
        let candidates: Vec<PathBuf> = match std::env::var_os("IRT_EMBREE") {
            Some(path) => vec![find(Path::new(&path))],
            None => ["libembree4.so.4", "libembree4.so", "libembree4.dylib", "embree4.dll"]
                .map(PathBuf::from)
                .into(),
        };
        let mut tried = Vec::new();
        for path in &candidates {
            // SAFETY: loading runs the library's initialisers; the user named it, or the system provides it.
            match unsafe { Library::new(path) } {
                Ok(library) => return Embree::with(library, config),
                Err(error) => tried.push(format!("{} ({error})", path.display())),
            }
        }
        Err(format!("cannot open Embree: tried {}; set IRT_EMBREE to its path", tried.join(", ")))
    }

    fn with(library: Library, config: &str) -> Result<Embree, String> {
        let config = CString::new(config).map_err(|_| "the configuration has a zero byte".to_string())?;
        let mut embree = Embree { library, device: std::ptr::null_mut(), bytes: Box::default() };
        // SAFETY: signature as in rtcore_device.h; the string outlives the call.
        embree.device = unsafe {
            embree.get::<unsafe extern "C" fn(*const c_char) -> Handle>("rtcNewDevice")?(config.as_ptr())
        };
        if embree.device.is_null() {
            return Err("Embree made no device".into());
        }
        let bytes: *const AtomicI64 = &raw const *embree.bytes;
        // SAFETY: signature as in rtcore_device.h; the counter outlives the device, because it is boxed and dropped
        // after `drop` has released that.
        unsafe {
            type Monitor = extern "C" fn(*mut c_void, isize, bool) -> bool;
            embree.get::<unsafe extern "C" fn(Handle, Monitor, *const AtomicI64)>(
                "rtcSetDeviceMemoryMonitorFunction",
            )?(embree.device, count_bytes, bytes);
        }
        Ok(embree)
    }

    /// Bytes that all scenes of the device hold.
    pub fn bytes(&self) -> i64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// # Safety
    /// `T` must be the signature of `name`.
    unsafe fn get<T>(&self, name: &str) -> Result<Symbol<'_, T>, String> {
        // SAFETY: passed on to the caller.
        unsafe { self.library.get(name.as_bytes()) }.map_err(|_| format!("this Embree has no {name}"))
    }

    /// Builds a scene over indexed triangles; returns it with its build time in seconds.
    ///
    /// # Errors
    /// If the library lacks a function.
    pub fn scene<'a>(
        &'a self,
        positions: &'a [[f32; 3]],
        triangles: &'a [[u32; 3]],
        quality: Quality,
        robust: bool,
    ) -> Result<(Scene<'a>, f64), String> {
        // SAFETY: signatures as in rtcore_scene.h and rtcore_geometry.h. The shared buffers outlive the scene by
        // 'a; Embree may read up to 16 bytes at the last vertex, which `positions` provides (see `pad`).
        unsafe {
            let new_scene = self.get::<unsafe extern "C" fn(Handle) -> Handle>("rtcNewScene")?;
            let set_quality = self.get::<unsafe extern "C" fn(Handle, u32)>("rtcSetSceneBuildQuality")?;
            let set_flags = self.get::<unsafe extern "C" fn(Handle, u32)>("rtcSetSceneFlags")?;
            let new_geometry = self.get::<unsafe extern "C" fn(Handle, u32) -> Handle>("rtcNewGeometry")?;
            let buffer =
                self.get::<unsafe extern "C" fn(Handle, u32, u32, u32, *const c_void, usize, usize, usize)>(
                    "rtcSetSharedGeometryBuffer",
                )?;
            let commit_geometry = self.get::<unsafe extern "C" fn(Handle)>("rtcCommitGeometry")?;
            let attach = self.get::<unsafe extern "C" fn(Handle, Handle) -> u32>("rtcAttachGeometry")?;
            let release = self.get::<unsafe extern "C" fn(Handle)>("rtcReleaseGeometry")?;
            let commit = self.get::<unsafe extern "C" fn(Handle)>("rtcCommitScene")?;

            let handle = new_scene(self.device);
            set_quality(handle, quality as u32);
            set_flags(handle, if robust { ROBUST } else { 0 });
            let geometry = new_geometry(self.device, 0);
            buffer(geometry, 1, 0, 0x9003, positions.as_ptr().cast(), 0, 12, positions.len());
            buffer(geometry, 0, 0, 0x5003, triangles.as_ptr().cast(), 0, 12, triangles.len());
            commit_geometry(geometry);
            attach(handle, geometry);
            release(geometry);
            let start = std::time::Instant::now();
            commit(handle);
            let seconds = start.elapsed().as_secs_f64();
            Ok((Scene { embree: self, handle, entries: Entries::load(self)? }, seconds))
        }
    }
}

// SAFETY: Embree's interface may be called from any thread; the device counts its references atomically, and the library
// and its functions do not change.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: the device is ours and no scene outlives it ('a of `scene`).
        unsafe {
            if let Ok(release) = self.get::<unsafe extern "C" fn(Handle)>("rtcReleaseDevice")
                && !self.device.is_null()
            {
                release(self.device);
            }
        }
    }
}

/// Embree tells how many bytes it is about to allocate, or has freed.
extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: the pointer given to rtcSetDeviceMemoryMonitorFunction.
    unsafe { &*counter.cast::<AtomicI64>() }.fetch_add(bytes as i64, Ordering::Relaxed);
    true
}

/// A folder stands for the library inside it (as in an unpacked Python wheel).
fn find(path: &Path) -> PathBuf {
    let inside = std::fs::read_dir(path).ok().and_then(|entries| {
        entries.filter_map(|entry| Some(entry.ok()?.path())).find(|path| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("libembree4"))
        })
    });
    inside.unwrap_or_else(|| path.into())
}

/// The traversal functions by width.
#[derive(Clone, Copy)]
struct Entries {
    intersect1: TraceOne,
    occluded1: TraceOne,
    intersect: [TraceMany; 3],
    occluded: [TraceMany; 3],
}

impl Entries {
    fn load(embree: &Embree) -> Result<Entries, String> {
        // SAFETY: signatures as in rtcore_scene.h; the pointers stay valid while the library is open, which the
        // scene's borrow of `Embree` ensures.
        unsafe {
            Ok(Entries {
                intersect1: *embree.get("rtcIntersect1")?,
                occluded1: *embree.get("rtcOccluded1")?,
                intersect: [
                    *embree.get("rtcIntersect4")?,
                    *embree.get("rtcIntersect8")?,
                    *embree.get("rtcIntersect16")?,
                ],
                occluded: [
                    *embree.get("rtcOccluded4")?,
                    *embree.get("rtcOccluded8")?,
                    *embree.get("rtcOccluded16")?,
                ],
            })
        }
    }
}

/// A committed scene.
pub struct Scene<'a> {
    embree: &'a Embree,
    handle: Handle,
    entries: Entries,
}

// SAFETY: rtcIntersect and rtcOccluded may be called from any thread at once on a committed scene.
unsafe impl Sync for Scene<'_> {}

impl Scene<'_> {
    /// First hits of all rays. `W` is 1, 4, 8 or 16.
    pub fn intersect<const W: usize>(&self, rays: &mut [Rays<W>], coherent: bool) {
        self.trace(rays, coherent, self.entries.intersect1, self.entries.intersect);
    }

    /// Occlusion of all rays. `W` is 1, 4, 8 or 16.
    pub fn occluded<const W: usize>(&self, rays: &mut [Rays<W>], coherent: bool) {
        self.trace(rays, coherent, self.entries.occluded1, self.entries.occluded);
    }

    fn trace<const W: usize>(
        &self,
        rays: &mut [Rays<W>],
        coherent: bool,
        one: TraceOne,
        many: [TraceMany; 3],
    ) {
        let arguments = Arguments {
            flags: if coherent { COHERENT } else { 0 },
            feature_mask: u32::MAX,
            context: std::ptr::null_mut(),
            filter: std::ptr::null_mut(),
            intersect: std::ptr::null_mut(),
        };
        let many = match W {
            1 => None,
            4 => Some(many[0]),
            8 => Some(many[1]),
            16 => Some(many[2]),
            _ => panic!("Embree has no packets of {W} rays"),
        };
        for group in rays {
            let valid = group.valid.as_ptr();
            let pointer = std::ptr::from_mut(group).cast();
            // SAFETY: `Rays<W>` has the layout and alignment of the structure that this width expects, and a
            // valid mask of W entries.
            unsafe {
                match many {
                    None => one(self.handle, pointer, &arguments),
                    Some(trace) => trace(valid, self.handle, pointer, &arguments),
                }
            }
        }
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: the scene is ours and nothing uses it any more.
        unsafe {
            if let Ok(release) = self.embree.get::<unsafe extern "C" fn(Handle)>("rtcReleaseScene") {
                release(self.handle);
            }
        }
    }
}
