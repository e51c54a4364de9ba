//! A table of results. The exporters beside this file write it in one format each.

use super::number::significant;

/// One value of a [`Table`].
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Any text.
    Text(String),
    /// A whole number.
    Count(u64),
    /// A measured number: shown with four significant digits to people, exactly to programs.
    Number(f64),
    /// Yes or no.
    Flag(bool),
    /// There is no value.
    Missing,
}

impl Cell {
    /// The value as people read it.
    pub(super) fn readable(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Count(number) => number.to_string(),
            Cell::Number(number) => significant(*number, 4),
            Cell::Flag(true) => "yes".into(),
            Cell::Flag(false) => "no".into(),
            Cell::Missing => "-".into(),
        }
    }

    /// True for values that are aligned to the right.
    pub(super) fn is_numeric(&self) -> bool {
        matches!(self, Cell::Count(_) | Cell::Number(_))
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::Text(text)
    }
}

impl From<u32> for Cell {
    fn from(number: u32) -> Cell {
        Cell::Count(number.into())
    }
}

impl From<u64> for Cell {
    fn from(number: u64) -> Cell {
        Cell::Count(number)
    }
}

impl From<usize> for Cell {
    fn from(number: usize) -> Cell {
        Cell::Count(number as u64)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Cell {
        Cell::Number(number)
    }
}

impl From<bool> for Cell {
    fn from(flag: bool) -> Cell {
        Cell::Flag(flag)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Cell {
        value.map_or(Cell::Missing, Into::into)
    }
}

/// Named columns and rows of as many cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows.
    pub fn new<C: Into<String>>(columns: impl IntoIterator<Item = C>) -> Table {
        Table { columns: columns.into_iter().map(Into::into).collect(), rows: vec![] }
    }

    /// Adds a row.
    ///
    /// # Panics
    ///
    /// If it has not one cell per column.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        let row: Vec<Cell> = row.into_iter().collect();
        assert_eq!(row.len(), self.columns.len(), "a row needs one cell per column");
        self.rows.push(row);
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// True if every value in `column` is a number, or missing.
    pub(super) fn is_numeric(&self, column: usize) -> bool {
        self.rows.iter().all(|row| row[column].is_numeric() || row[column] == Cell::Missing)
    }
}

/// The table that the exporters' tests write.
#[cfg(test)]
pub(super) fn sample() -> Table {
    let mut table = Table::new(["scene", "rays", "Mrays/s", "exact", "note"]);
    table.push(["a \"b\", c".into(), 1_000_000u64.into(), 81.234_56.into(), true.into(), Cell::Missing]);
    table.push(["two\nlines".into(), 7u64.into(), f64::NAN.into(), false.into(), "x|y".into()]);
    table
}
