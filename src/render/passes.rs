//! The passes of an adaptive image, whoever has them rendered: a session in one go, the viewer bit by bit.

use super::adaptive::{Known, Refining, samples_of};
use crate::film::Film;

/// Passes after the first two, at most.
pub(super) const REFINEMENTS: usize = 3;

/// Which samples of its pixels a tile is to take.
pub(super) enum Pass {
    /// All of them.
    All,
    /// One, through the lower right corner.
    Corners,
    /// One, through the centre. There is a film of the corners by then.
    Centres(Film),
    /// All of pixels that differ from others; the others stay as they are.
    Refine(Box<Refining>),
}

/// An adaptive image on its way: which pass is due, and what those before it have left.
///
/// Whoever drives it has every tile of a pass rendered, from that of the [corners](Pass::Corners) on, gives it back as
/// [done](Adaptive::done), and [takes](Adaptive::take) the next.
pub(super) struct Adaptive {
    /// Colours that differ by no more are taken for the same.
    least: f32,
    due: Option<Pass>,
    /// Refinements that are left.
    left: usize,
    /// Whether the film of the centres is kept, ...
    keep: bool,
    /// ... and that film, once the first refinement is done.
    centres: Option<Film>,
    /// What is known of a complete image.
    known: Option<Known>,
}

impl Adaptive {
    /// Before the first pass.
    pub(super) fn new(least: f32, keep: bool) -> Adaptive {
        Adaptive { least, due: None, left: REFINEMENTS, keep, centres: None, known: None }
    }

    /// The pass that is due, to be given back; `None` at the beginning, and if the image is complete.
    pub(super) fn take(&mut self) -> Option<Pass> {
        self.due.take()
    }

    /// This pass is due: the first one, or one of which tiles are left.
    pub(super) fn put(&mut self, pass: Pass) {
        self.due = Some(pass);
    }

    /// A pass has left its pixels on `film`, and traced so many primary rays. Afterwards `film` is the image, or one for the next
    /// pass to write over. Films that nobody needs any more go to `spare`.
    pub(super) fn done(&mut self, pass: Pass, film: &mut Film, spare: &mut Vec<Film>, traced: u64) {
        match pass {
            Pass::All => {}
            Pass::Corners => self.due = Some(Pass::Centres(exchange(film, spare))),
            Pass::Centres(corners) => {
                film.inherit_nan(&corners);
                self.refine(Known::new(corners, self.least), film, spare);
            }
            Pass::Refine(refining) => {
                let (before, known) = refining.end();
                film.inherit_nan(&before);
                if self.keep && self.centres.is_none() {
                    self.centres = Some(before);
                } else {
                    spare.push(before);
                }
                self.left -= 1;
                if traced > 0 && self.left > 0 {
                    self.refine(known, film, spare);
                } else {
                    self.known = Some(known);
                }
            }
        }
    }

    fn refine(&mut self, known: Known, film: &mut Film, spare: &mut Vec<Film>) {
        self.due = Some(Pass::Refine(Box::new(Refining::new(exchange(film, spare), known))));
    }

    /// Every pass is done.
    pub(super) fn complete(&self) -> bool {
        self.known.is_some()
    }

    /// The film with one sample of each pixel, unless it still is the one that is written on.
    pub(super) fn centres(&self) -> Option<&Film> {
        match &self.due {
            Some(Pass::Refine(refining)) if self.left == REFINEMENTS => Some(refining.before()),
            _ => self.centres.as_ref(),
        }
    }

    /// The samples of each pixel by now, row by row, beside those that tell whether it differs.
    pub(super) fn samples(&self) -> Option<impl ExactSizeIterator<Item = u32>> {
        let marks = match &self.due {
            Some(Pass::Refine(refining)) => refining.marks(),
            _ => self.known.as_ref()?.marks(),
        };
        Some(marks.iter().map(samples_of))
    }

    /// All films that it has.
    pub(super) fn end(self) -> impl Iterator<Item = Film> {
        let due: Vec<Film> = match self.due {
            Some(Pass::Centres(corners)) => vec![corners],
            Some(Pass::Refine(refining)) => {
                let (before, known) = refining.end();
                vec![before, known.end()]
            }
            _ => vec![],
        };
        due.into_iter().chain(self.centres).chain(self.known.map(Known::end))
    }
}

/// Takes a film, and puts another of its size in its place.
fn exchange(film: &mut Film, spare: &mut Vec<Film>) -> Film {
    let blank = blank(film, spare);
    std::mem::replace(film, blank)
}

/// A film to be written over.
fn blank(like: &Film, spare: &mut Vec<Film>) -> Film {
    let mut film = spare.pop().unwrap_or_else(|| Film::new(like.width(), like.height()));
    film.forget_nan();
    film
}
