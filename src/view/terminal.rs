//! The viewer in a terminal: two pixels in each character, 24-bit colours, the same keys. The only file that names
//! crossterm.

use super::{
    cells::Cells,
    draw::Surface,
    event::{Button, Event},
    link::Link,
    picture::{News, Picture},
    renderer::beside,
    setting::Setting,
    ui::{Ui, Wish},
};
use crate::{
    error::{Error, Result},
    render::RenderOptions,
    scene::Scene,
};
use crossterm::{
    cursor,
    event::{
        self, DisableFocusChange, DisableMouseCapture, EnableFocusChange, EnableMouseCapture, KeyCode,
        KeyEvent, KeyEventKind, KeyModifiers, KeyboardEnhancementFlags, MouseButton, MouseEventKind,
        PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
    },
    execute,
    terminal::{self, EnterAlternateScreen, LeaveAlternateScreen},
};
use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most terminals do not tell when a key comes up: it is taken to be held this long, and each repetition counts anew.
const HELD: Duration = Duration::from_millis(250);
/// Pixels of a window that a character of a dragged mouse stands for.
const DRAG: f32 = 10.0;
/// Pictures are looked for this often, and ...
const TICK: Duration = Duration::from_millis(10);
/// ... this often once nothing has happened for a while.
const IDLE_TICK: Duration = Duration::from_millis(100);

/// Shows the scene in the terminal until the user leaves.
///
/// # Errors
/// [`Error::Flag`] if standard output is no terminal, [`Error::Failed`] if that fails, and as [`beside`].
pub fn show_in_terminal(scene: &Scene, options: &RenderOptions, frame_time: Duration) -> Result<()> {
    if !io::stdout().is_terminal() || !io::stdin().is_terminal() {
        let remedy = "run it in a terminal, without redirection";
        return Err(Error::flag("--terminal", "standard input or output is no terminal", remedy));
    }
    let size = terminal::size().map_err(failed)?;
    let options = RenderOptions { size: pixels_of(size), ..*options };
    let (link, (tell, news)) = (Link::default(), channel());
    // Nobody listens after the end.
    let tell = move |piece| drop(tell.send(piece));
    beside(scene, &options, frame_time, &link, tell, || {
        link.send(Event::Set(Setting::Play(true)));
        link.send(Event::Set(Setting::AntiAliasing(true)));
        let mode = Mode::enter()?;
        User {
            link: &link,
            ui: Ui::default(),
            mode,
            held: vec![],
            cursor: None,
            picture: None,
            redraw: false,
        }
        .watch(&news)
    })
}

/// Two pixels to a character, and a line for what there is to say.
fn pixels_of((columns, rows): (u16, u16)) -> [u32; 2] {
    [u32::from(columns).max(1), 2 * u32::from(rows.saturating_sub(1)).max(1)]
}

fn failed(error: io::Error) -> Error {
    Error::Failed(format!("the terminal cannot be used ({error}); try another one"))
}

/// Whether the terminal is as the viewer needs it, and tells when keys come up. Drawn and restored under its lock, so that
/// nothing is drawn once the terminal is as it was.
static ENTERED: Mutex<Option<bool>> = Mutex::new(None);

fn entered() -> MutexGuard<'static, Option<bool>> {
    ENTERED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Leaves the terminal as it was before [`show_in_terminal`], if that is still going on: for whoever ends the process or
/// has something to say about its end.
pub fn restore_terminal() {
    let Some(releases) = entered().take() else { return };
    let mut out = io::stdout();
    // Whatever fails here cannot be mended, and nobody is left to tell.
    if releases {
        let _ = execute!(out, PopKeyboardEnhancementFlags);
    }
    let _ = execute!(out, DisableFocusChange, DisableMouseCapture, cursor::Show, LeaveAlternateScreen);
    let _ = terminal::disable_raw_mode();
}

/// The terminal as the viewer needs it; as it was, when dropped.
struct Mode {
    /// It tells when keys come up.
    releases: bool,
}

impl Mode {
    fn enter() -> Result<Mode> {
        terminal::enable_raw_mode().map_err(failed)?;
        let releases = terminal::supports_keyboard_enhancement().unwrap_or(false);
        let mode = Mode { releases };
        *entered() = Some(releases);
        let mut out = io::stdout();
        execute!(out, EnterAlternateScreen, cursor::Hide, EnableMouseCapture, EnableFocusChange)
            .map_err(failed)?;
        if releases {
            execute!(out, PushKeyboardEnhancementFlags(KeyboardEnhancementFlags::REPORT_EVENT_TYPES))
                .map_err(failed)?;
        }
        Ok(mode)
    }
}

impl Drop for Mode {
    fn drop(&mut self) {
        restore_terminal();
    }
}

struct User<'a> {
    link: &'a Link,
    ui: Ui,
    mode: Mode,
    /// Keys that are taken to be held, and until when.
    held: Vec<(String, Instant)>,
    cursor: Option<(u16, u16)>,
    /// What is shown, ...
    picture: Option<Box<Picture>>,
    /// ... and is to be drawn again.
    redraw: bool,
}

