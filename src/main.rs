//! The program.

use std::process::ExitCode;

fn main() -> ExitCode {
    biotope::cli::main()
}
