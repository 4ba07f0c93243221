//! A hierarchy of a scene: over all static primitives, or over one that moves.

use super::triangle::{SceneTriangle, is_mirrored};
use crate::bvh::{Bvh, Node, presplit};
use crate::core::{Aabb, AssetId, SceneId};
use crate::scene::Primitive;
use glam::{Affine3A, Vec3};

/// Most triangles of a leaf.
const LEAF_SIZE: usize = 2;
/// A refitted tree that costs so many times what it did when it was built is rebuilt.
const WORN_OUT: f32 = 1.5;

/// The work of the last [`SceneBvh::update`](super::SceneBvh::update).
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

/// The triangles of some primitives, with a hierarchy of their own.
#[derive(Clone, Debug, Default)]
pub struct ScenePart {
    /// The hierarchy over indices in [`SceneBvh::triangles`](super::SceneBvh::triangles).
    pub bvh: Bvh,
    /// Changes with the hierarchy, and with anything that rays meet in it.
    #[doc(hidden)]
    pub version: u64,
    /// The version in which it was built last: since then its triangles have the same order, and wind the same way.
    #[doc(hidden)]
    pub built: u64,
    /// Indices in [`Scene::primitives`].
    pub(super) primitives: Vec<usize>,
    /// Number of triangles in the hierarchy: those with a box.
    placed: usize,
    /// Whether the first child of the root holds all triangles that are not opaque, and the second all that are.
    #[doc(hidden)]
    pub is_split: bool,
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
    /// See [`Material::is_opaque`](crate::assets::Material::is_opaque).
    pub(super) is_opaque: bool,
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
            && self.is_opaque == primitive.material.is_opaque()
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

    fn source(&self, index: usize) -> &Source {
        &self.sources[self.triangle(index).primitive as usize]
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
    #[doc(hidden)]
    pub fn bounds(&self) -> Aabb {
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
            let split = |&index: &usize| (triangles.triangle(index).corners, !triangles.source(index).is_glass);
            let (corners, may_split): (Vec<[Vec3; 3]>, Vec<bool>) = indices.iter().map(split).unzip();
            let (pieces, triangle_of) = presplit(&corners, &boxes, &may_split);
            let is_opaque = |piece: usize| triangles.source(indices[triangle_of[piece] as usize]).is_opaque;
            (self.bvh, self.is_split) = split_by_class(&pieces, is_opaque);
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

/// A hierarchy over boxes of both classes of geometry, opaque and not, and whether there are both: then the first child of
/// the root holds what is not opaque, and the second one what is. Rays that meet no box of the first need to know nothing of
/// alpha and glass.
fn split_by_class(boxes: &[Aabb], is_opaque: impl Fn(usize) -> bool) -> (Bvh, bool) {
    let (opaque, others): (Vec<u32>, Vec<u32>) = (0..boxes.len() as u32).partition(|&index| is_opaque(index as usize));
    let tree = |class: &[u32]| {
        let of_class: Vec<Aabb> = class.iter().map(|&index| boxes[index as usize]).collect();
        let mut tree = Bvh::new(&of_class, LEAF_SIZE);
        tree.order.iter_mut().for_each(|entry| *entry = class[*entry as usize]);
        tree
    };
    let (opaque, others) = (tree(&opaque), tree(&others));
    match (opaque.nodes.is_empty(), others.nodes.is_empty()) {
        (_, true) => (opaque, false),
        (true, false) => (others, false),
        (false, false) => (Bvh::joined(others, opaque), true),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_of_geometry_are_children_of_the_root() {
        let boxes: Vec<Aabb> = (0..40_u8).map(|i| Aabb::from_points([Vec3::splat(f32::from(i)), Vec3::ONE])).collect();
        for step in [1, 3, 100] {
            let is_opaque = |index: usize| !index.is_multiple_of(step);
            let (bvh, is_split) = split_by_class(&boxes, is_opaque);
            assert_eq!(is_split, step == 3 || step == 100);
            let mut order = bvh.order.clone();
            order.sort_unstable();
            assert_eq!(order, (0..40).collect::<Vec<u32>>());
            for node in bvh.nodes.iter().filter(|node| node.count > 0) {
                let entries = &bvh.order[node.first as usize..][..node.count as usize];
                let bounds = entries.iter().fold(Aabb::EMPTY, |sum, &entry| sum.union(&boxes[entry as usize]));
                assert_eq!(bounds, node.bounds());
            }
            if is_split {
                let others = boxes.iter().enumerate().filter(|(index, _)| !is_opaque(*index)).count();
                assert!(bvh.order[..others].iter().all(|&index| !is_opaque(index as usize)));
                assert!(bvh.order[others..].iter().all(|&index| is_opaque(index as usize)));
                let mut open = vec![1];
                while let Some(index) = open.pop() {
                    let node: &Node = &bvh.nodes[index];
                    match node.count {
                        0 => open.extend([node.first as usize, node.first as usize + 1]),
                        _ => assert!((node.first as usize) < others),
                    }
                }
            }
        }
    }
}
