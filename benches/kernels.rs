//! `cargo bench`: the steps of `irt bench --micro` through criterion, for each instruction set of this machine, in less
//! than a minute. For quick comparisons of two versions; figures to publish come from `irt bench`.
//!
//! A 256x256 image of the built-in atrium; the last of the scene's positional lights casts the shadows. All threads
//! but one stay idle.

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use irt::{
    bvh::BuildPreset,
    kernels::{Isa, Kernels},
    scene::procedural,
    study::bench::micro::{Stage, steps},
};
use std::time::Duration;

fn kernels(criterion: &mut Criterion) {
    let scene = procedural::build("atrium", 1.0).expect("a built-in scene");
    let stage = Stage::new(&scene, BuildPreset::default(), [256; 2]).expect("a tree");
    for kernels in Isa::available().filter_map(Kernels::for_isa) {
        let mut group = criterion.benchmark_group(kernels.isa().name());
        group.sampling_mode(SamplingMode::Flat);
        for mut step in steps(&stage, kernels) {
            group.throughput(Throughput::Elements(step.units()));
            group.bench_function(step.name(), |bencher| bencher.iter(|| step.run()));
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .nresamples(10_000)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600));
    targets = kernels
}
criterion_main!(benches);
