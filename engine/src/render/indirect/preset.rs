//! Named settings of methods, which the program `bench` compares.

/// Settings of a method under a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// Its changes of the scene, as `--set` writes them.
    pub sets: &'static [(&'static str, &'static str)],
    /// Its description in the report.
    pub about: &'static str,
    /// When it is measured.
    pub runs: Runs,
}

/// When a preset is measured without being asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// In every run.
    Always,
    /// Not in quick runs.
    Thorough,
    /// Only by `--method`.
    Asked,
}
