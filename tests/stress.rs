//! Invariants of every scene, in the short run of `lightwell stress`.

use lightwell_runtime::cli::Common;
use lightwell_tools::cli::StressArgs;
use std::process::ExitCode;

#[test]
fn a_row_of_each_method_is_within_all_bounds() {
    let folder = tempfile::tempdir().expect("a folder");
    let args =
        StressArgs { output: folder.path().to_owned(), full: false, frames: 0, methods: Vec::new(), endure: None };
    let code = lightwell_tools::stress::run(&args, &Common::default()).expect("a device");
    let table = std::fs::read_to_string(folder.path().join("stress.txt")).expect("the table");
    assert_eq!(format!("{code:?}"), format!("{:?}", ExitCode::SUCCESS), "{table}");
    assert!(folder.path().join("stress.png").exists());
    // Every method was held against what it must hold.
    for method in ["direct", "diffusion", "sweep", "half sweep", "gather", "vpl", "slc", "reference"] {
        assert!(table.contains(method), "{table}");
    }
}
