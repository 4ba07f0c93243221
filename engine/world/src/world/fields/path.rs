//! Paths of fields, and the form of their values.

use ron::extensions::Extensions;

/// The first word of the path of a setting of the scene, `scene.exposure`.
pub const SCENE: &str = "scene";
/// Settings that nothing keys: the time that tracks are a function of follows from them.
pub const CLOCK_FIELDS: [&str; 2] = ["duration", "frame_rate"];

/// How values are written and read: as in scene files.
pub fn ron_options() -> ron::Options {
    let extensions = Extensions::IMPLICIT_SOME | Extensions::UNWRAP_NEWTYPES | Extensions::UNWRAP_VARIANT_NEWTYPES;
    ron::Options::default().with_default_extension(extensions)
}

/// Splits a path into the component's name and the steps to the field; no steps mean the component as a whole.
pub fn split(path: &str) -> (&str, Vec<&str>) {
    let mut words = path.split('.');
    (words.next().unwrap_or_default(), words.collect())
}
