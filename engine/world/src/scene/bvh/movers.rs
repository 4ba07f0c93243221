//! The hierarchies of what moves: one for each dynamic primitive, and one over all of them.
//!
//! All are in world space. An object that stands still costs nothing; one that has moved or bent has its own boxes fitted
//! again, and then those above the objects.

use super::part::{PartTriangles, ScenePart, Source, Updated};
use super::triangle::{SceneTriangle, place_corners};
use crate::assets::parallel;
use crate::bvh::Bvh;
use crate::core::Aabb;
use crate::scene::Primitive;

/// A refitted tree over the objects that costs so many times what it did when it was built is rebuilt.
const WORN_OUT: f32 = 1.25;
/// Triangles that a thread of its own is worth.
const WORTH_A_THREAD: usize = 4096;

/// All dynamic primitives.
#[derive(Debug, Default)]
pub struct Movers {
    /// One for each, in the order of the scene.
    pub objects: Vec<ScenePart>,
    /// Over the boxes of the objects, by their indices in that list.
    pub top: Bvh,
    /// Changes with the hierarchies, and with anything that rays meet in them.
    #[doc(hidden)]
    pub version: u64,
    built_cost: f32,
}

/// An object that has moved, its triangles, and the primitive that they follow.
struct Moved<'a> {
    object: &'a mut ScenePart,
    triangles: &'a mut [SceneTriangle],
    source: &'a Source,
    primitive: &'a Primitive,
}

impl Moved<'_> {
    fn follow(self, sources: &[Source], version: u64) -> Updated {
        place_corners(self.primitive, self.triangles);
        let triangles = PartTriangles { first: self.source.first, triangles: self.triangles, sources };
        let updated = self.object.refit(triangles, false);
        if updated == Updated::Built {
            self.object.built = version;
        }
        updated
    }
}

impl Movers {
    /// A box around all; [`Aabb::EMPTY`] if there is nothing.
    #[doc(hidden)]
    pub fn bounds(&self) -> Aabb {
        self.objects.iter().fold(Aabb::EMPTY, |sum, object| sum.union(&object.bounds()))
    }

    /// The hierarchy of a primitive by its index in the scene, if it is a dynamic one.
    #[doc(hidden)]
    pub fn object(&self, primitive: usize) -> Option<&ScenePart> {
        let index = self.objects.binary_search_by_key(&Some(&primitive), |object| object.primitives.first()).ok()?;
        self.objects.get(index)
    }

    /// Indices of all dynamic primitives.
    pub(super) fn primitives(&self) -> impl Iterator<Item = usize> + '_ {
        self.objects.iter().filter_map(|object| object.primitives.first().copied())
    }

    /// Builds all hierarchies anew.
    pub(super) fn build(&mut self, primitives: Vec<usize>, triangles: PartTriangles, version: u64) {
        self.version = version;
        let object = |primitive: usize| {
            let mut object = ScenePart::new(vec![primitive], version);
            object.build(triangles, false);
            object
        };
        self.objects = primitives.into_iter().map(object).collect();
        self.build_top();
    }

    fn build_top(&mut self) {
        let boxes: Vec<Aabb> = self.objects.iter().map(ScenePart::bounds).collect();
        self.top = Bvh::new(&boxes, 1);
        self.built_cost = self.top.cost();
    }

    /// Follows the primitives that have moved: those that `has_moved` says so of by their index.
    pub(super) fn follow(
        &mut self,
        primitives: &[Primitive],
        triangles: &mut [SceneTriangle],
        sources: &[Source],
        has_moved: impl Fn(usize) -> bool,
    ) -> Updated {
        let version = self.version;
        let mut jobs = Vec::new();
        let (mut rest, mut first) = (triangles, 0);
        for object in &mut self.objects {
            let Some(&index) = object.primitives.first().filter(|index| has_moved(**index)) else { continue };
            let source = &sources[index];
            let (own, behind) = std::mem::take(&mut rest).split_at_mut(source.first + source.count - first);
            let own = &mut own[source.first - first..];
            (rest, first) = (behind, source.first + source.count);
            jobs.push(Moved { object, triangles: own, source, primitive: &primitives[index] });
        }
        let count: usize = jobs.iter().map(|job| job.triangles.len()).sum();
        let results = parallel::consume(jobs, count / WORTH_A_THREAD, |job| job.follow(sources, version));
        let updated = results.into_iter().max().unwrap_or_default();
        updated.max(self.fit_top())
    }

    /// Fits the boxes above the objects.
    fn fit_top(&mut self) -> Updated {
        // Boxes that were empty at the building are in no leaf.
        let placed = self.objects.iter().filter(|object| !object.bvh.nodes.is_empty()).count();
        if placed == self.top.order.len() {
            self.top.refit_by(|index| self.objects[index as usize].bounds());
            if self.top.cost() <= WORN_OUT * self.built_cost {
                return Updated::Refitted;
            }
        }
        self.build_top();
        Updated::Refitted
    }
}
