//! The boxes of hierarchies as lists that rays follow without a stack, in the layout of `lib/walk.wgsl`.

use super::box_list::{BoxList, Links};
use super::words::Texel;
use crate::bvh::{Bvh, Node};
use crate::scene::Aabb;
use glam::Vec3;

/// Marks the link of a leaf.
pub(super) const LEAF: u32 = 1 << 31;
/// Bits of a leaf's link below the number of triangles less one.
pub(super) const COUNT_BITS: u32 = 29;
/// Units of the frame that the contents span. Two at either side are left for rounding.
const UNITS: f32 = 65531.0;
/// Boxes grow by this part of a unit on each side before they are rounded: more than what arithmetic in floats can be
/// off by within the frame, 2⁻²⁴ of 2¹⁶ units for each of three operations.
const MARGIN: f32 = 1.0 / 32.0;
/// A leaf that rounding makes so many times as long is coarse.
const COARSE: f32 = 1.5;

/// Half a unit is more than what a ray's start that lies far outside of a small frame costs, as long as the frame's unit
/// is [`FAR_UNIT`] of the whole scene or more.
const FAR_MARGIN: f32 = 0.5;
const FAR_UNIT: f32 = 1.0 / (1 << 20) as f32;

/// A list of all static objects' boxes for each of the eight signs of a direction.
pub(super) struct BoxLists {
    /// All lists, after the frame.
    pub(super) texels: Vec<Texel>,
    /// Boxes of one list.
    pub(super) box_count: u32,
}

/// Texels that the lists of so many boxes take.
pub(super) fn texel_count(boxes: usize, exact: bool) -> usize {
    HEADER + 8 * boxes * texels_of_box(exact) + END
}

/// Texels before the lists, and after them.
pub(super) const HEADER: usize = 2;
pub(super) const END: usize = 2;

/// Texels of a box.
pub(super) fn texels_of_box(exact: bool) -> usize {
    if exact { 2 } else { 1 }
}

/// Most boxes that a hierarchy over so many things has.
pub(super) fn most_boxes(things: usize) -> usize {
    (2 * things).saturating_sub(1)
}

/// Whether boxes are best kept in floats, two texels each: in scenes in which most things are smaller than a unit of
/// the frame, such as a room on a plain of 100 km.
pub(super) fn are_exact<'a>(trees: impl Iterator<Item = &'a Bvh> + Clone) -> bool {
    let roots = trees.clone().filter_map(|tree| tree.nodes.first());
    let bounds = roots.fold(Aabb::EMPTY, |sum, root| sum.union(&root.bounds()));
    !bounds.is_empty() && is_coarse(trees, &Frame::new(&bounds, 0.0))
}

/// How boxes are stored.
#[derive(Clone, Copy)]
pub(super) enum Encoding<'a> {
    /// As whole numbers of a frame's units.
    InFrame(&'a Frame),
    /// As they are.
    Exact,
}

impl Encoding<'_> {
    /// Adds a box.
    pub(super) fn push(self, texels: &mut Vec<Texel>, bounds: &Aabb, link: u32) {
        match self {
            Self::InFrame(frame) => texels.push(frame.texel(bounds, link)),
            Self::Exact => texels.extend(exact_texels(bounds, link)),
        }
    }

    /// Adds what leads on to another box and is never met: see `JUMP` of `lib/walk.wgsl`.
    pub(super) fn push_jump(self, texels: &mut Vec<Texel>, link: u32) {
        match self {
            Self::InFrame(_) => texels.push([0xffff, 0, 0, link]),
            Self::Exact => texels.extend([[f32::MAX.to_bits(), 0, 0, link], [0; 4]]),
        }
    }
}

