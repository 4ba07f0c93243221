//! The path tracer: the reference beside which all else is an approximation.

use crate::comparison::{LayerError, Mode};
use crate::editor::stage::Stage;
use crate::editor::widgets::named;
use egui::{DragValue, Grid, Slider, Ui};
use lightwell::render::GiMethod;

/// Shows its state and settings.
pub fn show(ui: &mut Ui, stage: &mut Stage) {
    ui.horizontal(|ui| {
        let is_on = stage.comparison.on;
        let help = "traces the view as it stands, beside the method that draws it; every change starts it anew";
        if ui.button(if is_on { "Stop" } else { "Start" }).on_hover_text(help).clicked() {
            start(stage, !is_on);
        }
        if let Some(tracing) = stage.facts.tracing {
            let share = tracing.samples as f32 / tracing.target.max(1) as f32;
            ui.add(egui::ProgressBar::new(share).text(format!("{} of {} samples", tracing.samples, tracing.target)));
        }
    });
    ui.horizontal_wrapped(|ui| {
        for (mode, name, help) in Mode::ALL {
            ui.selectable_value(&mut stage.comparison.mode, mode, name).on_hover_text(help);
        }
    });
    match stage.comparison.mode {
        Mode::Wipe => {
            ui.add(Slider::new(&mut stage.comparison.share, 0.0..=1.0).text("Wipe").max_decimals(2));
        }
        Mode::Difference => {
            let range = 0.01..=10.0;
            let slider = Slider::new(&mut stage.comparison.full, range).logarithmic(true).text("Full colour");
            ui.add(slider).on_hover_text("error shown in full colour, relative to the mean of the reference");
        }
        Mode::Drawn | Mode::Traced => {}
    }
    ui.separator();
    error(ui, stage);
    ui.separator();
    settings(ui, stage);
}

/// Starts or stops. A moving scene starts the image anew with every frame: it is paused.
fn start(stage: &mut Stage, on: bool) {
    stage.comparison.on = on;
    if on {
        stage.clock.playing = false;
        // There is nothing to compare with otherwise.
        stage.look.gi = stage.look.gi.filter(|gi| *gi != GiMethod::REFERENCE);
        if !stage.look.only.is_light() {
            stage.look.only = Default::default();
        }
    }
}

/// The error of the picture against the running reference, by layer.
pub fn error(ui: &mut Ui, stage: &Stage) {
    let Some(error) = stage.facts.live_error else {
        let why = if stage.comparison.on { "The reference begins." } else { "Path tracer ▸ Start measures it." };
        ui.horizontal_wrapped(|ui| {
            ui.label("Error against the running reference:").on_hover_text(ERROR_HELP);
            ui.weak(why);
        });
        return;
    };
    ui.label(format!("Error against {} samples", error.samples)).on_hover_text(ERROR_HELP);
    Grid::new("live error").num_columns(4).show(ui, |ui| {
        ["", "nrmse", "bias", "noise"].into_iter().for_each(|title| drop(ui.weak(title)));
        ui.end_row();
        for (name, layer) in [("indirect", &error.indirect), ("total", &error.total)] {
            ui.label(name);
            numbers(layer).into_iter().for_each(|text| drop(ui.monospace(text)));
            ui.end_row();
        }
    });
}

const ERROR_HELP: &str = "nrmse: root mean square error relative to the mean of the reference, free of the reference's \
    noise; bias: relative error of the mean; noise: of the reference's pixels. On unexposed linear light.";

fn numbers(error: &LayerError) -> [String; 3] {
    let percent = |value: f64| format!("{:.1} %", 100.0 * value);
    [percent(error.nrmse), format!("{:+.1} %", 100.0 * error.bias), percent(error.noise)]
}

fn settings(ui: &mut Ui, stage: &mut Stage) {
    let trace = &mut stage.look.trace;
    Grid::new("tracer").show(ui, |ui| {
        ui.label("Samples a pixel");
        named(&ui.add(DragValue::new(&mut trace.spp).range(1..=1 << 24)), "Samples a pixel");
        ui.end_row();
        ui.label("Indirect bounces");
        ui.horizontal(|ui| {
            let mut bounded = trace.bounces.is_some();
            if ui.checkbox(&mut bounded, "bounded").changed() {
                trace.bounces = bounded.then_some(3);
            }
            match &mut trace.bounces {
                Some(bounces) => named(&ui.add(DragValue::new(bounces).range(0..=64)), "Bounces"),
                None => drop(ui.weak("unbounded")),
            }
        });
        ui.end_row();
        ui.label("Seed");
        named(&ui.add(DragValue::new(&mut trace.seed)), "Seed");
        ui.end_row();
    });
}
