//! Counts of the thesis for its six scenes (Šefčík 2016, table 7.1 and section 7.3.4), and what a frame of ours does in
//! its settings. The counts depend on no machine. Faces of a light that see nothing, or reach no volume, are left out by
//! us and not by the thesis: what that saves is added, and printed.
#![allow(clippy::unwrap_used)]

use clap::Parser;
use lightwell::graph::{Counts, FrameReport, PassState};
use lightwell::scene::{LightShape, SceneView};
use lightwell_needs::needs;
use lightwell_program::cli::{Cli, Command};
use lightwell_runtime::session::Session;

/// A line of the thesis's tables.
struct Line {
    scene: &'static str,
    /// Texels injected into volumes, as light and as blockers.
    injections: u64,
    /// Cells times propagation steps, of all cascades.
    cell_steps: u64,
    /// Views of blockers merged into volumes that held some.
    merges: u64,
}

/// The views of all lights in one cascade.
struct Views {
    all: u64,
    drawn: u64,
    /// Texels of those that are left out.
    texels_saved: u64,
}

fn check(line: &Line) {
    let words = ["lightwell", "render", line.scene, "-o", "unused.png", "--gi", "clpv", "--set", "preset=thesis"];
    let cli = Cli::parse_from(words);
    let Command::Render(arguments) = cli.command else { panic!("not the command that was asked for") };
    let mut session = Session::headless(line.scene, &arguments.look, &cli.common).unwrap_or_else(|e| panic!("{e:#}"));
    // As many pixels as the thesis takes samples of the camera's view.
    let view = SceneView { camera: session.camera().unwrap(), size: [128, 128], jitter: [0.0; 2] };
    let report = session.render(&view, &session.render_settings(false)).unwrap_or_else(|e| panic!("{e:#}"));
    let (sum, cascades) = volumes(&report);
    let views = views(&session, &report);
    let camera = u64::from(session.scene().clpv.as_ref().unwrap().settings.camera_blockers);
    let injections = sum.injections + 2 * cascades * views.texels_saved;
    let merges = cascades * (views.all + camera - 1);
    let cell_steps = counts_of(&report, "propagate, ").cells;
    eprintln!(
        "{}: {} injections, {} saved; {cell_steps} cell-steps; {} merges; {} of {} views",
        line.scene,
        sum.injections,
        injections - sum.injections,
        sum.merges,
        views.drawn,
        views.all
    );
    assert_eq!(injections, line.injections, "injections of {}", line.scene);
    assert_eq!(cell_steps, line.cell_steps, "cell-steps of {}", line.scene);
    assert_eq!(merges, line.merges, "merges of {} with all views", line.scene);
    assert_eq!(sum.merges, cascades * (views.drawn + camera - 1), "merges of {} that ran", line.scene);
}

fn counts_of(report: &FrameReport, prefix: &str) -> Counts {
    let mut sum = Counts::default();
    report.passes.iter().filter(|pass| pass.name.starts_with(prefix)).for_each(|pass| sum += pass.counts);
    sum
}

/// The counts of injection and blockers, and the number of cascades.
fn volumes(report: &FrameReport) -> (Counts, u64) {
    let mut sum = counts_of(report, "inject, ");
    sum += counts_of(report, "blockers");
    let cascades = report.passes.iter().filter(|pass| pass.name.starts_with("inject, ")).count();
    (sum, cascades as u64)
}

/// What the report says was left out: `N of 6 faces …` of each point light, or a whole light.
fn views(session: &Session, report: &FrameReport) -> Views {
    let mut views = Views { all: 0, drawn: 0, texels_saved: 0 };
    for light in session.scene().lights.iter().filter(|light| light.indirect) {
        let all = if light.shape == LightShape::Point { 6 } else { 1 };
        let name = format!("rsm {}", light.name);
        let skipped = |pass: &&lightwell::graph::PassReport| {
            pass.name.starts_with(&name) && matches!(pass.state, PassState::Skipped(_))
        };
        let saved = report.passes.iter().filter(skipped).map(|pass| match &pass.state {
            PassState::Skipped(why) if pass.name.ends_with(", faces") => {
                why.split(' ').next().unwrap().parse::<u64>().expect("the number of faces left out")
            }
            _ => all,
        });
        let saved: u64 = saved.sum();
        views.all += all;
        views.drawn += all - saved;
        views.texels_saved += saved * u64::from(light.rsm_size) * u64::from(light.rsm_size);
    }
    views
}

#[test]
fn cornell() {
    check(&Line { scene: "cornell", injections: 32_768, cell_steps: 7_168, merges: 0 });
}

#[test]
fn bleeding_gloss() {
    check(&Line { scene: "bleeding_gloss", injections: 32_768, cell_steps: 829_440, merges: 0 });
}

#[needs("LIGHTWELL_MODELS")]
fn conference() {
    check(&Line { scene: "conference", injections: 49_152, cell_steps: 86_016, merges: 1 });
}

#[needs("LIGHTWELL_MODELS")]
fn dabrovic() {
    check(&Line { scene: "dabrovic", injections: 294_912, cell_steps: 1_179_648, merges: 6 });
}

#[needs("LIGHTWELL_MODELS")]
fn sibenik() {
    check(&Line { scene: "sibenik", injections: 1_228_800, cell_steps: 1_179_648, merges: 36 });
}

#[needs("LIGHTWELL_MODELS")]
fn sponza() {
    // Seven views of lights and the camera's, in three cascades. The thesis prints no merges for it.
    check(&Line { scene: "sponza", injections: 1_032_192, cell_steps: 1_572_864, merges: 21 });
}
