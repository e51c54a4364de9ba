//! JSON, of tables and of anything serialisable.

use super::table::{Cell, Table};
use crate::error::{Error, Result};
use serde::ser::{Serialize, SerializeMap, Serializer};

/// `value` as indented JSON with a final newline.
///
/// # Errors
///
/// [`Error::Failed`] if `value` has map keys that are not text.
pub fn to_json(value: &impl Serialize) -> Result<String> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => {
            Err(Error::Failed(format!("the report cannot be written as JSON ({error}); please report this")))
        }
    }
}

/// What [`to_json`] has written; `None` if `text` is anything else.
pub fn from_json<T: serde::de::DeserializeOwned>(text: &str) -> Option<T> {
    serde_json::from_str(text).ok()
}

/// An array with one object per row; missing values and numbers that are not finite are null.
impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_seq(self.rows().iter().map(|row| Row { columns: self.columns(), row }))
    }
}

struct Row<'a> {
    columns: &'a [String],
    row: &'a [Cell],
}

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.row.len()))?;
        for (column, cell) in self.columns.iter().zip(self.row) {
            match cell {
                Cell::Text(text) => map.serialize_entry(column, text)?,
                Cell::Count(number) => map.serialize_entry(column, number)?,
                Cell::Number(number) => map.serialize_entry(column, number)?,
                Cell::Flag(flag) => map.serialize_entry(column, flag)?,
                Cell::Missing => map.serialize_entry(column, &())?,
            }
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::table::sample;

    #[test]
    fn a_table_is_an_array_of_objects_in_column_order() {
        let expected = r#"[{"scene":"a \"b\", c","rays":1000000,"Mrays/s":81.23456,"exact":true,"note":null},{"scene":"two\nlines","rays":7,"Mrays/s":null,"exact":false,"note":"x|y"}]"#;
        assert_eq!(serde_json::to_string(&sample()).unwrap(), expected);
        assert!(to_json(&sample()).unwrap().ends_with("]\n"));
    }
}
