//! The command line: typed arguments, validated options, one function per command.
//!
//! ```text
//!   args --one value at a time--> RenderArgs, ... --options: together, with the scene--> RenderOptions -> render
//! ```
//!
//! The only module that names clap, indicatif and ctrlc.

mod accuracy;
mod animate;
mod args;
mod bench;
mod cache;
mod coherence;
mod common;
mod export;
mod inspect;
mod interrupt;
mod options;
mod price;
mod render;
mod scaling;
mod scenes;
mod stability;
mod study_args;
mod terminal;
mod trace;
mod usage;
mod value;
mod view;
mod wish;

use crate::error::{Error, Result};
use args::{Command, CommandLine, Talk};
use clap::Parser;
use std::panic::catch_unwind;
use std::process::ExitCode;

/// The `irt` command: reads the process's arguments, does what they ask for, tells about errors.
pub fn main() -> ExitCode {
    let line = match CommandLine::try_parse() {
        Ok(line) => line,
        Err(error) => return usage(&error),
    };
    terminal::announce_panics();
    terminal::start_log(line.talk);
    match catch_unwind(|| run(&line.command, line.talk)) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => fail(&error),
        Err(_panic) => ExitCode::FAILURE,
    }
}

fn run(command: &Command, talk: Talk) -> Result<()> {
    match command {
        Command::Render(args) => render::run(args, talk),
        Command::View(args) => view::run(args, talk),
        Command::Inspect(args) => inspect::run(args),
        Command::Scenes(args) => scenes::run(args),
        Command::Bench(args) => bench::run(args, talk),
        Command::Trace(args) => trace::run(args, talk),
        Command::Accuracy(args) => accuracy::run(args, talk),
        Command::Stability(args) => stability::run(args, talk),
        Command::Coherence(args) => coherence::run(args, talk),
        Command::Scaling(args) => scaling::run(args, talk),
    }
}

fn usage(error: &clap::Error) -> ExitCode {
    match usage::error(error) {
        Some(error) => fail(&error),
        None => {
            // Help and version; if nobody reads them, nobody needs to know.
            let _ = error.print();
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
        }
    }
}

fn fail(error: &Error) -> ExitCode {
    if interrupt::flag().load(std::sync::atomic::Ordering::SeqCst) {
        // The handler tells about it and ends the process; this error is only its consequence.
        std::thread::sleep(std::time::Duration::from_secs(5));
        return ExitCode::from(Error::Interrupted.exit_code());
    }
    terminal::complain(error);
    ExitCode::from(error.exit_code())
}
