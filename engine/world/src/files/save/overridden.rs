//! Values that were changed for a run and are no part of the document, as the command line changes them: a save writes
//! what the file said, unless they were edited since.

use crate::core::SceneId;
use crate::files::format::scene_file::OverrideFile;
use crate::files::ron::document::ron_options;
use crate::files::ron::preserve::same;
use crate::files::ron::tree::{Group, Item, Node};
use crate::world::SceneSettings;
use bevy_ecs::prelude::Resource;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::{BTreeSet, HashMap};

/// The changes for this run, see [`override_values`](super::override_values::override_values).
#[derive(Resource, Clone, Debug, Default)]
pub struct Overridden {
    /// As it was asked for, `--set PATH=VALUE`.
    pub(super) sets: Vec<String>,
    pub(super) entities: HashMap<SceneId, Change<OverrideFile>>,
    pub(super) settings: Option<Change<SceneSettings>>,
    pub(super) added: HashMap<SceneId, OverrideFile>,
}

/// A value in the file and as it was set.
#[derive(Clone, Debug)]
pub(super) struct Change<T> {
    pub(super) file: T,
    pub(super) set: T,
}

impl Overridden {
    /// The description of an entity in a file.
    pub(in crate::files) fn saved(&self, id: Option<SceneId>, now: OverrideFile) -> OverrideFile {
        let change = id.and_then(|id| self.entities.get(&id));
        change.and_then(|change| change.restored(&now)).unwrap_or(now)
    }

    /// The settings as a file has them.
    pub(in crate::files) fn saved_settings(&self, now: SceneSettings) -> SceneSettings {
        self.settings.as_ref().and_then(|change| change.restored(&now)).unwrap_or(now)
    }

    /// Whether the entity was added for this run, and is as it was added.
    pub(in crate::files) fn is_added(&self, id: Option<SceneId>, now: &OverrideFile) -> bool {
        id.and_then(|id| self.added.get(&id)) == Some(now)
    }

    /// The fields of an entity that a save leaves as the file has them, as paths such as `light.intensity`.
    pub fn fields(&self, id: SceneId, now: &OverrideFile) -> BTreeSet<String> {
        self.entities.get(&id).map(|change| change.fields(now)).unwrap_or_default()
    }

    /// The settings of the scene that a save leaves as the file has them.
    pub fn settings(&self, now: &SceneSettings) -> BTreeSet<String> {
        self.settings.as_ref().map(|change| change.fields(now)).unwrap_or_default()
    }

    /// The arguments that changed a field: all whose path ends like it, or else all.
    pub fn reason(&self, field: &str) -> String {
        let field = field.strip_prefix("components.").unwrap_or(field);
        let names_it = |set: &&String| {
            let target = set.trim_start_matches("--set").split('=').next().unwrap_or_default();
            ends_like(target.trim(), field)
        };
        let named: Vec<&str> = self.sets.iter().filter(names_it).map(String::as_str).collect();
        let all = || self.sets.iter().map(String::as_str).collect();
        let sets: Vec<&str> = if named.is_empty() { all() } else { named };
        format!("set by the command line: {}; not saved", sets.join(", "))
    }
}

/// Whether a target means a field or something inside of it.
fn ends_like(target: &str, field: &str) -> bool {
    format!(".{target}.").contains(&format!(".{field}."))
}

impl<T: Serialize + DeserializeOwned> Change<T> {
    /// The value as a file says it: what was set and is so still, as the file has it.
    fn restored(&self, now: &T) -> Option<T> {
        let [file, set, now] = [&self.file, &self.set, now].map(node);
        let mut fields = BTreeSet::new();
        let restored = restored(Some(&file?), Some(&set?), Some(&now?), "", &mut fields)?;
        ron_options().from_str(&restored.compact()).ok()
    }

    fn fields(&self, now: &T) -> BTreeSet<String> {
        let mut fields = BTreeSet::new();
        if let [Some(file), Some(set), Some(now)] = [&self.file, &self.set, now].map(node) {
            restored(Some(&file), Some(&set), Some(&now), "", &mut fields);
        }
        fields
    }
}

