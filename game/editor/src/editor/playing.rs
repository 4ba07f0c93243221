//! The editor while a game plays: its edits have a history of their own, that of the edited world rests.

use super::Editor;
use super::history::History;
use super::layout::ERROR;
use super::stage::{PlayFacts, PlayRequest, Request, Stage};
use super::value::Value;
use anyhow::{Context, Result};
use egui::{
    Align2, Color32, CornerRadius, Event, EventFilter, FontId, Painter, Pos2, Rect, Response, Stroke, StrokeKind, Ui,
    vec2,
};
use lightwell::files::{OverrideFile, describe_entity, ron_options};
use lightwell::scene::SceneId;
use lightwell::world::GameWorld;
use std::collections::BTreeMap;

impl Editor {
    /// A game begins to play on a copy of the edited world.
    ///
    /// # Errors
    /// If the edit that goes on cannot be ended.
    pub fn begin_play(&mut self, edited: &mut GameWorld) -> Result<()> {
        self.history.close(edited)?;
        self.resting = Some(std::mem::replace(&mut self.history, History::new()));
        self.view.takes_input = true;
        self.forget_edit();
        Ok(())
    }

    /// The game has ended: its edits are gone with its world, and those of the edited world can be undone again.
    pub fn end_play(&mut self) {
        if let Some(history) = self.resting.take() {
            self.history = history;
        }
        self.view.has_input = false;
        self.forget_edit();
    }

    fn forget_edit(&mut self) {
        (self.problem, self.view.drag, self.rebuilding) = (None, None, false);
    }

    /// What was done to the edited world.
    pub fn scene_history(&mut self) -> &mut History {
        self.resting.as_mut().unwrap_or(&mut self.history)
    }

    /// Whether the edited world has something that no file holds.
    pub fn is_dirty(&self) -> bool {
        self.resting.as_ref().unwrap_or(&self.history).is_dirty()
    }

    /// Gives entities of the edited world the components that the game was found to be good with, as one step of undo.
    /// `edited` is the stage of that world.
    ///
    /// # Errors
    /// If no game plays, or a value cannot be taken; nothing changes then.
    pub fn apply_to_scene(&mut self, edited: &mut Stage, edits: &[(SceneId, OverrideFile)]) -> Result<()> {
        let history = self.resting.take().context("no game plays")?;
        let playing = std::mem::replace(&mut self.history, history);
        let applied = self.edit_components(edited, "apply to scene", edits);
        let result = applied.and_then(|()| self.history.close(edited.world));
        self.resting = Some(std::mem::replace(&mut self.history, playing));
        self.rebuilding = false;
        result
    }

    /// Asks to apply all components of the selected entities.
    pub(super) fn ask_apply(&mut self, stage: &Stage) {
        let Some(Some((edited, _))) = stage.facts.playing.map(|playing| playing.edited) else {
            return self.tell("the game plays another scene than the edited one", true);
        };
        let known = self.selected(stage.world).into_iter().filter(|(id, _)| edited.entity(*id).is_some());
        let described = known.map(|(id, entity)| Ok((id, describe_entity(stage.world, entity, stage.files.path)?)));
        match described.collect::<Result<Vec<_>>>() {
            Ok(edits) if edits.is_empty() => self.tell("the edited scene has no such entity", true),
            Ok(edits) => self.requests.push(Request::Play(PlayRequest::Apply(edits))),
            Err(error) => self.tell(format!("{error:#}"), true),
        }
    }

    /// Asks to apply what stands at a path of an entity's description: a component, or a field of one.
    pub(super) fn ask_apply_field(&mut self, id: SceneId, edited: &Value, playing: &Value, path: &[&str]) {
        let mut value = edited.clone();
        copy_at(&mut value, playing, path);
        match ron_options().from_str::<OverrideFile>(&value.print()) {
            Ok(now) => self.requests.push(Request::Play(PlayRequest::Apply(vec![(id, now)]))),
            Err(error) => self.tell(format!("not applied: {}", error.code), true),
        }
    }
}

/// What the edited world says of an entity, as text that the inspector can read.
pub(super) fn edited_value(playing: Option<PlayFacts>, id: SceneId) -> Option<Value> {
    let (world, path) = playing?.edited?;
    let described = describe_entity(world, world.entity(id)?, path).ok()?;
    Value::parse(&ron_options().to_string(&described).ok()?)
}

