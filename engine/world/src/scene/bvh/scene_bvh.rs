//! The hierarchies over all triangles of a scene, in world space: one of static primitives, one of each moving primitive.
//!
//! Static objects have no level of their own: rays that cross many overlapping objects are twice as fast, and every
//! triangle is transformed once. Moving ones have, so that only what moves is followed. Of hits at the same distance the
//! one with the lower index counts, unless rounding hides its box.

use super::movers::Movers;
use super::part::{PartTriangles, ScenePart, Source, Updated, winding};
use super::triangle::{SceneTriangle, place_corners};
use crate::bvh::{Bvh, Ray, intersect_triangle};
use crate::scene::{Primitive, Scene};
use glam::Vec3;
use std::ops::Range;
use std::time::{Duration, Instant};

/// The purpose of a ray, which decides what it can hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// What the camera sees: everything but the backs of single-sided surfaces, as when drawn by triangles.
    Camera,
    /// Transported radiance: whatever casts shadows, from both sides.
    Light,
}

/// A hit of a ray in a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Index in [`SceneBvh::triangles`].
    pub triangle: u32,
    /// Barycentric coordinates of the second and third corner.
    pub barycentric: [f32; 2],
}

/// All surfaces of a scene, ready for rays.
#[derive(Debug, Default)]
pub struct SceneBvh {
    /// Triangles, in the order of the scene's primitives and of their meshes.
    pub triangles: Vec<SceneTriangle>,
    /// Those of primitives that are not [moving](Primitive::moving).
    pub statics: ScenePart,
    /// Those of primitives that are.
    pub movers: Movers,
    /// How long the last update took.
    pub update_time: Duration,
    /// Changes with which primitives there are in which part, and with their materials.
    #[doc(hidden)]
    pub surfaces_version: u64,
    flags: Vec<Flags>,
    sources: Vec<Source>,
    /// Identity and statics revision of the last scene, if it tells.
    told: Option<[u64; 2]>,
    versions: u64,
}

/// Primitives that differ from what they were, by index and in the order of the scene.
#[derive(Default)]
struct Changes {
    /// In anything.
    any: Vec<usize>,
    /// In place or pose.
    moved: Vec<usize>,
    /// In the way that triangles wind.
    turned: Vec<usize>,
    /// Whether any is of another material, or lets rays do other things with it.
    has_surfaces: bool,
}

/// Per primitive: what rays may do with it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flags {
    casts_shadow: bool,
    double_sided: bool,
}

impl Flags {
    fn of(primitive: &Primitive) -> Self {
        Self { casts_shadow: primitive.blocks_light(), double_sided: primitive.material.double_sided }
    }
}

