//! Markdown tables, as GitHub shows them.

use super::table::Table;

impl Table {
    /// The table as Markdown, columns of numbers aligned to the right.
    pub fn to_markdown(&self) -> String {
        let mut text = line(self.columns().iter().map(|column| escaped(column)));
        let rule = |column| if self.is_numeric(column) { "---:" } else { "---" }.to_string();
        text += &line((0..self.columns().len()).map(rule));
        for row in self.rows() {
            text += &line(row.iter().map(|cell| escaped(&cell.readable())));
        }
        text
    }
}

fn line(fields: impl Iterator<Item = String>) -> String {
    format!("| {} |\n", fields.collect::<Vec<_>>().join(" | "))
}

/// A cell ends at a bar or at the end of the line.
fn escaped(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}

#[cfg(test)]
mod tests {
    use crate::report::table::sample;

    #[test]
    fn bars_and_newlines_cannot_break_the_table() {
        let expected = "| scene | rays | Mrays/s | exact | note |\n\
                        | --- | ---: | ---: | --- | --- |\n\
                        | a \"b\", c | 1000000 | 81.23 | yes | - |\n\
                        | two lines | 7 | NaN | no | x\\|y |\n";
        assert_eq!(sample().to_markdown(), expected);
    }
}
