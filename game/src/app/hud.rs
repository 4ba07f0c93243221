//! Texts over the image.

use bevy_ecs::prelude::{Res, Resource};
use egui::{Align2, Color32, Context, FontId, FullOutput, LayerId, Pos2, RawInput, Rect};
use glam::Vec2;
use lightwell::game::{Draw, Game};
use lightwell::scene::{SceneCamera, SceneView};

/// What is drawn over the image, by systems in [`Update`](lightwell::game::Update). Lengths are percents of the
/// image's height, so that texts look alike at every size.
#[derive(Resource, Clone, Default)]
pub struct Hud {
    context: Context,
    /// What went wrong, until it is mended.
    trouble: Option<String>,
}

/// Size of the image before the window has told it \[pixels\].
const USUAL: [f32; 2] = [960.0, 600.0];

impl Hud {
    /// egui, for windows, buttons and whatever else it can do.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// White text at an edge, a corner or in the middle.
    pub fn text(&self, anchor: Align2, height: f32, text: impl Into<String>) {
        self.text_at(anchor, Vec2::ZERO, height, [1.0; 3], text);
    }

    /// Text of a colour (sRGB, 0 to 1), moved right and down by an offset.
    pub fn text_at(&self, anchor: Align2, offset: Vec2, height: f32, color: [f32; 3], text: impl Into<String>) {
        let (screen, text) = (self.context.content_rect(), text.into());
        let percent = screen.height() / 100.0;
        let [r, g, b] = color.map(|part| (255.0 * part.clamp(0.0, 1.0)).round() as u8);
        let place = anchor.pos_in_rect(&screen.shrink(3.0 * percent)) + egui::vec2(offset.x, offset.y) * percent;
        let (painter, font) = (self.painter(), FontId::proportional(height.max(0.1) * percent));
        // A shadow makes it legible on anything.
        let shadow = egui::Vec2::splat((0.06 * height * percent).max(1.0));
        painter.text(place + shadow, anchor, &text, font.clone(), Color32::from_black_alpha(200));
        painter.text(place, anchor, text, font, Color32::from_rgb(r, g, b));
    }

    /// A bar of a length, filled up to a share (0 to 1).
    pub fn bar(&self, anchor: Align2, offset: Vec2, size: Vec2, share: f32, color: [f32; 3]) {
        let screen = self.context.content_rect();
        let percent = screen.height() / 100.0;
        let [r, g, b] = color.map(|part| (255.0 * part.clamp(0.0, 1.0)).round() as u8);
        let place = anchor.pos_in_rect(&screen.shrink(3.0 * percent)) + egui::vec2(offset.x, offset.y) * percent;
        let whole = anchor.anchor_size(place, egui::vec2(size.x, size.y) * percent);
        let full = Rect::from_min_size(whole.min, whole.size() * egui::vec2(share.clamp(0.0, 1.0), 1.0));
        let painter = self.painter();
        painter.rect_filled(whole.expand(0.3 * percent), 0.4 * percent, Color32::from_black_alpha(160));
        painter.rect_filled(full, 0.3 * percent, Color32::from_rgb(r, g, b));
    }

    /// Darkens the image, 0: not at all, 1: to black.
    pub fn shade(&self, opacity: f32) {
        let alpha = (255.0 * opacity.clamp(0.0, 1.0)).round() as u8;
        self.painter().rect_filled(self.context.viewport_rect(), 0.0, Color32::from_black_alpha(alpha));
    }

    fn painter(&self) -> egui::Painter {
        self.context.layer_painter(LayerId::new(egui::Order::Middle, egui::Id::unique("hud")))
    }

    /// Writes the texts that systems have drawn at places in the world, as a camera sees them.
    pub(super) fn show_drawn_texts(game: &Game, camera: SceneCamera) {
        let ecs = &game.world.ecs;
        let (Some(hud), Some(draw)) = (ecs.get_resource::<Self>(), ecs.get_resource::<Draw>()) else { return };
        let screen = hud.context.viewport_rect();
        let size = [screen.width(), screen.height()].map(|edge| edge.max(1.0) as u32);
        let clip_from_world = SceneView { camera, size, jitter: [0.0; 2] }.clip_from_world();
        let font = FontId::proportional(2.5 * screen.height() / 100.0);
        for text in draw.texts() {
            let clip = clip_from_world * text.at.extend(1.0);
            // Behind the near plane, where depth is 1.
            if clip.w <= 0.0 || clip.z > clip.w {
                continue;
            }
            let share = egui::vec2(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
            let [r, g, b] = text.color.to_array().map(|part| (255.0 * part.clamp(0.0, 1.0)).round() as u8);
            let place = screen.min + share * screen.size();
            hud.painter().text(place, Align2::CENTER_CENTER, &text.text, font.clone(), Color32::from_rgb(r, g, b));
        }
    }

    pub(super) fn set_trouble(&mut self, trouble: Option<String>) {
        self.trouble = trouble;
    }

    /// Lets a game draw into one pass of egui; without input it is one of the usual size.
    pub(super) fn pass<T>(
        game: &mut Game,
        input: Option<RawInput>,
        work: impl FnOnce(&mut Game) -> T,
    ) -> (T, FullOutput) {
        let context = game.world.ecs.get_resource_or_init::<Self>().context.clone();
        let input = input.unwrap_or_else(|| RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, USUAL.into())),
            ..RawInput::default()
        });
        context.begin_pass(input);
        let result = work(game);
        (result, context.end_pass())
    }
}

/// Shows what went wrong, in letters of one width: files are quoted with a mark below the place.
pub(super) fn show_trouble(hud: Res<Hud>) {
    let Some(trouble) = &hud.trouble else { return };
    let screen = hud.context.content_rect();
    let percent = screen.height() / 100.0;
    let painter = hud.painter();
    let font = FontId::monospace((2.0 * percent).max(9.0));
    let text = painter.layout(trouble.clone(), font, Color32::from_rgb(255, 150, 130), screen.width() - 6.0 * percent);
    let place = Align2::LEFT_BOTTOM.anchor_size(screen.shrink(2.0 * percent).left_bottom(), text.size());
    painter.rect_filled(place.expand(percent), 0.5 * percent, Color32::from_black_alpha(210));
    painter.galley(place.min, text, Color32::WHITE);
}
