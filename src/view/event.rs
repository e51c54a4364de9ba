//! What users do, as plain data: the window, the terminal and scripts all speak it.

use super::setting::{Mode, Setting};
use std::path::PathBuf;

/// A button of the mouse that is held while it moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Turns the camera.
    Left,
    /// Shifts it sideways.
    Right,
}

/// A key by what is printed on it, in lower case: `a`, `shift`, `escape`, `f11`, `left`, ...
pub type Key = String;

/// Something that happened to the viewer.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A key went down.
    Press(Key),
    /// A key came up.
    Release(Key),
    /// The mouse moved by so many pixels to the right and down while a button was held.
    Drag(Button, [f32; 2]),
    /// The wheel turned, away from the user.
    Wheel(f32),
    /// The picture has this size in pixels from now on.
    Resize([u32; 2]),
    /// A mode was switched.
    Set(Setting),
    /// A mode goes on to its next value.
    Cycle(Mode),
    /// Time stops, and goes to the next moment (true) or back to the one before.
    Step(bool),
    /// Brighter by so many stops.
    Brighten(f32),
    /// No key is held any more: the window has lost the keyboard.
    ReleaseAll,
    /// The image is written to a file as soon as it is at rest; the extension tells the format.
    Screenshot(PathBuf),
    /// All keys are let go, and the renderer tells when the image is at rest.
    Settle,
    /// The camera goes back to where it began.
    Reset,
    /// The viewer ends.
    Quit,
}
