//! Scripts: what a user would do, with the time of each deed, to measure how the viewer feels and to test it.
//!
//! One deed a line, with the seconds since the start, or since the last `rest`, before it; `#` begins a comment:
//!
//! ```text
//!   0     press w                 hold a key: w a s d q e, left right up down, shift
//!   1.5   release w
//!   2     drag left 40 -10        move the mouse with a button held, in pixels
//!   2     wheel 2
//!   2.5   size 800x600
//!   3     set order scanline      switch a mode; see `NAMES` of the settings
//!   4     rest                    wait until every pixel is traced
//!   0     screenshot a.exr
//!   0.5   reset                   the camera goes home
//!   1     quit                    the end, also without it
//! ```

use super::{
    event::{Button, Event},
    link::Link,
    picture::{Frame, News, Picture},
    renderer::beside,
    setting::Setting,
    ui::{Ui, Wish},
};
use crate::{
    error::{Error, Result},
    render::RenderOptions,
    scene::Scene,
};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// A deed and the seconds since the start or the last rest.
#[derive(Clone, Debug, PartialEq)]
struct Line {
    seconds: f64,
    deed: Deed,
}

#[derive(Clone, Debug, PartialEq)]
enum Deed {
    Send(Event),
    Rest,
}

/// What a user does, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    lines: Vec<Line>,
}

/// What a line may say, for messages.
const DEEDS: &str = "a line is seconds and: press KEY, release KEY, drag left|right X Y, wheel STEPS, size WxH, set MODE VALUE, screenshot FILE, \
     reset, rest or quit";
/// Longest script in seconds; a typing mistake should not take days.
const LONGEST: f64 = 3600.0;

impl Script {
    /// Reads a script.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read, [`Error::Line`] for a line that makes no sense.
    pub fn read(path: &Path) -> Result<Script> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Error::file(path, format!("cannot be read ({error})"), "name a script"))?;
        Script::parse(&text, path)
    }

    /// Parses a script; `path` is for messages.
    ///
    /// # Errors
    /// [`Error::Line`] for a line that makes no sense.
    pub fn parse(text: &str, path: &Path) -> Result<Script> {
        let (mut lines, mut before) = (Vec::<Line>::new(), 0.0);
        for (index, line) in text.lines().enumerate() {
            let code = line.split('#').next().unwrap_or_default();
            let words: Vec<&str> = code.split_whitespace().collect();
            let [time, deed @ ..] = &words[..] else { continue };
            let wrong = |what: String, remedy: &str| Error::line(path, index + 1, what, remedy);
            let seconds =
                time.parse().ok().filter(|seconds| (before..=LONGEST).contains(seconds)).ok_or_else(
                    || {
                        wrong(
                            format!("'{time}' is no time"),
                            "give seconds, none before those of the line before",
                        )
                    },
                )?;
            let deed = parse_deed(deed).map_err(|what| wrong(what, DEEDS))?;
            before = if deed == Deed::Rest { 0.0 } else { seconds };
            lines.push(Line { seconds, deed });
        }
        Ok(Script { lines })
    }
}

fn parse_deed(words: &[&str]) -> std::result::Result<Deed, String> {
    let event = match *words {
        ["rest"] => return Ok(Deed::Rest),
        ["press", key] => Event::Press(key.to_lowercase()),
        ["release", key] => Event::Release(key.to_lowercase()),
        ["release-all"] => Event::ReleaseAll,
        ["drag", button, x, y] => {
            let button = match button {
                "left" => Button::Left,
                "right" => Button::Right,
                _ => return Err(format!("'{button}' is no button; use left or right")),
            };
            Event::Drag(button, [number(x)?, number(y)?])
        }
        ["wheel", steps] => Event::Wheel(number(steps)?),
        ["size", size] => {
            let side = |text: &str| text.parse().ok().filter(|side| (1..=65536u32).contains(side));
            let sides = size.split_once('x').and_then(|(w, h)| Some([side(w)?, side(h)?]));
            Event::Resize(sides.ok_or_else(|| format!("'{size}' is no size; give WIDTHxHEIGHT"))?)
        }
        ["set", name, value] => Event::Set(Setting::parse(name, value)?),
        ["screenshot", path] => {
            crate::output::Format::of(Path::new(path)).map_err(|error| error.to_string())?;
            Event::Screenshot(path.into())
        }
        ["reset"] => Event::Reset,
        ["quit"] => Event::Quit,
        [] => return Err("there is a time, but no deed".into()),
        [word, ..] => return Err(format!("'{word}' is no deed, or has too many or too few words")),
    };
    Ok(Deed::Send(event))
}

fn number(text: &str) -> std::result::Result<f32, String> {
    text.parse()
        .ok()
        .filter(|number: &f32| number.is_finite())
        .ok_or_else(|| format!("'{text}' is not a finite number"))
}

