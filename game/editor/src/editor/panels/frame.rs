//! What a frame did: passes, resources, numbers.

use crate::editor::stage::Stage;
use egui::{RichText, Ui};
use lightwell::graph::{FrameReport, PassState};

/// The passes with their state and why, then the resources.
pub fn graph(ui: &mut Ui, stage: &Stage) {
    let report = stage.facts.report;
    egui::Grid::new("passes").striped(true).show(ui, |ui| {
        for word in ["pass", "state", "GPU [ms]", "CPU [ms]", "why", "work"] {
            ui.strong(word);
        }
        ui.end_row();
        for pass in &report.passes {
            let ran = pass.state == PassState::Ran;
            let text = |text: String| if ran { RichText::new(text) } else { RichText::new(text).weak() };
            ui.label(text(pass.name.clone()));
            ui.label(text(pass.state.to_string()));
            ui.label(text(pass.gpu_ms.map_or(String::new(), |ms| format!("{ms:.3}"))));
            ui.label(text(if ran { format!("{:.3}", pass.cpu_ms) } else { String::new() }));
            ui.label(text(pass.why.clone()));
            ui.label(text(pass.counts.to_string()));
            ui.end_row();
        }
    });
    ui.separator();
    resources(ui, report);
}

fn resources(ui: &mut Ui, report: &FrameReport) {
    egui::Grid::new("resources").striped(true).show(ui, |ui| {
        for word in ["resource", "what", "KiB", "kept", "shares memory with"] {
            ui.strong(word);
        }
        ui.end_row();
        for resource in &report.resources {
            ui.label(&resource.name);
            ui.label(resource.desc.to_string());
            ui.label(format!("{:.1}", resource.bytes as f64 / 1024.0));
            ui.label(match (resource.retained, resource.imported) {
                (true, _) => "over frames",
                (_, true) => "by the caller",
                _ => "",
            });
            ui.label(resource.aliased_with.join(", "));
            ui.end_row();
        }
    });
}

/// Numbers of the scene and of the frame.
pub fn statistics(ui: &mut Ui, stage: &Stage) {
    let (scene, report) = (stage.facts.scene, stage.facts.report);
    let triangles: usize = scene.primitives.iter().map(|p| p.mesh.indices.len() / 3).sum();
    let particles: usize = scene.primitives.iter().filter_map(|p| p.mesh.balls.as_ref()).map(|balls| balls.len()).sum();
    let mebibytes = |bytes: u64| format!("{:.1} MiB", bytes as f64 / (1 << 20) as f64);
    let bounds = scene.bounds();
    let size = if bounds.is_empty() { "nothing".into() } else { format!("{:.2} m", bounds.size()) };
    let mut rows = vec![
        ("adapter", stage.facts.adapter.to_owned()),
        ("image", format!("{} × {}", stage.facts.image_size[0], stage.facts.image_size[1])),
        ("primitives", scene.primitives.len().to_string()),
        ("triangles", triangles.to_string()),
        ("lights", scene.lights.len().to_string()),
        ("fog", scene.media.len().to_string()),
        ("particles", particles.to_string()),
        ("cameras", scene.cameras.len().to_string()),
        ("size of the scene", size),
        ("passes that ran", format!("{} of {}", report.ran_count(), report.passes.len())),
        ("submits", report.submits.to_string()),
        ("GPU time", report.gpu_ms().map_or("not measured".into(), |ms| format!("{ms:.2} ms"))),
        ("memory of targets", mebibytes(report.allocated_bytes)),
        ("kept targets", format!("{} ({})", report.cache.retained, mebibytes(report.cache.retained_bytes))),
        ("shared memory", format!("{} ({})", report.cache.pooled, mebibytes(report.cache.pooled_bytes))),
    ];
    rows.extend(report.total().named().into_iter().filter(|(_, n)| *n > 0).map(|(name, n)| (name, n.to_string())));
    egui::Grid::new("statistics").striped(true).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        }
    });
}
