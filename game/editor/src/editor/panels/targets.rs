//! Images that passes made: any target that is kept, by channel, range, mip level and slice.

use crate::editor::Editor;
use crate::editor::stage::{Request, Stage};
use egui::{Color32, ColorImage, DragValue, TextureHandle, TextureOptions, Ui};
use lightwell::gpu::ImageF32;
use lightwell::graph::ResourceDesc;
use lightwell::render::debug::ShownTarget;

/// Which channels are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Red, green and blue as colours.
    #[default]
    Color,
    /// One of the four, in grey.
    One(usize),
}

/// What is asked to be shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// Name of the target.
    pub name: String,
    /// Mip level.
    pub mip: u32,
    /// Layer of an array or slice of a volume.
    pub layer: u32,
}

/// What the panel remembers.
#[derive(Default)]
pub struct State {
    choice: Choice,
    channel: Channel,
    /// Values that become black and white; none: the least and the largest.
    range: Option<[f32; 2]>,
    image: Option<ImageF32>,
    /// What is wrong with the choice.
    error: Option<String>,
    texture: Option<TextureHandle>,
    live: bool,
    in_view: bool,
}

impl Editor {
    /// The image of the target that was asked for, or why there is none.
    pub fn set_target(&mut self, result: Result<ImageF32, String>) {
        let state = &mut self.panels.targets;
        state.texture = None;
        match result {
            Ok(image) => (state.image, state.error) = (Some(image), None),
            Err(error) => (state.image, state.error) = (None, Some(error)),
        }
    }
}

impl State {
    /// What is to be shown in the place of the picture.
    pub fn in_view(&self) -> Option<&TextureHandle> {
        self.texture.as_ref().filter(|_| self.in_view)
    }

    /// The choice as a tile over the view.
    fn shown(&self) -> ShownTarget {
        let channel = match self.channel {
            Channel::Color => None,
            Channel::One(index) => Some(index as u8),
        };
        let Choice { name, mip, layer } = self.choice.clone();
        ShownTarget { name, slice: layer, mip, channel, range: self.range }
    }
}

