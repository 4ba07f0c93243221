//! Panels and where they stand.

use super::stage::Stage;
use super::{Editor, hierarchy, inspector, panels, view};
use egui::{Ui, WidgetText};
use egui_tiles::{
    Behavior, Container, Linear, LinearDir, SimplificationOptions, Tile, TileId, Tiles, Tree, UiResponse,
};
use serde::{Deserialize, Serialize};

/// A panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Pane {
    /// The picture.
    View,
    /// The tree of entities.
    Hierarchy,
    /// What the selection is made of.
    Inspector,
    /// What belongs to the scene as a whole.
    Scene,
    /// Method of light, layer, exposure.
    Display,
    /// Where the time goes.
    Profiler,
    /// Passes and resources.
    Graph,
    /// Images that passes made.
    Targets,
    /// Messages.
    Console,
    /// Numbers of the frame.
    Statistics,
    /// What is wrong just now.
    Errors,
    /// The path tracer.
    PathTracer,
    /// Keys.
    Help,
}

/// All panels.
pub const PANES: [Pane; 13] = [
    Pane::View,
    Pane::Hierarchy,
    Pane::Inspector,
    Pane::Scene,
    Pane::Display,
    Pane::Profiler,
    Pane::Graph,
    Pane::Targets,
    Pane::Console,
    Pane::Statistics,
    Pane::Errors,
    Pane::PathTracer,
    Pane::Help,
];

impl Pane {
    /// Its title.
    pub fn title(self) -> &'static str {
        match self {
            Self::View => "View",
            Self::Hierarchy => "Hierarchy",
            Self::Inspector => "Inspector",
            Self::Scene => "Scene",
            Self::Display => "Light & display",
            Self::Profiler => "Profiler",
            Self::Graph => "Render graph",
            Self::Targets => "Targets",
            Self::Console => "Console",
            Self::Statistics => "Statistics",
            Self::Errors => "Errors",
            Self::PathTracer => "Path tracer",
            Self::Help => "Help",
        }
    }
}

/// The panels of a window.
pub struct Layout {
    tree: Tree<Pane>,
}

impl Default for Layout {
    fn default() -> Self {
        Self { tree: usual() }
    }
}

/// View in the middle, hierarchy on the left, inspector on the right, the rest below.
fn usual() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut tabs = |panes: &[Pane]| {
        let panes = panes.iter().map(|pane| tiles.insert_pane(*pane)).collect();
        tiles.insert_tab_tile(panes)
    };
    let left = tabs(&[Pane::Hierarchy]);
    let view = tabs(&[Pane::View]);
    let below = tabs(&[Pane::Console, Pane::Profiler, Pane::Graph, Pane::Targets, Pane::Statistics, Pane::Errors]);
    let right = tabs(&[Pane::Inspector, Pane::Scene, Pane::Display, Pane::PathTracer, Pane::Help]);
    let mut split = |dir, children: [(TileId, f32); 2]| {
        let shares = children.map(|(_, share)| share);
        let mut linear = Linear::new(dir, children.map(|(id, _)| id).to_vec());
        children.iter().zip(shares).for_each(|((id, _), share)| linear.shares.set_share(*id, share));
        tiles.insert_new(Tile::Container(Container::Linear(linear)))
    };
    let middle = split(LinearDir::Vertical, [(view, 0.72), (below, 0.28)]);
    let middle = split(LinearDir::Horizontal, [(left, 0.22), (middle, 0.78)]);
    let root = split(LinearDir::Horizontal, [(middle, 0.74), (right, 0.26)]);
    Tree::new(egui::Id::unique("panels"), root, tiles)
}

impl Layout {
    /// As text.
    pub fn text(&self) -> Option<String> {
        ron::to_string(&self.tree).ok()
    }

    /// From text; what cannot be read, or lacks the view, is passed over.
    pub fn restore(&mut self, text: &str) {
        let Ok(tree) = ron::from_str::<Tree<Pane>>(text) else { return };
        if tree.tiles.find_pane(&Pane::View).is_some() && tree.root().is_some() {
            self.tree = tree;
        }
    }

    /// As it was at first.
    pub fn reset(&mut self) {
        self.tree = usual();
    }

    /// Whether a panel is there.
    pub fn has(&self, pane: Pane) -> bool {
        self.tree.tiles.find_pane(&pane).is_some()
    }

    /// Takes a panel away, or brings it back.
    pub fn toggle(&mut self, pane: Pane) {
        match self.tree.tiles.find_pane(&pane) {
            Some(id) => drop(self.tree.remove_recursively(id)),
            None => self.add(pane),
        }
    }

    /// Brings a panel to the front.
    pub fn focus(&mut self, pane: Pane) {
        if !self.has(pane) {
            self.add(pane);
        }
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(p) if *p == pane));
    }

    /// Adds a panel beside the inspector, or else wherever there are tabs.
    fn add(&mut self, pane: Pane) {
        let id = self.tree.tiles.insert_pane(pane);
        let beside = self.tree.tiles.find_pane(&Pane::Inspector).and_then(|id| self.tree.tiles.parent_of(id));
        let parent = beside.or(self.tree.root());
        if let Some(parent) = parent {
            self.tree.move_tile_to_container(id, parent, usize::MAX, false);
        }
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(p) if *p == pane));
    }
}

/// Shows all panels.
pub fn show(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let empty = Tree::empty(egui::Id::unique("no panels"));
    let mut tree = std::mem::replace(&mut editor.layout.tree, empty);
    editor.view.is_shown = false;
    tree.ui(&mut Dock { editor, stage }, ui);
    // A panel may have been asked for meanwhile.
    let asked = std::mem::replace(&mut editor.layout.tree, tree);
    if asked.root().is_some() {
        editor.layout.tree = asked;
    }
}

struct Dock<'a, 'b> {
    editor: &'a mut Editor,
    stage: &'a mut Stage<'b>,
}

impl Behavior<Pane> for Dock<'_, '_> {
    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        let errors = self.stage.facts.errors.len();
        match pane {
            Pane::Errors if errors > 0 => egui::RichText::new(format!("Errors ({errors})")).color(ERROR).into(),
            Pane::Errors => match self.stage.warnings().len() {
                0 => pane.title().into(),
                1 => "Errors (1 warning)".into(),
                count => format!("Errors ({count} warnings)").into(),
            },
            pane => pane.title().into(),
        }
    }

    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, pane: &mut Pane) -> UiResponse {
        let (editor, stage) = (&mut *self.editor, &mut *self.stage);
        if *pane == Pane::View {
            view::show(ui, editor, stage);
            return UiResponse::None;
        }
        egui::Frame::central_panel(ui.style()).inner_margin(6.0).show(ui, |ui| {
            ui.take_available_space();
            if *pane == Pane::Hierarchy {
                return hierarchy::show(ui, editor, stage);
            }
            // Fields take the width that there is; tables may be wider.
            let is_form = matches!(pane, Pane::Inspector | Pane::Scene | Pane::Display | Pane::PathTracer | Pane::Help);
            let area = egui::ScrollArea::new([!is_form, true]).id_salt(*pane).auto_shrink(false);
            area.show(ui, |ui| match pane {
                Pane::Inspector => inspector::show(ui, editor, stage),
                Pane::Scene => inspector::show_scene(ui, editor, stage),
                pane => panels::show(ui, *pane, editor, stage),
            });
        });
        UiResponse::None
    }

    fn tab_bar_height(&self, _: &egui::Style) -> f32 {
        22.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}

/// Colour of errors.
pub const ERROR: egui::Color32 = egui::Color32::from_rgb(255, 120, 100);
