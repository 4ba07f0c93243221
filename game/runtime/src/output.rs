//! What the program says on its standard output.

use std::fmt::Arguments;
use std::io::Write;

/// Prints a line. A reader that has gone away, such as `head`, is no error.
pub fn line(text: Arguments) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Prints a line as `println!` does, but does not panic when nobody reads it.
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => { $crate::output::line(format_args!($($text)*)) };
}
