//! The picture: camera by mouse and keys, selection by click, handles.

use super::Editor;
use super::camera::Pose;
use super::commands::relative_to;
use super::gizmo::{self, Lens};
use super::stage::{Request, Stage};
use crate::comparison::Mode;
use bevy_ecs::prelude::{Component, Entity, With};
use egui::{Color32, CornerRadius, CursorIcon, Key, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui, pos2};
use glam::{Affine3A, DVec3, Vec3};
use lightwell::files;
use lightwell::scene::{Aabb, SceneCamera, SceneId, ViewProjection};
use lightwell::world::{Camera, Fog, GameWorld, GlobalTransform, Light, MeshRenderer, Particles};
use lightwell_runtime::window::Area;

/// What the view remembers.
#[derive(Debug)]
pub struct View {
    /// Which handle is shown.
    pub mode: gizmo::Mode,
    /// Handles along the entity's own axes.
    pub local: bool,
    /// Handles move in steps.
    pub snap: bool,
    /// The drag of a handle that goes on.
    pub drag: Option<gizmo::Drag>,
    /// Whether the view was shown in this frame.
    pub is_shown: bool,
    /// Size that the image should have \[pixels\].
    pub size: [u32; 2],
    /// Speed of flight relative to the scene's setting.
    pub flight_speed: f32,
    /// Places of the camera that were kept.
    pub bookmarks: [Option<Pose>; 4],
    /// Shows signs where lights, cameras, fog and particles stand.
    pub signs: bool,
    /// Whether a game that plays is to have mouse and keyboard, and whether it has.
    pub takes_input: bool,
    pub has_input: bool,
    /// Whether it had them when the view was shown last, and the view the focus for it.
    pub holds_focus: bool,
    /// What the egui of that game is to be told.
    pub forwarded: Vec<egui::Event>,
    /// Where the view lies in the window \[points\].
    rect: Rect,
}

impl View {
    /// Where the view lies in the window, with so many pixels a point.
    pub fn area(&self, scale: f32) -> Area {
        let pixels = |v: egui::Vec2| [v.x * scale, v.y * scale];
        Area { min: pixels(self.rect.min.to_vec2()), size: pixels(self.rect.size()) }
    }
}

impl Default for View {
    fn default() -> Self {
        Self {
            mode: gizmo::Mode::Move,
            local: false,
            snap: false,
            drag: None,
            is_shown: false,
            size: [0; 2],
            flight_speed: 1.0,
            bookmarks: [None; 4],
            signs: true,
            takes_input: false,
            has_input: false,
            holds_focus: false,
            forwarded: Vec::new(),
            rect: Rect::NOTHING,
        }
    }
}

/// Distance at which a click still hits a sign \[points\].
const NEAR: f32 = 10.0;

/// Shows the picture.
pub fn show(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max([16.0; 2].into()), Sense::click_and_drag());
    super::widgets::named(&response, "Picture");
    editor.view.is_shown = true;
    editor.view.rect = rect;
    super::playing::capture(ui, editor, stage, &response);
    let scale = ui.ctx().pixels_per_point();
    editor.view.size = [rect.width(), rect.height()].map(|edge| (edge * scale).round().max(1.0) as u32);
    let painter = ui.painter_at(rect);
    match stage.facts.image {
        Some(image) => {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(image, rect, whole, Color32::WHITE);
        }
        None => {
            painter.rect_filled(rect, CornerRadius::ZERO, Color32::BLACK);
            let (text, font) = ("The first picture is being drawn…", egui::FontId::proportional(16.0));
            painter.text(rect.center(), egui::Align2::CENTER_CENTER, text, font, Color32::GRAY);
        }
    }
    super::playing::over_view(&painter, editor, stage, rect);
    target(&painter, editor, rect);
    let Some(scene_camera) = stage.facts.scene_camera.clone() else {
        painter.text(
            rect.center(),
            egui::Align2::CENTER_CENTER,
            "The scene has no camera: Add ▸ Camera",
            egui::FontId::proportional(16.0),
            Color32::WHITE,
        );
        return;
    };
    if editor.view.has_input {
        return;
    }
    fly(ui, editor, stage, &scene_camera, &response);
    let lens = Lens::new(&stage.camera.apply(&scene_camera), rect);
    if editor.hidden {
        look(ui, stage, &scene_camera, &response);
        return;
    }
    bounds(&painter, editor, stage, &lens);
    super::fog::show(&painter, editor, stage, &lens);
    let signs = signs(&painter, editor, stage, &lens);
    let wiping = wipe(ui, stage, rect);
    let held = wiping || gizmo::show(ui, &painter, editor, stage, &lens, &response);
    if !held {
        look(ui, stage, &scene_camera, &response);
        click(ui, editor, stage, rect, &response, &signs);
    }
}

