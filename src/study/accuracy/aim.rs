//! Leaks and self-hits of ways to trace, on the closed meshes of the stability battery: once for all scenes.

use super::modes::Mode;
use crate::{
    error::Result,
    kernels::{Isa, Visibility},
    render::{RenderOptions, choose_kernels},
    study::stability::{Aimed, Kernel, aimed},
    trace::KernelChoice,
};
use std::sync::atomic::{AtomicBool, Ordering};

type Way = (Option<Isa>, Visibility, KernelChoice);

/// What was found so far.
pub struct Battery<'a> {
    cancel: &'a AtomicBool,
    found: Vec<(Way, Aimed)>,
}

impl<'a> Battery<'a> {
    /// Nothing is found yet; once `cancel` is true, nothing will be.
    pub fn new(cancel: &'a AtomicBool) -> Battery<'a> {
        Battery { cancel, found: vec![] }
    }

    /// Aims at the closed meshes as a mode would, or remembers it; `None` for modes that hit by no other way.
    ///
    /// # Errors
    /// As [`aimed`].
    pub fn aim(
        &mut self,
        mode: Mode,
        options: &RenderOptions,
        amounts: [u64; 2],
        threads: usize,
    ) -> Result<Option<Aimed>> {
        if !matches!(mode, Mode::Default | Mode::Visibility(_) | Mode::Kernel(_) | Mode::Isa(_)) {
            return Ok(None);
        }
        let RenderOptions { isa, visibility, kernel, .. } = mode.options(options);
        // What packets are given up for are flights, which streams have, too.
        let kernel = if kernel == KernelChoice::Auto { KernelChoice::Tile } else { kernel };
        let way = (isa, visibility, kernel);
        if let Some((_, known)) = self.found.iter().find(|(known, _)| *known == way) {
            return Ok(Some(*known));
        }
        let ways: &[Kernel] = match kernel {
            KernelChoice::Single => &[Kernel::Flight],
            _ => &[Kernel::Tile, Kernel::Stream, Kernel::ShadowStream],
        };
        let kernels = choose_kernels(isa)?.with_visibility(visibility);
        let found = aimed(kernels, ways, amounts, threads, &|| self.cancel.load(Ordering::SeqCst))?;
        self.found.push((way, found));
        Ok(Some(found))
    }
}
