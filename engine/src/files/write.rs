//! The text of a scene file, and how it gets to disk.

use super::custom_components::ComponentTypes;
use super::document::ron_options;
use super::error::{FileError, FileErrorKind as Kind};
use super::format::{ImportSettings, MaterialFile, PrefabFile, SceneFile};
use super::tree::{Node, OWN};
use crate::core::{beside, discard, write_in_place_of};
use crate::world::{
    Animation, Bloom, Camera, Clpv, DepthOfField, Fog, InstantRadiosity, Lens, Light, Particles, SceneSettings,
    StochasticLightCulling,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The file's text, without the fields that say what is the default anyway.
pub fn to_text(file: &SceneFile, types: Option<&ComponentTypes>) -> Result<String, ron::Error> {
    let mut tree = Node::parse(&ron_options().to_string(file)?);
    let defaults = Defaults::new(types)?;
    tree.for_each_field(&mut |key, node| defaults.drop_from(key, node));
    tree.drop_defaults(&defaults.scene, &["entities", "gi"]);
    let body = tree.pretty();
    Ok(format!("Scene{body}"))
}

/// The text of a prefab file, likewise.
pub fn prefab_text(file: &PrefabFile, types: Option<&ComponentTypes>) -> Result<String, ron::Error> {
    let mut tree = Node::parse(&ron_options().to_string(file)?);
    let defaults = Defaults::new(types)?;
    tree.for_each_field(&mut |key, node| defaults.drop_from(key, node));
    Ok(format!("Prefab{}\n", tree.pretty()))
}

/// How the defaults of components look in a file.
pub(super) struct Defaults {
    scene: Node,
    components: BTreeMap<&'static str, Node>,
    material: Node,
    own: BTreeMap<&'static str, Node>,
}

impl Defaults {
    pub fn new(types: Option<&ComponentTypes>) -> Result<Self, ron::Error> {
        fn node(value: &impl Serialize) -> Result<Node, ron::Error> {
            Ok(Node::parse(&ron_options().to_string(value)?))
        }
        let components = BTreeMap::from([
            ("light", node(&Light::default())?),
            ("camera", node(&Camera::default())?),
            ("lens", node(&Lens::default())?),
            ("depth_of_field", node(&DepthOfField::default())?),
            ("bloom", node(&Bloom::default())?),
            ("clpv", node(&Clpv::default())?),
            ("vpl", node(&InstantRadiosity::default())?),
            ("slc", node(&StochasticLightCulling::default())?),
            ("fog", node(&Fog::default())?),
            ("particles", node(&Particles::default())?),
            ("animation", node(&Animation::default())?),
            ("import", node(&ImportSettings::default())?),
            ("settings", node(&SceneSettings::default())?),
        ]);
        let own = types.map(ComponentTypes::defaults).unwrap_or_default();
        Ok(Self { scene: node(&SceneFile::default())?, components, material: node(&MaterialFile::default())?, own })
    }

    fn drop_from(&self, key: &str, node: &mut Node) {
        match key {
            "gi" => node.unraw(),
            OWN => self.drop_from_own(node),
            "material" => node.drop_defaults(&self.material, &[]),
            "materials" => node.for_each_field(&mut |_, material| material.drop_defaults(&self.material, &[])),
            _ => {
                if let Some(default) = self.components.get(key) {
                    node.drop_defaults(default, &["kind", "intensity"]);
                }
            }
        }
    }
}

impl Defaults {
    /// The value without fields that say what is the default, by the key of the group that holds it and its own.
    pub fn printed(&self, holder: &str, own: &str, node: &Node) -> Node {
        let mut tree = node.clone().within(own).within(holder);
        tree.for_each_field(&mut |key, node| self.drop_from(key, node));
        // A value that is the default itself is asked for by name.
        let inner = tree.into_only().and_then(Node::into_only);
        inner.unwrap_or_else(|| node.clone())
    }

    fn drop_from_own(&self, node: &mut Node) {
        node.for_each_direct_field(&mut |name, component| {
            if let Some(default) = self.own.get(name.trim_matches('"')) {
                component.drop_defaults(default, &[]);
            }
        });
    }
}

/// Replaces the file in one step, and keeps the one before as `NAME.bak`. Both have the permissions of the file before.
pub fn write_atomically(path: &Path, text: &str) -> Result<(), FileError> {
    // A link stays a link: the file it leads to is replaced.
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let failed = |what: &str, e: &std::io::Error| {
        FileError::new(path, Kind::Io, format!("{what}: {e}"))
            .with_help("check the folder's permissions and free space")
    };
    if path.file_name().is_none() {
        return Err(FileError::new(path, Kind::Io, "the path names no file"));
    }
    super::remove_leftovers(path);
    let (temporary, copy) = (beside(path, ".tmp"), beside(path, ".bak.tmp"));
    let mut backup = path.as_os_str().to_owned();
    backup.push(".bak");
    let result = write_in_place_of(&temporary, text.as_bytes(), path)
        .map_err(|e| failed("cannot write beside it", &e))
        .and_then(|()| match path.exists() {
            // In one step too: a backup that is cut off would be none.
            true => std::fs::read(path)
                .and_then(|old| write_in_place_of(&copy, &old, path))
                .and_then(|()| std::fs::rename(&copy, backup))
                .map_err(|e| failed("cannot keep the file before as backup", &e)),
            false => Ok(()),
        })
        .and_then(|()| std::fs::rename(&temporary, path).map_err(|e| failed("cannot replace it", &e)));
    if result.is_err() {
        [&temporary, &copy].into_iter().for_each(|file| discard(file));
    }
    result
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::core::replace_file;
    use std::fs::File;
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::{MetadataExt, PermissionsExt};

    #[test]
    fn permissions_stay_those_of_the_file_before() {
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| folder.path().join(name).metadata().unwrap().mode() & 0o777;
        let (path, plain) = (folder.path().join("a.scene.ron"), folder.path().join("plain"));
        File::create(&plain).unwrap();
        write_atomically(&path, "one").unwrap();
        assert_eq!(mode("a.scene.ron"), mode("plain"), "a new file has the usual permissions");
        for wanted in [0o600, 0o640, 0o664, 0o755, 0o444] {
            set_permissions(&path, Permissions::from_mode(wanted)).unwrap();
            write_atomically(&path, "two").unwrap();
            assert_eq!((mode("a.scene.ron"), mode("a.scene.ron.bak")), (wanted, wanted), "{wanted:o}");
            replace_file(&path, b"three").unwrap();
            assert_eq!(mode("a.scene.ron"), wanted, "{wanted:o}");
        }
    }

    #[test]
    fn the_owner_stays_where_the_system_lets() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scene.ron");
        std::fs::write(&path, "one").unwrap();
        if std::os::unix::fs::chown(&path, Some(4242), Some(4243)).is_err() {
            return; // only root may give files away
        }
        write_atomically(&path, "two").unwrap();
        for name in ["a.scene.ron", "a.scene.ron.bak"] {
            let data = folder.path().join(name).metadata().unwrap();
            assert_eq!((data.uid(), data.gid()), (4242, 4243), "{name}");
        }
    }
}
