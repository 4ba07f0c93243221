//! Bringing the device up to date with the scene: all of it, or only dynamic objects.

use super::material::is_nowhere_opaque;
use super::media::GpuMedia;
use super::mesh::{GpuMesh, is_drawable};
use super::{Batch, Blocks, DrawFilter, GpuScene, Instance, MaterialClass, Member, Motion};
use crate::assets::AssetId;
use crate::gpu::Gpu;
use crate::scene::{Aabb, Primitive, Scene, SceneId};
use bytemuck::Zeroable;
use std::collections::BTreeMap;

/// Which state of a scene the device holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Synced {
    identity: u64,
    geometry: u64,
    materials: u64,
    statics: u64,
}

impl Synced {
    fn of(scene: &Scene) -> Self {
        let revisions = scene.revisions;
        Self {
            identity: scene.identity,
            geometry: revisions.geometry,
            materials: revisions.materials,
            statics: revisions.statics,
        }
    }

    /// Whether the two states differ by nothing but moving primitives, of which there are the same.
    fn has_statics_of(&self, other: &Self) -> bool {
        self.statics != 0 && (self.identity, self.statics) == (other.identity, other.statics)
    }

    /// Changes with any static object.
    fn still_key(&self) -> [u64; 3] {
        // A scene that does not say which objects are dynamic is static as a whole.
        let revisions = if self.statics == 0 { [self.geometry, self.materials] } else { [self.statics, 0] };
        [self.identity, revisions[0], revisions[1]]
    }
}

/// A moving primitive.
pub(super) struct Mover {
    /// Its place among the scene's primitives.
    primitive: usize,
    /// Its batch, and its instance if it has anything that could be drawn.
    batch: usize,
    instance: Option<u32>,
}

