//! Tables on the terminal. The only file that names `comfy_table`.

use super::table::Table;
use comfy_table::{CellAlignment, presets};

impl Table {
    /// The table in plain text, columns of numbers aligned to the right.
    pub fn to_terminal(&self) -> String {
        let mut text = comfy_table::Table::new();
        text.load_style(presets::UTF8_HORIZONTAL_ONLY);
        text.set_header(self.columns());
        for row in self.rows() {
            text.add_row(row.iter().map(|cell| cell.readable()));
        }
        for (i, column) in text.column_iter_mut().enumerate() {
            if self.is_numeric(i) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        text.to_string() + "\n"
    }
}

#[cfg(test)]
mod tests {
    use crate::report::table::sample;

    #[test]
    fn every_value_is_there_and_numbers_end_in_one_column() {
        let text = sample().to_terminal();
        let end = |needle: &str| {
            let line = text
                .lines()
                .find(|line| line.contains(needle))
                .unwrap_or_else(|| panic!("{needle} in\n{text}"));
            line.find(needle).unwrap() + needle.len()
        };
        assert_eq!(end("1000000"), end("rays"));
        assert!(text.contains("a \"b\", c") && text.contains("81.23") && text.contains("x|y"), "{text}");
    }
}
