//! Panels that show what goes on, and the choices that change the picture.

mod display;
mod frame;
mod messages;
mod profiler;
pub mod targets;
mod tracer;

use super::Editor;
use super::layout::Pane;
use super::stage::Stage;
use egui::Ui;

/// What the panels remember.
#[derive(Default)]
pub struct State {
    pub(super) profiler: profiler::State,
    pub(super) targets: targets::State,
    filter: String,
    hide: messages::Hide,
    /// Whether videos can be made, once that was asked.
    pub(super) ffmpeg: Option<bool>,
}

/// Shows one panel.
pub fn show(ui: &mut Ui, pane: Pane, editor: &mut Editor, stage: &mut Stage) {
    match pane {
        Pane::Display => display::show(ui, stage),
        Pane::Profiler => profiler::show(ui, editor, stage),
        Pane::Graph => frame::graph(ui, stage),
        Pane::Statistics => frame::statistics(ui, stage),
        Pane::Console => messages::console(ui, editor, stage),
        Pane::Errors => messages::errors(ui, stage),
        Pane::PathTracer => tracer::show(ui, stage),
        Pane::Help => messages::help(ui),
        Pane::Targets => targets::show(ui, editor, stage),
        // These have places of their own.
        Pane::View | Pane::Hierarchy | Pane::Inspector | Pane::Scene => {}
    }
}

/// Whether videos can be made.
pub fn has_ffmpeg() -> bool {
    let asked = std::process::Command::new("ffmpeg").arg("-version").output();
    asked.is_ok_and(|output| output.status.success())
}
