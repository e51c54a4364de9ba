//! The `irt` command.

fn main() -> std::process::ExitCode {
    irt::cli::main()
}