/// The target that was chosen, in the place of the picture: as large as it fits.
fn target(painter: &egui::Painter, editor: &Editor, rect: Rect) {
    let Some(texture) = editor.panels.targets.in_view() else { return };
    let size = texture.size_vec2();
    let scale = (rect.size() / size).min_elem();
    painter.rect_filled(rect, CornerRadius::ZERO, Color32::BLACK);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(texture.id(), Rect::from_center_size(rect.center(), size * scale), whole, Color32::WHITE);
}

/// The line between the drawn and the path-traced picture, which can be dragged; whether it is held.
fn wipe(ui: &Ui, stage: &mut Stage, rect: Rect) -> bool {
    if !stage.comparison.on || stage.comparison.mode != Mode::Wipe {
        return false;
    }
    let x = rect.left() + stage.comparison.share * rect.width();
    let grip = Rect::from_center_size(pos2(x, rect.center().y), [12.0, rect.height()].into());
    let response =
        ui.interact(grip, ui.scope_id().with("wipe"), Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
    super::widgets::named(&response, "Wipe line");
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        stage.comparison.share = ((at.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
    let painter = ui.painter_at(rect);
    painter.vline(x, rect.y_range(), Stroke::new(3.0, Color32::from_black_alpha(120)));
    painter.vline(x, rect.y_range(), Stroke::new(1.0, Color32::WHITE));
    let label = |dx: f32, align, text: &str| {
        let at = pos2(x + dx, rect.top() + 8.0);
        let galley = painter.layout_no_wrap(text.to_owned(), egui::FontId::proportional(13.0), Color32::WHITE);
        let place = egui::Align2([align, egui::Align::TOP]).anchor_size(at, galley.size());
        painter.rect_filled(place.expand(3.0), 3.0, Color32::from_black_alpha(140));
        painter.galley(place.min, galley, Color32::WHITE);
    };
    label(-8.0, egui::Align::Max, "drawn");
    label(8.0, egui::Align::Min, "path traced");
    response.dragged() || response.hovered()
}

/// Looks around by drags.
fn look(ui: &Ui, stage: &mut Stage, camera: &SceneCamera, response: &Response) {
    let drag = response.drag_delta();
    if drag == egui::Vec2::ZERO {
        return;
    }
    let by = [drag.x, drag.y];
    if response.dragged_by(PointerButton::Primary) {
        stage.camera.look(camera, by);
    } else if response.dragged_by(PointerButton::Secondary) {
        let distance = orbit_distance(stage, camera);
        stage.camera.orbit(camera, by, distance);
    } else if response.dragged_by(PointerButton::Middle) {
        let seen = stage.camera.apply(camera);
        let step = match seen.is_orthographic() {
            true => 2.0 * seen.half_height() / response.rect.height().max(1.0),
            false => orbit_distance(stage, camera) * 0.0015,
        };
        stage.camera.fly(camera, Vec3::new(-by[0] * step, by[1] * step, 0.0));
    }
    ui.ctx().request_repaint();
}

/// Flies by keys.
fn fly(ui: &Ui, editor: &mut Editor, stage: &mut Stage, camera: &SceneCamera, response: &Response) {
    if ui.ctx().egui_wants_keyboard_input() || editor.dialog.is_some() {
        return;
    }
    let (direction, elapsed) = ui.input(|i| {
        let free = i.modifiers.is_none() || i.modifiers.shift_only();
        let down = |key| f32::from(u8::from(free && i.key_down(key)));
        let axis = |plus, minus| down(plus) - down(minus);
        let direction = Vec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::S, Key::W));
        (direction, i.stable_dt.min(0.1))
    });
    if response.hovered() {
        let turn = ui.input(|i| i.smooth_scroll_delta.y) / 40.0;
        let seen = stage.camera.apply(camera);
        if !seen.is_orthographic() {
            editor.view.flight_speed = (editor.view.flight_speed * 1.2f32.powf(turn)).clamp(0.01, 100.0);
        } else if turn != 0.0 {
            stage.camera.set_height(2.0 * seen.half_height() * 1.2f32.powf(-turn));
        }
    }
    if direction != Vec3::ZERO {
        let settings = stage.world.ecs.get_resource::<lightwell::world::SceneSettings>();
        let speed = settings.map_or(3.0, |s| s.move_speed) * editor.view.flight_speed;
        stage.camera.fly(camera, direction.normalize() * speed * elapsed);
        ui.ctx().request_repaint();
    }
}

/// Distance of the point that is orbited: where the scene's middle lies along the view direction \[m\].
fn orbit_distance(stage: &Stage, camera: &SceneCamera) -> f32 {
    let view = stage.camera.apply(camera).world_from_view;
    let bounds = stage.facts.scene.bounds();
    if bounds.is_empty() {
        return 1.0;
    }
    let ahead = (bounds.center() - Vec3::from(view.translation)).dot(-Vec3::from(view.matrix3.z_axis));
    ahead.max(0.05 * bounds.size().length()).max(0.01)
}

/// Selects what was clicked on.
fn click(ui: &Ui, editor: &mut Editor, stage: &Stage, rect: Rect, response: &Response, signs: &[(SceneId, Pos2)]) {
    let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) else { return };
    let add = ui.input(|i| i.modifiers.command);
    let distance = |sign: &&(SceneId, Pos2)| sign.1.distance(at);
    let sign = signs.iter().filter(|sign| distance(sign) < NEAR).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    if let Some((id, _)) = sign {
        return if add { editor.toggle(*id) } else { editor.select_only(*id) };
    }
    let inside = (at - rect.min) / rect.size();
    let [width, height] = stage.facts.image_size;
    let pixel = |share: f32, count: u32| ((share * count as f32) as u32).min(count.saturating_sub(1));
    editor.requests.push(Request::Pick { pixel: [pixel(inside.x, width), pixel(inside.y, height)], add });
}

