//! What the renderer gives to whoever shows it.

use super::overlay::Overlay;
use crate::{
    render::{Level, RayMap, RayTally, Refined, RenderOptions, Update},
    scene::CameraDescription,
    schedule::{Span, WorkerStats},
};
use std::sync::{
    Arc,
    atomic::{AtomicU32, Ordering},
};
use std::time::{Duration, Instant};

/// A finished picture.
#[derive(Debug)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Row by row, 0x00rrggbb. Give them back to the [`Link`].
    pub pixels: Vec<AtomicU32>,
    /// What it took.
    pub frame: Frame,
    /// What is to be laid over it.
    pub overlay: Overlay,
    /// What rays do, if the overlay needs it and the camera rests.
    pub map: Option<Arc<RayMap>>,
    /// The samples of each pixel, row by row; if the overlay tells that, and some pixels shall have more than one.
    pub refined: Option<Vec<u32>>,
}

impl Picture {
    /// Red, green and blue of each pixel, row by row.
    pub fn bytes(&self) -> Vec<u8> {
        let rgb = |pixel: &AtomicU32| {
            let [_, r, g, b] = pixel.load(Ordering::Relaxed).to_be_bytes();
            [r, g, b]
        };
        self.pixels.iter().flat_map(rgb).collect()
    }
}

/// Hashes of the linear pixels of an image at rest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hashes {
    /// Before anti-aliasing.
    pub image_sha256: String,
    /// After it, if it is on.
    pub antialiased_sha256: Option<String>,
}

/// What the renderer tells.
#[derive(Debug)]
pub enum News {
    /// A picture is finished.
    Picture(Box<Picture>),
    /// Every pixel of the last picture is traced, and has all its samples if there is anti-aliasing; nothing moves.
    Rest {
        /// Hashes, if an event had asked to be told ([`Event::Settle`](super::Event::Settle)).
        hashes: Option<Hashes>,
    },
    /// A sentence for people.
    Note(String),
}

/// The moment that a picture of a moving scene shows: all of it is of this one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownMoment {
    /// Seconds from the beginning of the motion, ...
    pub time: f64,
    /// ... and to its end.
    pub length: f64,
    /// Seconds to move the vertices and to let tree and surface table follow; 0 if they were there already.
    pub follow_seconds: f64,
    /// What was done to the tree then.
    pub update: Option<Update>,
}

/// What a picture took.
#[derive(Clone, Debug)]
pub struct Frame {
    /// When work on it began.
    pub start: Instant,
    /// When it was finished.
    pub end: Instant,
    /// From the oldest event that it is the first to show until it was finished.
    pub latency: Option<Duration>,
    /// The camera or the scene had moved, so that it was made from nothing; else it refines the last one.
    pub moved: bool,
    /// Share of the pixels that are traced.
    pub share: f64,
    /// The level that all of the picture has.
    pub base: Level,
    /// How many pixels have more than one sample, once anti-aliasing has begun.
    pub refined: Option<Refined>,
    /// Rays traced for it.
    pub rays: RayTally,
    /// Seconds of filling in the missing pixels.
    pub fill_seconds: f64,
    /// The moment, if the scene moves.
    pub moment: Option<ShownMoment>,
    /// The camera.
    pub camera: CameraDescription,
    /// Stops by which it is brightened.
    pub exposure: f32,
    /// How it was rendered, ...
    pub options: RenderOptions,
    /// ... and that in one line.
    pub modes: String,
    /// What each worker did in the first pass, ...
    pub workers: Vec<WorkerStats>,
    /// ... and which tile when.
    pub spans: Vec<Span>,
    /// The level of each square of 16 pixels, row by row.
    pub levels: Vec<Level>,
    /// Seconds spent on tracing this image, from its beginning on.
    pub image_seconds: f64,
}
