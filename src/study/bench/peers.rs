//! Other engines as modes: obvhs' own traversal, and Embree where it is available.

use super::{BenchOptions, Engine, RaySet, timer::Mode};
use crate::{
    bvh::Baseline,
    error::{Error, Result},
    scene::Scene,
};

/// Rays in a unit of work.
const UNIT: usize = 4096;

/// Tells early whether an engine cannot be had.
///
/// # Errors
/// As [`Peers::new`].
pub(super) fn check(engines: &[Engine]) -> Result<()> {
    if !engines.contains(&Engine::Embree) {
        return Ok(());
    }
    #[cfg(feature = "embree")]
    return embree::Embree::open("threads=1").map(drop).map_err(unavailable);
    #[cfg(not(feature = "embree"))]
    Err(unavailable("this irt was built without it".into()))
}

/// The trees of the engines asked for.
pub(super) struct Peers {
    obvhs: Option<Baseline>,
    #[cfg(feature = "embree")]
    embree: Option<embree_modes::Scenes>,
}

/// What Embree's builder gave.
#[cfg(feature = "embree")]
pub(super) use embree_modes::{EmbreeTree, Library};

impl Peers {
    /// # Errors
    /// [`Error::Flag`] if Embree is asked for and cannot be had.
    pub(super) fn new(scene: &Scene, options: &BenchOptions) -> Result<Peers> {
        let wants = |engine| options.engines.contains(&engine);
        let obvhs = wants(Engine::Obvhs).then(|| Baseline::build(&scene.mesh));
        #[cfg(feature = "embree")]
        return Ok(Peers {
            obvhs,
            embree: wants(Engine::Embree)
                .then(|| {
                    let library = Library::open(scene, options)?;
                    embree_modes::Scenes::new(&library, embree::Quality::High)
                })
                .transpose()
                .map_err(unavailable)?,
        });
        #[cfg(not(feature = "embree"))]
        check(&options.engines).map(|()| Peers { obvhs })
    }

    /// The modes of one engine for a set of rays.
    pub(super) fn modes<'a>(&'a self, engine: Engine, set: &'a RaySet) -> Vec<Box<dyn Mode + 'a>> {
        match engine {
            Engine::Irt => Vec::new(),
            Engine::Obvhs => self
                .obvhs
                .iter()
                .map(|baseline| -> Box<dyn Mode + 'a> { Box::new(Obvhs { baseline, set }) })
                .collect(),
            #[cfg(feature = "embree")]
            Engine::Embree => self.embree.iter().flat_map(|scenes| scenes.modes(set)).collect(),
            #[cfg(not(feature = "embree"))]
            Engine::Embree => Vec::new(),
        }
    }
}

pub(in crate::study) fn unavailable(what: String) -> Error {
    let remedy = "build with --features embree and set IRT_EMBREE to the library (see the README), or leave embree out";
    Error::flag("--engines", format!("Embree is not available: {what}"), remedy)
}

/// obvhs' binary tree, one ray at a time.
struct Obvhs<'a> {
    baseline: &'a Baseline,
    set: &'a RaySet,
}

impl Mode for Obvhs<'_> {
    fn engine(&self) -> Engine {
        Engine::Obvhs
    }

    fn isa(&self) -> String {
        "native".into()
    }

    fn kernel(&self) -> String {
        "bvh2".into()
    }

    fn width(&self) -> usize {
        1
    }

    fn units(&self) -> usize {
        self.set.len().div_ceil(UNIT)
    }

    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
        let occlusion = self.set.kind().occlusion();
        Box::new(move |unit| {
            let rays = self.set.rays().chunks(UNIT).nth(unit).unwrap_or_default();
            let hit = |ray: &&crate::kernels::Ray| {
                if occlusion { self.baseline.occluded(ray) } else { self.baseline.intersect(ray).is_some() }
            };
            rays.iter().filter(hit).count() as u64
        })
    }
}

#[cfg(feature = "embree")]
#[path = "../../../benches/support/embree.rs"]
pub(in crate::study) mod embree;

#[cfg(feature = "embree")]
mod embree_modes {
    use super::{
        super::{BenchOptions, Engine, RaySet, timer::Mode},
        UNIT, embree,
    };
    use crate::scene::Scene;
    use embree::{Embree, Quality, Rays};
    use std::sync::Mutex;

    /// Embree with the geometry of a scene. All of it is leaked: the library stays loaded for the life of the process
    /// anyway.
    #[derive(Clone)]
    pub(crate) struct Library {
        engine: &'static Embree,
        positions: &'static [[f32; 3]],
        triangles: &'static [[u32; 3]],
        isa: String,
    }

    /// A tree with what it took.
    pub(crate) struct EmbreeTree {
        pub(crate) scenes: Scenes,
        pub(crate) bytes: i64,
    }

