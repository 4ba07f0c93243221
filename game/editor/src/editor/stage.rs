//! What the editor works on, and what it is told of.

use super::camera::FlyCamera;
use super::clock::PlayClock;
use super::console::Record;
use crate::comparison::{Comparison, LiveError};
use lightwell::files::OverrideFile;
use lightwell::graph::FrameReport;
use lightwell::profile::Profiler;
use lightwell::render::{DisplaySettings, MethodInfo};
use lightwell::scene::{Scene, SceneCamera, SceneId};
use lightwell::world::GameWorld;
use lightwell_runtime::cli::LookArgs;
use lightwell_runtime::session::Files;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What the editor works on.
pub struct Stage<'a> {
    /// The world.
    pub world: &'a mut GameWorld,
    /// Its files.
    pub files: Files<'a>,
    /// Choices that change the picture.
    pub look: &'a mut LookArgs,
    /// How light becomes what the screen shows.
    pub display: &'a mut DisplaySettings,
    /// The reference beside the picture.
    pub comparison: &'a mut Comparison,
    /// The clock of play.
    pub clock: &'a mut PlayClock,
    /// The camera that is flown.
    pub camera: &'a mut FlyCamera,
    /// What there is to show.
    pub facts: Facts<'a>,
}

impl Stage<'_> {
    /// What of the scene does not show: in the last frame, and of its models.
    pub fn warnings(&self) -> Vec<String> {
        self.facts.report.warnings.iter().cloned().chain(self.files.library.warnings()).collect()
    }
}

/// What there is to show.
pub struct Facts<'a> {
    /// Name of the scene.
    pub name: &'a str,
    /// What the renderer sees.
    pub scene: &'a Scene,
    /// The methods of indirect light that it can be drawn with.
    pub methods: &'a [MethodInfo],
    /// The last frame.
    pub report: &'a FrameReport,
    /// Times of the last frames.
    pub profiler: &'a Profiler,
    /// What is wrong just now.
    pub errors: &'a [String],
    /// What was logged.
    pub log: &'a [Record],
    /// The scene's camera that is used, as it stands in the scene.
    pub scene_camera: Option<SceneCamera>,
    /// The last image.
    pub image: Option<egui::TextureId>,
    /// Size of the last image \[pixels\].
    pub image_size: [u32; 2],
    /// State of the path tracer, while it runs.
    pub tracing: Option<Tracing>,
    /// Error of the picture against the running reference.
    pub live_error: Option<LiveError>,
    /// Name of the adapter.
    pub adapter: &'a str,
    /// What was chosen to hold the frame rate; none: nothing is.
    pub budget: Option<String>,
    /// What goes on behind the panels.
    pub working: Working,
    /// The game that plays; none: the world is the edited one.
    pub playing: Option<PlayFacts<'a>>,
}

/// The game that plays. The world of the stage is its world then, a copy of the edited one.
#[derive(Clone, Copy)]
pub struct PlayFacts<'a> {
    /// Whether time stands still.
    pub paused: bool,
    /// Steps so far.
    pub step: u64,
    /// Time of the game \[s\].
    pub seconds: f64,
    /// What systems failed with last.
    pub trouble: Option<&'a str>,
    /// What the game draws over the view.
    pub overlay: Option<egui::TextureId>,
    /// The edited world and its file, while the game is in that scene.
    pub edited: Option<(&'a GameWorld, &'a Path)>,
}

/// What goes on behind the panels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Working {
    /// For how long the next picture has been drawn, and how many of its passes are done.
    pub picture: Option<(Duration, (usize, usize))>,
    /// Frames of the export that are written, and all of them.
    pub export: Option<(u64, u64)>,
}

/// How far a path-traced image is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracing {
    /// Samples a pixel so far.
    pub samples: u32,
    /// Samples a pixel of the finished image.
    pub target: u32,
}

/// What the editor asks of the program.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Save under the scene's own name.
    Save,
    /// Save under another name, and go on with that file.
    SaveAs(PathBuf),
    /// Load the scene anew from its file; edits are lost.
    Reload,
    /// Play another scene; edits are lost.
    Open(PathBuf),
    /// End; edits are lost.
    Quit,
    /// Save a picture.
    Screenshot,
    /// Say what is seen at a pixel of the image.
    Pick {
        /// The pixel.
        pixel: [u32; 2],
        /// Whether it joins what is selected.
        add: bool,
    },
    /// Read all shaders anew.
    RebuildShaders,
    /// Read a target back.
    Target(super::panels::targets::Choice),
    /// Render the animation into files.
    Export(Export),
    /// End that; what is written stays.
    CancelExport,
    /// Play the game, or have it do something.
    Play(PlayRequest),
}

/// What is asked of the game that plays.
#[derive(Clone, Debug, PartialEq)]
pub enum PlayRequest {
    /// Begin, with a copy of the edited world.
    Begin,
    /// End; the edited world comes back as it was.
    Stop,
    /// Let time stand still, or go on.
    Pause(bool),
    /// Pause, and have one step pass.
    Step,
    /// Give entities of the edited world these components.
    Apply(Vec<(SceneId, OverrideFile)>),
}

/// An animation to be written as files.
#[derive(Clone, Debug, PartialEq)]
pub struct Export {
    /// Folder.
    pub folder: PathBuf,
    /// Image size \[pixels\].
    pub size: [u32; 2],
    /// Frames a second.
    pub rate: u32,
    /// Number of frames.
    pub frames: u64,
    /// Whether a video is made of them too.
    pub video: bool,
}
