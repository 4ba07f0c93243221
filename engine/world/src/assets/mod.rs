//! Meshes, materials and textures: import, procedural shapes, and the cache of loaded assets.

pub(crate) mod atmosphere;
mod ball;
mod balls;
mod budget;
mod clip;
mod cube_table;
mod deform;
mod error;
mod gltf;
mod image;
mod ktx2;
pub mod layers;
mod library;
mod material;
mod mesh;
#[doc(hidden)]
pub mod parallel;
mod pixels;
mod pose;
mod shape;
mod shape_mesh;
#[cfg(test)]
mod shape_tests;
mod sky_directions;
mod sky_image;
mod sky_map;
mod sky_reflection;
mod texture;
mod vertex;

pub use self::budget::LoadBudget;
pub(crate) use self::budget::Meter;
pub use self::clip::{Between, Clip, Curve, NodeCurves};
pub use self::deform::{Deform, Influences, MorphTarget, Pose};
pub use self::error::AssetError;
#[cfg(test)]
pub(crate) use self::gltf::rig_tests;
pub use self::gltf::{
    Gltf, GltfCamera, GltfLight, GltfNode, GltfPrimitive, GltfSkin, ImportFault, ImportSettings, LightConversion,
    LightUnits, Normals, Parts, UpAxis,
};
pub use crate::core::{AssetId, MAX_IMAGE_SIZE};
pub use atmosphere::{Atmosphere, AtmosphereTables};
pub use ball::Ball;
pub(crate) use balls::{material_of_balls, mesh_of_balls};
pub use cube_table::CubeTable;
pub use layers::{Anisotropy, Clearcoat, Iridescence, Sheen};
pub use library::AssetLibrary;
#[doc(hidden)]
pub use material::TEXTURE_COUNT;
pub use material::{AlphaMode, Attenuation, Material, UvMap, UvMaps};
pub use mesh::Mesh;
pub(crate) use pose::pose_all;
pub use shape::{MAX_SEGMENTS, Shape};
#[doc(hidden)]
pub use sky_directions::{SkyDirections, SkySample};
pub use sky_map::SkyMap;
pub use sky_reflection::{REFLECTION_LEVELS, SkyReflection};
pub use texture::{Levels, Minification, Sampling, Texture, Wrap};
pub use vertex::{Vertex, VertexExtra};

use std::path::Path;

/// Largest file that is read \[bytes\].
const MAX_FILE: u64 = 4 << 30;

/// Reads a whole regular file of sensible size, if the budget allows.
fn read_file(path: &Path, meter: &Meter) -> Result<Vec<u8>, AssetError> {
    meter.ask(path);
    let meta = std::fs::metadata(path).map_err(|e| AssetError::io(path, e))?;
    if !meta.is_file() {
        return Err(AssetError::format(path, "file", "is a folder or device, not a regular file"));
    }
    if meta.len() > MAX_FILE {
        return Err(AssetError::format(path, "file", format!("has {} bytes; at most {MAX_FILE} are read", meta.len())));
    }
    meter.bytes(path, meta.len())?;
    std::fs::read(path).map_err(|e| AssetError::io(path, e))
}
