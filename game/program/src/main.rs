//! The program `lightwell`.

use std::process::ExitCode;

fn main() -> ExitCode {
    lightwell_program::run()
}