impl User<'_> {
    fn watch(&mut self, news: &Receiver<News>) -> Result<()> {
        let mut tick = TICK;
        loop {
            let mut busy = false;
            while event::poll(if busy { Duration::ZERO } else { tick }).map_err(failed)? {
                busy = true;
                if self.take(event::read().map_err(failed)?) {
                    return Ok(());
                }
            }
            self.let_go();
            let mut latest = None;
            loop {
                match news.try_recv() {
                    Ok(News::Picture(picture)) => latest = Some(picture),
                    Ok(News::Note(note)) => (self.ui.note, self.redraw) = (Some(note), true),
                    Ok(News::Rest { .. }) => {}
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => return Ok(()),
                }
            }
            busy |= latest.is_some() || !self.held.is_empty();
            tick = if busy { TICK } else { (tick * 2).min(IDLE_TICK) };
            if let Some(picture) = latest {
                self.ui.note_picture(&picture);
                if let Some(old) = self.picture.replace(picture) {
                    self.link.give_back(old.pixels);
                }
                self.redraw = true;
            }
            if std::mem::take(&mut self.redraw) {
                self.draw()?;
            }
        }
    }

    fn draw(&mut self) -> Result<()> {
        let Some(picture) = &self.picture else { return Ok(()) };
        let frame = &picture.frame;
        let note = self.ui.note.clone().unwrap_or_else(|| {
            let ms = (frame.end - frame.start).as_secs_f64() * 1e3;
            format!("{:.0} % traced, {ms:.1} ms, {}; escape quits", frame.share * 100.0, frame.modes)
        });
        let text = drawn(&mut self.ui, picture).text() + &status(&note, picture.size[0] as usize);
        let entered = entered();
        if entered.is_none() {
            return Ok(());
        }
        let mut out = io::stdout().lock();
        out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(failed)
    }

    /// True if the user leaves.
    fn take(&mut self, event: event::Event) -> bool {
        match event {
            event::Event::Key(key) => return self.key(key),
            event::Event::Resize(columns, rows) => {
                let _ = execute!(io::stdout(), terminal::Clear(terminal::ClearType::All));
                self.link.send(Event::Resize(pixels_of((columns, rows))));
            }
            event::Event::FocusLost => self.link.send(Event::ReleaseAll),
            event::Event::Mouse(mouse) => {
                let at = (mouse.column, mouse.row);
                match mouse.kind {
                    MouseEventKind::Down(_) => self.cursor = Some(at),
                    MouseEventKind::Drag(button) => {
                        let from = self.cursor.replace(at).unwrap_or(at);
                        let by =
                            [i32::from(at.0) - i32::from(from.0), 2 * (i32::from(at.1) - i32::from(from.1))];
                        let button = if button == MouseButton::Left { Button::Left } else { Button::Right };
                        self.link.send(Event::Drag(button, by.map(|by| by as f32 * DRAG)));
                    }
                    MouseEventKind::ScrollUp => self.link.send(Event::Wheel(1.0)),
                    MouseEventKind::ScrollDown => self.link.send(Event::Wheel(-1.0)),
                    _ => {}
                }
            }
            event::Event::FocusGained => {}
        }
        false
    }

    fn key(&mut self, key: KeyEvent) -> bool {
        let Some(name) = name_of(key.code) else { return false };
        if name == "c" && key.modifiers.contains(KeyModifiers::CONTROL) {
            return true;
        }
        let down = key.kind != KeyEventKind::Release;
        if key.kind == KeyEventKind::Repeat && self.mode.releases {
            return false;
        }
        let wishes = self.ui.key(&name, down);
        let holds = matches!(wishes.first(), Some(Wish::Send(Event::Press(_))));
        if holds && !self.mode.releases {
            let known = self.held.iter().any(|(held, _)| *held == name);
            self.held.retain(|(held, _)| *held != name);
            self.held.push((name, Instant::now() + HELD));
            if known {
                return false;
            }
        }
        for wish in wishes {
            match wish {
                Wish::Send(Event::Quit) => return true,
                Wish::Send(event) => self.link.send(event),
                // What is copied stands in the note; the terminal's own selection takes it from there.
                Wish::Copy(_) | Wish::FullScreen => {}
                Wish::Redraw => self.redraw = true,
            }
        }
        false
    }

    /// Keys that have not been repeated come up.
    fn let_go(&mut self) {
        let now = Instant::now();
        let link = self.link;
        self.held.retain(|(key, until)| {
            let held = *until > now;
            if !held {
                link.send(Event::Release(key.clone()));
            }
            held
        });
    }
}

/// The picture as the terminal shows it, with all that the window would lay over it but notes.
pub(super) fn drawn(ui: &mut Ui, picture: &Picture) -> Cells {
    let mut pixels = vec![0; picture.pixels.len()];
    let painted = ui.paint(picture, &mut Surface { size: picture.size, pixels: &mut pixels });
    let mut cells = Cells::of(&pixels, picture.size);
    cells.write(painted.into_iter().chain(ui.figures()).chain(ui.help()));
    cells
}

/// The line below the picture.
fn status(note: &str, width: usize) -> String {
    let line: String = note.chars().filter(|c| !c.is_control()).take(width).collect();
    format!("\r\n{line}\x1b[K")
}

fn name_of(code: KeyCode) -> Option<String> {
    Some(match code {
        KeyCode::Char(' ') => "space".into(),
        KeyCode::Char(c) => c.to_lowercase().to_string(),
        KeyCode::Left => "left".into(),
        KeyCode::Right => "right".into(),
        KeyCode::Up => "up".into(),
        KeyCode::Down => "down".into(),
        KeyCode::Esc => "escape".into(),
        KeyCode::Home => "home".into(),
        KeyCode::Tab => "tab".into(),
        KeyCode::F(n) => format!("f{n}"),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_terminal_is_too_small_and_notes_stay_in_their_line() {
        assert_eq!([pixels_of((0, 0)), pixels_of((80, 25))], [[1, 2], [80, 48]]);
        assert_eq!(status("a\nbcd\x1b[1m", 3), "\r\nabc\x1b[K");
    }
}
