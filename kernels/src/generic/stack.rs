//! A traversal stack that costs nothing to create.

use crate::node::STACK;
use std::mem::MaybeUninit;

/// At most [`STACK`] entries; a tree within [`crate::MAX_DEPTH`] cannot exceed that.
pub(crate) struct Stack<T: Copy> {
    entries: [MaybeUninit<T>; STACK],
    len: usize,
}

impl<T: Copy> Stack<T> {
    #[inline(always)]
    pub(crate) fn new() -> Stack<T> {
        Stack { entries: [const { MaybeUninit::uninit() }; STACK], len: 0 }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, entry: T) {
        self.entries[self.len] = MaybeUninit::new(entry);
        self.len += 1;
    }

    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Inserts above `bottom`, below the topmost entries for which `above` holds: keeps what lies above `bottom`
    /// sorted, when called for one entry after the other.
    #[inline(always)]
    pub(crate) fn insert(&mut self, bottom: usize, entry: T, above: impl Fn(&T) -> bool) {
        let mut at = self.len;
        while at > bottom {
            // SAFETY: entries below `len` are initialised, and indexing checks the bound.
            let below = unsafe { self.entries[at - 1].assume_init() };
            if !above(&below) {
                break;
            }
            self.entries[at] = MaybeUninit::new(below);
            at -= 1;
        }
        self.entries[at] = MaybeUninit::new(entry);
        self.len += 1;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: `push` initialised every entry below the previous `len`, and indexing checks the bound.
        Some(unsafe { self.entries[self.len].assume_init() })
    }
}
