//! The text of a scene or prefab file.

use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::{ImportSettings, MaterialFile, PrefabFile, SceneFile};
use crate::files::ron::document::ron_options;
use crate::files::ron::tree::{Node, OWN};
use crate::world::{
    Animation, Bloom, Camera, Clpv, DepthOfField, Fog, InstantRadiosity, Lens, Light, Particles, SceneSettings,
    StochasticLightCulling,
};
use serde::Serialize;
use std::collections::BTreeMap;

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
pub(in crate::files) struct Defaults {
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
