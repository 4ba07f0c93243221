//! `lightwell test`: runs scene tests.

use crate::cli::TestArgs;
use crate::scene_test::{
    Options, Outcome, Report, SceneTest, TestCase, default_folder, default_workers, discover, run_all, select,
};
use anyhow::Result;
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use lightwell_runtime::say;
use std::process::ExitCode;
use std::time::Instant;

/// Runs the tests and prints what came of them; exit code 1 if one failed.
///
/// # Errors
/// If there are no tests to run.
pub fn run(args: &TestArgs, common: &Common) -> Result<ExitCode> {
    let paths = if args.paths.is_empty() { vec![default_folder()?] } else { args.paths.clone() };
    let cases = select(discover(&paths)?, &args.filter)?;
    if args.list {
        return Ok(list(&cases));
    }
    let options = Options { common: common.clone(), bless: args.bless, output: args.output.clone() };
    let workers = args.jobs.map_or_else(default_workers, |jobs| usize::from(jobs.get()));
    let start = Instant::now();
    let bar = progress::bar(cases.len() as u64, "scene tests");
    let width = cases.iter().map(|case| case.name.chars().count()).max().unwrap_or(0);
    let reports = run_all(&cases, &options, workers, &mut |case, report| {
        bar.suspend(|| print_report(case, report, width));
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(summary(&reports, start))
}

/// Prints name and description of each test; exit code 1 if a file cannot be read.
fn list(cases: &[TestCase]) -> ExitCode {
    let mut code = ExitCode::SUCCESS;
    let width = cases.iter().map(|case| case.name.chars().count()).max().unwrap_or(0);
    for case in cases {
        match SceneTest::read(&case.path) {
            Ok(test) => say!("{:width$}  {}", case.name, test.description),
            Err(error) => {
                say!("{:width$}  error: {error}", case.name);
                code = ExitCode::from(1);
            }
        }
    }
    code
}

fn print_report(case: &TestCase, report: &Report, width: usize) {
    let seconds = report.elapsed.as_secs_f64();
    match &report.outcome {
        Outcome::Passed => say!("ok       {:width$}  {seconds:6.1} s", case.name),
        Outcome::Skipped(reason) => say!("skipped  {:width$}  {seconds:6.1} s  {reason}", case.name),
        Outcome::Failed(faults) => {
            say!("FAILED   {:width$}  {seconds:6.1} s  {}", case.name, case.path.display());
            for fault in faults {
                say!("         - {}", fault.replace('\n', "\n           "));
            }
        }
    }
    for golden in &report.blessed {
        say!("         blessed {}: look at it before it is committed", golden.display());
    }
}

fn summary(reports: &[Report], start: Instant) -> ExitCode {
    let count = |matches: fn(&Outcome) -> bool| reports.iter().filter(|report| matches(&report.outcome)).count();
    let passed = count(|outcome| *outcome == Outcome::Passed);
    let skipped = count(|outcome| matches!(outcome, Outcome::Skipped(_)));
    let failed = count(|outcome| matches!(outcome, Outcome::Failed(_)));
    let blessed: usize = reports.iter().map(|report| report.blessed.len()).sum();
    let blessed = if blessed > 0 { format!(", {blessed} golden images written") } else { String::new() };
    say!("{passed} passed, {failed} failed, {skipped} skipped in {:.1} s{blessed}", start.elapsed().as_secs_f64());
    if failed > 0 { ExitCode::from(1) } else { ExitCode::SUCCESS }
}
