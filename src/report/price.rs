//! The table of `irt inspect --price`.

use super::{Cell, Statistics, Table};
use crate::study::price::{Difference, Prices};

/// What each effect costs, as a table: a row for the whole frame, one for the kernel for all effects, and one for each
/// effect with what its absence saves and changes.
pub fn price_table(prices: &Prices) -> Table {
    let columns = ["frame", "ms", "saves ms", "saves %", "RMSE", "max difference", "changed pixels %"];
    let mut table = Table::new(columns);
    let median = |seconds: &[f64]| Statistics::of(seconds).map_or(f64::NAN, |of| of.median);
    let whole = median(&prices.seconds);
    let mut row = |name: String, seconds: &[f64], of: Option<Difference>| {
        let own = median(seconds);
        let saved = of.map(|_| whole - own);
        table.push([
            Cell::Text(name),
            (1e3 * own).into(),
            saved.map(|saved| 1e3 * saved).into(),
            saved.map(|saved| 100.0 * saved / whole).into(),
            of.map(|of| of.rmse).into(),
            of.map(|of| of.max).into(),
            of.map(|of| 100.0 * of.changed).into(),
        ]);
    };
    row("all effects of the scene".into(), &prices.seconds, None);
    row("the same by the general kernel".into(), &prices.general_seconds, Some(prices.general));
    for price in &prices.prices {
        row(format!("without {}", price.effect), &price.seconds, Some(price.difference));
    }
    table
}