impl BoxLists {
    /// The lists of a hierarchy; rays go on at a box of dynamic objects, or at none if that is 0. The lists of one that
    /// [is split](crate::scene::ScenePart) have the first child of the root in front, and behind it the second.
    pub(super) fn new(bvh: &Bvh, exact: bool, movers: u32, is_split: bool) -> Self {
        let boxes = bvh.nodes.len();
        let frame = bvh.nodes.first().map(|root| Frame::new(&root.bounds(), 0.0));
        let mut texels = Vec::with_capacity(texel_count(boxes, exact));
        texels.extend(frame.as_ref().filter(|_| !exact).map_or([[0; 4]; 2], Frame::texels));
        (texels[0][3], texels[1][3]) = (boxes as u32, movers);
        if let Some(frame) = &frame {
            let encoding = if exact { Encoding::Exact } else { Encoding::InFrame(frame) };
            let lists = BoxList::new(bvh, encoding);
            let lists = if is_split { lists.with_first_child_in_front() } else { lists };
            let mut first = (HEADER / texels_of_box(exact)) as u32;
            for octant in 0..8 {
                let end = first + boxes as u32;
                lists.push(&mut texels, octant, Links { first, behind: end, triangle: 0 });
                first = end;
            }
        }
        // Rays look at two boxes at once: after the last one of the last list comes one that leads nowhere.
        texels.extend([[0, 0, 0, NOWHERE]; END]);
        Self { texels, box_count: boxes as u32 }
    }

    /// Lists of one box that holds nothing, from which rays go on to dynamic objects.
    pub(super) fn passage(exact: bool, movers: u32) -> Self {
        let header = (HEADER / texels_of_box(exact)) as u32;
        let mut texels = vec![[0, 0, 0, 1], [0, 0, 0, movers]];
        for octant in 0..8 {
            texels.push([0, 0, 0, header + octant + 1]);
            if exact {
                texels.push([0; 4]);
            }
        }
        texels.extend([[0, 0, 0, NOWHERE]; END]);
        Self { texels, box_count: 1 }
    }
}

/// A link that ends all lists.
pub(super) const NOWHERE: u32 = LEAF - 1;

fn exact_texels(bounds: &Aabb, link: u32) -> [Texel; 2] {
    let [[ax, ay, az], [bx, by, bz]] = [bounds.min, bounds.max].map(|corner| corner.to_array().map(f32::to_bits));
    [[ax, ay, az, link], [bx, by, bz, 0]]
}

/// The grid of 2¹⁶ units an axis whose corners the boxes are rounded to.
pub(super) struct Frame {
    origin: Vec3,
    unit: Vec3,
    margin: f32,
}

impl Frame {
    /// Around all that is within the bounds. `scene_size` is the edge of the whole scene \[m\], where that is but some
    /// of it; else 0.
    pub(super) fn new(bounds: &Aabb, scene_size: f32) -> Self {
        // A flat scene has a thin frame, not none.
        let size = bounds.size();
        let least = (size.max_element() * 1e-6).max(1e-25);
        // What is finer than the coordinates themselves would be lost in the frame's origin.
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let finest = (scene_size * FAR_UNIT).max(largest * f32::EPSILON);
        let unit = (size.max(Vec3::splat(least)) / UNITS).max(Vec3::splat(finest));
        let margin = if scene_size > 0.0 { FAR_MARGIN } else { MARGIN };
        Self { origin: bounds.min - 2.0 * unit, unit, margin }
    }

    pub(super) fn texels(&self) -> [Texel; 2] {
        let words = |v: Vec3| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), 0];
        [words(self.origin), words(self.unit)]
    }

    /// Corners in units, lower ones rounded down and upper ones up.
    fn corners(&self, bounds: &Aabb) -> [[u32; 3]; 2] {
        let low = (bounds.min - self.origin) / self.unit - self.margin;
        let high = (bounds.max - self.origin) / self.unit + self.margin;
        // Conversion leaves the fraction out of what is not negative, and takes a fraction of the time of floor and ceil.
        let up = |units: f32| units as u32 + u32::from(units > units as u32 as f32);
        [low.to_array().map(|units| units as u32), high.to_array().map(up)].map(|corner| corner.map(|c| c.min(0xffff)))
    }

    fn texel(&self, bounds: &Aabb, link: u32) -> Texel {
        let [[ax, ay, az], [bx, by, bz]] = self.corners(bounds);
        [ax | ay << 16, az | bx << 16, by | bz << 16, link]
    }

    /// The box that the texel stands for.
    fn rounded(&self, bounds: &Aabb) -> Aabb {
        let [min, max] =
            self.corners(bounds).map(|corner| self.origin + Vec3::from(corner.map(|c| c as f32)) * self.unit);
        Aabb { min, max }
    }
}

