//! From the nodes of a model to entities.

use super::components::renderer;
use super::source::{Origin, Source};
use crate::assets::{Gltf, GltfNode, LightConversion, Material, Mesh};
use crate::files::format::scene_file::OverrideFile;
use crate::world::{ClipTarget, Clips, GameWorld, MeshRenderer, MorphWeights, Posed};
use bevy_ecs::prelude::Entity;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

/// The parts that are taken from a model.
pub(in crate::files) struct Take<'a> {
    /// How intensities are read; none: lights are left out.
    pub lights: Option<LightConversion>,
    pub cameras: bool,
    pub material: Option<&'a Arc<Material>>,
    pub components: &'a OverrideFile,
}

/// A model that is being spawned below an entity.
pub(in crate::files) struct Model<'a> {
    world: &'a mut GameWorld,
    gltf: &'a Gltf,
    root: Entity,
    take: Take<'a>,
    names: Names,
    /// Entities of the nodes.
    entities: BTreeMap<usize, Entity>,
    /// A skinned mesh: the node, its mesh's entity and the mesh.
    skinned: Vec<(usize, Entity, Arc<Mesh>)>,
}

impl<'a> Model<'a> {
    pub fn new(world: &'a mut GameWorld, gltf: &'a Gltf, root: Entity, take: Take<'a>) -> Self {
        let (names, entities, skinned) = (Names::default(), BTreeMap::new(), Vec::new());
        Self { world, gltf, root, take, names, entities, skinned }
    }

    /// The entity of a node that is there for its place alone, with those above it.
    pub fn holder(&mut self, node: usize) -> Entity {
        let mut above = Vec::new();
        let mut next = Some(node);
        while let Some(node) = next.filter(|node| !self.entities.contains_key(node)) {
            above.push(node);
            next = self.gltf.nodes[node].parent;
        }
        let mut parent = next.and_then(|node| self.entities.get(&node)).copied().unwrap_or(self.root);
        while let Some(node) = above.pop() {
            parent = self.place(node, parent);
        }
        parent
    }

    /// Spawns nodes with all below them. Iterative: models may nest deeper than the stack.
    pub fn spawn(&mut self, roots: &[usize], parent: Entity) {
        let mut pending: Vec<(usize, Entity)> = roots.iter().rev().map(|r| (*r, parent)).collect();
        while let Some((index, parent)) = pending.pop() {
            let node = &self.gltf.nodes[index];
            let entity = self.place(index, parent);
            self.primitives(index, node, entity);
            if let Some((light, conversion)) = node.light.as_ref().zip(self.take.lights.as_ref()) {
                self.world.ecs.entity_mut(entity).insert(conversion.apply(light).light());
            }
            if let Some(camera) = node.camera.as_ref().filter(|_| self.take.cameras) {
                self.world.ecs.entity_mut(entity).insert(camera.camera());
            }
            pending.extend(node.children.iter().rev().map(|c| (*c, entity)));
        }
    }

    fn place(&mut self, index: usize, parent: Entity) -> Entity {
        let node = &self.gltf.nodes[index];
        let name = self.names.unique(parent, &node.name);
        let entity = self.world.spawn(&name, Some(parent));
        self.world.ecs.entity_mut(entity).insert((node.local, model_source()));
        if !node.weights.is_empty() {
            self.world.ecs.entity_mut(entity).insert(MorphWeights(node.weights.clone()));
        }
        self.entities.insert(index, entity);
        entity
    }

