//! Content keys: 64-bit hashes of everything that went into a version of a resource.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::builder::{Graph, ResourceNode, Storage};

/// A content key; `None` is volatile: unknown content, equal to nothing, not even itself.
pub(super) type Key = Option<u64>;

/// Hashes with SipHash under fixed keys, so that equal inputs give equal keys in every run.
#[doc(hidden)]
pub fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// All that one execution of a pass depends on, kept so that a report can tell what changed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Recipe {
    pub pass: String,
    pub seed: u64,
    /// The pass's own key.
    pub own: Key,
    /// Names and keys of the versions read, then of those modified in place.
    pub inputs: Vec<(String, Key)>,
}

impl Recipe {
    /// The key of what the pass makes of one of its resources.
    pub fn output_key(&self, resource: &ResourceNode) -> Key {
        let own = self.own?;
        let inputs = self.inputs.iter().map(|(_, key)| *key).collect::<Option<Vec<u64>>>()?;
        Some(hash(&(self.seed, &self.pass, own, hash(&(&resource.name, &resource.desc)), inputs)))
    }
}

/// The recipe of every pass, and the key of every version by resource and number.
pub(super) struct Keys {
    pub recipes: Vec<Recipe>,
    pub versions: Vec<Vec<Key>>,
}

impl Keys {
    /// Derives all keys, in an `order` in which inputs come before what is made of them.
    pub fn new(graph: &Graph<'_>, order: &[usize]) -> Self {
        let versions = graph.resources.iter().map(|resource| {
            let mut keys = vec![None; resource.writers.len() + 1];
            keys[0] = resource.initial_key();
            keys
        });
        let mut versions: Vec<Vec<Key>> = versions.collect();
        let mut recipes: Vec<Option<Recipe>> = vec![None; graph.passes.len()];
        for &index in order {
            let recipe = recipe(graph, index, &versions);
            for write in &graph.passes[index].writes {
                versions[write.resource][write.number + 1] = recipe.output_key(&graph.resources[write.resource]);
            }
            recipes[index] = Some(recipe);
        }
        Self { recipes: recipes.into_iter().flatten().collect(), versions }
    }
}

fn recipe(graph: &Graph<'_>, index: usize, versions: &[Vec<Key>]) -> Recipe {
    let pass = &graph.passes[index];
    let inputs = graph.inputs(index).map(|version| {
        let name = graph.resources[version.resource].name.clone();
        (name, versions[version.resource][version.number])
    });
    Recipe { pass: pass.name.clone(), seed: graph.seed, own: pass.key, inputs: inputs.collect() }
}

impl ResourceNode {
    /// The key of version 0: an import's content. Nothing else has content yet.
    fn initial_key(&self) -> Key {
        match &self.storage {
            Storage::Imported { content, .. } => Some(hash(&(&self.name, &self.desc, (*content)?))),
            Storage::Transient | Storage::Retained => None,
        }
    }
}
