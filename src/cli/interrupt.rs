//! Ctrl-C and requests to terminate. The only file that names `ctrlc`.

use super::terminal;
use crate::{
    error::{Error, Result},
    output::discard_pending,
    view::restore_terminal,
};
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on, an interrupt removes unfinished files and ends the process at once: loading and building would
/// notice a flag much too late. Must come before the first file is opened.
///
/// # Errors
/// [`Error::Failed`] if the system refuses to install the handler.
pub(super) fn install() -> Result<()> {
    ctrlc::set_handler(|| {
        INTERRUPTED.store(true, Ordering::SeqCst);
        discard_pending();
        restore_terminal();
        terminal::clear_line();
        terminal::complain(&Error::Interrupted);
        exit(Error::Interrupted.exit_code().into());
    })
    .map_err(|error| {
        Error::Failed(format!("the handler for Ctrl-C cannot be installed ({error}); please report this"))
    })
}

/// True once the process is about to end. Whatever fails from then on fails for that reason.
pub(super) fn flag() -> &'static AtomicBool {
    &INTERRUPTED
}