/// Shows the panel.
pub fn show(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let before = editor.panels.targets.choice.clone();
    let mut again = false;
    ui.horizontal_wrapped(|ui| again = controls(ui, &mut editor.panels.targets, stage));
    laid_over(ui, &editor.panels.targets, stage);
    let state = &mut editor.panels.targets;
    if state.choice != before || again || state.live && !state.choice.name.is_empty() {
        editor.requests.push(Request::Target(state.choice.clone()));
    }
    if let Some(error) = &state.error {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
    let Some(image) = &state.image else {
        ui.weak("Choose a target.");
        return;
    };
    let [low, high] = state.range.unwrap_or_else(|| extent(image, state.channel));
    ui.monospace(format!("{} × {}, shown from {low:.5} to {high:.5}", image.width, image.height));
    let texture = state.texture.get_or_insert_with(|| {
        let picture = picture(image, state.channel, [low, high]);
        ui.ctx().load_texture("target", picture, TextureOptions::NEAREST)
    });
    let size = texture.size_vec2();
    let scale = (ui.available_width() / size.x).clamp(0.1, 16.0);
    let response = ui.image((texture.id(), size * scale));
    if let Some(at) = response.hover_pos() {
        let texel = ((at - response.rect.min) / scale).floor();
        let index = texel.y as usize * image.width as usize + texel.x as usize;
        if let Some(value) = image.rgba.get(index) {
            response.on_hover_text_at_pointer(format!("({}, {}): {value:?}", texel.x, texel.y));
        }
    }
}

/// Whether the image is to be read again.
fn controls(ui: &mut Ui, state: &mut State, stage: &Stage) -> bool {
    let textures = stage.facts.report.resources.iter().filter(|r| r.retained);
    let textures: Vec<_> = textures
        .filter_map(|r| match &r.desc {
            ResourceDesc::Texture(desc) => Some((&r.name, desc, r.desc.to_string())),
            ResourceDesc::Buffer(_) => None,
        })
        .collect();
    let shown = if state.choice.name.is_empty() { "none" } else { &state.choice.name };
    egui::ComboBox::from_label("Target").selected_text(shown.to_owned()).height(320.0).show_ui(ui, |ui| {
        for (name, _, what) in &textures {
            let entry = ui.selectable_label(state.choice.name == **name, *name).on_hover_text(what);
            if entry.clicked() {
                state.choice = Choice { name: (*name).clone(), mip: 0, layer: 0 };
            }
        }
    });
    if let Some((_, desc, _)) = textures.iter().find(|(name, ..)| **name == state.choice.name) {
        let mips = DragValue::new(&mut state.choice.mip).range(0..=desc.mips.saturating_sub(1));
        crate::editor::widgets::named(&ui.add(mips.prefix("mip ")), "Mip level");
        let slices = DragValue::new(&mut state.choice.layer).range(0..=desc.size[2].saturating_sub(1));
        crate::editor::widgets::named(&ui.add(slices.prefix("slice ")), "Slice");
    }
    let before = (state.channel, state.range);
    ui.selectable_value(&mut state.channel, Channel::Color, "rgb");
    for (index, name) in ["r", "g", "b", "a"].into_iter().enumerate() {
        ui.selectable_value(&mut state.channel, Channel::One(index), name);
    }
    let mut fixed = state.range.is_some();
    if ui.checkbox(&mut fixed, "range").on_hover_text("values that become black and white").changed() {
        let now = state.image.as_ref().map_or([0.0, 1.0], |image| extent(image, state.channel));
        state.range = fixed.then_some(now);
    }
    if let Some(range) = &mut state.range {
        range.iter_mut().for_each(|end| drop(ui.add(DragValue::new(end).speed(0.01))));
    }
    if (state.channel, state.range) != before {
        state.texture = None;
    }
    ui.checkbox(&mut state.live, "live").on_hover_text("reads it back with every frame");
    ui.checkbox(&mut state.in_view, "in the view").on_hover_text("shows it in the place of the picture");
    ui.button("Read again").clicked()
}

/// The targets that are laid side by side over the view, and a button for the chosen one.
fn laid_over(ui: &mut Ui, state: &State, stage: &mut Stage) {
    ui.horizontal_wrapped(|ui| {
        let targets = &mut stage.look.debug.targets;
        if !state.choice.name.is_empty() && ui.button("Lay over the view").clicked() {
            let target = state.shown();
            targets.retain(|other| *other != target);
            targets.push(target);
        }
        let before = targets.len();
        targets.retain(|target| {
            let button = ui.button(format!("{target} ✖")).on_hover_text("takes it away from the view");
            !button.clicked()
        });
        if before > 1 && ui.button("None").clicked() {
            targets.clear();
        }
    });
}

/// The least and the largest value.
fn extent(image: &ImageF32, channel: Channel) -> [f32; 2] {
    let values = |texel: &[f32; 4]| match channel {
        Channel::Color => texel[..3].to_vec(),
        Channel::One(index) => vec![texel[index]],
    };
    let finite = image.rgba.iter().flat_map(values).filter(|v| v.is_finite());
    let [low, high] = finite.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    if low <= high { [low, high] } else { [0.0, 1.0] }
}

/// As a picture; what is not finite is magenta.
fn picture(image: &ImageF32, channel: Channel, [low, high]: [f32; 2]) -> ColorImage {
    let byte = |v: f32| (((v - low) / (high - low).max(1e-30)).clamp(0.0, 1.0) * 255.0).round() as u8;
    let color = |texel: &[f32; 4]| {
        let [r, g, b] = match channel {
            Channel::Color => [texel[0], texel[1], texel[2]],
            Channel::One(index) => [texel[index]; 3],
        };
        match [r, g, b].iter().all(|v| v.is_finite()) {
            true => Color32::from_rgb(byte(r), byte(g), byte(b)),
            false => Color32::from_rgb(255, 0, 255),
        }
    };
    let pixels = image.rgba.iter().map(color).collect();
    ColorImage::new([image.width as usize, image.height as usize], pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_grey_over_their_range() {
        let rgba = vec![[1.0, 5.0, 0.0, 1.0], [3.0, 5.0, 0.0, 1.0], [f32::NAN, 5.0, 0.0, 1.0]];
        let image = ImageF32 { width: 3, height: 1, rgba };
        assert_eq!(extent(&image, Channel::One(0)), [1.0, 3.0]);
        let picture = picture(&image, Channel::One(0), [1.0, 3.0]);
        let magenta = Color32::from_rgb(255, 0, 255);
        assert_eq!(picture.pixels, [Color32::from_gray(0), Color32::from_gray(255), magenta]);
        assert_eq!(extent(&ImageF32 { width: 0, height: 0, rgba: Vec::new() }, Channel::Color), [0.0, 1.0]);
    }
}
