//! Counted warnings: what a reader repaired, dropped or ignored.

/// Where the readers count the triangles that [`super::TriangleMesh`] must not hold.
pub(super) const DEGENERATE: &str = "triangles of exactly zero area dropped";

/// Kinds of warnings that one file may give; the rest are counted together, so that a garbage file stays readable.
const MAX_KINDS: usize = 40;

/// Warnings about one file, in order of first appearance.
pub(super) struct Tally {
    file: String,
    entries: Vec<Entry>,
}

struct Entry {
    what: String,
    count: usize,
    line: Option<usize>,
}

impl Tally {
    /// No warnings yet. `file` begins each sentence.
    pub(super) fn new(file: impl ToString) -> Tally {
        Tally { file: file.to_string(), entries: Vec::new() }
    }

    /// Counts one occurrence, in line `line` (counted from 1).
    pub(super) fn at(&mut self, line: usize, what: &str) {
        self.count(1, Some(line), what);
    }

    /// Counts occurrences that belong to no one line.
    pub(super) fn add(&mut self, count: usize, what: &str) {
        if count > 0 {
            self.count(count, None, what);
        }
    }

    fn count(&mut self, count: usize, line: Option<usize>, what: &str) {
        let full = self.entries.len() >= MAX_KINDS;
        let what = match self.entries.iter().any(|entry| entry.what == what) {
            false if full => "further problems of other kinds",
            _ => what,
        };
        match self.entries.iter_mut().find(|entry| entry.what == what) {
            Some(entry) => entry.count += count,
            None => self.entries.push(Entry { what: what.into(), count, line }),
        }
    }

    /// The warnings as sentences, `FILE: WHAT: COUNT (first in line N)`.
    pub(super) fn sentences(self) -> impl Iterator<Item = String> {
        let file = self.file;
        self.entries.into_iter().map(move |Entry { what, count, line }| match line {
            Some(line) => format!("{file}: {what}: {count} (first in line {line})"),
            None => format!("{file}: {what}: {count}"),
        })
    }
}

/// Sum of the counts of `what` in the sentences of any number of tallies.
pub(super) fn total(sentences: &[String], what: &str) -> usize {
    let marker = format!(": {what}: ");
    let count = |sentence: &String| {
        let rest = sentence.split_once(&marker)?.1;
        rest.split(' ').next()?.parse::<usize>().ok()
    };
    sentences.iter().filter_map(count).sum()
}
