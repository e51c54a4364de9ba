//! The thesis' own figures: its tables 1, 6, 7, 9 and 10 as data.

use crate::tile::Order;

const TABLE_1: &str = include_str!("thesis/table1_primary_coherence.csv");
const TABLES_6_7: &str = include_str!("thesis/table6-8_shadow_coherence.csv");
const TABLES_9_10: &str = include_str!("thesis/table9-10_early_termination.csv");

/// The thesis' scene that one of ours stands for.
pub fn counterpart(scene: &str) -> Option<&'static str> {
    const PAIRS: [(&str, &str); 9] = [
        ("bunny", "bunny"),
        ("statue", "bunny"),
        ("office", "office"),
        ("sibenik", "sibenik"),
        ("nave", "sibenik"),
        ("sponza", "sponza"),
        ("atrium", "sponza"),
        ("conference", "conference"),
        ("hall", "conference"),
    ];
    let name = scene.split('@').next()?;
    PAIRS.into_iter().find(|(ours, _)| *ours == name).map(|(_, theirs)| theirs)
}

/// Table 1: pixels whose primary ray hits the same triangle as the one before.
pub fn primary(scene: &str, order: Order) -> Option<u64> {
    cell(TABLE_1, &[order.name()], counterpart(scene)?)?.parse().ok()
}

/// Tables 6 and 7: a row `1` to `7`, `8+` or `total`.
pub fn shadow(scene: &str, order: Order, row: &str) -> Option<u64> {
    cell(TABLES_6_7, &[order.name(), row], counterpart(scene)?)?.parse().ok()
}

/// Tables 9 and 10: frames per second.
pub fn frames_per_second(scene: &str, order: Order, technique: &str) -> Option<f64> {
    cell(TABLES_9_10, &[order.name(), technique, counterpart(scene)?], "fps")?.parse().ok()
}

/// Tables 9 and 10: gain over base in percent.
pub fn technique_gain(scene: &str, order: Order, technique: &str) -> Option<f64> {
    cell(TABLES_9_10, &[order.name(), technique, counterpart(scene)?], "gain_percent")?.parse().ok()
}

/// The value in a column of the line that starts with `keys`.
fn cell<'a>(csv: &'a str, keys: &[&str], column: &str) -> Option<&'a str> {
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let at = lines.next()?.split(',').position(|name| name == column)?;
    let line = lines.find(|line| line.split(',').zip(keys).filter(|(a, b)| a == *b).count() == keys.len())?;
    line.split(',').nth(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_found_by_scene_order_and_row() {
        assert_eq!(primary("nave", Order::Hilbert), Some(40_817));
        assert_eq!(primary("hall@2", Order::Scanline), Some(53_836));
        assert_eq!(shadow("sponza", Order::Scanline, "8+"), Some(6_920));
        assert_eq!(shadow("bunny", Order::Hilbert, "total"), Some(56_120));
        assert_eq!(frames_per_second("office", Order::Scanline, "base"), Some(0.4181));
        assert_eq!(technique_gain("sponza", Order::Hilbert, "SET-OCC-PET"), Some(92.9385));
    }

    #[test]
    fn what_the_thesis_did_not_measure_is_missing() {
        assert_eq!(primary("hairball", Order::Scanline), None);
        assert_eq!(primary("sponza", Order::Morton), None);
        assert_eq!(shadow("conference", Order::Scanline, "1"), None);
        assert_eq!(technique_gain("sponza", Order::Scanline, "SET-OCC"), None);
    }
}
