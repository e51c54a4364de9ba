//! `irt view`.

use super::{
    args::{Talk, ViewerArgs},
    common::make_folder,
    export::Export,
    interrupt,
    options::{check_engine, check_tiles, engine_options, replace_sampling, replace_view},
    terminal,
};
use crate::{
    error::Result,
    output::{PendingFile, write_bytes},
    report::to_json,
    scene::load,
    view::{Picture, Scale, Script, Surface, Ui, errors, open, play, show_in_terminal, summarise},
};
use std::path::Path;
use std::time::Duration;

/// Opens a window, or plays a script and sums up how it felt.
///
/// # Errors
/// Whatever is wrong with the arguments, the scene, the script, the display or the disk.
pub(super) fn run(args: &ViewerArgs, talk: Talk) -> Result<()> {
    check_engine(&args.engine)?;
    interrupt::install()?;
    let script = args.script.as_deref().map(Script::read).transpose()?;
    let export = Export::open(args.export_json.as_deref())?;
    if let Some(folder) = &args.record {
        make_folder(folder)?;
    }
    let mut scene = load(&args.scene)?;
    scene.warnings.iter().for_each(|warning| log::warn!("{warning}"));
    replace_view(&mut scene, &args.view)?;
    replace_sampling(&mut scene, &args.sampling);
    let size = args.size.unwrap_or(scene.size);
    check_tiles(size, args.engine.tile)?;
    let options = engine_options(&args.engine, size);
    let frame_time = Duration::from_secs_f64(args.frame_time * 1e-3);
    let script = match script {
        Some(script) => script,
        None if args.terminal => return show_in_terminal(&scene, &options, frame_time),
        None => return open(&scene, &options, frame_time),
    };

    let played = play(&scene, &options, frame_time, &script, |number, picture, ui| match &args.record {
        Some(folder) => record(folder, number, picture, ui),
        None => Ok(()),
    })?;
    let errors = errors(&scene, &options, &played)?;
    let summary = summarise(&scene, &options, frame_time, &played, &errors);
    let stdout_taken = export.is_stdout();
    export.write(|| to_json(&summary))?;
    if talk.quiet { Ok(()) } else { terminal::results(&summary.to_string(), stdout_taken, talk) }
}

/// Writes a frame as the window would show it.
fn record(folder: &Path, number: usize, picture: &Picture, ui: &mut Ui) -> Result<()> {
    let path = folder.join(format!("frame-{number:05}.png"));
    let mut pixels = vec![0; picture.pixels.len()];
    ui.compose(picture, &mut Surface { size: picture.size, pixels: &mut pixels }, Scale::Small);
    let bytes: Vec<u8> = pixels.iter().flat_map(|pixel| pixel.to_be_bytes().into_iter().skip(1)).collect();
    PendingFile::create(&path)?.complete(|file| write_bytes(file, picture.size, &bytes))
}
