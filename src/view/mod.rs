//! The interactive viewer: a picture that is complete in every frame, and finer with every moment the camera rests.
//!
//! ```text
//!   window, terminal or script --events--> Link --> renderer's thread --> workers
//!                             <--pictures, news----
//! ```
//!
//! The side that shows pictures never waits for the renderer: while it shows one, the next is made, and what is shown is
//! at most one frame behind.

mod bindings;
mod cells;
mod clock;
mod draw;
mod event;
mod figures;
mod link;
mod maker;
mod overlay;
mod pacer;
mod picture;
mod publish;
mod renderer;
mod rest;
mod rig;
mod script;
mod setting;
mod state;
mod summary;
mod terminal;
#[cfg(test)]
mod tests;
mod ui;
mod window;

pub use bindings::{BINDINGS, Command};
pub use clock::Clock;
pub use draw::{Scale, Surface};
pub use event::{Button, Event, Key};
pub use link::{Link, Timed};
pub use overlay::Overlay;
pub use pacer::{Pacer, Region, regions};
pub use picture::{Frame, Hashes, News, Picture, ShownMoment};
pub use renderer::{beside, run};
pub use rig::{Rig, RigMode};
pub use script::{Played, Script, play};
pub use setting::{Mode, NAMES, Now, Setting};
pub use state::{Change, State};
pub use summary::{Summary, errors, summarise};
pub use terminal::{restore_terminal, show_in_terminal};
pub use ui::{Ui, Wish};
pub use window::open;