/// Fields of a component that are others in the edited world, each with what it is there: those of its first level, or the
/// component itself, named `name`, if it has none.
pub(super) fn differences(edited: Option<&Value>, playing: &Value, name: &str) -> BTreeMap<String, String> {
    let said = |value: Option<&Value>| {
        let value = value.map_or_else(|| "nothing".to_owned(), Value::print);
        format!("the edited scene has {value}; a click applies the value of the game to it")
    };
    let Some(edited) = edited else { return BTreeMap::from([(name.to_owned(), said(None))]) };
    let has_fields = playing.items().iter().any(|(key, _)| key.is_some());
    if !has_fields || playing.head != edited.head {
        let differs = edited != playing;
        return differs.then(|| (name.to_owned(), said(Some(edited)))).into_iter().collect();
    }
    let fields = playing.items().iter().filter_map(|(key, value)| Some((key.as_deref()?, value)));
    let other = fields.filter(|(key, value)| edited.field(key) != Some(value));
    other.map(|(key, _)| (key.to_owned(), said(edited.field(key)))).collect()
}

/// Copies what stands at a path of fields; what is not there is taken away.
fn copy_at(target: &mut Value, from: &Value, path: &[&str]) {
    let [name, rest @ ..] = path else { return };
    match (from.field(name), rest.is_empty()) {
        (None, _) => target.remove(name),
        (Some(value), true) => target.set(name, value.clone()),
        (Some(below), false) => match target.field_mut(name) {
            Some(there) => copy_at(there, below, rest),
            None => target.set(name, below.clone()),
        },
    }
}

/// Gives a game that plays mouse and keyboard after a click into the view, and takes them back after one elsewhere.
pub(super) fn capture(ui: &Ui, editor: &mut Editor, stage: &Stage, response: &Response) {
    let runs = stage.facts.playing.is_some_and(|playing| !playing.paused) && editor.dialog.is_none();
    let has_lost = editor.view.has_input && !response.has_focus();
    if response.clicked() {
        editor.view.takes_input = true;
    } else if response.clicked_elsewhere() || has_lost {
        editor.view.takes_input = false;
    }
    editor.view.has_input = runs && editor.view.takes_input;
    // However the game has ended, the keys are the editor's again.
    let held_focus = std::mem::replace(&mut editor.view.holds_focus, editor.view.has_input);
    if !editor.view.has_input {
        editor.view.forwarded.clear();
        if held_focus && response.has_focus() {
            response.surrender_focus();
        }
        return;
    }
    response.request_focus();
    let all = EventFilter { tab: true, horizontal_arrows: true, vertical_arrows: true, escape: true };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, all));
    let events = ui.input(|input| input.raw.events.clone());
    editor.view.forwarded.extend(events.into_iter().filter_map(|event| forwarded(event, response.rect)));
}

/// An event as the game's egui is to see it, whose screen is the view.
fn forwarded(event: Event, view: Rect) -> Option<Event> {
    let inside = |at: Pos2| at - view.min.to_vec2();
    match event {
        Event::PointerMoved(at) => Some(Event::PointerMoved(inside(at))),
        Event::PointerButton { pos, pressed, .. } if pressed && !view.contains(pos) => None,
        Event::PointerButton { pos, button, pressed, modifiers } => {
            Some(Event::PointerButton { pos: inside(pos), button, pressed, modifiers })
        }
        Event::PointerGone | Event::Key { .. } | Event::Text(_) | Event::MouseWheel { .. } => Some(event),
        _ => None,
    }
}

/// What a game draws over the view, and the frame that says that it plays.
pub(super) fn over_view(painter: &Painter, editor: &Editor, stage: &Stage, rect: Rect) {
    let Some(playing) = stage.facts.playing else { return };
    if let Some(overlay) = playing.overlay {
        painter.image(overlay, rect, Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0)), Color32::WHITE);
    }
    let (state, color) = playing.state();
    let stroke = Stroke::new(if editor.view.has_input { 4.0 } else { 2.0 }, color);
    painter.rect_stroke(rect, CornerRadius::ZERO, stroke, StrokeKind::Inside);
    let what = match (playing.paused, editor.view.has_input) {
        (true, _) => "F7 lets it go on, F10 one step",
        (false, true) => "it has mouse and keyboard; a click beside the view takes them back",
        (false, false) => "a click gives it mouse and keyboard",
    };
    let corner = rect.left_bottom() + vec2(10.0, -10.0);
    let place = label(painter, corner, Color32::BLACK, color, &format!("{state}: {what}"));
    if let Some(trouble) = playing.trouble {
        let line = trouble.lines().next().unwrap_or_default();
        label(painter, place.left_top() - vec2(0.0, 10.0), ERROR, Color32::from_black_alpha(220), line);
    }
}

/// A text on a ground of its own, above a point.
fn label(painter: &Painter, at: Pos2, ink: Color32, ground: Color32, text: &str) -> Rect {
    let width = (painter.clip_rect().right() - at.x - 10.0).max(40.0);
    let galley = painter.layout(text.to_owned(), FontId::proportional(13.0), ink, width);
    let place = Align2::LEFT_BOTTOM.anchor_size(at, galley.size());
    painter.rect_filled(place.expand(4.0), 3.0, ground);
    painter.galley(place.min, galley, ink);
    place
}
