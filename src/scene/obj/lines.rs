//! Statements of an OBJ or MTL file: comments removed, continued lines joined.

/// One statement and where it begins.
pub(super) struct Statement<'a> {
    /// Line number of its first line, counted from 1.
    pub(super) line: usize,
    /// First word.
    pub(super) keyword: &'a str,
    /// Everything after it, trimmed; never holds a line break.
    pub(super) rest: &'a str,
}

/// Calls `visit` for each statement of `text` in order, until it fails.
///
/// A `#` begins a comment at the start of a word (names may contain one), and a `\` at the end of a line joins the
/// next line to it, unless it is in a comment: paths of other systems end so.
pub(super) fn for_each_statement<E>(
    text: &str,
    mut visit: impl FnMut(Statement<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let mut joined = String::new();
    let mut first = None;
    for (index, line) in text.strip_prefix('\u{feff}').unwrap_or(text).lines().enumerate() {
        let line = without_comment(line).trim();
        if let Some(begun) = line.strip_suffix('\\') {
            first = first.or(Some(index + 1));
            joined.push_str(begun);
            joined.push(' ');
            continue;
        }
        match first.take() {
            None => statement(index + 1, line, &mut visit)?,
            Some(first) => {
                joined.push_str(line);
                statement(first, joined.trim(), &mut visit)?;
                joined.clear();
            }
        }
    }
    // The last line of the file may end in a backslash, too.
    match first {
        Some(first) => statement(first, joined.trim(), &mut visit),
        None => Ok(()),
    }
}

fn statement<E>(
    line: usize,
    text: &str,
    visit: &mut impl FnMut(Statement<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    match keyword {
        "" => Ok(()),
        _ => visit(Statement { line, keyword, rest: rest.trim() }),
    }
}

fn without_comment(line: &str) -> &str {
    let starts_word = |at: usize| line[..at].chars().next_back().is_none_or(char::is_whitespace);
    match line.match_indices('#').find(|&(at, _)| starts_word(at)) {
        Some((at, _)) => &line[..at],
        None => line,
    }
}
