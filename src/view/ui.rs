//! What lies between the user's hands and the renderer, and over the picture: keys, help, figures. Window and script share
//! it.

use super::{
    bindings::{Command, command, help},
    draw::{Scale, Surface},
    event::Event,
    figures::Figures,
    overlay::tint,
    picture::Picture,
};
use crate::scene::CameraDescription;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// Width of the bar of a worker's time, in characters, ...
pub(super) const BAR: u32 = 24;
/// ... and where it begins in its line.
pub(super) const BAR_AT: u32 = 11;
/// Colours of a worker's time: busy, and idle at the start, for work, to deliver, at the end.
const LOADS: [u32; 5] = [0x0058_a55c, 0x0045_6a9a, 0x00c8_a23c, 0x00b0_5fa0, 0x00b8_4a3c];

/// What has to be done for a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// The renderer wants to know.
    Send(Event),
    /// The user wants this in the clipboard.
    Copy(String),
    /// Fill the screen, or not.
    FullScreen,
    /// Draw the picture again.
    Redraw,
}

/// A picture that others are compared with.
#[derive(Clone, Debug)]
struct Frozen {
    size: [u32; 2],
    pixels: Vec<u32>,
    modes: String,
    seconds: f64,
}

/// Differences are shown this many times as large.
const AMPLIFIED: u32 = 8;

/// What is shown over the picture.
#[derive(Clone, Debug, Default)]
pub struct Ui {
    /// The keys.
    pub help: bool,
    /// The figures.
    pub show_figures: bool,
    /// A sentence for the user.
    pub note: Option<String>,
    /// The difference from the frozen picture instead of the picture.
    pub difference: bool,
    /// The next picture that is composed is to be frozen.
    freeze: bool,
    frozen: Option<Frozen>,
    figures: Figures,
    camera: Option<CameraDescription>,
    /// The overlay's colours and what they mean.
    tint: Option<(Vec<u32>, String)>,
}

impl Ui {
    /// With the figures shown.
    pub fn with_figures() -> Ui {
        Ui { show_figures: true, ..Ui::default() }
    }

    /// A key went down or up.
    pub fn key(&mut self, key: &str, down: bool) -> Vec<Wish> {
        let Some(command) = command(key) else { return vec![] };
        if command == Command::Hold {
            let key = key.to_string();
            return vec![Wish::Send(if down { Event::Press(key) } else { Event::Release(key) })];
        }
        if !down {
            return vec![];
        }
        self.note = None;
        match command {
            Command::Hold => vec![],
            Command::Cycle(mode) => vec![Wish::Send(Event::Cycle(mode))],
            Command::Help => {
                self.help = !self.help;
                vec![Wish::Redraw]
            }
            Command::Figures => {
                self.show_figures = !self.show_figures;
                vec![Wish::Redraw]
            }
            Command::Freeze => {
                self.freeze = true;
                self.note = Some("frozen: g shows how other pictures differ".into());
                vec![Wish::Redraw]
            }
            Command::Difference => {
                self.difference = !self.difference;
                vec![Wish::Redraw]
            }
            Command::Reset => vec![Wish::Send(Event::Reset)],
            Command::Screenshot => {
                let files = free_names();
                self.note = Some("the picture is written when it is at rest".into());
                files
                    .into_iter()
                    .map(|path| Wish::Send(Event::Screenshot(path)))
                    .chain([Wish::Redraw])
                    .collect()
            }
            Command::CopyToml => self.copy(toml),
            Command::CopyFlags => self.copy(flags),
            Command::Step(ahead) => vec![Wish::Send(Event::Step(ahead))],
            Command::Brighter(more) => vec![Wish::Send(Event::Brighten(if more { 0.5 } else { -0.5 }))],
            Command::FullScreen => vec![Wish::FullScreen],
            Command::Quit => vec![Wish::Send(Event::Quit)],
        }
    }

    fn copy(&mut self, text: fn(&CameraDescription) -> String) -> Vec<Wish> {
        let Some(camera) = &self.camera else { return vec![] };
        let text = text(camera);
        self.note = Some(format!("copied: {}", text.replace('\n', "  ")));
        vec![Wish::Copy(text), Wish::Redraw]
    }

