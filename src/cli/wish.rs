//! `irt render --max-error` and `--time-budget`: which modes are chosen, and why.

use super::{
    args::{Talk, WishArgs},
    cache, interrupt,
    terminal::{self, Meter},
};
use crate::{
    error::{Error, Result},
    render::RenderOptions,
    report::significant,
    scene::Scene,
    schedule::Control,
    study::accuracy::{CAUTION, Choice, Mode, Prices, Wish, choose, prices},
};

/// Chooses what the wishes ask for, and changes scene and options so; does nothing if there is no wish. The study looks from
/// the scene's camera, wherever the image is taken from.
///
/// # Errors
/// [`Error::Failed`] if nothing that was measured grants the wishes. What the study returns.
pub(super) fn grant(
    args: &WishArgs,
    scene: &mut Scene,
    options: &mut RenderOptions,
    talk: Talk,
) -> Result<()> {
    if args.max_error.is_none() && args.time_budget.is_none() {
        return Ok(());
    }
    let RenderOptions { size, frames, .. } = *options;
    let wish = Wish { error: args.max_error, seconds: args.time_budget, size, frames };
    let prices = known_or_measured(scene, options, talk)?;
    let choice = match choose(&prices, scene, options, &wish) {
        Ok(choice) => choice,
        Err(nearest) => return Err(refused(&wish, &nearest)),
    };
    terminal::tell(talk, &told(&choice));
    for mode in choice.modes {
        *options = mode.options(options);
        if let std::borrow::Cow::Owned(changed) = mode.scene(scene) {
            *scene = changed;
        }
    }
    Ok(())
}

/// Numbered images have no wishes.
///
/// # Errors
/// [`Error::Flag`] if there is one.
pub(super) fn refuse_for_many_images(args: &WishArgs) -> Result<()> {
    let flag = match (args.max_error, args.time_budget) {
        (Some(_), _) => "--max-error",
        (None, Some(_)) => "--time-budget",
        (None, None) => return Ok(()),
    };
    Err(Error::flag(
        flag,
        "it chooses for one image, not for numbered ones",
        "render one with --time, and use the flags told",
    ))
}

fn known_or_measured(scene: &Scene, options: &RenderOptions, talk: Talk) -> Result<Prices> {
    let (folder, key) = (cache::folder(), cache::key(scene, options));
    if let Some(known) = folder.as_deref().and_then(|folder| cache::read(folder, &key)) {
        return Ok(known);
    }
    terminal::tell(talk, &format!("{} is not measured yet on this machine", scene.name));
    let meter = Meter::new(talk);
    let tell = |share: f64| meter.tell("what accuracy costs", (1000.0 * share) as u64, 1000);
    let control = Control::new(interrupt::flag(), &|_| {});
    let measured = prices(scene, options, &control, &tell)?;
    drop(meter);
    if let Some(Err(error)) = folder.map(|folder| cache::write(&folder, &key, &measured)) {
        log::warn!("what was measured cannot be kept: {error}");
    }
    Ok(measured)
}

fn told(choice: &Choice) -> String {
    let Choice { modes, seconds, error, default } = choice;
    let number = |value: f64| significant(value, 3);
    let flags: Vec<String> = modes.iter().filter_map(|mode: &Mode| mode.flag()).collect();
    let what = if flags.is_empty() { "the default".into() } else { flags.join(" ") };
    format!(
        "chosen: {what}, for at most {} s to build and render and an RMSE of at most {}; the default would take {} s with an \
         RMSE of {} (errors with a caution of {CAUTION} for views that were not measured)",
        number(*seconds),
        number(*error),
        number(default[0]),
        number(default[1])
    )
}

fn refused(wish: &Wish, nearest: &Choice) -> Error {
    let number = |value: f64| significant(value, 3);
    let (error, seconds) = (number(nearest.error), number(nearest.seconds));
    let text = match (wish.error, wish.seconds) {
        (Some(most), None) => {
            format!(
                "--max-error: no combination promises an RMSE of {most}; the best one {error}, in {seconds} s; allow as much"
            )
        }
        (None, Some(most)) => {
            format!(
                "--time-budget: no combination is done in {most} s; the quickest one takes {seconds} s; allow as much"
            )
        }
        _ => format!(
            "--max-error: no combination promises that in the time of --time-budget; the best one promises {error} in \
             {seconds} s; allow more error or time"
        ),
    };
    Error::Failed(text)
}
