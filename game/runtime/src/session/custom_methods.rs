//! Methods of indirect light that a game adds to each of its renderers.

use lightwell::render::{IndirectMethod, MethodInfo};
use std::fmt;
use std::sync::Arc;

type Maker = Arc<dyn Fn() -> Box<dyn IndirectMethod> + Send + Sync>;

/// Methods of indirect light that a game adds to each of its renderers.
#[derive(Clone, Default)]
pub struct CustomMethods(Vec<(MethodInfo, Maker)>);

impl fmt::Debug for CustomMethods {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.list()).finish()
    }
}

impl CustomMethods {
    /// Adds a method, which `make` makes for each renderer, and returns its description. It replaces one of the same name.
    pub fn add<M: IndirectMethod>(&mut self, make: impl Fn() -> M + Send + Sync + 'static) -> MethodInfo {
        let info = MethodInfo::of(&make());
        self.0.retain(|(known, _)| known.id != info.id);
        self.0.push((info, Arc::new(move || Box::new(make()))));
        info
    }

    /// Descriptions of all.
    pub fn list(&self) -> impl Iterator<Item = MethodInfo> + '_ {
        self.0.iter().map(|(info, _)| *info)
    }

    /// New instances of all, for another renderer.
    pub(super) fn make(&self) -> impl Iterator<Item = Box<dyn IndirectMethod>> + '_ {
        self.0.iter().map(|(_, make)| make())
    }
}