    /// A picture is going to be shown.
    pub fn note_picture(&mut self, picture: &Picture) {
        self.figures.note(&picture.frame);
        self.camera = Some(picture.frame.camera);
        let options = &picture.frame.options;
        self.tint = tint(picture, options.order, options.tile);
    }

    /// Puts the picture and what lies over it on a surface of any size.
    pub fn compose(&mut self, picture: &Picture, surface: &mut Surface, scale: Scale) {
        let painted = self.paint(picture, surface);
        let note = self.note.clone().map(|note| Panel { lines: vec![note], loads: vec![] });
        let [cell, line] = scale.cell();
        let mut top = line / 2;
        for panel in painted.into_iter().chain(self.figures()).chain(note).chain(self.help()) {
            top += panel.draw(surface, [cell, top], scale) + line / 2;
        }
    }

    /// Puts the picture on a surface of any size, with the map or the difference that is wanted, and tells what it means.
    pub(super) fn paint(&mut self, picture: &Picture, surface: &mut Surface) -> Option<Panel> {
        if std::mem::take(&mut self.freeze) {
            self.frozen = Some(Frozen {
                size: picture.size,
                pixels: picture.pixels.iter().map(|pixel| pixel.load(Ordering::Relaxed)).collect(),
                modes: picture.frame.modes.clone(),
                seconds: picture.frame.image_seconds,
            });
        }
        let frozen = self.frozen.as_ref().filter(|frozen| self.difference && frozen.size == picture.size);
        let lines = match (frozen, &self.tint) {
            (Some(frozen), _) => {
                copy(picture, surface, |i, pixel| apart(pixel, frozen.pixels[i]));
                compared(picture, frozen)
            }
            (None, Some((colors, text))) => {
                copy(picture, surface, |i, pixel| mixed(pixel, colors[i]));
                vec![text.clone()]
            }
            (None, None) => {
                copy(picture, surface, |_, pixel| pixel);
                return None;
            }
        };
        Some(Panel { lines, loads: vec![] })
    }

    /// The figures, if they are to be shown.
    pub(super) fn figures(&self) -> Option<Panel> {
        let panel = || Panel { lines: self.figures.lines(), loads: self.figures.loads() };
        self.show_figures.then(panel)
    }

    /// The keys, if they are to be shown.
    pub(super) fn help(&self) -> Option<Panel> {
        self.help.then(|| Panel { lines: help(), loads: vec![] })
    }
}

/// Text over the picture, and below it the times of workers as bars.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Panel {
    pub(super) lines: Vec<String>,
    /// See [`Figures::loads`].
    pub(super) loads: Vec<[f64; 5]>,
}

impl Panel {
    /// The text, with room for the bars.
    pub(super) fn text(&self) -> Vec<String> {
        let room = " ".repeat(BAR as usize);
        let workers = (0..self.loads.len()).map(|i| format!("worker {i:<3} {room}"));
        self.lines.iter().cloned().chain(workers).collect()
    }

    /// Draws it from (left, top) on; returns its height.
    fn draw(&self, surface: &mut Surface, [left, top]: [u32; 2], scale: Scale) -> u32 {
        let [cell, line] = scale.cell();
        let [_, height] = surface.lines([left, top], scale, &self.text());
        for (i, load) in self.loads.iter().enumerate() {
            let row = (self.lines.len() + i) as u32;
            let at = [left + (1 + BAR_AT) * cell, top + line / 2 + row * line + 2];
            bar(surface, at, [BAR * cell, line.saturating_sub(4)], load);
        }
        height
    }
}

