//! Several tables in one report.

use super::Table;
use serde::ser::{Serialize, SerializeMap, Serializer};

/// A table with its title.
#[derive(Clone, Debug, PartialEq)]
pub struct Titled {
    /// Name in JSON.
    pub key: &'static str,
    /// What people read above it.
    pub title: String,
    /// The table.
    pub table: Table,
}

/// Tables one below the other. As JSON, an object with an array for each table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report(pub Vec<Titled>);

impl Report {
    /// Adds a table, unless it has no rows.
    pub fn push(&mut self, key: &'static str, title: impl Into<String>, table: Table) {
        if !table.rows().is_empty() {
            self.0.push(Titled { key, title: title.into(), table });
        }
    }

    /// In plain text.
    pub fn to_terminal(&self) -> String {
        self.join(|titled| format!("{}\n{}", titled.title, titled.table.to_terminal()))
    }

    /// As CSV: titles stand in lines that start with #.
    pub fn to_csv(&self) -> String {
        self.join(|titled| format!("# {}\n{}", titled.title, titled.table.to_csv()))
    }

    /// As Markdown: titles are headings.
    pub fn to_markdown(&self) -> String {
        self.join(|titled| format!("## {}\n\n{}", titled.title, titled.table.to_markdown()))
    }

    fn join(&self, text: impl Fn(&Titled) -> String) -> String {
        self.0.iter().map(text).collect::<Vec<_>>().join("\n")
    }
}

impl Serialize for Report {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for titled in &self.0 {
            map.serialize_entry(titled.key, &titled.table)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_follow_each_other_under_their_titles() {
        let table = |value: u32| {
            let mut table = Table::new(["n"]);
            table.push([value.into()]);
            table
        };
        let mut report = Report::default();
        report.push("a", "First", table(1));
        report.push("none", "Empty", Table::new(["n"]));
        report.push("b", "Second", table(2));
        assert_eq!(report.to_csv(), "# First\nn\n1\n\n# Second\nn\n2\n");
        assert_eq!(serde_json::to_string(&report).unwrap(), r#"{"a":[{"n":1}],"b":[{"n":2}]}"#);
        assert!(report.to_markdown().starts_with("## First\n\n| n |\n"));
        assert!(report.to_terminal().contains("Second\n"));
    }
}