impl Editor {
    /// Selects what was seen at a clicked pixel; `exact` takes the part of a model and not the entity that holds it.
    pub fn picked(&mut self, world: &GameWorld, id: Option<SceneId>, add: bool, exact: bool) {
        let entity = id.and_then(|id| world.entity(id));
        let holder = |entity: Entity| {
            let mut above = std::iter::successors(Some(entity), |e| world.parent(*e));
            above.find(|e| exact || !files::is_from_model(world, *e)).unwrap_or(entity)
        };
        match entity.map(holder).and_then(|e| world.id(e)) {
            Some(id) if add => self.toggle(id),
            Some(id) => self.select_only(id),
            None if !add => self.selection.clear(),
            None => {}
        }
        self.problem = None;
    }

    /// A point ahead of the camera: where new things are put.
    pub fn place_ahead(&self, stage: &Stage) -> Vec3 {
        let Some(camera) = &stage.facts.scene_camera else { return Vec3::ZERO };
        let view = stage.camera.apply(camera).world_from_view;
        let distance = orbit_distance(stage, camera).min(4.0);
        let point = Vec3::from(view.translation) - Vec3::from(view.matrix3.z_axis) * distance;
        let point = (point.as_dvec3() + stage.facts.scene.origin).as_vec3();
        // Whole centimetres read better.
        (point * 100.0).round() / 100.0
    }
}

impl Editor {
    /// Identities of the primitives that get an outline: the selection with all below it.
    pub fn outlined(&self, world: &GameWorld) -> Vec<u32> {
        if self.hidden {
            return Vec::new();
        }
        let parts = self.selected(world).into_iter().flat_map(|(_, entity)| world.subtree(entity));
        let drawn = parts.filter(|entity| world.ecs.get::<MeshRenderer>(*entity).is_some());
        let mut ids: Vec<u32> = drawn.filter_map(|entity| Some(world.id(entity)?.0 as u32)).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }
}

/// Bounds of the entity with all below it, from an origin \[m\].
pub fn bounds_of(world: &GameWorld, entity: Entity, origin: DVec3) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    for part in world.subtree(entity) {
        let place = world.ecs.get::<GlobalTransform>(part);
        if let Some((renderer, place)) = world.ecs.get::<MeshRenderer>(part).zip(place) {
            bounds = bounds.union(&renderer.mesh.bounds.transformed(&place.relative_to(origin)));
        }
    }
    bounds
}

/// The box around each selected thing.
fn bounds(painter: &egui::Painter, editor: &Editor, stage: &Stage, lens: &Lens) {
    for (index, (_, entity)) in editor.selected(stage.world).iter().rev().take(64).enumerate() {
        let bounds = bounds_of(stage.world, *entity, stage.facts.scene.origin);
        if bounds.is_empty() {
            continue;
        }
        let color = if index == 0 { Color32::from_rgb(255, 170, 60) } else { Color32::from_rgb(200, 140, 80) };
        for [a, b] in lightwell::render::debug::box_edges(&bounds) {
            if let Some((a, b)) = lens.segment(a, b) {
                painter.line_segment([a, b], Stroke::new(1.0, color));
            }
        }
    }
}

