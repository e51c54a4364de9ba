//! What irt found out, for people and for programs: summaries, statistics, and tables in four formats.

mod accuracy;
mod accuracy_page;
mod animation;
mod bench;
mod builds;
mod coherence;
mod csv;
mod curves;
mod html;
mod json;
mod markdown;
mod micro;
mod number;
mod scaling;
mod stability;
mod plot;
mod price;
mod statistics;
mod summary;
mod sweep;
mod table;
mod terminal;
mod titled;
mod timeline;

pub use accuracy::accuracy_report;
pub use accuracy_page::accuracy_page;
pub use animation::{AnimationSummary, MomentSummary};
pub use bench::{BenchRow, bench_summary, bench_table};
pub use builds::builds_table;
pub use coherence::coherence_report;
pub use curves::{Curve, Curves, Mark};
pub use html::{escaped, picture};
pub use json::{from_json, to_json};
pub use micro::micro_table;
pub use number::{bytes, count, significant};
pub use plot::{Plot, Series};
pub use price::price_table;
pub use scaling::{
    ScalingRecord, idle_table, limits_table, scaling_table, sizes_table, thesis_table, validation_table,
};
pub use stability::{
    stability_cells, stability_errors, stability_fuzz, stability_images, stability_kernels, stability_places,
    stability_spawn,
};
pub use statistics::Statistics;
pub use summary::{BuildSummary, FrameSummary, RayCounts, StageSeconds, Summary, WorkerSummary};
pub use sweep::{finding_table, sweep_plots, sweep_report};
pub use table::{Cell, Table};
pub use timeline::{timeline_svg, timeline_trace, worker_map};
pub use titled::{Report, Titled};