/// What came of a script.
#[derive(Debug, Default)]
pub struct Played {
    /// Every frame, in order.
    pub frames: Vec<Frame>,
    /// Hash of the image at each rest, before anti-aliasing.
    pub hashes: Vec<String>,
    /// The same after it, where it was on.
    pub antialiased: Vec<Option<String>>,
    /// Some pictures among the frames, by number, to compare with the whole image; at most 16.
    pub kept: Vec<(usize, Box<Picture>)>,
    /// When the script began.
    pub start: Option<Instant>,
}

/// Most pictures that are kept.
const KEPT: usize = 16;

/// Plays a script without a window. `each` gets every picture as it comes, and its number.
///
/// # Errors
/// As [`beside`], and what `each` returns.
pub fn play(
    scene: &Scene,
    options: &RenderOptions,
    frame_time: Duration,
    script: &Script,
    mut each: impl FnMut(usize, &Picture, &mut Ui) -> Result<()>,
) -> Result<Played> {
    let (link, (tell, news)) = (Link::default(), channel());
    // Nobody listens after the end.
    let tell = move |piece| drop(tell.send(piece));
    beside(scene, options, frame_time, &link, tell, || {
        let mut stage = Audience {
            link: &link,
            news,
            played: Played::default(),
            every: 1,
            each: &mut each,
            ui: Ui::default(),
        };
        // The time of the script begins with the first picture: before, the tree is built.
        stage.wait(None, true)?;
        stage.played.start = Some(Instant::now());
        let mut begin = Instant::now();
        for line in &script.lines {
            stage.wait(Some(begin + Duration::from_secs_f64(line.seconds)), false)?;
            match &line.deed {
                Deed::Send(event) => stage.send(event),
                Deed::Rest => {
                    stage.rest()?;
                    begin = Instant::now();
                }
            }
            if line.deed == Deed::Send(Event::Quit) || line.deed == Deed::Send(Event::Press("escape".into()))
            {
                break;
            }
        }
        Ok(stage.played)
    })
}

/// Who watches a script being played.
struct Audience<'a> {
    link: &'a Link,
    news: Receiver<News>,
    played: Played,
    /// Every which picture is kept.
    every: usize,
    each: &'a mut dyn FnMut(usize, &Picture, &mut Ui) -> Result<()>,
    ui: Ui,
}

impl Audience<'_> {
    /// Keys mean what they mean in the window, as far as there is something without one.
    fn send(&mut self, event: &Event) {
        let wishes = match event {
            Event::Press(key) => self.ui.key(key, true),
            Event::Release(key) => self.ui.key(key, false),
            event => vec![Wish::Send(event.clone())],
        };
        for wish in wishes {
            match wish {
                Wish::Send(event) => self.link.send(event),
                Wish::Copy(text) => log::info!("{text}"),
                Wish::FullScreen | Wish::Redraw => {}
            }
        }
    }

    /// Watches until a moment, or until the first picture.
    fn wait(&mut self, until: Option<Instant>, first: bool) -> Result<()> {
        loop {
            let timeout = until.map(|until| until.saturating_duration_since(Instant::now()));
            let news = match timeout {
                Some(timeout) => self.news.recv_timeout(timeout),
                None => self.news.recv().map_err(|_| RecvTimeoutError::Disconnected),
            };
            match news {
                Ok(news) => drop(self.take(news)?),
                Err(RecvTimeoutError::Timeout) => return Ok(()),
                Err(RecvTimeoutError::Disconnected) => return Err(gone()),
            }
            if first && !self.played.frames.is_empty() {
                return Ok(());
            }
        }
    }

    /// Watches until the image is at rest, with all that was sent before.
    fn rest(&mut self) -> Result<()> {
        self.link.send(Event::Settle);
        loop {
            let news = self.news.recv().map_err(|_| gone())?;
            if self.take(news)? {
                return Ok(());
            }
        }
    }

    /// True if the image is at rest, as it was asked.
    fn take(&mut self, news: News) -> Result<bool> {
        match news {
            News::Picture(picture) => {
                let number = self.played.frames.len();
                self.ui.note_picture(&picture);
                (self.each)(number, &picture, &mut self.ui)?;
                self.played.frames.push(picture.frame.clone());
                self.keep(number, picture);
            }
            News::Rest { hashes: None } => {}
            News::Rest { hashes: Some(hashes) } => {
                self.played.hashes.push(hashes.image_sha256);
                self.played.antialiased.push(hashes.antialiased_sha256);
                return Ok(true);
            }
            News::Note(note) => log::info!("{note}"),
        }
        Ok(false)
    }

    /// Keeps some pictures that are not complete, evenly over the script however long it is.
    fn keep(&mut self, number: usize, picture: Box<Picture>) {
        if !number.is_multiple_of(self.every) || picture.frame.share >= 1.0 {
            return self.link.give_back(picture.pixels);
        }
        self.played.kept.push((number, picture));
        if self.played.kept.len() > KEPT {
            self.every *= 2;
            let every = self.every;
            self.played.kept.retain(|(number, _)| number.is_multiple_of(every));
        }
    }
}

/// The renderer has failed; what it says is the better error.
fn gone() -> Error {
    Error::Failed("the renderer ended before the script".into())
}
