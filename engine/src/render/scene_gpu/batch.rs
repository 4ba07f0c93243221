//! Primitives that are drawn together, and which of them a pass draws.

use super::MaterialClass;
use super::mesh::MeshPlace;
use crate::assets::AssetId;
use crate::scene::{Aabb, Frustum, Primitive, SceneId, wall_extent};
use std::ops::Range;

/// Instances of one mesh with one material that lie together.
pub(super) struct Batch {
    /// See [`Primitive::moving`].
    pub moving: bool,
    pub class: MaterialClass,
    /// Nothing of it hides what lies behind.
    pub nowhere_opaque: bool,
    pub material: AssetId,
    pub mesh: AssetId,
    /// Where the mesh lies; none if it has no triangles.
    pub place: Option<MeshPlace>,
    /// Its instances, and their members.
    pub instances: Range<u32>,
}

/// The data of an instance. All of a scene lie in one array in the order of the instances.
pub(super) struct Member {
    pub id: SceneId,
    pub bounds: Aabb,
    /// Revisions of its geometry and its material.
    pub revisions: [u64; 2],
    /// See [`Primitive::blocks_light`].
    pub casts_shadow: bool,
    /// See [`wall_extent`].
    pub wall: f32,
}

impl Member {
    pub fn new(primitive: &Primitive) -> Self {
        Self {
            id: primitive.id,
            bounds: primitive.bounds,
            revisions: [primitive.geometry_revision, primitive.material_revision],
            casts_shadow: primitive.blocks_light(),
            wall: wall_extent(primitive, &primitive.mesh, &primitive.world_from_object.matrix3),
        }
    }
}

/// Which primitives a pass draws, by whether they move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// All; those that move come last.
    Any,
    /// Those that do not move.
    Still,
    /// Those that do, over what holds the others.
    Moving,
}

impl Motion {
    pub(super) fn takes(self, moving: bool) -> bool {
        self == Self::Any || moving == (self == Self::Moving)
    }
}

/// Which primitives a pass draws.
#[derive(Clone, Copy)]
pub struct DrawFilter<'a> {
    /// Primitives outside are left out.
    pub frustum: &'a Frustum,
    /// Only those that cast shadows.
    pub casters_only: bool,
    /// Only those of which a part hides what lies behind.
    pub opaque_only: bool,
    /// Only those of glass.
    pub glass_only: bool,
    /// Only those with a second lobe.
    pub second_lobe_only: bool,
    /// Only those that are walls in cells of this size \[m\], see `wall_extent`.
    pub least_wall: f32,
    /// Only those that move, or that do not.
    pub motion: Motion,
}

impl DrawFilter<'_> {
    /// Instances that a camera may see.
    pub fn seen(frustum: &Frustum) -> DrawFilter<'_> {
        DrawFilter {
            frustum,
            casters_only: false,
            opaque_only: false,
            glass_only: false,
            second_lobe_only: false,
            least_wall: 0.0,
            motion: Motion::Any,
        }
    }

    /// Of that, what hides what lies behind.
    pub fn opaque(frustum: &Frustum) -> DrawFilter<'_> {
        DrawFilter { opaque_only: true, ..Self::seen(frustum) }
    }

    /// Of that, what is of glass.
    pub fn glass(frustum: &Frustum) -> DrawFilter<'_> {
        DrawFilter { glass_only: true, ..Self::seen(frustum) }
    }

    /// Of that, what has a second lobe.
    pub fn with_second_lobe(frustum: &Frustum) -> DrawFilter<'_> {
        DrawFilter { second_lobe_only: true, ..Self::seen(frustum) }
    }

    /// Instances that cast shadows.
    pub fn casters(frustum: &Frustum) -> DrawFilter<'_> {
        DrawFilter { casters_only: true, ..Self::seen(frustum) }
    }

    /// Of that, the walls in cells of so many metres.
    pub fn walls(frustum: &Frustum, cell: f32) -> DrawFilter<'_> {
        // A little less: surfels know the extent of their object but for a rounding.
        DrawFilter { least_wall: 0.9999 * cell, ..Self::casters(frustum) }
    }

    /// The same of those alone that move, or that do not.
    pub fn of(self, motion: Motion) -> Self {
        Self { motion, ..self }
    }
}

impl Member {
    pub fn visible(&self, filter: &DrawFilter) -> bool {
        (self.casts_shadow || !filter.casters_only)
            // An extent that is no number counts as a wall, and hides the primitive from no other pass.
            && !(self.wall < filter.least_wall)
            && filter.frustum.intersects(&self.bounds)
    }
}

impl Batch {
    /// Whether the filter may let anything of it pass.
    pub fn passes(&self, filter: &DrawFilter) -> bool {
        filter.motion.takes(self.moving)
            && !(filter.opaque_only && self.nowhere_opaque)
            && (self.class.glass || !filter.glass_only)
            && (self.class.second_lobe || !filter.second_lobe_only)
    }

    /// Its part of all members.
    pub fn of<'m>(&self, members: &'m [Member]) -> &'m [Member] {
        members.get(self.instances.start as usize..self.instances.end as usize).unwrap_or_default()
    }

    /// Ranges of instances that lie next to each other and pass the filter.
    pub fn visible_runs(&self, members: &[Member], filter: &DrawFilter) -> impl Iterator<Item = Range<u32>> {
        let visible = self.instances.clone().zip(self.of(members)).filter(|(_, member)| member.visible(filter));
        let mut visible = visible.map(|(index, _)| index).peekable();
        std::iter::from_fn(move || {
            let first = visible.next()?;
            let mut end = first + 1;
            while visible.next_if_eq(&end).is_some() {
                end += 1;
            }
            Some(first..end)
        })
    }
}
