//! CSV as RFC 4180 wants it, except that lines end with a plain newline.

use super::table::{Cell, Table};

impl Table {
    /// The table as CSV, with a header. Missing values and numbers that are not finite are empty.
    pub fn to_csv(&self) -> String {
        let mut text = line(self.columns().iter().map(|column| quoted(column)));
        for row in self.rows() {
            text += &line(row.iter().map(field));
        }
        text
    }
}

fn line(fields: impl Iterator<Item = String>) -> String {
    fields.collect::<Vec<_>>().join(",") + "\n"
}

fn field(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => quoted(text),
        Cell::Count(number) => number.to_string(),
        Cell::Number(number) if number.is_finite() => number.to_string(),
        Cell::Flag(flag) => flag.to_string(),
        Cell::Number(_) | Cell::Missing => String::new(),
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

#[cfg(test)]
mod tests {
    use crate::report::table::sample;

    #[test]
    fn commas_quotes_and_newlines_are_quoted() {
        let expected = "scene,rays,Mrays/s,exact,note\n\
                        \"a \"\"b\"\", c\",1000000,81.23456,true,\n\
                        \"two\nlines\",7,,false,x|y\n";
        assert_eq!(sample().to_csv(), expected);
    }
}
