//! Builders of trees side by side: how long they take, how large their trees are, and how fast rays get through them.
//!
//! Builds are interleaved like the rounds of traversal. The trees of all presets are then traced together, so that
//! their figures come from the same minutes.

use super::{BenchOptions, Engine, Kind, RaySet, Row, Seen, irt, measure, timer::Mode};
use crate::{
    bvh::{BuildPreset, Bvh},
    error::Result,
    render::choose_kernels,
    scene::Scene,
};

/// One preset of one engine on one scene.
#[derive(Clone, Debug)]
pub struct BuildRow {
    /// Scene.
    pub scene: String,
    /// Number of its triangles.
    pub triangles: usize,
    /// Engine.
    pub engine: Engine,
    /// Preset, as the engine calls it.
    pub preset: &'static str,
    /// Seconds of each build.
    pub seconds: Vec<f64>,
    /// Bytes of tree and triangles together.
    pub bytes: usize,
    /// Expected cost of a random ray, of our trees alone: each engine counts its own way.
    pub sah_cost: Option<f64>,
    /// The fastest kernel for each kind of rays.
    pub traced: Vec<Row>,
}

/// A tree that rays can be traced through.
enum Tree {
    Irt(Bvh),
    #[cfg(feature = "embree")]
    Embree(super::peers::EmbreeTree),
}

/// What builds a tree.
#[derive(Clone)]
enum Builder {
    Irt(BuildPreset),
    #[cfg(feature = "embree")]
    Embree(super::peers::Library, super::peers::embree::Quality),
}

/// Builds the trees of all presets, and traces rays through them; `tell` hears what comes next.
///
/// # Errors
/// As [`super::bench`].
pub fn builds(scene: &Scene, options: &BenchOptions, mut tell: impl FnMut(&str)) -> Result<Vec<BuildRow>> {
    let kernels = choose_kernels(options.isa)?;
    scene.check()?;
    tell("builds");
    let builders = builders(scene, options)?;
    let mut seconds = vec![Vec::new(); builders.len()];
    for round in 0..=options.rounds {
        for (builder, seconds) in builders.iter().zip(&mut seconds) {
            let took = builder.seconds(scene)?;
            // The first round warms up.
            if round > 0 {
                seconds.push(took);
            }
        }
    }
    let trees = builders.iter().map(|builder| builder.tree(scene)).collect::<Result<Vec<_>>>()?;
    let mut rows: Vec<BuildRow> = builders
        .iter()
        .zip(&trees)
        .zip(seconds)
        .map(|((builder, tree), seconds)| row(scene, builder, tree, seconds))
        .collect();
    let reference = Bvh::build(&scene.mesh, BuildPreset::Medium)?;
    let seen = Seen::new(scene, &reference, kernels, options.size);
    for &kind in &options.kinds {
        let set = RaySet::new(kind, scene, &seen);
        if set.is_empty() {
            continue;
        }
        tell(kind.name());
        let mut modes: Vec<Box<dyn Mode + '_>> = Vec::new();
        let mut owners = Vec::new();
        for (index, tree) in trees.iter().enumerate() {
            match tree {
                Tree::Irt(bvh) => modes.extend(irt::modes(bvh, kernels, &set)),
                #[cfg(feature = "embree")]
                Tree::Embree(tree) => modes.extend(tree.scenes.modes(&set)),
            }
            owners.resize(modes.len(), index);
        }
        let measured = measure(scene, &set, modes, options);
        for (index, row) in rows.iter_mut().enumerate() {
            let own = measured.iter().zip(&owners).filter(|(_, owner)| **owner == index).map(|(row, _)| row);
            row.traced.extend(own.max_by(|a, b| a.middle().total_cmp(&b.middle())).cloned());
        }
    }
    Ok(rows)
}

impl BuildRow {
    /// What was measured for one kind of rays.
    pub fn traced(&self, kind: Kind) -> Option<&Row> {
        self.traced.iter().find(|row| row.kind == kind)
    }
}

fn builders(scene: &Scene, options: &BenchOptions) -> Result<Vec<Builder>> {
    let mut builders: Vec<Builder> = BuildPreset::ALL.into_iter().map(Builder::Irt).collect();
    super::peers::check(&options.engines)?;
    #[cfg(feature = "embree")]
    if options.engines.contains(&Engine::Embree) {
        use super::peers::{Library, embree::Quality, unavailable};
        let library = Library::open(scene, options).map_err(unavailable)?;
        builders.extend([Quality::Medium, Quality::High].map(|q| Builder::Embree(library.clone(), q)));
    }
    #[cfg(not(feature = "embree"))]
    let _ = scene;
    builders.retain(|builder| options.engines.contains(&builder.engine()));
    Ok(builders)
}

impl Builder {
    fn engine(&self) -> Engine {
        match self {
            Builder::Irt(_) => Engine::Irt,
            #[cfg(feature = "embree")]
            Builder::Embree(..) => Engine::Embree,
        }
    }

    fn preset(&self) -> &'static str {
        match self {
            Builder::Irt(preset) => preset.name(),
            #[cfg(feature = "embree")]
            Builder::Embree(_, super::peers::embree::Quality::Medium) => "medium",
            #[cfg(feature = "embree")]
            Builder::Embree(_, super::peers::embree::Quality::High) => "high",
        }
    }

    /// Seconds of a build whose tree is dropped again.
    fn seconds(&self, scene: &Scene) -> Result<f64> {
        match self {
            Builder::Irt(preset) => {
                Bvh::build(&scene.mesh, *preset).map(|bvh| bvh.build_time().as_secs_f64())
            }
            #[cfg(feature = "embree")]
            Builder::Embree(library, quality) => library.seconds(*quality).map_err(super::peers::unavailable),
        }
    }

    fn tree(&self, scene: &Scene) -> Result<Tree> {
        match self {
            Builder::Irt(preset) => Bvh::build(&scene.mesh, *preset).map(Tree::Irt),
            #[cfg(feature = "embree")]
            Builder::Embree(library, quality) => {
                library.tree(*quality).map(Tree::Embree).map_err(super::peers::unavailable)
            }
        }
    }
}

fn row(scene: &Scene, builder: &Builder, tree: &Tree, seconds: Vec<f64>) -> BuildRow {
    let (bytes, sah_cost) = match tree {
        Tree::Irt(bvh) => (bvh.bytes(), Some(bvh.report().sah_cost)),
        #[cfg(feature = "embree")]
        Tree::Embree(tree) => (usize::try_from(tree.bytes).unwrap_or(0), None),
    };
    BuildRow {
        scene: scene.name.clone(),
        triangles: scene.mesh.len(),
        engine: builder.engine(),
        preset: builder.preset(),
        seconds,
        bytes,
        sah_cost,
        traced: Vec::new(),
    }
}
