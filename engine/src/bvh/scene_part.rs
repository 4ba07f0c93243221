//! A hierarchy of a scene: over all static primitives, or over one that moves.

use super::presplit::presplit;
use super::scene::Updated;
use super::scene_triangle::{SceneTriangle, is_mirrored};
use super::{Bvh, Node};
use crate::assets::AssetId;
use crate::scene::{Aabb, Primitive, SceneId};
use glam::{Affine3A, Vec3};

/// Most triangles of a leaf.
const LEAF_SIZE: usize = 2;
/// A refitted tree that costs so many times what it did when it was built is rebuilt.
const WORN_OUT: f32 = 1.5;

/// The triangles of some primitives, with a hierarchy of their own.
#[derive(Clone, Debug, Default)]
pub struct ScenePart {
    /// The hierarchy over indices in [`SceneBvh::triangles`](super::SceneBvh::triangles).
    pub bvh: Bvh,
    /// Changes with the hierarchy, and with anything that rays meet in it.
    pub(crate) version: u64,
    /// The version in which it was built last: since then its triangles have the same order, and wind the same way.
    pub(crate) built: u64,
    /// Indices in [`Scene::primitives`].
    pub(super) primitives: Vec<usize>,
    /// Number of triangles in the hierarchy: those with a box.
    placed: usize,
    built_cost: f32,
}

/// Where the triangles of a primitive come from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Source {
    pub(super) id: SceneId,
    pub(super) mesh: AssetId,
    pub(super) topology: AssetId,
    /// Which way its triangles wind: see [`Mesh::winding`](crate::assets::Mesh::winding), and whether the transform mirrors.
    pub(super) winding: (u64, bool),
    pub(super) material: AssetId,
    pub(super) is_moving: bool,
    /// See [`Material::is_glass`](crate::assets::Material::is_glass).
    pub(super) is_glass: bool,
    pub(super) world_from_object: Affine3A,
    pub(super) first: usize,
    pub(super) count: usize,
}

/// Which way the triangles of a primitive wind, for [`Source::winding`].
pub(super) fn winding(primitive: &Primitive) -> (u64, bool) {
    (primitive.mesh.winding, is_mirrored(&primitive.world_from_object))
}

impl Source {
    /// Whether the primitive can differ in nothing but place, pose and surface.
    pub(super) fn is_of(&self, primitive: &Primitive) -> bool {
        self.id == primitive.id
            && self.topology == primitive.mesh.topology()
            && self.is_moving == primitive.moving
            && self.is_glass == primitive.material.is_glass()
            && self.count == primitive.mesh.triangle_count()
    }
}

/// Triangles of a scene, those of a part among them, and where those of each primitive lie.
#[derive(Clone, Copy)]
pub(super) struct PartTriangles<'a> {
    /// From the scene's triangle of that index on.
    pub(super) first: usize,
    pub(super) triangles: &'a [SceneTriangle],
    pub(super) sources: &'a [Source],
}

impl PartTriangles<'_> {
    fn triangle(&self, index: usize) -> &SceneTriangle {
        &self.triangles[index - self.first]
    }

    fn is_glass(&self, index: usize) -> bool {
        self.sources[self.triangle(index).primitive as usize].is_glass
    }

    fn bounds(&self, index: usize) -> Aabb {
        let corners = self.triangle(index).corners;
        if corners.iter().all(|corner| corner.is_finite()) { Aabb::from_points(corners) } else { Aabb::EMPTY }
    }
}

impl ScenePart {
    /// One that is not built yet.
    pub(super) fn new(primitives: Vec<usize>, version: u64) -> Self {
        Self { primitives, version, built: version, ..Self::default() }
    }

    /// A box around all; [`Aabb::EMPTY`] if there is nothing.
    pub(crate) fn bounds(&self) -> Aabb {
        self.bvh.nodes.first().map_or(Aabb::EMPTY, Node::bounds)
    }

    /// Indices of its triangles.
    fn indices<'a>(&'a self, triangles: PartTriangles<'a>) -> impl Iterator<Item = usize> + 'a {
        let sources = self.primitives.iter().map(move |&index| &triangles.sources[index]);
        sources.flat_map(|source| source.first..source.first + source.count)
    }

    /// Builds the hierarchy. Static triangles may be in several leaves, see [`presplit`]; the boxes of dynamic ones are
    /// fitted again to whole triangles whenever these move, and so they are in one.
    pub(super) fn build(&mut self, triangles: PartTriangles, is_static: bool) -> Updated {
        let indices: Vec<usize> = self.indices(triangles).collect();
        let boxes: Vec<Aabb> = indices.iter().map(|&index| triangles.bounds(index)).collect();
        self.placed = boxes.iter().filter(|bounds| !bounds.is_empty()).count();
        if is_static {
            let split = |&index: &usize| (triangles.triangle(index).corners, !triangles.is_glass(index));
            let (corners, may_split): (Vec<[Vec3; 3]>, Vec<bool>) = indices.iter().map(split).unzip();
            let (pieces, triangle_of) = presplit(&corners, &boxes, &may_split);
            self.bvh = Bvh::new(&pieces, LEAF_SIZE);
            self.bvh.order.iter_mut().for_each(|entry| *entry = triangle_of[*entry as usize]);
        } else {
            self.bvh = Bvh::new(&boxes, LEAF_SIZE);
        }
        self.bvh.order.iter_mut().for_each(|entry| *entry = indices[*entry as usize] as u32);
        self.built_cost = self.bvh.cost();
        Updated::Built
    }

    pub(super) fn refit(&mut self, triangles: PartTriangles, is_static: bool) -> Updated {
        // Boxes that were empty at the building are in no leaf.
        let placed = self.indices(triangles).filter(|&index| !triangles.bounds(index).is_empty()).count();
        if placed != self.placed {
            return self.build(triangles, is_static);
        }
        self.bvh.refit_by(|index| triangles.bounds(index as usize));
        if self.bvh.cost() > WORN_OUT * self.built_cost { self.build(triangles, is_static) } else { Updated::Refitted }
    }
}
