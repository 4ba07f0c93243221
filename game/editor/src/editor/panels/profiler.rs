//! Where the time of frames goes: history, flame view, table, export.

use crate::editor::Editor;
use crate::editor::stage::Stage;
use egui::{Color32, Rect, Sense, Stroke, Ui, pos2, vec2};
use lightwell::profile::{Frame, Profiler, chrome_trace};
use std::path::{Path, PathBuf};

/// What the panel remembers.
#[derive(Debug)]
pub struct State {
    /// Frames that are shown while they are frozen.
    frozen: Option<Vec<Frame>>,
    /// The frame that is shown, counted from the newest.
    chosen: usize,
    /// Where traces are written.
    pub folder: PathBuf,
}

impl Default for State {
    fn default() -> Self {
        Self { frozen: None, chosen: 0, folder: "out".into() }
    }
}

/// Shows the panel.
pub fn show(ui: &mut Ui, editor: &mut Editor, stage: &Stage) {
    let state = &mut editor.panels.profiler;
    let live = stage.facts.profiler;
    let mut notice = None;
    ui.horizontal(|ui| {
        let mut frozen = state.frozen.is_some();
        if ui.checkbox(&mut frozen, "Freeze").changed() {
            state.frozen = frozen.then(|| live.frames().cloned().collect());
            state.chosen = 0;
        }
        if ui.button("Export").on_hover_text("as a Chrome trace, for chrome://tracing or ui.perfetto.dev").clicked() {
            let frames = state.frozen.clone().unwrap_or_else(|| live.frames().cloned().collect());
            notice = Some(export(&state.folder, &frames));
        }
        if let Some(s) = live.frame_statistics() {
            ui.monospace(format!("median {:.2} ms, {:.2} to {:.2}, {} frames", s.median, s.min, s.max, s.frames));
        }
    });
    let frames: Vec<&Frame> = match &state.frozen {
        Some(frames) => frames.iter().collect(),
        None => live.frames().collect(),
    };
    history(ui, &frames, &mut state.chosen);
    let Some(frame) = frames.len().checked_sub(state.chosen + 1).and_then(|i| frames.get(i)) else { return };
    flames(ui, frame);
    table(ui, frame, live);
    match notice {
        Some(Ok(path)) => editor.tell(format!("wrote {path}"), false),
        Some(Err(error)) => editor.tell(format!("no trace was written: {error}"), true),
        None => {}
    }
}

/// A bar a frame, the newest on the right; a click chooses one.
fn history(ui: &mut Ui, frames: &[&Frame], chosen: &mut usize) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width().max(100.0), 48.0), Sense::click());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, Color32::from_black_alpha(110));
    let longest = frames.iter().map(|f| f.duration).fold(1e-3, f64::max);
    let width = rect.width() / lightwell::profile::FRAMES as f32;
    for (index, frame) in frames.iter().rev().enumerate() {
        let right = rect.right() - index as f32 * width;
        let height = (frame.duration / longest) as f32 * rect.height();
        let color = if index == *chosen { Color32::from_rgb(255, 170, 60) } else { Color32::from_rgb(110, 170, 220) };
        let bar = Rect::from_min_max(pos2(right - width.max(1.0), rect.bottom() - height), pos2(right, rect.bottom()));
        painter.rect_filled(bar, 0.0, color);
    }
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
        *chosen = (((rect.right() - at.x) / width) as usize).min(frames.len().saturating_sub(1));
    }
    crate::editor::widgets::named(&response, "Frames");
    response.on_hover_text(format!("longest: {longest:.2} ms; click on a frame to see it below"));
}

/// CPU spans by their depth; below them the GPU's, one after the other.
fn flames(ui: &mut Ui, frame: &Frame) {
    const ROW: f32 = 18.0;
    let (gpu, cpu): (Vec<_>, Vec<_>) = frame.spans.iter().partition(|s| s.path.starts_with("gpu/"));
    let depth = cpu.iter().map(|s| s.depth + 1).max().unwrap_or(0);
    let total_gpu: f64 = gpu.iter().map(|s| s.duration).sum();
    let longest = frame.duration.max(total_gpu).max(1e-6);
    let rows = depth + usize::from(!gpu.is_empty());
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width().max(100.0), ROW * rows as f32 + 2.0), Sense::hover());
    let painter = ui.painter_at(rect);
    let mut hovered = None;
    let pointer = response.hover_pos();
    let mut bar = |row: usize, start: f64, length: f64, name: &str| {
        let x = |t: f64| rect.left() + (t / longest) as f32 * rect.width();
        let top = rect.top() + row as f32 * ROW;
        let area =
            Rect::from_min_max(pos2(x(start), top), pos2(x(start + length).max(x(start) + 1.0), top + ROW - 1.0));
        painter.rect_filled(area, 1.0, color_of(name));
        painter.rect_stroke(area, 1.0, Stroke::new(0.5, Color32::BLACK), egui::StrokeKind::Inside);
        let short = name.rsplit('/').next().unwrap_or(name);
        if area.width() > 7.0 * short.len() as f32 {
            let font = egui::FontId::proportional(11.0);
            painter.text(area.left_center() + vec2(3.0, 0.0), egui::Align2::LEFT_CENTER, short, font, Color32::BLACK);
        }
        if pointer.is_some_and(|at| area.contains(at)) {
            hovered = Some(format!("{name}: {length:.3} ms"));
        }
    };
    cpu.iter().for_each(|span| bar(span.depth, span.start, span.duration, &span.path));
    let mut at = 0.0;
    for span in gpu {
        bar(depth, at, span.duration, &span.path);
        at += span.duration;
    }
    if let Some(text) = hovered {
        response.on_hover_text_at_pointer(text);
    }
}

fn color_of(name: &str) -> Color32 {
    let hash = name.bytes().fold(7u32, |h, b| h.wrapping_mul(31).wrapping_add(u32::from(b)));
    egui::ecolor::Hsva::new((hash % 360) as f32 / 360.0, 0.45, 0.85, 1.0).into()
}

fn table(ui: &mut Ui, frame: &Frame, profiler: &Profiler) {
    egui::Grid::new("spans").striped(true).show(ui, |ui| {
        for word in ["span", "this frame [ms]", "median [ms]", "longest [ms]"] {
            ui.strong(word);
        }
        ui.end_row();
        for span in &frame.spans {
            let name = span.path.rsplit('/').next().unwrap_or(&span.path);
            ui.label(format!("{}{name}", "    ".repeat(span.depth)));
            ui.monospace(format!("{:8.3}", span.duration));
            if let Some(s) = profiler.statistics(&span.path) {
                ui.monospace(format!("{:8.3}", s.median));
                ui.monospace(format!("{:8.3}", s.max));
            }
            ui.end_row();
        }
    });
}

fn export(folder: &Path, frames: &[Frame]) -> std::io::Result<String> {
    std::fs::create_dir_all(folder)?;
    let path = folder.join("profile.json");
    std::fs::write(&path, chrome_trace(frames))?;
    Ok(path.display().to_string())
}