/// Whether a quarter of the leaves or more would be coarse. What rays cost there shows in no mean over the whole scene:
/// they may all stay in one room of it.
fn is_coarse<'a>(trees: impl Iterator<Item = &'a Bvh> + Clone, frame: &Frame) -> bool {
    let leaves = || trees.clone().flat_map(|tree| &tree.nodes).filter(|node| node.count > 0).map(Node::bounds);
    let longest = |bounds: &Aabb| bounds.size().max_element();
    let coarse = leaves().filter(|bounds| longest(&frame.rounded(bounds)) > COARSE * longest(bounds)).count();
    4 * coarse >= leaves().count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes(count: usize, extent: f32) -> impl Strategy<Value = Vec<Aabb>> {
        let corner = move || (-extent..extent, -extent..extent, -extent..extent).prop_map(Vec3::from);
        let size = (0.0..1.0_f32, 0.0..1.0_f32, 0.0..1.0_f32).prop_map(Vec3::from);
        let bounds = (corner(), size).prop_map(|(min, size)| Aabb { min, max: min + size });
        proptest::collection::vec(bounds, 1..count)
    }

    /// Leaves in the order of a list, as `go_on` of `lib/walk.wgsl` goes: into all boxes that `meets` says yes to, two
    /// boxes at once.
    fn walk(lists: &BoxLists, octant: u32, mut meets: impl FnMut(&Texel) -> bool) -> Vec<u32> {
        let first = 2 + octant * lists.box_count;
        let end = first + lists.box_count;
        let mut next = first;
        let mut leaves = Vec::new();
        while next < end {
            let mut goes_on = true;
            for texel in &lists.texels[next as usize..][..2] {
                let (met, is_leaf) = (meets(texel), texel[3] >= LEAF);
                if goes_on && met && is_leaf {
                    leaves.push(texel[3]);
                }
                if goes_on {
                    goes_on = met || is_leaf;
                    next = if goes_on { next + 1 } else { texel[3] };
                }
            }
        }
        leaves
    }

    proptest! {
        #[test]
        fn every_list_has_every_leaf_once(boxes in boxes(60, 20.0), octant in 0..8_u32) {
            let bvh = Bvh::new(&boxes, 2);
            let lists = BoxLists::new(&bvh, false, 0, false);
            let mut leaves = walk(&lists, octant, |_| true);
            leaves.sort_unstable();
            if bvh.nodes.len() == 1 {
                // The only leaf may be met again, as the box behind itself.
                leaves.dedup();
            }
            let link = |node: &Node| LEAF | (node.count - 1) << COUNT_BITS | node.first;
            let mut expected: Vec<u32> = bvh.nodes.iter().filter(|node| node.count > 0).map(link).collect();
            expected.sort_unstable();
            prop_assert_eq!(leaves, expected);
            // Whoever misses the root misses all.
            prop_assert!(walk(&lists, octant, |_| false).is_empty());
        }

        #[test]
        fn rounded_boxes_hold_what_they_round(
            boxes in boxes(20, 1e3),
            away in prop_oneof![Just(0.0), -1e7..1e7_f32],
        ) {
            let moved = |bounds: Aabb| Aabb { min: bounds.min + away, max: bounds.max + away };
            let boxes: Vec<Aabb> = boxes.into_iter().map(moved).collect();
            let whole = boxes.iter().fold(Aabb::EMPTY, |sum, bounds| sum.union(bounds));
            for scene_size in [0.0, 1.0, 1e6] {
                let frame = Frame::new(&whole, scene_size);
                for bounds in &boxes {
                    let rounded = frame.rounded(bounds);
                    prop_assert!(rounded.min.cmple(bounds.min).all() && rounded.max.cmpge(bounds.max).all());
                }
            }
        }
    }

    #[test]
    fn lists_take_the_room_that_is_reserved_for_them_and_lead_to_their_own_place() {
        let things = (0..64).map(|i| Aabb { min: Vec3::splat(i as f32), max: Vec3::splat(i as f32 + 0.5) });
        let bvh = Bvh::new(&things.collect::<Vec<_>>(), 1);
        assert!(bvh.nodes.len() <= most_boxes(64));
        for exact in [false, true] {
            let lists = BoxLists::new(&bvh, exact, 4096, false);
            assert_eq!(lists.texels.len(), texel_count(bvh.nodes.len(), exact));
            assert_eq!((lists.texels[0][3], lists.texels[1][3]), (bvh.nodes.len() as u32, 4096));
            let end = (lists.texels.len() / texels_of_box(exact)) as u32;
            for texel in lists.texels[HEADER..lists.texels.len() - END].iter().step_by(texels_of_box(exact)) {
                let (link, triangle) = (texel[3], texel[3] & ((1 << COUNT_BITS) - 1));
                assert!(if link >= LEAF { triangle < 64 } else { link < end }, "{link:x}");
            }
            assert_eq!(BoxLists::passage(exact, 4096).texels.len(), texel_count(1, exact));
            assert_eq!(BoxLists::new(&Bvh::default(), exact, 0, false).texels.len(), texel_count(0, exact));
        }
    }

    #[test]
    fn lists_of_a_split_hierarchy_have_its_first_child_in_front() {
        let row = |from: f32| (0..9).map(move |i| Aabb::from_points([Vec3::splat(from), Vec3::splat(from + i as f32)]));
        let bvh = Bvh::joined(Bvh::new(&row(0.0).collect::<Vec<_>>(), 2), Bvh::new(&row(-20.0).collect::<Vec<_>>(), 2));
        let lists = BoxLists::new(&bvh, false, 0, true);
        let first_child = &lists.texels[HEADER + 1];
        for octant in 0..8 {
            let first = HEADER + octant * bvh.nodes.len();
            let child = &lists.texels[first + 1];
            assert_eq!(child[..3], first_child[..3], "octant {octant}");
            // Behind it comes the other child, whose leaves are entries of the second hierarchy.
            let behind = &lists.texels[child[3] as usize..first + bvh.nodes.len()];
            let leaves = behind.iter().filter(|texel| texel[3] >= LEAF).map(|texel| texel[3] & ((1 << COUNT_BITS) - 1));
            assert!(leaves.clone().count() > 4 && leaves.min() == Some(9), "octant {octant}");
        }
    }

    #[test]
    fn a_room_on_a_wide_plain_keeps_its_boxes() {
        let plain = Aabb { min: Vec3::new(-1e5, -1.0, -1e5), max: Vec3::new(1e5, 0.0, 1e5) };
        let things = (0..64).map(|i| {
            let min = Vec3::new((i % 8) as f32, 0.0, (i / 8) as f32) * 0.4;
            Aabb { min, max: min + 0.2 }
        });
        let wide: Vec<Aabb> = things.clone().chain([plain]).collect();
        assert!(are_exact([&Bvh::new(&wide, 2)].into_iter()));
        assert!(!are_exact([&Bvh::new(&things.collect::<Vec<_>>(), 2)].into_iter()));
        assert_eq!(BoxLists::new(&Bvh::default(), false, 0, false).box_count, 0);
    }
}
