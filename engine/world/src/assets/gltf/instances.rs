//! Copies of what a node draws: `EXT_mesh_gpu_instancing`.

use super::accessor::{Buffers, place};
use crate::assets::AssetError;
use crate::core::Transform;
use glam::{Quat, Vec3};
use gltf::Document;
use gltf::accessor::Accessor;
use gltf::json::Value;

const NAME: &str = "EXT_mesh_gpu_instancing";

/// Most copies of a node.
const MAX_INSTANCES: usize = 100_000;

/// Where the copies of a node's meshes stand, in the node's own space; none if the node has none.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers,
    node: &gltf::json::Node,
    at: &str,
) -> Result<Vec<Transform>, AssetError> {
    let others = node.extensions.as_ref().map(|e| &e.others);
    let Some(attributes) = others.and_then(|e| e.get(NAME)).and_then(|e| e.get("attributes")) else {
        return Ok(Vec::new());
    };
    let fail = |problem: String| AssetError::format(buffers.path, format!("{at}, {NAME}"), problem);
    let accessor = |name: &str| -> Result<Option<Accessor>, AssetError> {
        let Some(index) = attributes.get(name) else { return Ok(None) };
        let found = index.as_u64().and_then(|i| document.accessors().nth(i as usize));
        found.map(Some).ok_or_else(|| fail(format!("{name} refers to accessor {index}, which is not there")))
    };
    let (translations, rotations, scales) = (accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?);
    let counts: Vec<usize> = [&translations, &rotations, &scales].into_iter().flatten().map(Accessor::count).collect();
    let Some(&count) = counts.first() else { return Ok(Vec::new()) };
    if counts.iter().any(|c| *c != count) || count > MAX_INSTANCES {
        return Err(fail(format!("accessors of {counts:?} elements: all must have as many, at most {MAX_INSTANCES}")));
    }
    let mut instances = vec![Transform::default(); count];
    if let Some(a) = &translations {
        let values = buffers.vectors::<3>(a)?;
        instances.iter_mut().zip(values).for_each(|(to, v)| to.translation = Vec3::from(v));
    }
    if let Some(a) = &rotations {
        let values = buffers.vectors::<4>(a)?;
        instances.iter_mut().zip(values).for_each(|(to, v)| to.rotation = Quat::from_array(v));
    }
    if let Some(a) = &scales {
        let values = buffers.vectors::<3>(a)?;
        instances.iter_mut().zip(values).for_each(|(to, v)| to.scale = Vec3::from(v));
    }
    let broken = instances.iter().position(|t| !t.matrix().is_finite() || !t.rotation.is_finite());
    match broken.zip(translations.or(rotations).or(scales)) {
        Some((i, a)) => Err(fail(format!("{}: instance {i} is not finite", place(&a)))),
        None => Ok(instances),
    }
}

/// Whether the extension says more of the copies than their places.
pub(super) fn has_more(node: &gltf::json::Node) -> bool {
    let others = node.extensions.as_ref().map(|e| &e.others);
    let attributes = others.and_then(|e| e.get(NAME)).and_then(|e| e.get("attributes")).and_then(Value::as_object);
    attributes.is_some_and(|a| a.keys().any(|key| !matches!(key.as_str(), "TRANSLATION" | "ROTATION" | "SCALE")))
}
