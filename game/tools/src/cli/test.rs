//! The command line of `test`.

use clap::Args;
use std::path::PathBuf;

const TEST_HELP: &str = "\
A scene test is a file NAME.test.ron: a scene, times, camera, size and settings, and what must hold: golden images,
errors against references, what passes do, counts, equal bits in a second run. No pixel may ever be NaN.

Examples:
  lightwell test                                all tests in tests/scenes
  lightwell test --filter cornell               those with `cornell` in their name
  lightwell test my.test.ron --bless            write its golden images: look at them before they are committed
  lightwell test -o failures --jobs 1           pictures of what fails into failures/, one test at a time

Exit codes: 0 all that ran passed; 1 a test failed or there are none; 2 wrong usage.";

/// Arguments of `test`.
#[derive(Args, Debug)]
#[command(after_help = TEST_HELP)]
pub struct TestArgs {
    /// Scene tests, or folders of them [default: tests/scenes]
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Run only tests with TEXT in their name; may be given many times
    #[arg(short, long, value_name = "TEXT")]
    pub filter: Vec<String>,
    /// List the tests and run none
    #[arg(long)]
    pub list: bool,
    /// Write the golden images that are missing or do not match
    #[arg(long, conflicts_with = "list")]
    pub bless: bool,
    /// Folder for images of what fails
    #[arg(short, long, value_name = "DIR", default_value = "out/tests")]
    pub output: PathBuf,
    /// Number of tests that run side by side [default: by cores and free memory]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroU16>,
}
