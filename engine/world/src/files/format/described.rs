//! The sources of the types that scene files hold, for tools that show their documentation.

/// Texts of the source files whose documentation comments describe components and their fields: one place for help,
/// units and ranges, whether they are read in the documentation or in an inspector.
pub const DESCRIBED: [&str; 13] = [
    include_str!("scene_file.rs"),
    include_str!("parts.rs"),
    include_str!("../../assets/shape.rs"),
    include_str!("../../assets/gltf/import/mod.rs"),
    include_str!("../../../../core/src/core/light_kind.rs"),
    include_str!("../../world/components.rs"),
    include_str!("../../world/animation/mod.rs"),
    include_str!("../../world/animation/key.rs"),
    include_str!("../../world/lens.rs"),
    include_str!("../../world/instant_radiosity.rs"),
    include_str!("../../world/light_culling.rs"),
    include_str!("../../world/fog.rs"),
    include_str!("../../world/particles.rs"),
];
