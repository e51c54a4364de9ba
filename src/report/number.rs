//! Numbers as people read them.

/// `1234567` as `1,234,567`.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A size in bytes, in the binary unit that leaves at most four digits before the point.
pub fn bytes(number: u64) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let mut value = number as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{number} bytes") } else { format!("{} {}", significant(value, 3), units[unit]) }
}

/// `value` with `digits` significant digits, but never fewer than all of its integer part.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    // Rounding first: 9.996 has one digit before the point, but 10.00 has two.
    let rounded: f64 = format!("{value:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(value);
    let magnitude = rounded.abs().log10().floor() as i32;
    format!("{value:.*}", (digits - 1 - magnitude).clamp(0, 12) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_separated() {
        let texts = [0, 7, 999, 1000, 12_345, 1_234_567].map(count);
        assert_eq!(texts, ["0", "7", "999", "1,000", "12,345", "1,234,567"]);
    }

    #[test]
    fn sizes_get_a_unit() {
        let texts = [0, 1023, 1024, 10 << 20, 3 << 40].map(bytes);
        assert_eq!(texts, ["0 bytes", "1023 bytes", "1.00 KiB", "10.0 MiB", "3.00 TiB"]);
    }

    #[test]
    fn digits_are_counted_from_the_first_that_matters() {
        let texts = [0.0, 1.0, 0.012_345, 9.9996, 123.456, 98_765.4, -2.5].map(|v| significant(v, 4));
        assert_eq!(texts, ["0", "1.000", "0.01235", "10.00", "123.5", "98765", "-2.500"]);
        assert_eq!(significant(f64::INFINITY, 4), "inf");
    }
}
