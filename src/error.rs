//! The one error type of the library.
//!
//! Every message is a single sentence that names the file, line or flag at fault and says what to do about it.
//! The exit code is part of the command-line contract: 1 means the work failed, 2 means the input was unusable.

use std::path::PathBuf;

/// Why a command could not do what it was asked to.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file cannot be used as a whole.
    #[error("{}: {what}; {remedy}", path.display())]
    File {
        /// The file at fault.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
        /// What the user can do about it.
        remedy: String,
    },
    /// One line of a text file cannot be used.
    #[error("{}:{line}: {what}; {remedy}", path.display())]
    Line {
        /// The file at fault.
        path: PathBuf,
        /// Line number, counted from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
        /// What the user can do about it.
        remedy: String,
    },
    /// A command-line flag has an unusable value.
    #[error("{flag}: {what}; {remedy}")]
    Flag {
        /// The flag, with its dashes.
        flag: String,
        /// What is wrong with its value.
        what: String,
        /// What the user can do about it.
        remedy: String,
    },
    /// A worker panicked; the frame is lost, the process is not.
    #[error(
        "tile at ({x}, {y}) of {width}x{height} pixels failed: {message}; please report this with the command line"
    )]
    Worker {
        /// Left edge of the tile in pixels.
        x: u32,
        /// Top edge of the tile in pixels.
        y: u32,
        /// Width of the tile in pixels.
        width: u32,
        /// Height of the tile in pixels.
        height: u32,
        /// The panic's message.
        message: String,
    },
    /// The work was started but did not succeed.
    #[error("{0}")]
    Failed(String),
    /// The user interrupted the work (Ctrl-C).
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// Result of everything in this library that can fail.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Exit code of the process that ends with this error: 130 after Ctrl-C, 1 when the work failed, 2 when the
    /// usage or the input was wrong.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Interrupted => 130,
            Error::Worker { .. } | Error::Failed(_) => 1,
            Error::File { .. } | Error::Line { .. } | Error::Flag { .. } => 2,
        }
    }

    /// An [`Error::File`].
    pub fn file(path: impl Into<PathBuf>, what: impl ToString, remedy: impl ToString) -> Error {
        Error::File { path: path.into(), what: what.to_string(), remedy: remedy.to_string() }
    }

    /// An [`Error::Line`].
    pub fn line(path: impl Into<PathBuf>, line: usize, what: impl ToString, remedy: impl ToString) -> Error {
        Error::Line { path: path.into(), line, what: what.to_string(), remedy: remedy.to_string() }
    }

    /// An [`Error::Flag`].
    pub fn flag(flag: impl Into<String>, what: impl ToString, remedy: impl ToString) -> Error {
        Error::Flag { flag: flag.into(), what: what.to_string(), remedy: remedy.to_string() }
    }
}
