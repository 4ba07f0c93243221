//! A scene in a window, with the editor around it.

mod answers;
pub(crate) mod export;
mod game;
mod measurement;
mod memory;
mod meter;
mod picture;
mod player;
pub(crate) mod playing;
mod remembered;
mod render_thread;
mod window;

use crate::editor::{CustomComponent, console};
use anyhow::Result;
use lightwell::files::ComponentTypes;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::session::CustomMethods;
use lightwell_runtime::{logging, scene_path};
use std::path::PathBuf;
use std::time::Instant;
use winit::event_loop::EventLoop;

/// What the window shows at first.
#[derive(Clone, Debug)]
pub struct Opening {
    /// The scene, by file or name.
    pub scene: String,
    /// Size of the window \[pixels\]; none: as it was last.
    pub size: Option<[u32; 2]>,
    /// Part of the view's size that is drawn.
    pub scale: f32,
    /// Frames per second that it holds by drawing them smaller while anything moves, 0 for always at full size; none: as
    /// [`FrameBudget::choose`](lightwell_runtime::frame_budget::FrameBudget::choose) has it.
    pub frames_per_second: Option<f32>,
    /// Choices that change the picture.
    pub look: LookArgs,
    /// A file that figures of the window go to, and when the program was started: it measures itself then, and ends.
    pub measure: Option<(PathBuf, Instant)>,
}

pub use playing::{NewGame, Overlay, PlayedGame};

/// What the editor knows of the game whose scenes it edits.
#[derive(Default)]
pub struct EditedGame {
    /// How files hold them.
    pub types: ComponentTypes,
    /// How the inspector shows them.
    pub shown: Vec<CustomComponent>,
    /// Its methods of indirect light.
    pub methods: CustomMethods,
    /// What Play plays; none: what the engine does by itself.
    pub new_game: Option<NewGame>,
}

/// A connection to a display that windows open on.
pub struct Display(EventLoop<()>);

impl Display {
    /// Connects to the display of the environment.
    ///
    /// # Errors
    /// If there is none, or it cannot be used.
    pub fn open() -> Result<Self> {
        Ok(Self(EventLoop::new()?))
    }

    /// Opens a window with the editor, until it is closed.
    ///
    /// # Errors
    /// If the scene cannot be loaded, no device is found, or the device is lost.
    pub fn edit(self, opening: &Opening, common: &Common, game: &EditedGame) -> Result<()> {
        logging::also_tell(console::hear);
        scene_path::find(&opening.scene)?;
        window::run(self.0, opening, common, game)
    }
}