fn node(value: &impl Serialize) -> Option<Node> {
    ron_options().to_string(value).ok().map(|text| Node::parse(&text))
}

/// `now` with the file's value where it is still what was set; `fields` gets the paths of those.
fn restored(
    file: Option<&Node>,
    set: Option<&Node>,
    now: Option<&Node>,
    path: &str,
    fields: &mut BTreeSet<String>,
) -> Option<Node> {
    let equal = |a: Option<&Node>, b: Option<&Node>| match (a, b) {
        (Some(a), Some(b)) => same(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    if equal(file, set) {
        return now.cloned();
    }
    let groups = [file, set, now].map(|node| node.and_then(|node| node.group.as_ref().map(|group| (node, group))));
    let [Some((f, file_group)), Some((s, set_group)), Some((n, now_group))] = groups else {
        return whole(file, now, path, fields, equal(set, now));
    };
    let has_keys = |group: &Group| group.open != '[' && group.items.iter().all(|item| item.key.is_some());
    if f.head != s.head || s.head != n.head || ![file_group, set_group, now_group].into_iter().all(has_keys) {
        return whole(file, now, path, fields, equal(set, now));
    }
    let mut result = n.clone();
    let mut items = Vec::new();
    let known: BTreeSet<&Option<String>> =
        [file_group, set_group, now_group].iter().flat_map(|group| &group.items).map(|item| &item.key).collect();
    for key in known {
        let name = key.as_deref().unwrap_or_default();
        let inner = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        let value = restored(file_group.get(key), set_group.get(key), now_group.get(key), &inner, fields);
        let item = [now_group, file_group].into_iter().flat_map(|group| &group.items).find(|item| item.key == *key);
        if let (Some(node), Some(item)) = (value, item) {
            items.push(Item { node, ..item.clone() });
        }
    }
    result.group.as_mut()?.items = items;
    Some(result)
}

/// A value that cannot be taken apart.
fn whole(
    file: Option<&Node>,
    now: Option<&Node>,
    path: &str,
    fields: &mut BTreeSet<String>,
    is_set: bool,
) -> Option<Node> {
    if is_set {
        fields.insert(path.to_owned());
    }
    if is_set { file.cloned() } else { now.cloned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saved(file: &str, set: &str, now: &str) -> (String, String) {
        let [file, set, now] = [file, set, now].map(Node::parse);
        let mut fields = BTreeSet::new();
        let saved = restored(Some(&file), Some(&set), Some(&now), "", &mut fields);
        (saved.map(|node| node.compact()).unwrap_or_default(), fields.into_iter().collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn what_was_set_is_the_files_until_it_is_edited() {
        let (file, set) = ("(a: (x: 1, y: 2), c: 3)", "(a: (x: 5, y: 2), b: 7, c: 3)");
        assert_eq!(saved(file, set, set), ("(a: (x: 1, y: 2), c: 3)".into(), "a.x b".into()));
        let edited = "(a: (x: 6, y: 4), b: 7, c: 8)";
        assert_eq!(saved(file, set, edited), ("(a: (x: 6, y: 4), c: 8)".into(), "b".into()));
        assert_eq!(saved("(k: P)", "(k: S(i: 1))", "(k: S(i: 2))").0, "(k: S(i: 2))");
    }

    #[test]
    fn the_reason_is_what_asked_for_it() {
        let sets =
            ["--set Lamp.light.intensity=5", "--set preset=x", "--set scene.exposure=2"].map(str::to_owned).to_vec();
        let overridden = Overridden { sets, ..Default::default() };
        let said = "set by the command line: --set Lamp.light.intensity=5; not saved";
        assert_eq!(overridden.reason("light.intensity"), said);
        assert_eq!(overridden.reason("components.light.intensity"), said);
        assert!(overridden.reason("camera.fov").contains("--set preset=x"));
    }
}
