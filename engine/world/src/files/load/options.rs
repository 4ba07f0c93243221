//! How scenes are loaded.

use crate::assets::{LightUnits, LoadBudget};
use crate::files::format::custom_components::ComponentTypes;
use std::path::PathBuf;

/// How scenes are loaded.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Folder of third-party models (`--models`).
    pub models: Option<PathBuf>,
    /// Folders that files are read from beside that of models and the scene's project, see [`project_root`](super::trust::project_root) (`--trust`).
    pub trusted: Vec<PathBuf>,
    /// Limits of a load (`--budget`).
    pub budget: LoadBudget,
    /// Units of the lights of models whose import settings name none (`--light-units`).
    pub light_units: LightUnits,
    /// Whether a model of which something is broken is refused, in place of a warning (`--strict`).
    pub strict: bool,
    /// Components of a game that scenes may hold.
    pub types: ComponentTypes,
}
