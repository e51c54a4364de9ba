//! The `irt` command.
fn main() {}
