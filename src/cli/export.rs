//! Files for other programs, opened before the work starts.

use super::{args::ExportArgs, terminal};
use crate::{
    error::{Error, Result},
    output::PendingFile,
    report::{Report, Table, to_json},
};
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Where an export goes.
pub(super) enum Export {
    /// Nobody asked for it.
    Nowhere,
    /// `-`.
    Stdout,
    /// A file that appears when it is complete.
    File(PendingFile),
}

impl Export {
    /// Opens the target.
    ///
    /// # Errors
    /// [`Error::File`] if the file could not be written.
    pub(super) fn open(path: Option<&Path>) -> Result<Export> {
        match path {
            None => Ok(Export::Nowhere),
            Some(path) if path == Path::new("-") => Ok(Export::Stdout),
            Some(path) => PendingFile::create(path).map(Export::File),
        }
    }

    /// True if standard output is taken, so that people are told on standard error.
    pub(super) fn is_stdout(&self) -> bool {
        matches!(self, Export::Stdout)
    }

    /// Writes what `text` makes, if anybody asked for it.
    ///
    /// # Errors
    /// What `text` returns, or [`Error::Failed`] if the target cannot be written.
    pub(super) fn write(self, text: impl FnOnce() -> Result<String>) -> Result<()> {
        match self {
            Export::Nowhere => Ok(()),
            Export::Stdout => terminal::print(&text()?),
            Export::File(file) => {
                let text = text()?;
                file.complete(|out| out.write_all(text.as_bytes()))
            }
        }
    }
}

/// Where a table goes beside the terminal.
pub(super) struct TableExports {
    json: Export,
    csv: Export,
    markdown: Export,
}

impl TableExports {
    /// Opens the targets.
    ///
    /// # Errors
    /// [`Error::Flag`] if two of them are standard output, and as [`Export::open`].
    pub(super) fn open(args: &ExportArgs) -> Result<TableExports> {
        let json = Export::open(args.export_json.as_deref())?;
        let csv = Export::open(args.export_csv.as_deref())?;
        let markdown = Export::open(args.export_markdown.as_deref())?;
        if [&json, &csv, &markdown].iter().filter(|export| export.is_stdout()).count() > 1 {
            let remedy = "give all but one of them a file name";
            return Err(Error::flag("--export-csv", "two exports cannot share standard output", remedy));
        }
        Ok(TableExports { json, csv, markdown })
    }

    /// True if standard output is taken.
    pub(super) fn is_stdout(&self) -> bool {
        self.json.is_stdout() || self.csv.is_stdout() || self.markdown.is_stdout()
    }

    /// Writes the table to its targets, and to the terminal unless standard output is one of them.
    ///
    /// # Errors
    /// As [`Export::write`].
    pub(super) fn write(self, table: &Table) -> Result<()> {
        let taken = self.is_stdout();
        self.write_files(table, table)?;
        if taken { Ok(()) } else { terminal::print(&table.to_terminal()) }
    }

    /// Writes several tables to the targets.
    ///
    /// # Errors
    /// As [`Export::write`].
    pub(super) fn write_report(self, report: &Report) -> Result<()> {
        self.json.write(|| to_json(report))?;
        self.csv.write(|| Ok(report.to_csv()))?;
        self.markdown.write(|| Ok(report.to_markdown()))
    }

    /// Writes the table to its targets, but `json` as JSON.
    ///
    /// # Errors
    /// As [`Export::write`].
    pub(super) fn write_files(self, json: &impl Serialize, table: &Table) -> Result<()> {
        self.json.write(|| to_json(json))?;
        self.csv.write(|| Ok(table.to_csv()))?;
        self.markdown.write(|| Ok(table.to_markdown()))
    }
}