    /// The mesh of a node. Joints say where skinned meshes are, and not the node: they stand at the model's root.
    fn primitives(&mut self, index: usize, node: &GltfNode, entity: Entity) {
        let is_skinned = |mesh: &Mesh| node.skin.is_some() && mesh.deform.as_ref().is_some_and(|d| d.skin.is_some());
        for (i, (mesh, material)) in node.primitives.iter().enumerate() {
            let material = self.take.material.unwrap_or(material).clone();
            let renderer = renderer(self.take.components, mesh.clone(), material);
            if !node.instances.is_empty() && !is_skinned(mesh) {
                self.copies(node, entity, &renderer);
                continue;
            }
            let part = if is_skinned(mesh) {
                self.part(self.root, &format!("{} skin", node.name))
            } else if node.primitives.len() == 1 {
                entity
            } else {
                self.part(entity, &format!("primitive {i}"))
            };
            self.world.ecs.entity_mut(part).insert(renderer);
            if is_skinned(mesh) {
                self.skinned.push((index, part, mesh.clone()));
            } else if mesh.deform.is_some() {
                self.world.ecs.entity_mut(part).insert(Posed::new(mesh.clone(), Some(entity)));
            }
        }
    }

    /// One entity for each instance of the node.
    fn copies(&mut self, node: &GltfNode, entity: Entity, renderer: &MeshRenderer) {
        for place in &node.instances {
            let part = self.part(entity, "instance");
            self.world.ecs.entity_mut(part).insert((*place, renderer.clone()));
            if renderer.mesh.deform.is_some() {
                self.world.ecs.entity_mut(part).insert(Posed::new(renderer.mesh.clone(), Some(entity)));
            }
        }
    }

    fn part(&mut self, parent: Entity, name: &str) -> Entity {
        let name = self.names.unique(parent, name);
        let part = self.world.spawn(&name, Some(parent));
        self.world.ecs.entity_mut(part).insert(model_source());
        part
    }

    /// Binds skins to their joints and nodes to the model's clips.
    pub fn finish(mut self) {
        for (node, part, mesh) in std::mem::take(&mut self.skinned) {
            let weights = self.entities.get(&node).copied();
            let skin = self.gltf.nodes[node].skin.and_then(|skin| self.gltf.skins.get(skin));
            let Some(skin) = skin.cloned() else { continue };
            let joints = skin.joints.iter().map(|joint| self.holder(*joint)).collect();
            let inverse_bind = Arc::new(skin.inverse_bind.clone());
            let posed = Posed::new(mesh, weights).with_skin(self.root, joints, inverse_bind);
            self.world.ecs.entity_mut(part).insert(posed);
        }
        if self.gltf.clips.is_empty() {
            return;
        }
        self.world.ecs.entity_mut(self.root).insert(Clips(self.gltf.clips.clone()));
        let moved: BTreeSet<usize> = self.gltf.clips.iter().flat_map(|clip| clip.nodes.keys().copied()).collect();
        for node in moved {
            if let Some(&entity) = self.entities.get(&node) {
                self.world.ecs.entity_mut(entity).insert(ClipTarget { player: self.root, node });
            }
        }
    }
}

pub(in crate::files) fn model_source() -> Source {
    Source {
        components: OverrideFile::default(),
        material: None,
        prefab: None,
        repeat: None,
        overrides: BTreeMap::new(),
        members: Vec::new(),
        origin: Origin::Model,
    }
}

/// Makes names unique among siblings, and free of `/`.
#[derive(Default)]
pub(in crate::files) struct Names {
    taken: HashSet<(Entity, String)>,
    /// The number that the next one of a name gets, so that many of one name take no longer than others.
    next: HashMap<(Entity, String), u64>,
}

impl Names {
    pub(in crate::files) fn unique(&mut self, parent: Entity, name: &str) -> String {
        let base = name.replace('/', "_");
        if self.taken.insert((parent, base.clone())) {
            return base;
        }
        let next = self.next.entry((parent, base.clone())).or_insert(2);
        loop {
            let name = format!("{base} {next}");
            *next += 1;
            if self.taken.insert((parent, name.clone())) {
                return name;
            }
        }
    }
}

pub(in crate::files) fn despawn(world: &mut GameWorld, entities: &[Entity]) {
    for entity in entities {
        crate::world::despawn(&mut world.ecs, *entity);
    }
}
