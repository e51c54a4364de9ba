//! What the keys do. The help is made from the same table.

use super::setting::Mode;

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Moves the camera as long as it is held.
    Hold,
    /// The next value of a mode.
    Cycle(Mode),
    /// Shows or hides the keys.
    Help,
    /// Shows or hides the figures.
    Figures,
    /// Keeps the picture, to compare others with it.
    Freeze,
    /// Shows how the picture differs from the one that is kept, or the picture.
    Difference,
    /// The camera goes home.
    Reset,
    /// Writes the image at rest as EXR and PNG.
    Screenshot,
    /// Tells the camera as TOML of a scene.
    CopyToml,
    /// Tells the camera as flags of the command line.
    CopyFlags,
    /// Brighter or darker by half a stop.
    Brighter(bool),
    /// Time stops and goes to the next moment, or to the one before.
    Step(bool),
    /// Fills the screen, or not.
    FullScreen,
    /// The viewer ends.
    Quit,
}

/// Keys, what they do, and how the help says it. Keys that the help tells together have the text at the first.
pub const BINDINGS: [(&str, Command, &str); 43] = [
    ("w", Command::Hold, "w a s d    move ahead, left, back, right"),
    ("a", Command::Hold, ""),
    ("s", Command::Hold, ""),
    ("d", Command::Hold, ""),
    ("q", Command::Hold, "q e        move down, up"),
    ("e", Command::Hold, ""),
    ("left", Command::Hold, "arrows     turn"),
    ("right", Command::Hold, ""),
    ("up", Command::Hold, ""),
    ("down", Command::Hold, ""),
    ("shift", Command::Hold, "shift      four times as fast"),
    ("o", Command::Cycle(Mode::Camera), "o          orbit or fly"),
    ("home", Command::Reset, "home       back to where it began"),
    ("+", Command::Brighter(true), "+ -        brighter, darker"),
    ("=", Command::Brighter(true), ""),
    ("-", Command::Brighter(false), ""),
    ("1", Command::Cycle(Mode::Order), "1          order of the tiles"),
    ("2", Command::Cycle(Mode::Schedule), "2          schedule"),
    ("3", Command::Cycle(Mode::Film), "3          film"),
    ("4", Command::Cycle(Mode::Threads), "4          threads"),
    ("5", Command::Cycle(Mode::Isa), "5          instruction set"),
    ("6", Command::Cycle(Mode::Visibility), "6          visibility"),
    ("7", Command::Cycle(Mode::Kernel), "7          kernel"),
    ("8", Command::Cycle(Mode::Early), "8          early termination"),
    ("9", Command::Cycle(Mode::Tile), "9          size of tiles"),
    ("0", Command::Cycle(Mode::Pin), "0          pinning"),
    ("n", Command::Cycle(Mode::AntiAliasing), "n          anti-aliasing at rest"),
    (
        "x",
        Command::Cycle(Mode::Effects),
        "x          effects: the scene's, by the kernel for all, without one",
    ),
    ("space", Command::Cycle(Mode::Play), "space      time passes or stops"),
    (",", Command::Step(false), ", .        one moment back, ahead"),
    (".", Command::Step(true), ""),
    ("tab", Command::Cycle(Mode::Overlay), "tab        map: workers, samples, time, steps, lanes, coherence"),
    ("f", Command::Freeze, "f          freeze the picture"),
    ("g", Command::Difference, "g          difference from the frozen one"),
    ("i", Command::Figures, "i          figures"),
    ("p", Command::Screenshot, "p          picture to irt-view.exr and .png"),
    ("c", Command::CopyToml, "c          copy the camera as TOML"),
    ("v", Command::CopyFlags, "v          copy the camera as flags"),
    ("f11", Command::FullScreen, "f11        full screen"),
    ("h", Command::Help, "h          these keys"),
    ("f1", Command::Help, ""),
    ("escape", Command::Quit, "escape     quit"),
    ("?", Command::Help, ""),
];

/// What a key does, if anything.
pub(super) fn command(key: &str) -> Option<Command> {
    BINDINGS.iter().find(|(known, _, _)| *known == key).map(|(_, command, _)| *command)
}

/// The help, a line for each deed.
pub(super) fn help() -> Vec<String> {
    let mouse = ["drag       turn", "right drag shift sideways", "wheel      nearer; flying: faster"];
    let keys = BINDINGS.iter().map(|(_, _, text)| *text).filter(|text| !text.is_empty());
    mouse.into_iter().chain(keys).map(String::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_has_one_meaning_and_every_meaning_a_line() {
        for (i, (key, command, text)) in BINDINGS.iter().enumerate() {
            assert!(BINDINGS[..i].iter().all(|(other, _, _)| other != key), "{key} twice");
            let same = |other: &Command| match (other, command) {
                (Command::Brighter(_), Command::Brighter(_)) | (Command::Step(_), Command::Step(_)) => true,
                _ => other == command,
            };
            let told = BINDINGS.iter().any(|(_, other, text)| same(other) && !text.is_empty());
            assert!(told, "{command:?} is told nowhere");
            assert!(text.is_empty() || text.starts_with(key) || text.starts_with("arrows"), "{text}");
        }
        assert_eq!(command("1"), Some(Command::Cycle(Mode::Order)));
        assert_eq!(command("nothing"), None);
        for mode in Mode::ALL {
            assert!(BINDINGS.iter().any(|(_, command, _)| *command == Command::Cycle(mode)), "{mode:?}");
        }
    }
}
