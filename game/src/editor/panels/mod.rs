//! Panels that show what goes on, and the choices that change the picture.

mod display;
mod frame;
mod messages;
mod profiler;
mod tracer;

use super::Editor;
use super::layout::Pane;
use super::stage::Stage;
use egui::Ui;
use std::sync::LazyLock;

/// What the panels remember.
#[derive(Debug, Default)]
pub struct State {
    profiler: profiler::State,
    filter: String,
    hide: messages::Hide,
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
        Pane::View | Pane::Hierarchy | Pane::Inspector | Pane::Scene | Pane::Targets => {}
    }
}

/// Whether videos can be made.
pub fn has_ffmpeg() -> bool {
    static FOUND: LazyLock<bool> = LazyLock::new(|| {
        let asked = std::process::Command::new("ffmpeg").arg("-version").output();
        asked.is_ok_and(|output| output.status.success())
    });
    *FOUND
}
