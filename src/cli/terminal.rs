//! Everything said on the terminal: results on standard output, the rest on standard error. A closed pipe is no reason
//! to fail, let alone to panic (as `println!` would): whoever read has read enough.

use super::args::Talk;
use crate::error::{Error, Result};
use crate::view::restore_terminal;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::Cell;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::{panic, thread};

/// Writes results.
///
/// # Errors
/// [`Error::Failed`] if standard output cannot be written, unless nobody reads it any more.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::Failed(format!(
            "standard output cannot be written ({error}); send it to a file on another disk"
        ))),
        _ => Ok(()),
    }
}

/// Tells people the results: on standard output, or, if an export has `taken` that, on standard error unless they want
/// it quiet.
///
/// # Errors
/// As [`print`].
pub(super) fn results(text: &str, taken: bool, talk: Talk) -> Result<()> {
    match (taken, talk.quiet) {
        (false, _) => return print(text),
        (true, false) => note(text),
        (true, true) => {}
    }
    Ok(())
}

/// Tells what is being worked on, unless people want it quiet.
pub(super) fn tell(talk: Talk, text: &str) {
    if !talk.quiet {
        note(&format!("irt: {text}\n"));
    }
}

/// Writes what is not a result.
pub(super) fn note(text: &str) {
    // If standard error fails, there is nobody left to tell.
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Tells about an error.
pub(super) fn complain(error: &Error) {
    note(&format!("irt: {error}\n"));
}

/// Removes what a progress bar may have left on the line.
pub(super) fn clear_line() {
    if io::stderr().is_terminal() {
        note("\r\x1b[2K");
    }
}

/// Sends the library's log to standard error, as sentences.
pub(super) fn start_log(talk: Talk) {
    let level = match talk {
        Talk { quiet: true, .. } => log::LevelFilter::Off,
        Talk { verbose: true, .. } => log::LevelFilter::Debug,
        _ => log::LevelFilter::Warn,
    };
    // Fails only if a log was started before.
    let _ = env_logger::Builder::new()
        .filter_level(level)
        .format(|line, record| {
            let level = match record.level() {
                log::Level::Warn => "warning".into(),
                other => other.to_string().to_lowercase(),
            };
            writeln!(line, "irt: {level}: {}", record.args())
        })
        .try_init();
}

/// Panics are defects of irt: say so in one sentence. Workers are silent, their panics return as errors.
pub(super) fn announce_panics() {
    panic::set_hook(Box::new(|panic| {
        if thread::current().name().is_some_and(|name| name.starts_with("worker")) {
            log::debug!("{panic}");
            return;
        }
        restore_terminal();
        let message = panic.payload_as_str().unwrap_or("no message");
        let place = panic.location().map(|place| format!(" at {place}")).unwrap_or_default();
        note(&format!("irt: internal error{place}: {message}; please report this with the command line\n"));
    }));
}

/// A bar over the tiles of all frames; shows itself only where standard error is a terminal.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar for `frames` frames, or none.
    pub(super) fn new(frames: u32, talk: Talk) -> Progress {
        if talk.quiet || !io::stderr().is_terminal() {
            return Progress { bar: ProgressBar::hidden() };
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let template = if frames > 1 {
            "{wide_bar} {percent:>3} % of all frames, {eta} left"
        } else {
            "{wide_bar} {percent:>3} %, {eta} left"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Progress { bar }
    }

    /// One more tile is done; there are `total` in all frames.
    pub(super) fn tick(&self, total: u64) {
        if self.bar.length() != Some(total) {
            self.bar.set_length(total);
        }
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// How far a command of several stages is: a bar where standard error is a terminal, else a line for each stage.
pub(super) struct Meter {
    bar: ProgressBar,
    quiet: bool,
    lines: bool,
    stage: Cell<&'static str>,
}

impl Meter {
    pub(super) fn new(talk: Talk) -> Meter {
        let lines = !io::stderr().is_terminal();
        let bar = if talk.quiet || lines {
            ProgressBar::hidden()
        } else {
            ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10))
        };
        if let Ok(style) = ProgressStyle::with_template("{msg:>14} {wide_bar} {percent:>3} %, {eta} left") {
            bar.set_style(style);
        }
        Meter { bar, quiet: talk.quiet, lines, stage: Cell::new("") }
    }

    /// `done` of `of` pieces of `stage` are done.
    pub(super) fn tell(&self, stage: &'static str, done: u64, of: u64) {
        if self.stage.replace(stage) != stage {
            self.bar.reset();
            self.bar.set_length(of);
            self.bar.set_message(stage);
            if self.lines && !self.quiet {
                note(&format!("irt: {stage}\n"));
            }
        }
        self.bar.set_position(done);
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
