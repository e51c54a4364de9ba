//! Where the frames of a stream come from, and where they go.

use super::TileTask;
use crate::tile::Tile;

/// Gives and takes the frames of a stream. All of it is called on the master's thread, while workers are busy: what takes
/// long here takes a core from one of them.
pub trait Source<T: TileTask> {
    /// The next frame; `None` if there is no other. It begins at once.
    fn next(&mut self) -> Option<T::Frame>;

    /// True if there is another frame. Then the workers have something to go on with at the end of the one before, and
    /// its last tiles need not be cut.
    fn more(&self) -> bool;

    /// A tile of `frame` is done. Tiles come in any order, and those of frames in flight come mixed.
    fn collect(&mut self, frame: &T::Frame, tile: Tile, output: &mut T::Output);

    /// A frame is complete and nobody uses it any more. Frames come back in the order in which they were given.
    fn done(&mut self, frame: T::Frame);
}

/// A single frame, handed to a closure tile by tile.
pub(super) struct OneFrame<F, C> {
    pub(super) waiting: Option<F>,
    pub(super) collect: C,
    pub(super) complete: Option<F>,
}

impl<T, C> Source<T> for OneFrame<T::Frame, C>
where
    T: TileTask,
    C: FnMut(&T::Frame, Tile, &mut T::Output),
{
    fn next(&mut self) -> Option<T::Frame> {
        self.waiting.take()
    }

    fn more(&self) -> bool {
        self.waiting.is_some()
    }

    fn collect(&mut self, frame: &T::Frame, tile: Tile, output: &mut T::Output) {
        (self.collect)(frame, tile, output);
    }

    fn done(&mut self, frame: T::Frame) {
        self.complete = Some(frame);
    }
}
