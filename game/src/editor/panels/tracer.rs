//! The path tracer: the reference beside which all else is an approximation.

use crate::cli::Gi;
use crate::editor::stage::Stage;
use egui::{DragValue, Ui};

/// Shows its state and settings.
pub fn show(ui: &mut Ui, stage: &mut Stage) {
    let is_on = stage.look.gi == Some(Gi::Reference);
    ui.horizontal(|ui| {
        let word = if is_on { "Stop" } else { "Start" };
        if ui.button(word).on_hover_text("shows the path-traced image instead of the drawn one").clicked() {
            stage.look.gi = if is_on { None } else { Some(Gi::Reference) };
            if !is_on {
                // A moving scene starts the image anew with every frame.
                stage.clock.playing = false;
            }
        }
        if let Some(tracing) = stage.facts.tracing {
            let share = tracing.samples as f32 / tracing.target.max(1) as f32;
            ui.add(egui::ProgressBar::new(share).text(format!("{} of {} samples", tracing.samples, tracing.target)));
        }
    });
    let trace = &mut stage.look.trace;
    egui::Grid::new("tracer").show(ui, |ui| {
        ui.label("Samples a pixel");
        ui.add(DragValue::new(&mut trace.spp).range(1..=1 << 24));
        ui.end_row();
        ui.label("Indirect bounces");
        ui.horizontal(|ui| {
            let mut bounded = trace.bounces.is_some();
            if ui.checkbox(&mut bounded, "bounded").changed() {
                trace.bounces = bounded.then_some(3);
            }
            match &mut trace.bounces {
                Some(bounces) => drop(ui.add(DragValue::new(bounces).range(0..=64))),
                None => drop(ui.weak("as many as the light makes")),
            }
        });
        ui.end_row();
        ui.label("Seed");
        ui.add(DragValue::new(&mut trace.seed));
        ui.end_row();
    });
}
