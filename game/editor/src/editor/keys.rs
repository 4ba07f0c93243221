//! Keys, as the help lists them.

use super::Editor;
use super::gizmo::Mode;
use super::layout::Pane;
use super::stage::{PlayRequest, Request, Stage};
use egui::{Key, KeyboardShortcut, Modifiers, Ui};

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Takes the last step back.
    Undo,
    /// Does it again.
    Redo,
    /// Saves.
    Save,
    /// Saves under another name.
    SaveAs,
    /// Plays another scene.
    Open,
    /// Copies the selection.
    Duplicate,
    /// Takes the selection away.
    Delete,
    /// Puts the cursor into the search of the hierarchy.
    Find,
    /// Flies to the selection.
    Focus,
    /// Selects nothing.
    Escape,
    /// Hides or shows the panels.
    Panels,
    /// Plays the game, or stops it.
    Play,
    /// Stops the game.
    Stop,
    /// Lets the game stand still, or go on.
    PauseGame,
    /// One step of the game.
    StepGame,
    /// Gives the edited scene what the selected entities are in the game.
    Apply,
    /// Lets the animation stand still, or go on; the game, if it plays.
    Pause,
    /// One tick of the animation; one step of the game, if it plays.
    Step,
    /// Back to the start.
    Rewind,
    /// Faster (1) or slower (−1).
    Speed(i32),
    /// Back to the scene's camera.
    SceneCamera,
    /// Keeps the camera's place under a number.
    Keep(usize),
    /// Goes to a place that was kept.
    Recall(usize),
    /// Chooses a gizmo.
    Gizmo(Mode),
    /// Saves a picture.
    Screenshot,
    /// Shows the help.
    Help,
    /// Ends.
    Quit,
}

impl Action {
    /// Whether the editor takes its key while a game has the keyboard, and while something is typed.
    fn is_of_editor(self) -> bool {
        use Action::{PauseGame, Play, Quit, Save, Screenshot, StepGame, Stop};
        matches!(self, Play | Stop | PauseGame | StepGame | Save | Quit | Screenshot)
    }
}

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };
const NONE: Modifiers = Modifiers::NONE;

/// All keys, what they do, and how the help says it. Those with more modifiers come first.
pub const KEYS: [(Modifiers, Key, Action, &str); 41] = [
    (CTRL_SHIFT, Key::Z, Action::Redo, "redo"),
    (CTRL_SHIFT, Key::S, Action::SaveAs, "save as"),
    (CTRL_SHIFT, Key::P, Action::PauseGame, "pause the game, or let it go on"),
    (NONE, Key::F5, Action::Play, "play the game, or stop it"),
    (CTRL, Key::P, Action::Play, "play the game, or stop it"),
    (NONE, Key::F7, Action::PauseGame, "pause the game, or let it go on"),
    (NONE, Key::F8, Action::Stop, "stop the game"),
    (NONE, Key::F10, Action::StepGame, "one step of the game"),
    (CTRL, Key::Enter, Action::Apply, "apply the selection of the game to the scene"),
    (CTRL, Key::Z, Action::Undo, "undo"),
    (CTRL, Key::Y, Action::Redo, "redo"),
    (CTRL, Key::S, Action::Save, "save"),
    (CTRL, Key::O, Action::Open, "open another scene"),
    (CTRL, Key::D, Action::Duplicate, "duplicate the selection"),
    (CTRL, Key::F, Action::Find, "search the hierarchy"),
    (CTRL, Key::Q, Action::Quit, "quit"),
    (CTRL, Key::Num5, Action::Keep(0), "keep the camera as bookmark 1"),
    (CTRL, Key::Num6, Action::Keep(1), "keep the camera as bookmark 2"),
    (CTRL, Key::Num7, Action::Keep(2), "keep the camera as bookmark 3"),
    (CTRL, Key::Num8, Action::Keep(3), "keep the camera as bookmark 4"),
    (NONE, Key::Num6, Action::Recall(1), "go to bookmark 2"),
    (NONE, Key::Num7, Action::Recall(2), "go to bookmark 3"),
    (NONE, Key::Num8, Action::Recall(3), "go to bookmark 4"),
    (NONE, Key::Num5, Action::Recall(0), "go to bookmark 1"),
    (NONE, Key::Delete, Action::Delete, "delete the selection"),
    (NONE, Key::F, Action::Focus, "focus on the selection"),
    (NONE, Key::Escape, Action::Escape, "select nothing"),
    (NONE, Key::H, Action::Panels, "hide or show the panels"),
    (NONE, Key::Space, Action::Pause, "preview the animation, or pause"),
    (NONE, Key::Period, Action::Step, "one step of the clock"),
    (NONE, Key::Home, Action::Rewind, "back to the start of the clock"),
    (NONE, Key::Plus, Action::Speed(1), "faster"),
    (NONE, Key::Equals, Action::Speed(1), "faster"),
    (NONE, Key::Minus, Action::Speed(-1), "slower"),
    (NONE, Key::C, Action::SceneCamera, "back to the scene's camera"),
    (NONE, Key::Num1, Action::Gizmo(Mode::Move), "gizmo: move"),
    (NONE, Key::Num2, Action::Gizmo(Mode::Rotate), "gizmo: rotate"),
    (NONE, Key::Num3, Action::Gizmo(Mode::Scale), "gizmo: scale"),
    (NONE, Key::Num4, Action::Gizmo(Mode::None), "no gizmo"),
    (NONE, Key::F12, Action::Screenshot, "save a picture into out/"),
    (NONE, Key::F1, Action::Help, "this help"),
];

