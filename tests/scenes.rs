//! Every scene test in `tests/scenes`, as a test of its own. `lightwell test` runs the same ones.
//!
//! `LIGHTWELL_BLESS=1` writes their golden images. Images of what fails go into `out/tests`. Tests that need models
//! or reference images that are not there are ignored, with the reason; with `LIGHTWELL_REQUIRE=1` they fail.

use libtest_mimic::{Arguments, Completion, Failed, Trial};
use lightwell_runtime::cli::Common;
use lightwell_tests::root;
use lightwell_tools::scene_test::{Options, Outcome, Report, TestCase, default_workers, discover, run};
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    // Each test has a device of its own: memory counts as well as cores.
    arguments.test_threads = arguments.test_threads.or_else(|| Some(default_workers()));
    let options = Options {
        common: Common { models: std::env::var_os("LIGHTWELL_MODELS").map(Into::into), ..Common::default() },
        bless: std::env::var_os("LIGHTWELL_BLESS").is_some(),
        output: root().join("out/tests"),
    };
    match discover(&[root().join("tests/scenes")]) {
        Ok(cases) => {
            let mut trials: Vec<Trial> = cases.iter().map(|case| trial(case.clone(), options.clone())).collect();
            trials.push(Trial::test("every_golden_image_has_its_test", move || no_stray_goldens(&cases)));
            libtest_mimic::run(&arguments, trials).exit_code()
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn trial(case: TestCase, options: Options) -> Trial {
    let is_required = std::env::var_os("LIGHTWELL_REQUIRE").is_some_and(|value| value == "1");
    Trial::ignorable_test(case.name.clone(), move || {
        let Report { outcome, blessed, .. } = run(&case, &options, &mut None);
        for golden in blessed {
            eprintln!("blessed {}: look at it before it is committed", golden.display());
        }
        match outcome {
            Outcome::Passed => Ok(Completion::Completed),
            Outcome::Skipped(reason) if is_required => Err(Failed::from(format!("LIGHTWELL_REQUIRE=1, but {reason}"))),
            Outcome::Skipped(reason) => Ok(Completion::ignored_with(reason)),
            Outcome::Failed(faults) => Err(Failed::from(faults.join("\n"))),
        }
    })
}

/// A golden image that no test looks at is one that nobody checks.
fn no_stray_goldens(cases: &[TestCase]) -> Result<(), Failed> {
    let mut known = Vec::new();
    for case in cases {
        let test = lightwell_tools::scene_test::SceneTest::read(&case.path)?;
        known.extend(test.golden_times().map(|time| case.golden(time)));
    }
    let folders: std::collections::BTreeSet<_> = cases.iter().map(|case| case.folder().join("goldens")).collect();
    let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
    let strays: Vec<String> =
        files.map(|file| file.path()).filter(|path| !known.contains(path)).map(|p| p.display().to_string()).collect();
    if strays.is_empty() { Ok(()) } else { Err(format!("no scene test looks at {}", strays.join(", ")).into()) }
}
