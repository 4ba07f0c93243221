//! Method of light, layer, exposure and tone map.

use crate::editor::stage::Stage;
use clap::ValueEnum;
use egui::{Slider, Ui};
use lightwell::render::ToneMap;
use lightwell_runtime::cli::{Edges, Only, Switch};

/// Shows the choices. They belong to the window, not to the scene.
pub fn show(ui: &mut Ui, stage: &mut Stage) {
    ui.weak("Choices of this window; the scene's own are under Scene and in its components.");
    let gi = &mut stage.look.gi;
    let methods = stage.facts.methods;
    let chosen = gi.and_then(|gi| methods.iter().find(|method| method.id == gi));
    choice(ui, "Indirect light", chosen.map_or("as the scene asks", |method| method.title), |ui| {
        ui.selectable_value(gi, None, "as the scene asks");
        for method in methods {
            let label = ui.selectable_value(gi, Some(method.id), method.title);
            label.on_hover_text(format!("{} (`--gi {}`)", method.about, method.id.name()).trim_start());
        }
    });
    let only = &mut stage.look.only;
    let shown = word_of(*only);
    choice(ui, "Layer", &shown, |ui| {
        for layer in Only::value_variants() {
            ui.selectable_value(only, *layer, word_of(*layer));
        }
    });
    camera(ui, stage);
    ui.separator();
    super::tracer::error(ui, stage);
    ui.separator();
    let display = &mut *stage.display;
    let response = ui.add(Slider::new(&mut display.exposure, -10.0..=10.0).text("Exposure [stops]").max_decimals(2));
    response.on_hover_text("in stops on top of the exposure of scene and camera; twice as bright each");
    ui.checkbox(&mut display.auto_exposure, "Auto-exposure")
        .on_hover_text("brings the mean of the logarithm of the luminance to middle grey");
    tone_map(ui, &mut display.tone_map);
    let look = &mut *stage.look;
    let mut smooth = !look.no_mlaa;
    ui.checkbox(&mut smooth, "Smooth edges").on_hover_text("smooths edges over frames where those are averaged and nothing is drawn over the picture, or else in each picture by \
         itself (morphological anti-aliasing)");
    look.no_mlaa = !smooth;
    let mut averages = look.average == Some(Switch::On);
    ui.checkbox(&mut averages, "Temporal accumulation").on_hover_text(
        "averages light with that of the frames before, which takes few rays: light that goes is gone within three frames, \
         and a view that rests loses its noise within 64",
    );
    look.average = Some(if averages { Switch::On } else { Switch::Off });
    let shown = word_of(look.mlaa_edges);
    choice(ui, "Edges by", &shown, |ui| {
        for edges in Edges::value_variants() {
            let help = edges.to_possible_value().and_then(|v| v.get_help().map(|h| h.to_string()));
            let label = ui.selectable_value(&mut look.mlaa_edges, *edges, word_of(*edges));
            label.on_hover_text(help.unwrap_or_default());
        }
    });
    if ui.button("Reset").clicked() {
        *display = Default::default();
    }
}

fn tone_map(ui: &mut Ui, chosen: &mut Option<ToneMap>) {
    let shown = chosen.map_or_else(|| "the camera's".to_owned(), |tone_map| format!("{tone_map:?}"));
    choice(ui, "Tone map", &shown, |ui| {
        ui.selectable_value(chosen, None, "the camera's");
        for tone_map in ToneMap::ALL {
            ui.selectable_value(chosen, Some(tone_map), format!("{tone_map:?}"));
        }
    });
}

fn camera(ui: &mut Ui, stage: &mut Stage) {
    let shown = stage.look.camera.clone().unwrap_or_else(|| "the scene's primary".into());
    let scene = stage.facts.scene;
    let chosen = &mut stage.look.camera;
    let before = chosen.clone();
    choice(ui, "Camera", &shown, |ui| {
        ui.selectable_value(chosen, None, "the scene's primary");
        for camera in &scene.cameras {
            ui.selectable_value(chosen, Some(camera.name.clone()), &camera.name);
        }
    });
    if *chosen != before {
        stage.camera.reset();
    }
    if stage.camera.is_free() && ui.button("Back to this camera (C)").clicked() {
        stage.camera.reset();
    }
}

fn choice(ui: &mut Ui, label: &str, shown: &str, entries: impl FnOnce(&mut Ui)) {
    egui::ComboBox::from_label(label).selected_text(shown).show_ui(ui, entries);
}

fn word_of(value: impl ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}