impl SceneBvh {
    /// The hierarchies of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut bvh = Self::default();
        bvh.update(scene);
        bvh
    }

    /// Updates everything from the scene. If the same primitives have only moved, the trees are kept and
    /// their boxes are fitted to them, unless that has made them too slow. A part in which nothing moved stays as it is.
    pub fn update(&mut self, scene: &Scene) -> Updated {
        let start = Instant::now();
        let statics = scene.revisions.statics;
        let told = (statics != 0).then_some([scene.identity, statics]);
        let are_statics_kept = told.is_some() && told == self.told;
        let fits = |index: usize| self.sources[index].is_of(&scene.primitives[index]);
        let same = self.sources.len() == scene.primitives.len()
            && if are_statics_kept { self.movers.primitives().all(fits) } else { (0..self.sources.len()).all(fits) };
        let updated = if !same || self.sources.is_empty() {
            self.rebuild(scene)
        } else if are_statics_kept {
            self.follow_movers(scene)
        } else {
            self.follow_statics(scene).max(self.follow_movers(scene))
        };
        self.told = told;
        self.update_time = start.elapsed();
        updated
    }

    /// The hierarchies that hold triangles: of static objects, and of each dynamic one.
    pub fn trees(&self) -> impl Iterator<Item = &Bvh> + Clone {
        std::iter::once(&self.statics.bvh).chain(self.movers.objects.iter().map(|object| &object.bvh))
    }

    /// Visits those of them that the ray meets before `t_max`. `visit` gets the bound so far, and returns the bound from
    /// there on.
    #[doc(hidden)]
    pub fn traverse_trees(&self, ray: &Ray, t_max: f32, mut visit: impl FnMut(&Bvh, f32) -> f32) {
        let bound = visit(&self.statics.bvh, t_max);
        let objects = &self.movers.objects;
        self.movers.top.traverse(ray, bound, |object, bound| visit(&objects[object as usize].bvh, bound));
    }

    /// Number of triangles of each moving primitive, with those that have no box and so are in no tree.
    #[doc(hidden)]
    pub fn counts_of_movers(&self) -> Vec<usize> {
        self.movers.primitives().map(|index| self.sources[index].count).collect()
    }

    /// Number of triangles of all of them.
    #[doc(hidden)]
    pub fn moving_triangles(&self) -> usize {
        self.movers.primitives().map(|index| self.sources[index].count).sum()
    }

    /// Indices of the triangles of a primitive.
    #[doc(hidden)]
    pub fn triangles_of(&self, primitive: usize) -> Range<usize> {
        let source = &self.sources[primitive];
        source.first..source.first + source.count
    }

    fn next_version(&mut self) -> u64 {
        self.versions += 1;
        self.versions
    }

    fn rebuild(&mut self, scene: &Scene) -> Updated {
        self.flags = scene.primitives.iter().map(Flags::of).collect();
        self.sources.clear();
        self.triangles.clear();
        self.statics.primitives.clear();
        let mut movers = Vec::new();
        for (primitive, index) in scene.primitives.iter().zip(0..) {
            let count = primitive.mesh.triangle_count();
            self.sources.push(Source {
                id: primitive.id,
                mesh: primitive.mesh.id,
                topology: primitive.mesh.topology(),
                winding: winding(primitive),
                material: primitive.material.id,
                is_moving: primitive.moving,
                is_glass: primitive.material.is_glass(),
                is_opaque: primitive.material.is_opaque(),
                world_from_object: primitive.world_from_object,
                first: self.triangles.len(),
                count,
            });
            let part = if primitive.moving { &mut movers } else { &mut self.statics.primitives };
            part.push(index as usize);
            let triangle = |triangle| SceneTriangle { corners: [Vec3::ZERO; 3], primitive: index, triangle };
            let first = self.triangles.len();
            self.triangles.extend((0..count as u32).map(triangle));
            place_corners(primitive, &mut self.triangles[first..]);
        }
        self.surfaces_version = self.next_version();
        let [statics, moving] = [self.next_version(), self.next_version()];
        let triangles = PartTriangles { first: 0, triangles: &self.triangles, sources: &self.sources };
        (self.statics.version, self.statics.built) = (statics, statics);
        self.statics.build(triangles, true);
        self.movers.build(movers, triangles, moving);
        Updated::Built
    }

    /// Takes the surfaces of primitives that are the same as before, and tells which of them changed in what.
    fn follow_surfaces(&mut self, scene: &Scene, primitives: &[usize]) -> Changes {
        let mut changes = Changes::default();
        for &index in primitives {
            let (source, primitive) = (&mut self.sources[index], &scene.primitives[index]);
            let flags = Flags::of(primitive);
            let (has_flags, has_surface) = (flags == self.flags[index], source.material == primitive.material.id);
            let is_placed = source.world_from_object == primitive.world_from_object && source.mesh == primitive.mesh.id;
            changes.has_surfaces |= !has_surface || !has_flags;
            if !has_flags || !has_surface || !is_placed {
                changes.any.push(index);
            }
            if !is_placed {
                changes.moved.push(index);
                let winding = winding(primitive);
                if std::mem::replace(&mut source.winding, winding) != winding {
                    changes.turned.push(index);
                }
            }
            self.flags[index] = flags;
            source.material = primitive.material.id;
            source.mesh = primitive.mesh.id;
            source.world_from_object = primitive.world_from_object;
        }
        if changes.has_surfaces {
            self.surfaces_version = self.next_version();
        }
        changes
    }

    /// Updates the static part where the same primitives have moved or have other surfaces.
    fn follow_statics(&mut self, scene: &Scene) -> Updated {
        let primitives = std::mem::take(&mut self.statics.primitives);
        let changes = self.follow_surfaces(scene, &primitives);
        self.statics.primitives = primitives;
        if changes.any.is_empty() {
            return Updated::Nothing;
        }
        let version = self.next_version();
        self.statics.version = version;
        for &index in &changes.moved {
            let source = &self.sources[index];
            let triangles = &mut self.triangles[source.first..source.first + source.count];
            place_corners(&scene.primitives[index], triangles);
        }
        if changes.moved.is_empty() {
            return Updated::Nothing;
        }
        let triangles = PartTriangles { first: 0, triangles: &self.triangles, sources: &self.sources };
        let updated = self.statics.refit(triangles, true);
        if updated == Updated::Built {
            self.statics.built = version;
        }
        updated
    }

    /// The same for the objects that move.
    fn follow_movers(&mut self, scene: &Scene) -> Updated {
        let primitives: Vec<usize> = self.movers.primitives().collect();
        let changes = self.follow_surfaces(scene, &primitives);
        if changes.any.is_empty() {
            return Updated::Nothing;
        }
        let version = self.next_version();
        self.movers.version = version;
        // Both lists are in the order of the scene.
        for object in &mut self.movers.objects {
            let is_in =
                |list: &[usize]| object.primitives.first().is_some_and(|index| list.binary_search(index).is_ok());
            let (has_changed, is_turned) = (is_in(&changes.any), is_in(&changes.turned));
            if has_changed {
                object.version = version;
            }
            if is_turned {
                object.built = version;
            }
        }
        if changes.moved.is_empty() {
            return Updated::Nothing;
        }
        let has_moved = |index: usize| changes.moved.binary_search(&index).is_ok();
        self.movers.follow(&scene.primitives, &mut self.triangles, &self.sources, has_moved)
    }

    /// The nearest hit of the ray before `t_max`. Alpha is ignored.
    pub fn closest_hit(&self, ray: &Ray, t_max: f32, kind: RayKind) -> Option<SceneHit> {
        let mut closest: Option<SceneHit> = None;
        self.traverse_trees(ray, t_max, |bvh, bound| {
            bvh.traverse(ray, bound, |index, bound| match self.meets(ray, index, kind) {
                Some(hit) if is_nearer(hit.t, index, bound, closest.map(|best| (best.t, best.triangle))) => {
                    closest = Some(hit);
                    hit.t
                }
                _ => bound,
            });
            closest.map_or(bound, |hit| hit.t)
        });
        closest
    }

    /// The same by trying every triangle: what the hierarchies are tested against.
    pub fn closest_hit_by_brute_force(&self, ray: &Ray, t_max: f32, kind: RayKind) -> Option<SceneHit> {
        let mut closest: Option<SceneHit> = None;
        for index in 0..self.triangles.len() as u32 {
            let bound = closest.map_or(t_max, |hit| hit.t);
            closest = self.meets(ray, index, kind).filter(|hit| hit.t < bound).or(closest);
        }
        closest
    }

    /// Whether anything that casts shadows lies on the ray before `t_max`.
    pub fn is_blocked(&self, ray: &Ray, t_max: f32) -> bool {
        // Nothing lies before the ray's start: a bound below it ends the search.
        const ENDED: f32 = -1.0;
        let mut blocked = false;
        self.traverse_trees(ray, t_max, |bvh, bound| {
            bvh.traverse(ray, bound, |index, bound| {
                blocked |= self.meets(ray, index, RayKind::Light).is_some_and(|hit| hit.t < bound);
                if blocked { ENDED } else { bound }
            });
            if blocked { ENDED } else { bound }
        });
        blocked
    }

    fn meets(&self, ray: &Ray, index: u32, kind: RayKind) -> Option<SceneHit> {
        let triangle = &self.triangles[index as usize];
        let (t, u, v) = intersect_triangle(ray, triangle.corners, f32::INFINITY)?;
        let flags = self.flags[triangle.primitive as usize];
        let counts = match kind {
            RayKind::Light => flags.casts_shadow,
            RayKind::Camera => flags.double_sided || triangle.is_front(ray),
        };
        counts.then_some(SceneHit { t, triangle: index, barycentric: [u, v] })
    }
}

/// Whether a hit at `t` counts rather than the closest one so far (its distance and triangle): where two triangles are
/// met at the same distance the lower index wins, whatever the order of the trees.
#[doc(hidden)]
pub fn is_nearer(t: f32, triangle: u32, bound: f32, closest: Option<(f32, u32)>) -> bool {
    t < bound || closest.is_some_and(|best| t == best.0 && triangle < best.1)
}