/// What the difference from a frozen picture comes to.
fn compared(picture: &Picture, frozen: &Frozen) -> Vec<String> {
    let now = picture.pixels.iter().map(|pixel| pixel.load(Ordering::Relaxed));
    let apart = now.zip(&frozen.pixels).map(|(now, &then)| {
        let [a, b] = [now, then].map(u32::to_be_bytes);
        a.into_iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
    });
    let (mut differ, mut most) = (0usize, 0);
    for byte in apart {
        differ += usize::from(byte > 0);
        most = most.max(byte);
    }
    let ms = |seconds: f64| seconds * 1e3;
    vec![
        format!("difference x{AMPLIFIED}: {differ} pixels differ, by {most} of 255 at most"),
        format!("now    {:.1} ms  {}", ms(picture.frame.image_seconds), picture.frame.modes),
        format!("frozen {:.1} ms  {}", ms(frozen.seconds), frozen.modes),
    ]
}

/// The differences of the channels, amplified.
fn apart(a: u32, b: u32) -> u32 {
    let channel =
        |shift: u32| ((a >> shift & 0xff).abs_diff(b >> shift & 0xff) * AMPLIFIED).min(255) << shift;
    channel(16) | channel(8) | channel(0)
}

/// A quarter of the picture in grey, three quarters of the colour.
fn mixed(pixel: u32, color: u32) -> u32 {
    let grey = ((pixel >> 16 & 0xff) + 2 * (pixel >> 8 & 0xff) + (pixel & 0xff)) / 4;
    let channel = |shift: u32| ((grey + 3 * (color >> shift & 0xff)) / 4) << shift;
    channel(16) | channel(8) | channel(0)
}

/// A worker's time as a bar.
fn bar(surface: &mut Surface, [x, y]: [u32; 2], [width, height]: [u32; 2], load: &[f64; 5]) {
    for (range, color) in parts(load, width) {
        surface.block([x + range.start, y], [range.end - range.start, height], color);
    }
}

/// A worker's time as parts of a bar of this width, and their colours.
pub(super) fn parts(load: &[f64; 5], width: u32) -> impl Iterator<Item = (Range<u32>, u32)> {
    let (mut sum, mut from) = (0.0, 0);
    load.iter().zip(LOADS).map(move |(part, color)| {
        sum += part;
        let to = (sum * f64::from(width)).round() as u32;
        (std::mem::replace(&mut from, to)..to, color)
    })
}

/// The picture, changed pixel by pixel, and stretched if the surface has another size by now.
fn copy(picture: &Picture, surface: &mut Surface, change: impl Fn(usize, u32) -> u32) {
    if picture.size == surface.size {
        // By far the most frequent case, on the thread that answers the user.
        for (i, (to, from)) in surface.pixels.iter_mut().zip(&picture.pixels).enumerate() {
            *to = change(i, from.load(Ordering::Relaxed));
        }
        return;
    }
    let [width, height] = surface.size.map(|side| side as usize);
    let [from_width, from_height] = picture.size.map(|side| side as usize);
    for (y, row) in surface.pixels.chunks_exact_mut(width.max(1)).enumerate() {
        let left = y * from_height / height.max(1) * from_width;
        for (x, to) in row.iter_mut().enumerate() {
            let from = left + if from_width == width { x } else { x * from_width / width };
            *to = change(from, picture.pixels[from].load(Ordering::Relaxed));
        }
    }
}

/// Names for a screenshot that no file has yet.
fn free_names() -> Vec<PathBuf> {
    let names = |i: u32| ["exr", "png"].map(|extension| PathBuf::from(format!("irt-view-{i}.{extension}")));
    let free = |names: &[PathBuf; 2]| !names.iter().any(|name| name.exists());
    (1..).map(names).find(free).map(Vec::from).unwrap_or_default()
}

fn toml(camera: &CameraDescription) -> String {
    let [eye, at, up] = [camera.eye, camera.at, camera.up].map(|v| format!("[{}, {}, {}]", v.x, v.y, v.z));
    format!("[camera]\neye = {eye}\nat = {at}\nup = {up}\nfov = {}\n", camera.fov_deg)
}

fn flags(camera: &CameraDescription) -> String {
    let [eye, at, up] = [camera.eye, camera.at, camera.up].map(|v| format!("{},{},{}", v.x, v.y, v.z));
    format!("--camera-eye {eye} --camera-at {at} --camera-up {up} --fov {}", camera.fov_deg)
}
