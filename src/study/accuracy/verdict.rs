//! A sentence for each mode that claims no more than was measured.

use super::{Knob, Row, SceneAccuracy, Spread, modes::Mode};
use crate::study::stability::Aimed;

/// The sentence of a row of a scene.
pub fn verdict(scene: &SceneAccuracy, row: &Row) -> String {
    match scene.rows.first() {
        Some(default) => sentence(default, row, scene.noise),
        None => String::new(),
    }
}

/// What a mode costs in time and changes, beside the default and a converged image whose noise has this RMSE. Without a full
/// stop.
pub fn sentence(default: &Row, row: &Row, noise: f64) -> String {
    if row.mode == Mode::Default {
        return format!(
            "default: RMSE {} from the converged image, whose own noise is {}; measured against itself, a frame takes {}{}",
            number(row.error.rmse),
            number(noise),
            ratio(row.times.ratio),
            row.aimed.map(|aimed| format!("; {}", leaks(&aimed))).unwrap_or_default()
        );
    }
    let mut parts = vec![time(row.times.ratio)];
    parts.push(change(default, row, noise));
    if let Some(aimed) = &row.aimed {
        parts.push(leaks(aimed));
    }
    if row.nan > 0 {
        parts.push(format!("{} pixels are NaN or infinite", row.nan));
    }
    format!("{}: {}", row.mode, parts.join("; "))
}

fn ratio(ratio: Spread) -> String {
    format!("{:.3} times as long ({:.3} to {:.3})", ratio.median, ratio.low, ratio.high)
}

/// What a ratio of times means.
fn time(ratio: Spread) -> String {
    let Spread { median, low, high, .. } = ratio;
    let percent = |ratio: f64| 100.0 * (ratio - 1.0).abs();
    if ratio.has(1.0) {
        let (least, most) = (100.0 * (low - 1.0), 100.0 * (high - 1.0));
        format!("no difference in time measured ({least:+.1} to {most:+.1} %)")
    } else if median > 2.0 {
        format!("takes {median:.2} times as long ({low:.2} to {high:.2})")
    } else if median > 1.0 {
        format!("costs {:.1} % of time ({:.1} to {:.1})", percent(median), percent(low), percent(high))
    } else {
        format!("saves {:.1} % of time ({:.1} to {:.1})", percent(median), percent(high), percent(low))
    }
}

/// What becomes of the image.
fn change(default: &Row, row: &Row, noise: f64) -> String {
    if row.same == Some(true) {
        return "the image is the same, bit by bit".into();
    }
    if row.change.changed == 0.0 {
        return "no pixel differs in what a screen shows".into();
    }
    let (now, before) = (row.error.rmse, default.error.rmse);
    let converges = row.mode.knob().is_some_and(Knob::converges);
    let error = if (now - before).abs() <= noise {
        format!("no difference in error measured (RMSE {}, noise {})", number(now), number(noise))
    } else {
        let flip = format!("FLIP {} instead of {}", number(row.error.flip), number(default.error.flip));
        format!("RMSE {} instead of {}, {flip}", number(now), number(before))
    };
    if converges {
        return error;
    }
    let (share, rmse, max) = (100.0 * row.change.changed, row.change.rmse, row.change.max);
    let changed = format!(
        "changes {} % of the pixels by RMSE {}, {} at most",
        number(share),
        number(rmse),
        number(max)
    );
    format!("{changed}; {error}")
}

/// Leaks among a million rays; of none, what more than one in twenty such runs would have shown.
fn leaks(aimed: &Aimed) -> String {
    let million = 1.0e6 / aimed.rays.max(1) as f64;
    let leaks = if aimed.leaks == 0 {
        format!("no leak among {} aimed rays (fewer than {} per million)", aimed.rays, number(3.0 * million))
    } else {
        format!("{} leaks per million aimed rays", number(aimed.leaks as f64 * million))
    };
    match aimed.self_hits {
        0 => leaks,
        hits => format!("{leaks}, {hits} self-hits among {} spawned rays", aimed.spawned),
    }
}

/// Three significant digits.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if value.abs() < 1.0e-4 || value.abs() >= 1.0e6 {
        return format!("{value:.2e}");
    }
    let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 7) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::super::{Times, compare::Distance};
    use super::*;
    use crate::kernels::Visibility;

    fn row(mode: Mode, median: f64, low: f64, high: f64, rmse: f64) -> Row {
        let ratio = Spread { median, low, high, rounds: 9 };
        let error = Distance { rmse, flip: 2.0 * rmse, ..Distance::NONE };
        Row {
            mode,
            times: Times { seconds: Spread::exactly(0.1), ratio, rays: 100 },
            error,
            change: Distance { rmse: 0.004, changed: 0.02, max: 0.5, ..Distance::NONE },
            same: Some(false),
            nan: 0,
            geometry: None,
            aimed: None,
            map: vec![],
            front: false,
        }
    }

    #[test]
    fn a_sentence_says_what_was_measured_with_its_spread() {
        let default = row(Mode::Default, 1.0, 0.99, 1.01, 0.03);
        let mut fast = row(Mode::Visibility(Visibility::Fast), 0.93, 0.92, 0.94, 0.0301);
        fast.aimed = Some(Aimed { rays: 200_000, leaks: 2500, ..Aimed::default() });
        assert_eq!(
            sentence(&default, &fast, 0.001),
            "visibility fast: saves 7.0 % of time (6.0 to 8.0); changes 2.00 % of the pixels by RMSE 0.00400, 0.500 at \
             most; no difference in error measured (RMSE 0.0301, noise 0.00100); 12500 leaks per million aimed rays"
        );
        let many = row(Mode::Samples(16), 16.2, 15.9, 16.6, 0.004);
        assert_eq!(
            sentence(&default, &many, 0.001),
            "samples 16: takes 16.20 times as long (15.90 to 16.60); RMSE 0.00400 instead of 0.0300, FLIP 0.00800 \
             instead of 0.0600"
        );
    }

    #[test]
    fn what_the_spread_does_not_show_is_not_claimed() {
        let default = row(Mode::Default, 1.0, 0.99, 1.01, 0.03);
        let mut same = row(Mode::Visibility(Visibility::Fast), 0.98, 0.95, 1.02, 0.03);
        same.same = Some(true);
        same.aimed = Some(Aimed { rays: 300_000, self_hits: 2, spawned: 10, ..Aimed::default() });
        assert_eq!(
            sentence(&default, &same, 0.001),
            "visibility fast: no difference in time measured (-5.0 to +2.0 %); the image is the same, bit by bit; no leak \
             among 300000 aimed rays (fewer than 10.0 per million), 2 self-hits among 10 spawned rays"
        );
    }
}