/// Signs of lights, cameras, fog and particles, which have no surface to click on.
fn signs(painter: &egui::Painter, editor: &Editor, stage: &mut Stage, lens: &Lens) -> Vec<(SceneId, Pos2)> {
    if !editor.view.signs {
        return Vec::new();
    }
    let (world, origin) = (&mut *stage.world, stage.facts.scene.origin);
    let fog = places_of::<Fog>(world, origin).into_iter().map(|f| (f, "≈"));
    let lights = places_of::<Light>(world, origin).into_iter().map(|l| (l, "◆"));
    let cameras = places_of::<Camera>(world, origin).into_iter().map(|c| (c, "►"));
    let particles = places_of::<Particles>(world, origin).into_iter().map(|p| (p, "✳"));
    let all = fog.chain(particles).chain(lights).chain(cameras);
    let mut shown = Vec::new();
    for ((entity, place), sign) in all {
        let Some(id) = world.id(entity) else { continue };
        let Some(at) = lens.point(place.translation.into()) else { continue };
        let selected = editor.selection.contains(&id);
        let color = if selected { Color32::from_rgb(255, 170, 60) } else { Color32::from_white_alpha(200) };
        let font = egui::FontId::proportional(16.0);
        painter.text(at + egui::vec2(1.0, 1.0), egui::Align2::CENTER_CENTER, sign, font.clone(), Color32::BLACK);
        painter.text(at, egui::Align2::CENTER_CENTER, sign, font, color);
        shown.push((id, at));
    }
    shown
}

/// The entities that have a component, and where they stand from an origin.
fn places_of<C: Component>(world: &mut GameWorld, origin: DVec3) -> Vec<(Entity, Affine3A)> {
    let mut query = world.ecs.query_filtered::<(Entity, &GlobalTransform), With<C>>();
    query.iter(&world.ecs).map(|(entity, place)| (entity, place.relative_to(origin))).collect()
}

/// Flies to the selection.
pub fn focus(editor: &mut Editor, stage: &mut Stage) {
    let Some(camera) = stage.facts.scene_camera.clone() else { return };
    let mut bounds = Aabb::EMPTY;
    for (_, entity) in editor.selected(stage.world) {
        let origin = stage.facts.scene.origin;
        let fog = super::fog::outline_of(stage.world, entity, origin);
        let own = bounds_of(stage.world, entity, origin).union(&Aabb::from_points(fog.into_iter().flatten()));
        let place = stage.world.ecs.get::<GlobalTransform>(entity);
        let place = place.map_or(Vec3::ZERO, |g| g.relative_to(origin).translation.into());
        let around = Aabb { min: place - Vec3::splat(0.5), max: place + Vec3::splat(0.5) };
        // The bulb of a lamp is small, and what it lights is around it.
        let is_light = stage.world.ecs.get::<Light>(entity).is_some();
        bounds = bounds.union(&own);
        if own.is_empty() || is_light {
            bounds = bounds.union(&around);
        }
    }
    if bounds.is_empty() {
        bounds = stage.facts.scene.bounds();
    }
    if !bounds.is_empty() {
        let radius = (0.5 * bounds.size().length()).max(0.05);
        let distance = match camera.projection {
            ViewProjection::Perspective { vertical_fov } => 1.2 * radius / (0.5 * vertical_fov).sin().max(0.05),
            ViewProjection::Orthographic { .. } => {
                stage.camera.set_height(2.4 * radius);
                camera.near + 2.0 * radius
            }
        };
        stage.camera.look_from(&camera, bounds.center(), distance);
    }
}

/// Keeps the camera's place.
pub fn keep(editor: &mut Editor, stage: &mut Stage, number: usize) {
    let Some(camera) = &stage.facts.scene_camera else { return };
    let mut here = stage.camera.clone();
    here.fly(camera, Vec3::ZERO);
    editor.view.bookmarks[number] = here.place();
    editor.tell(format!("kept the camera's place as bookmark {}", number + 1), false);
}

/// Goes to a place that was kept.
pub fn recall(editor: &mut Editor, stage: &mut Stage, number: usize) {
    match editor.view.bookmarks[number] {
        Some(place) => stage.camera.go(Some(place)),
        None => editor.tell(format!("bookmark {} is empty; Ctrl and its key keep a place", number + 1), false),
    }
}

/// Takes files that were dropped on the window.
pub fn take_dropped_files(ui: &Ui, editor: &mut Editor, stage: &mut Stage) {
    let files = ui.input(|i| i.raw.dropped_files.clone());
    for path in files.into_iter().map(|file| file.path().to_owned()).filter(|path| !path.as_os_str().is_empty()) {
        if path.to_string_lossy().ends_with(".scene.ron") {
            editor.ask(Request::Open(path));
            continue;
        }
        match editor.add_file(stage, &path) {
            Ok(()) => editor.tell(format!("added {}", relative_to(&path, stage.files.path)), false),
            Err(error) => editor.tell(format!("{error:#}"), true),
        }
    }
}
