//! `irt inspect --price`.

use super::{args::InspectArgs, export::Export, interrupt, options::check_tiles, terminal};
use crate::{
    effects::EffectChoice,
    error::{Error, Result},
    kernels::Visibility,
    render::{RenderOptions, choose_kernels},
    report::{price_table, to_json},
    scene::Scene,
    schedule::{Control, FilmMode, Schedule, Strategy},
    study::price::{Difference, Prices, prices},
    tile::Order,
    trace::{EarlyTermination, KernelChoice},
};

/// Side of a tile in pixels, as in `irt render`.
const TILE: u32 = 64;

/// Tells what each effect of `scene` costs and changes.
///
/// # Errors
/// Whatever is wrong with the arguments, the scene or the export; [`Error::Failed`] if the kernel for all effects makes
/// another image than the one for the scene's.
pub(super) fn run(args: &InspectArgs, scene: &Scene, export: Export) -> Result<()> {
    let options = options(args, scene)?;
    let silent = |_: crate::schedule::Progress| {};
    let control = Control::new(interrupt::flag(), &silent);
    let prices = prices(scene, &options, args.rounds.unwrap_or(3), &control)?;
    let stdout_taken = export.is_stdout();
    export.write(|| to_json(&prices))?;
    if !stdout_taken {
        terminal::print(&text(&prices, options.size))?;
    }
    if prices.general == Difference::NONE {
        return Ok(());
    }
    let what = format!("scene {}: the kernel for all effects makes another image", prices.scene);
    Err(Error::Failed(format!("{what}; please report this with the command line")))
}

fn options(args: &InspectArgs, scene: &Scene) -> Result<RenderOptions> {
    let isa = args.isa.and_then(|choice| choice.isa());
    choose_kernels(isa)?;
    let size = args.size.unwrap_or(scene.size);
    check_tiles(size, TILE)?;
    Ok(RenderOptions {
        isa,
        kernel: KernelChoice::default(),
        visibility: Visibility::default(),
        threads: args.threads,
        pin: true,
        order: Order::default(),
        schedule: Schedule { strategy: Strategy::default(), film: FilmMode::default() },
        tile: TILE,
        size,
        frames: 1,
        build: args.build,
        seed: 0,
        early: EarlyTermination::default(),
        effects: EffectChoice::Auto,
    })
}

fn text(prices: &Prices, [width, height]: [u32; 2]) -> String {
    let Prices { scene, seconds, .. } = prices;
    let rounds = seconds.len();
    let frames = if rounds == 1 { "one frame".into() } else { format!("medians of {rounds} frames") };
    format!(
        "{scene}, {width}x{height} pixels, {frames}, linear values\n{}",
        price_table(prices).to_terminal()
    )
}