/// The mouse, as the help lists it.
pub const MOUSE: [(&str, &str); 10] = [
    ("click", "select (Ctrl: more; Alt: the part of a model itself)"),
    ("click while a game plays", "in the view: give it mouse and keyboard; elsewhere: take them back"),
    ("drag a gizmo", "move, rotate, scale (Ctrl: in steps)"),
    ("drag left", "look around"),
    ("drag right", "orbit"),
    ("drag middle", "move sideways"),
    ("wheel", "speed of flight"),
    ("W A S D, Q E", "fly, down and up"),
    ("drop a file", ".glb, .gltf and .prefab.ron are added, a .scene.ron is played"),
    ("drag in the tree", "another parent"),
];

/// How everything is reached without a mouse, as the help lists it.
pub const WITHOUT_MOUSE: [(&str, &str); 3] = [
    ("Tab, Shift+Tab", "on to the next thing that can be changed, or back"),
    ("Enter", "press it; end the typing of a value"),
    ("arrows", "through the tree"),
];

/// Does what the keys ask for, unless something is being typed.
pub fn take(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let typing = ui.ctx().egui_wants_keyboard_input();
    if editor.dialog.is_some() {
        return;
    }
    for (modifiers, key, action, _) in KEYS {
        // A game that has the keyboard leaves few keys to the editor.
        if editor.view.has_input && !action.is_of_editor() {
            continue;
        }
        let always = modifiers == CTRL || modifiers == CTRL_SHIFT || action.is_of_editor() || action == Action::Help;
        // Undo of text belongs to the text.
        // Escape closes a menu that is open.
        let closes = action == Action::Escape && egui::Popup::is_any_open(ui.ctx());
        let texts_own = typing && matches!(action, Action::Undo | Action::Redo);
        if typing && !always || texts_own || closes {
            continue;
        }
        if ui.input_mut(|i| i.consume_shortcut(&KeyboardShortcut::new(modifiers, key))) {
            act(editor, stage, action);
        }
    }
}

/// Does one thing.
pub fn act(editor: &mut Editor, stage: &mut Stage, action: Action) {
    let result = match action {
        Action::Undo => return editor.undo(stage),
        Action::Redo => return editor.redo(stage),
        Action::Save if stage.facts.playing.is_some() => return editor.requests.push(Request::Save),
        Action::Save => editor.history.close(stage.world).map(|()| editor.requests.push(Request::Save)),
        Action::SaveAs => return super::dialogs::ask_save_as(editor, stage.files.path),
        Action::Open => return super::dialogs::ask_open(editor, stage),
        Action::Duplicate => editor.duplicate(stage),
        Action::Delete => editor.delete(stage),
        Action::Find => {
            editor.layout.focus(Pane::Hierarchy);
            return editor.hierarchy.find = true;
        }
        Action::Focus => return super::view::focus(editor, stage),
        Action::Escape => return editor.selection.clear(),
        Action::Panels => return editor.hidden = !editor.hidden,
        Action::Play | Action::Stop | Action::PauseGame | Action::StepGame => return play(editor, stage, action),
        Action::Apply if stage.facts.playing.is_some() => return editor.ask_apply(stage),
        Action::Apply => return editor.tell("there is nothing to apply: no game plays", false),
        Action::Pause if stage.facts.playing.is_some() => return play(editor, stage, Action::PauseGame),
        Action::Step if stage.facts.playing.is_some() => return play(editor, stage, Action::StepGame),
        Action::Pause => return stage.clock.playing = !stage.clock.playing,
        Action::Step => return stage.clock.step(),
        Action::Rewind => return stage.clock.seek(0.0),
        Action::Speed(by) => return stage.clock.change_speed(by),
        Action::SceneCamera => return stage.camera.reset(),
        Action::Keep(number) => return super::view::keep(editor, stage, number),
        Action::Recall(number) => return super::view::recall(editor, stage, number),
        Action::Gizmo(mode) => return editor.view.mode = mode,
        Action::Screenshot => return editor.requests.push(Request::Screenshot),
        Action::Help => {
            editor.hidden = false;
            return editor.layout.focus(Pane::Help);
        }
        Action::Quit => return editor.ask(Request::Quit),
    };
    editor.told(result);
}

/// Asks the game for something.
fn play(editor: &mut Editor, stage: &Stage, action: Action) {
    let request = match (action, stage.facts.playing) {
        (Action::Play, None) => PlayRequest::Begin,
        (Action::Play | Action::Stop, Some(_)) => PlayRequest::Stop,
        (Action::PauseGame, Some(playing)) => PlayRequest::Pause(!playing.paused),
        (Action::StepGame, Some(_)) => PlayRequest::Step,
        _ => return editor.tell("no game plays; F5 plays it", false),
    };
    editor.requests.push(Request::Play(request));
}

/// The key of an action as text.
pub fn text_of(action: Action) -> String {
    let key = KEYS.iter().find(|(_, _, a, _)| *a == action);
    key.map_or_else(String::new, |(modifiers, key, ..)| {
        let mut text = String::new();
        if modifiers.command {
            text += "Ctrl+";
        }
        if modifiers.shift {
            text += "Shift+";
        }
        text + key.name()
    })
}