impl GpuScene {
    /// Updates the device from the scene. Costs nothing if no primitive changed, and what is moving alone if
    /// nothing else changed.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene) {
        self.sky.update(gpu, scene);
        let media_revision = [scene.identity, scene.revisions.media];
        if self.media_revision != media_revision {
            (self.media, self.media_revision) = (GpuMedia::of(scene), media_revision);
        }
        let now = Synced::of(scene);
        if self.synced == Some(now) {
            return;
        }
        let follows = self.synced.is_some_and(|then| now.has_statics_of(&then)) && self.follow(gpu, scene);
        if !follows {
            self.rebuild(gpu, scene);
        }
        self.synced = Some(now);
    }

    /// Bounds of all primitives but particles of the scene that it was brought up to date with.
    pub fn bounds(&self, scene: &Scene) -> Aabb {
        let moving = self.movers.iter().filter_map(|mover| scene.primitives.get(mover.primitive));
        moving
            .filter(|primitive| !primitive.is_particles())
            .fold(self.still_bounds, |bounds, primitive| bounds.union(&primitive.bounds))
    }

    /// Changes with any static object.
    pub fn still_key(&self) -> [u64; 3] {
        self.synced.map_or([0; 3], |synced| synced.still_key())
    }

    /// Identity and revisions of all moving primitives that pass one of the filters.
    pub fn moving(&self, filters: &[DrawFilter]) -> Vec<[u64; 3]> {
        let mut moving = Vec::new();
        let batches = self.batches.iter().filter(|batch| batch.moving);
        for batch in batches {
            let filters = || filters.iter().map(|filter| filter.of(Motion::Moving)).filter(|f| batch.passes(f));
            let seen = batch.of(&self.members).iter().filter(|member| filters().any(|filter| member.visible(&filter)));
            moving.extend(seen.map(|member| [member.id.0, member.revisions[0], member.revisions[1]]));
        }
        moving
    }

    /// Updates the moving primitives. False if that takes more than new places and new poses.
    fn follow(&mut self, gpu: &Gpu, scene: &Scene) -> bool {
        let mut changed: Option<[usize; 2]> = None;
        for (index, mover) in self.movers.iter().enumerate() {
            let Some(primitive) = scene.primitives.get(mover.primitive) else { return false };
            let batch = &mut self.batches[mover.batch];
            let member = mover.instance.and_then(|instance| self.members.get_mut(instance as usize));
            let Some(member) = member.filter(|member| member.id == primitive.id) else {
                // It has nothing that could be drawn.
                if is_drawable(&primitive.mesh) { return false } else { continue }
            };
            if member.revisions == [primitive.geometry_revision, primitive.material_revision] {
                continue;
            }
            if MaterialClass::of(primitive) != batch.class || primitive.material.id != batch.material {
                return false;
            }
            if primitive.mesh.id != batch.mesh {
                if !self.meshes.repose(gpu, batch.mesh, &primitive.mesh) {
                    return false;
                }
                batch.mesh = primitive.mesh.id;
            }
            *member = Member::new(primitive);
            changed = Some([changed.map_or(index, |[first, _]| first), index]);
        }
        if let Some([first, last]) = changed {
            self.blocks.sum_up(&self.batches, &self.members, |batch| batch.moving);
            self.write_movers(gpu, scene, first, last);
        }
        true
    }

    /// Writes the instances of the movers from the `first` to the `last`.
    fn write_movers(&self, gpu: &Gpu, scene: &Scene, first: usize, last: usize) {
        let movers = || self.movers[first..=last].iter().filter(|mover| mover.instance.is_some());
        let Some(start) = movers().find_map(|mover| mover.instance) else { return };
        let instances: Vec<Instance> =
            movers().map(|mover| Instance::new(&scene.primitives[mover.primitive])).collect();
        let offset = u64::from(start) * size_of::<Instance>() as u64;
        gpu.write_buffer(&self.instances, offset, bytemuck::cast_slice(&instances));
    }

    fn rebuild(&mut self, gpu: &Gpu, scene: &Scene) {
        self.materials.update(gpu, scene.primitives.iter().map(|p| &p.material));
        self.meshes.update(gpu, &scene.primitives, |primitive| MaterialClass::of(primitive).plain);
        self.rebuild_batches(gpu, scene);
        let still = scene.primitives.iter().filter(|primitive| !primitive.moving);
        self.still_bounds = still.fold(Aabb::EMPTY, |bounds, primitive| bounds.union(&primitive.bounds));
    }

    fn rebuild_batches(&mut self, gpu: &Gpu, scene: &Scene) {
        type Group<'a> = Vec<(usize, &'a Primitive)>;
        let mut groups: BTreeMap<(bool, MaterialClass, AssetId, AssetId), Group> = BTreeMap::new();
        for (index, primitive) in scene.primitives.iter().enumerate() {
            let key = (primitive.moving, MaterialClass::of(primitive), primitive.material.id, primitive.mesh.id);
            if is_drawable(&primitive.mesh) || primitive.moving {
                groups.entry(key).or_default().push((index, primitive));
            }
        }
        let mut groups: Vec<_> = groups.into_iter().collect();
        let least = |members: &Group| members.iter().map(|(_, p)| p.id).min().unwrap_or(SceneId::default());
        groups.sort_by_key(|((moving, ..), members)| (*moving, least(members)));
        let mut instances = Vec::with_capacity(scene.primitives.len());
        self.batches.clear();
        self.members.clear();
        self.movers.clear();
        for ((moving, class, material, mesh), members) in groups {
            let place = self.meshes.get(mesh).map(GpuMesh::place);
            let first = instances.len() as u32;
            if moving {
                // All of a batch are of one mesh.
                let instance = |index: usize| place.map(|_| first + index as u32);
                let movers = members.iter().enumerate().map(|(index, &(primitive, _))| Mover {
                    primitive,
                    batch: self.batches.len(),
                    instance: instance(index),
                });
                self.movers.extend(movers);
            }
            let drawn = || members.iter().map(|(_, primitive)| *primitive).filter(|_| place.is_some());
            instances.extend(drawn().map(Instance::new));
            self.members.extend(drawn().map(Member::new));
            let nowhere_opaque = drawn().any(|primitive| is_nowhere_opaque(&primitive.material));
            let instances = first..instances.len() as u32;
            self.batches.push(Batch { moving, class, nowhere_opaque, material, mesh, place, instances });
        }
        self.blocks = Blocks::new(gpu, &self.batches, &self.members);
        if instances.is_empty() {
            instances.push(Instance::zeroed());
        }
        let bytes: &[u8] = bytemuck::cast_slice(&instances);
        if self.instances.size() == bytes.len() as u64 {
            gpu.write_buffer(&self.instances, 0, bytes);
        } else {
            self.instances = gpu.storage("instances", &instances, wgpu::BufferUsages::COPY_DST);
        }
    }
}
