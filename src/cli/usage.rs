//! Turns what clap has to say about a command line into one sentence of our own.

use crate::error::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error as _;

/// Our error for clap's; `None` if it is no error but a wish for help or the version.
pub(super) fn error(error: &clap::Error) -> Option<Error> {
    let flag = text(error, ContextKind::InvalidArg);
    let value = text(error, ContextKind::InvalidValue);
    let sentence = match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => return None,
        ErrorKind::InvalidValue if value.is_empty() => {
            Error::flag(flag, "a value is missing", "give one, or leave the flag out")
        }
        ErrorKind::InvalidValue => Error::flag(
            flag,
            format!("'{value}' is not available"),
            format!("use one of: {}", text(error, ContextKind::ValidValue)),
        ),
        ErrorKind::ValueValidation => {
            let reason = error.source().map(ToString::to_string).unwrap_or_default();
            let (what, remedy) = reason.split_once("; ").unwrap_or((&reason, "see irt --help"));
            Error::flag(flag, what, remedy)
        }
        ErrorKind::UnknownArgument if flag.starts_with('-') => {
            Error::flag(flag, "there is no such flag here", remedy(error, ContextKind::SuggestedArg))
        }
        ErrorKind::UnknownArgument => {
            Error::flag(flag, "there is nothing left to be named here", "leave it out, or see irt --help")
        }
        ErrorKind::InvalidSubcommand => Error::flag(
            text(error, ContextKind::InvalidSubcommand),
            "there is no such command",
            remedy(error, ContextKind::SuggestedSubcommand),
        ),
        ErrorKind::ArgumentConflict => {
            let other = text(error, ContextKind::PriorArg);
            let what = if other == flag {
                "it was given more than once".into()
            } else {
                format!("it cannot be used with {other}")
            };
            Error::flag(flag, what, "leave one of them out")
        }
        ErrorKind::MissingRequiredArgument => Error::flag(flag, "it is missing", "see irt --help"),
        _ => Error::flag("command line", first_line(error), "see irt --help"),
    };
    Some(sentence)
}

/// A part of clap's error; flags without the name of their value, several texts separated by commas.
fn text(error: &clap::Error, kind: ContextKind) -> String {
    let bare = |text: &String| match text.split_once(' ') {
        Some((flag, _)) if flag.starts_with('-') && kind != ContextKind::InvalidValue => flag.to_string(),
        _ => text.clone(),
    };
    match error.get(kind) {
        Some(ContextValue::String(text)) => bare(text),
        Some(ContextValue::Strings(texts)) => texts.iter().map(bare).collect::<Vec<_>>().join(", "),
        _ => String::new(),
    }
}

fn remedy(error: &clap::Error, kind: ContextKind) -> String {
    match text(error, kind) {
        similar if similar.is_empty() => "see irt --help".into(),
        similar => format!("did you mean {similar}?"),
    }
}

fn first_line(error: &clap::Error) -> String {
    let all = error.to_string();
    all.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string()
}

#[cfg(test)]
mod tests {
    use super::super::args::CommandLine;
    use super::*;
    use clap::Parser;

    fn message(line: &str) -> String {
        let clap = CommandLine::try_parse_from(line.split(' ')).unwrap_err();
        error(&clap).map_or_else(|| "none".into(), |error| error.to_string())
    }

    #[test]
    fn every_mistake_becomes_one_sentence_with_the_flag_and_the_remedy() {
        for (line, expected) in [
            (
                "irt render --order spiral",
                "--order: 'spiral' is not available; use one of: scanline, serpentine, hilbert, morton, peano",
            ),
            (
                "irt render --threads 0",
                "--threads: '0' is not a whole number in range; give one from 1 to 1024",
            ),
            ("irt render --sise 5x5", "--sise: there is no such flag here; did you mean --size?"),
            ("irt render --size", "--size: a value is missing; give one, or leave the flag out"),
            ("irt rendr", "rendr: there is no such command; did you mean render?"),
            ("irt inspect", "<SCENE>: it is missing; see irt --help"),
            ("irt render -q -v", "--quiet: it cannot be used with --verbose; leave one of them out"),
            ("irt render --fov 5 --fov 6", "--fov: it was given more than once; leave one of them out"),
            ("irt render a b", "b: there is nothing left to be named here; leave it out, or see irt --help"),
        ] {
            assert_eq!(message(line), expected, "{line}");
        }
    }

    #[test]
    fn help_and_version_are_no_errors() {
        assert_eq!(message("irt --help"), "none");
        assert_eq!(message("irt render --version"), "none");
    }
}
