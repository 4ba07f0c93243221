//! The hierarchies over all triangles of a scene, in world space: one of static primitives, one of moving primitives.
//!
//! Objects have no level of their own: rays that cross many overlapping objects are twice as fast, and every static
//! triangle is transformed once. Moved objects have the boxes above them fitted again, which leaves the static part as it
//! is. Of hits at the same distance the one with the lower index counts, unless rounding hides its box.

use super::scene_part::{PartTriangles, ScenePart, Source};
use super::scene_triangle::{SceneTriangle, world_corners};
use super::{Bvh, Ray, intersect_triangle};
use crate::scene::{Primitive, Scene};
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

/// The work of the last [`SceneBvh::update`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Updated {
    /// Nothing had changed.
    #[default]
    Nothing,
    /// Boxes were fitted to moved triangles.
    Refitted,
    /// A tree was built.
    Built,
}

/// All surfaces of a scene, ready for rays.
#[derive(Debug, Default)]
pub struct SceneBvh {
    /// Triangles, in the order of the scene's primitives and of their meshes.
    pub triangles: Vec<SceneTriangle>,
    /// Those of primitives that are not [moving](Primitive::moving).
    pub statics: ScenePart,
    /// Those of primitives that are.
    pub movers: ScenePart,
    /// How long the last update took.
    pub update_time: Duration,
    /// Changes with which primitives there are in which part, and with their materials.
    pub(crate) surfaces_version: u64,
    flags: Vec<Flags>,
    sources: Vec<Source>,
    /// Identity and statics revision of the last scene, if it tells.
    told: Option<[u64; 2]>,
    versions: u64,
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
            && if are_statics_kept {
                self.movers.primitives.iter().all(|&index| fits(index))
            } else {
                (0..self.sources.len()).all(fits)
            };
        let updated = if !same || self.sources.is_empty() {
            self.rebuild(scene)
        } else if are_statics_kept {
            self.follow(scene, true)
        } else {
            self.follow(scene, false).max(self.follow(scene, true))
        };
        self.told = told;
        self.update_time = start.elapsed();
        updated
    }

    /// The hierarchies of both parts: static objects, and dynamic ones. Rays go through them in turn.
    pub fn trees(&self) -> [&Bvh; 2] {
        [&self.statics.bvh, &self.movers.bvh]
    }

    /// Number of triangles of moving primitives, with those that have no box and so are in no tree.
    pub(crate) fn moving_triangles(&self) -> usize {
        self.movers.primitives.iter().map(|&index| self.sources[index].count).sum()
    }

    /// Indices of the triangles of a primitive.
    pub(crate) fn triangles_of(&self, primitive: usize) -> Range<usize> {
        let source = &self.sources[primitive];
        source.first..source.first + source.count
    }

    /// Whether a primitive has changed since a version of its part.
    pub(crate) fn has_changed(&self, primitive: u32, since: u64) -> bool {
        self.sources[primitive as usize].changed > since
    }

    fn next_version(&mut self) -> u64 {
        self.versions += 1;
        self.versions
    }

    fn rebuild(&mut self, scene: &Scene) -> Updated {
        let changed = self.next_version();
        self.flags = scene.primitives.iter().map(Flags::of).collect();
        self.sources.clear();
        self.triangles.clear();
        let parts = [&mut self.statics, &mut self.movers];
        for part in parts {
            part.primitives.clear();
        }
        for (primitive, index) in scene.primitives.iter().zip(0..) {
            let count = primitive.mesh.triangle_count();
            self.sources.push(Source {
                id: primitive.id,
                mesh: primitive.mesh.id,
                topology: primitive.mesh.topology(),
                material: primitive.material.id,
                is_moving: primitive.moving,
                is_glass: primitive.material.is_glass(),
                world_from_object: primitive.world_from_object,
                first: self.triangles.len(),
                count,
                changed,
            });
            let part = if primitive.moving { &mut self.movers } else { &mut self.statics };
            part.primitives.push(index as usize);
            self.triangles.extend((0..count as u32).map(|triangle| SceneTriangle {
                corners: world_corners(primitive, triangle),
                primitive: index,
                triangle,
            }));
        }
        self.surfaces_version = self.next_version();
        for is_moving in [false, true] {
            let version = self.next_version();
            let (part, triangles) = self.part(is_moving);
            (part.version, part.built) = (version, version);
            part.build(triangles, !is_moving);
        }
        Updated::Built
    }

    /// A part, and what it needs to be built: its triangles.
    fn part(&mut self, is_moving: bool) -> (&mut ScenePart, PartTriangles<'_>) {
        let part = if is_moving { &mut self.movers } else { &mut self.statics };
        (part, PartTriangles { all: &self.triangles, sources: &self.sources })
    }

    /// Updates one part where the same primitives have moved or have other surfaces.
    fn follow(&mut self, scene: &Scene, is_moving: bool) -> Updated {
        let version = self.next_version();
        let (mut moved, mut has_other_surfaces, mut has_other_flags) = (false, false, false);
        let part = if is_moving { &self.movers } else { &self.statics };
        for &index in &part.primitives {
            let (source, primitive) = (&mut self.sources[index], &scene.primitives[index]);
            let flags = Flags::of(primitive);
            let (has_flags, has_surface) = (flags == self.flags[index], source.material == primitive.material.id);
            (has_other_flags, has_other_surfaces) = (has_other_flags || !has_flags, has_other_surfaces || !has_surface);
            if !has_flags || !has_surface {
                source.changed = version;
            }
            self.flags[index] = flags;
            source.material = primitive.material.id;
            if source.world_from_object == primitive.world_from_object && source.mesh == primitive.mesh.id {
                continue;
            }
            moved = true;
            source.changed = version;
            source.mesh = primitive.mesh.id;
            source.world_from_object = primitive.world_from_object;
            for triangle in &mut self.triangles[source.first..source.first + source.count] {
                triangle.corners = world_corners(primitive, triangle.triangle);
            }
        }
        if has_other_surfaces {
            self.surfaces_version = self.next_version();
        }
        if moved || has_other_surfaces || has_other_flags {
            let (part, triangles) = self.part(is_moving);
            part.version = version;
            let updated = if moved { part.refit(triangles, !is_moving) } else { Updated::Nothing };
            if updated == Updated::Built {
                part.built = version;
            }
            return updated;
        }
        Updated::Nothing
    }

    /// The nearest hit of the ray before `t_max`. Alpha is ignored.
    pub fn closest_hit(&self, ray: &Ray, t_max: f32, kind: RayKind) -> Option<SceneHit> {
        let mut closest: Option<SceneHit> = None;
        for bvh in self.trees() {
            let bound = closest.map_or(t_max, |hit| hit.t);
            bvh.traverse(ray, bound, |index, bound| match self.meets(ray, index, kind) {
                Some(hit) if is_nearer(hit.t, index, bound, closest.map(|best| (best.t, best.triangle))) => {
                    closest = Some(hit);
                    hit.t
                }
                _ => bound,
            });
        }
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
        let mut blocked = false;
        for bvh in self.trees() {
            bvh.traverse(ray, t_max, |index, bound| {
                blocked |= self.meets(ray, index, RayKind::Light).is_some_and(|hit| hit.t < bound);
                // Nothing lies before the ray's start: a bound below it ends the search.
                if blocked { -1.0 } else { bound }
            });
            if blocked {
                return true;
            }
        }
        false
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
pub(crate) fn is_nearer(t: f32, triangle: u32, bound: f32, closest: Option<(f32, u32)>) -> bool {
    t < bound || closest.is_some_and(|best| t == best.0 && triangle < best.1)
}
