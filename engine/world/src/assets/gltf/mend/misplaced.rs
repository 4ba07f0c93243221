//! Extensions under the names of their drafts, and where they do not belong.

use crate::assets::gltf::remarks::Remarks;
use gltf::json::Value;
use std::collections::{BTreeSet, HashMap};

/// Names of drafts that exporters have written, and the names of the extensions that became of them.
const DRAFTS: [(&str, &str); 2] = [("EXT_texture_transform", TRANSFORM), ("KHR_lights", "KHR_lights_punctual")];
const TRANSFORM: &str = "KHR_texture_transform";

/// Renames drafts of extensions, and moves the transforms of textures to the materials that use them.
pub(in crate::assets::gltf) fn move_misplaced(root: &mut Value, remarks: &mut Remarks) {
    let mut renamed = BTreeSet::new();
    rename(root, &mut renamed);
    for list in ["extensionsUsed", "extensionsRequired"] {
        for name in root.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten() {
            let draft = DRAFTS.into_iter().find(|(draft, _)| name.as_str() == Some(*draft));
            if let Some((draft, became)) = draft {
                renamed.insert((draft, became));
                *name = Value::from(became);
            }
        }
    }
    for (draft, became) in renamed {
        remarks.fault(format!("the extension {draft} is a draft; read as {became}"));
    }
    move_transforms(root, remarks);
}

/// Renames the keys of all objects of extensions.
fn rename(value: &mut Value, renamed: &mut BTreeSet<(&str, &str)>) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| rename(item, renamed)),
        Value::Object(fields) => {
            if let Some(extensions) = fields.get_mut("extensions").and_then(Value::as_object_mut) {
                for (draft, became) in DRAFTS {
                    if !extensions.contains_key(became)
                        && let Some(content) = extensions.remove(draft)
                    {
                        extensions.insert(became.into(), content);
                        renamed.insert((draft, became));
                    }
                }
            }
            fields.values_mut().for_each(|field| rename(field, renamed));
        }
        _ => {}
    }
}

/// A transform belongs to the use of a texture in a material, and not to the texture.
fn move_transforms(root: &mut Value, remarks: &mut Remarks) {
    let textures = root.get_mut("textures").and_then(Value::as_array_mut).into_iter().flatten();
    let mut transforms = HashMap::new();
    for (index, texture) in textures.enumerate() {
        let extensions = texture.get_mut("extensions").and_then(Value::as_object_mut);
        if let Some(transform) = extensions.and_then(|extensions| extensions.remove(TRANSFORM)) {
            remarks.fault(format!("texture {index}: {TRANSFORM} belongs to the uses of the texture; moved there"));
            transforms.insert(index as u64, transform);
        }
    }
    if let Some(materials) = root.get_mut("materials").filter(|_| !transforms.is_empty()) {
        give_transforms(materials, &transforms);
    }
}

/// Gives the uses of textures the transforms of these, unless they have one.
fn give_transforms(value: &mut Value, transforms: &HashMap<u64, Value>) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| give_transforms(item, transforms)),
        Value::Object(fields) => {
            if let Some(transform) = fields.get("index").and_then(Value::as_u64).and_then(|i| transforms.get(&i)) {
                let extensions = fields.entry("extensions").or_insert_with(|| Value::Object(Default::default()));
                if let Some(extensions) = extensions.as_object_mut() {
                    extensions.entry(TRANSFORM).or_insert_with(|| transform.clone());
                }
            }
            fields.values_mut().for_each(|field| give_transforms(field, transforms));
        }
        _ => {}
    }
}