    impl Library {
        pub(crate) fn open(scene: &Scene, options: &BenchOptions) -> Result<Library, String> {
            let isa = options.isa.map_or(String::new(), |isa| format!(",isa={}", isa.name()));
            // As many threads as our own builder takes.
            let threads = std::thread::available_parallelism().map_or(1, usize::from);
            let engine = Box::leak(Box::new(Embree::open(&format!("threads={threads}{isa}"))?));
            // Embree reads 16 bytes at the last vertex: one more stands behind it.
            let positions = scene.mesh.positions.iter().map(|p| p.to_array()).chain([[0.0; 3]]);
            Ok(Library {
                engine,
                positions: Vec::leak(positions.collect()),
                triangles: Vec::leak(scene.mesh.triangles.clone()),
                isa: options.isa.map_or_else(|| "native".to_string(), |isa| isa.name().to_string()),
            })
        }

        /// Seconds of a build whose tree is dropped again.
        pub(crate) fn seconds(&self, quality: Quality) -> Result<f64, String> {
            self.build(quality, false).map(|(_, seconds)| seconds)
        }

        /// Trees to trace rays through, and the size of one.
        pub(crate) fn tree(&self, quality: Quality) -> Result<EmbreeTree, String> {
            let before = self.engine.bytes();
            let held = self.build(quality, false)?;
            let bytes = self.engine.bytes() - before;
            drop(held);
            Ok(EmbreeTree { scenes: Scenes::new(self, quality)?, bytes })
        }

        fn build(&self, quality: Quality, robust: bool) -> Result<(embree::Scene<'static>, f64), String> {
            self.engine.scene(self.positions, self.triangles, quality, robust)
        }
    }

    /// One tree for each of Embree's two accuracies: default and robust.
    pub(crate) struct Scenes {
        scenes: [embree::Scene<'static>; 2],
        isa: String,
    }

    impl Scenes {
        pub(crate) fn new(library: &Library, quality: Quality) -> Result<Scenes, String> {
            let scenes = [library.build(quality, false)?.0, library.build(quality, true)?.0];
            Ok(Scenes { scenes, isa: library.isa.clone() })
        }

        pub(crate) fn modes<'a>(&'a self, set: &'a RaySet) -> Vec<Box<dyn Mode + 'a>> {
            let mut modes: Vec<Box<dyn Mode + 'a>> = Vec::new();
            for robust in [false, true] {
                for coherent in [true, false] {
                    modes.push(Box::new(Packets::<1>::new(self, set, coherent, robust)));
                    modes.push(Box::new(Packets::<4>::new(self, set, coherent, robust)));
                    modes.push(Box::new(Packets::<8>::new(self, set, coherent, robust)));
                    modes.push(Box::new(Packets::<16>::new(self, set, coherent, robust)));
                }
            }
            modes
        }
    }

    /// One way to call Embree.
    struct Packets<'a, const W: usize> {
        scenes: &'a Scenes,
        set: &'a RaySet,
        coherent: bool,
        robust: bool,
        /// The rays of each unit; filled by `reset`, because tracing overwrites them.
        units: Vec<Mutex<Vec<Rays<W>>>>,
    }

    impl<'a, const W: usize> Packets<'a, W> {
        fn new(scenes: &'a Scenes, set: &'a RaySet, coherent: bool, robust: bool) -> Packets<'a, W> {
            Packets { scenes, set, coherent, robust, units: Vec::new() }
        }
    }

    impl<const W: usize> Mode for Packets<'_, W> {
        fn engine(&self) -> Engine {
            Engine::Embree
        }

        fn isa(&self) -> String {
            self.scenes.isa.clone()
        }

        fn kernel(&self) -> String {
            let coherence = if self.coherent { "coherent" } else { "incoherent" };
            format!("{coherence}{}", if self.robust { " robust" } else { "" })
        }

        fn width(&self) -> usize {
            W
        }

        fn units(&self) -> usize {
            self.set.len().div_ceil(UNIT)
        }

        fn reset(&mut self) {
            let pack = |rays: &[crate::kernels::Ray]| {
                let rays: Vec<embree::Ray> = rays.iter().map(|r| (r.org, r.dir, r.tnear, r.tfar)).collect();
                Mutex::new(Rays::pack(&rays))
            };
            self.units = self.set.rays().chunks(UNIT).map(pack).collect();
        }

        fn release(&mut self) {
            self.units = Vec::new();
        }

        fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
            let occlusion = self.set.kind().occlusion();
            let scene = &self.scenes.scenes[usize::from(self.robust)];
            Box::new(move |unit| {
                // Each unit is taken once a round, so nobody waits for this lock.
                let mut rays = self.units[unit].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                if occlusion {
                    scene.occluded(&mut rays, self.coherent);
                    rays.iter().map(|group| (0..W).filter(|&i| group.blocked(i)).count() as u64).sum()
                } else {
                    scene.intersect(&mut rays, self.coherent);
                    rays.iter().map(|group| (0..W).filter(|&i| group.prim(i).is_some()).count() as u64).sum()
                }
            })
        }
    }
}
