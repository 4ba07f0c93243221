//! The boxes of moving objects, in the layout of `lib/walk.wgsl`: lists over the objects, which lead into lists of each.
//!
//! ```text
//! header | lists over the objects, one an octant | ways back of all objects, for each octant | lists of each object
//! ```
//!
//! A list over the objects has a box for each and behind it a jump to the object's own list. From there rays come back by
//! the object's way back, which is a jump to what follows it in the list over the objects. So an object's own lists stay as
//! they are while it stands still, whatever happens around it.

use super::box_list::{BoxList, Links, Order};
use super::boxes::{END, Encoding, Frame, HEADER, NOWHERE, most_boxes, texels_of_box};
use super::words::{Texel, Words};
use crate::assets::parallel;
use crate::bvh::{Bvh, Node};
use crate::gpu::{Gpu, changed};
use crate::scene::Aabb;
use crate::scene::{Movers, ScenePart};
use glam::Vec3;
use std::ops::Range;

/// Boxes whose encoding a thread of its own is worth.
const WORTH_A_THREAD: usize = 8192;
/// Texels between two objects that are rather written again than left out.
const GAP: usize = 512;
/// A frame leaves room on each side, by this part of what it holds, for what moves on.
const ROOM: f32 = 0.125;
/// A frame that is so many times as long as what it holds is too coarse.
const COARSE: f32 = 4.0;

/// Where an object lies.
#[derive(Clone, Copy, Debug)]
struct Place {
    first_triangle: u32,
    triangles: u32,
    first_box: u32,
    /// Boxes that a list of it has room for.
    room: u32,
}

/// The boxes of moving objects on the device.
pub(super) struct MovingBoxes {
    /// The first one.
    first: u32,
    exact: bool,
    frame: Option<Frame>,
    /// What the frame is around.
    held: Aabb,
    /// The longest edge of a scene that it is for \[m\].
    scene_size: f32,
    places: Vec<Place>,
    /// All before the objects' own lists, as the device has it.
    over: Vec<Texel>,
}

impl MovingBoxes {
    /// Texels for objects of so many triangles, whatever their hierarchies become.
    pub(super) fn texel_count(triangles: &[usize], exact: bool) -> usize {
        let of_object = |count: &usize| 4 + most_boxes(*count) + 1;
        HEADER + 8 * texels_of_box(exact) * triangles.iter().map(of_object).sum::<usize>() + END
    }

    /// Objects of so many triangles, from a box and a triangle on.
    pub(super) fn new(triangles: &[usize], exact: bool, [first, first_triangle]: [u32; 2]) -> Self {
        let mut next = first_triangle;
        let places = triangles.iter().map(|&count| {
            let place = Place { first_triangle: next, triangles: count as u32, first_box: 0, room: 0 };
            next += place.triangles;
            place
        });
        let places = places.collect();
        Self { first, exact, frame: None, held: Aabb::EMPTY, scene_size: 0.0, places, over: Vec::new() }
    }

    /// First triangle of an object.
    pub(super) fn first_triangle(&self, object: usize) -> u32 {
        self.places[object].first_triangle
    }

    /// Uploads the boxes of objects that have changed since a version which the device holds (none: of all), and those
    /// over the objects.
    pub(super) fn update(&mut self, gpu: &Gpu, nodes: &Words, movers: &Movers, scene_size: f32, since: Option<u64>) {
        let is_kept = self.fit(movers, scene_size);
        let since = since.filter(|_| is_kept);
        let is_new = |object: &ScenePart| since.is_none_or(|since| object.version > since);
        let new: Vec<usize> = (0..movers.objects.len()).filter(|&index| is_new(&movers.objects[index])).collect();
        self.write_objects(gpu, nodes, movers, &new);
        let over = self.over_objects(movers);
        self.write_over(gpu, nodes, over);
    }

    /// Keeps where the boxes lie and what they are rounded to, if they fit, and says so.
    fn fit(&mut self, movers: &Movers, scene_size: f32) -> bool {
        let is_framed = self.exact || self.fit_frame(&movers.bounds(), scene_size);
        // Nothing lies at the first box of all: that is the header of static objects.
        let has_room = |(place, object): (&Place, &ScenePart)| {
            place.first_box > 0 && object.bvh.nodes.len() <= place.room as usize
        };
        let is_placed = self.places.iter().zip(&movers.objects).all(has_room);
        if !is_placed {
            self.lay_out(movers);
        }
        is_framed && is_placed
    }

    /// Gives each object as much room as it needs, and a little more: another pose may have another hierarchy.
    fn lay_out(&mut self, movers: &Movers) {
        let header = (HEADER / texels_of_box(self.exact)) as u32;
        let mut next = self.first + header + 32 * self.places.len() as u32;
        for (place, object) in self.places.iter_mut().zip(&movers.objects) {
            let boxes = object.bvh.nodes.len() as u32;
            place.room = (boxes + boxes / 8).min(most_boxes(place.triangles as usize) as u32);
            place.first_box = next;
            next += 8 * (place.room + 1);
        }
    }

    /// Keeps the frame if it holds the bounds and is not much too large for them, and says so.
    fn fit_frame(&mut self, bounds: &Aabb, scene_size: f32) -> bool {
        let bounds = if bounds.is_empty() { Aabb { min: Vec3::ZERO, max: Vec3::ZERO } } else { *bounds };
        let holds = self.held.union(&bounds) == self.held && scene_size <= self.scene_size;
        let is_fine = self.held.size().max_element() <= COARSE * bounds.size().max_element();
        if self.frame.is_some() && holds && is_fine {
            return true;
        }
        let room = ROOM * bounds.size();
        self.held = Aabb { min: bounds.min - room, max: bounds.max + room };
        self.scene_size = 2.0 * scene_size;
        self.frame = Some(Frame::new(&self.held, self.scene_size));
        false
    }

    fn encoding(&self) -> Encoding<'_> {
        self.frame.as_ref().filter(|_| !self.exact).map_or(Encoding::Exact, Encoding::InFrame)
    }

    /// The way back of an object.
    fn way_back(&self, object: usize, octant: u32) -> u32 {
        let objects = self.places.len() as u32;
        self.first + (HEADER / texels_of_box(self.exact)) as u32 + (24 + octant) * objects + object as u32
    }

    /// Uploads objects' own lists: those that lie close to each other at once.
    fn write_objects(&self, gpu: &Gpu, nodes: &Words, movers: &Movers, new: &[usize]) {
        let boxes: usize = new.iter().map(|&object| 8 * movers.objects[object].bvh.nodes.len()).sum();
        let in_box = texels_of_box(self.exact);
        let place = |object: usize| self.places[object].first_box as usize * in_box;
        for run in runs(new, |before, object| place(object) - place(before + 1) <= GAP) {
            let lists = |object: usize| self.lists_of(&movers.objects[object].bvh, object);
            let lists = parallel::consume(run.clone().collect(), boxes / WORTH_A_THREAD, lists);
            let mut texels =
                Vec::with_capacity(place(run.end - 1) - place(run.start) + lists.last().map_or(0, Vec::len));
            for (object, lists) in run.clone().zip(&lists) {
                texels.resize(place(object) - place(run.start), Texel::default());
                texels.extend_from_slice(lists);
            }
            nodes.write(gpu, place(run.start), &texels);
        }
    }

    /// An object's own lists.
    fn lists_of(&self, bvh: &Bvh, object: usize) -> Vec<Texel> {
        let Place { first_box, first_triangle: triangle, .. } = self.places[object];
        let lists = BoxList::new(bvh, self.encoding());
        let mut texels = Vec::with_capacity(8 * texels_of_box(self.exact) * (bvh.nodes.len() + 1));
        for octant in 0..8 {
            let behind = self.way_back(object, octant);
            lists.push(&mut texels, octant, Links { first: own_list(bvh, first_box, octant), behind, triangle });
            self.encoding().push_jump(&mut texels, behind);
        }
        texels
    }

    /// The header, the lists over the objects, and the ways back.
    fn over_objects(&self, movers: &Movers) -> Vec<Texel> {
        let (encoding, objects) = (self.encoding(), self.places.len());
        let (length, in_box) = (3 * objects as u32, texels_of_box(self.exact));
        let mut texels = Vec::with_capacity(HEADER + 32 * objects * in_box);
        texels.extend(self.frame.as_ref().filter(|_| !self.exact).map_or([[0; 4]; 2], Frame::texels));
        (texels[0][3], texels[1][3]) = (length, 0);
        let mut ways_back = vec![[NOWHERE; 8]; objects];
        let order = Order::new(&movers.top);
        for octant in 0..8 {
            let nodes: Vec<(Node, u32)> =
                order.nodes(octant).map(|(index, skip)| (movers.top.nodes[index], skip)).collect();
            let mut places = vec![self.first + (HEADER / in_box) as u32 + octant * length];
            places.extend(nodes.iter().scan(places[0], |place, (node, _)| {
                *place += if node.count > 0 { 2 } else { 1 };
                Some(*place)
            }));
            for ((node, skip), place) in nodes.iter().zip(&places) {
                if node.count == 0 {
                    encoding.push(&mut texels, &node.bounds(), places[*skip as usize]);
                    continue;
                }
                let object = movers.top.order[node.first as usize] as usize;
                encoding.push(&mut texels, &node.bounds(), place + 2);
                encoding.push_jump(&mut texels, self.entrance(&movers.objects[object].bvh, object, octant));
                ways_back[object][octant as usize] = place + 2;
            }
            // The end, more than once where objects have no box and are in no list.
            while texels.len() < HEADER + (octant + 1) as usize * length as usize * in_box {
                encoding.push_jump(&mut texels, NOWHERE);
            }
        }
        for octant in 0..8 {
            ways_back.iter().for_each(|way| encoding.push_jump(&mut texels, way[octant]));
        }
        texels
    }

    /// Where an object's own list begins: behind its root, whose box is that in the list over the objects.
    fn entrance(&self, bvh: &Bvh, object: usize, octant: u32) -> u32 {
        let is_inner = bvh.nodes.first().is_some_and(|root| root.count == 0);
        own_list(bvh, self.places[object].first_box, octant) + u32::from(is_inner)
    }

    /// Uploads what differs from what the device has.
    fn write_over(&mut self, gpu: &Gpu, nodes: &Words, over: Vec<Texel>) {
        let place = self.first as usize * texels_of_box(self.exact);
        for range in changed(&self.over, &over, GAP) {
            nodes.write(gpu, place + range.start, &over[range]);
        }
        self.over = over;
    }
}

/// Ranges of objects, of which these are new, to be written at once: one goes on where the new one is close behind.
pub(super) fn runs(new: &[usize], is_close: impl Fn(usize, usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for &object in new {
        match runs.last_mut().filter(|run| is_close(run.end - 1, object)) {
            Some(run) => run.end = object + 1,
            None => runs.push(object..object + 1),
        }
    }
    runs
}

/// The first box of an object's list for an octant; its lists lie behind each other, each with a jump at its end.
fn own_list(bvh: &Bvh, first_box: u32, octant: u32) -> u32 {
    first_box + octant * (bvh.nodes.len() as u32 + 1)
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::boxes::{COUNT_BITS, LEAF};
    use super::*;
    use crate::assets::{Material, Shape};
    use crate::scene::SceneBvh;
    use crate::scene::{Primitive, Scene, SceneId};
    use glam::Affine3A;
    use proptest::prelude::*;
    use std::sync::Arc;

    const FIRST: [u32; 2] = [16, 500];
    const TRIANGLES: u32 = 12;

    /// Boxes that move; those that stand nowhere have no box.
    pub(in super::super) fn scene(places: &[Affine3A]) -> Scene {
        let mesh = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().expect("a valid shape"));
        let material = Arc::new(Material::diffuse("grey", Vec3::splat(0.5)));
        let primitives = places.iter().zip(0..).map(|(place, id)| Primitive {
            id: SceneId(id),
            mesh: mesh.clone(),
            material: material.clone(),
            world_from_object: *place,
            bounds: mesh.bounds.transformed(place),
            casts_shadow: true,
            moving: true,
            geometry_revision: 1,
            material_revision: 1,
        });
        Scene { primitives: primitives.collect(), ..Scene::default() }
    }

    /// All that the device holds of the moving boxes.
    fn memory(boxes: &MovingBoxes, movers: &Movers) -> Vec<Texel> {
        let in_box = texels_of_box(boxes.exact);
        let mut memory = vec![Texel::default(); FIRST[0] as usize * in_box];
        memory.extend(boxes.over_objects(movers));
        for (object, place) in boxes.places.iter().enumerate() {
            memory.resize(place.first_box as usize * in_box, Texel::default());
            memory.extend(boxes.lists_of(&movers.objects[object].bvh, object));
        }
        let counts = vec![TRIANGLES as usize; boxes.places.len()];
        let room = MovingBoxes::texel_count(&counts, boxes.exact);
        assert!(memory.len() <= FIRST[0] as usize * in_box + room, "{} texels", memory.len());
        memory
    }

    /// First triangles of the leaves that a ray comes by, as `go_on` of `lib/walk.wgsl` goes.
    fn walk(memory: &[Texel], exact: bool, octant: u32, mut meets: impl FnMut(&Texel) -> bool) -> Vec<u32> {
        let in_box = texels_of_box(exact);
        let length = memory[FIRST[0] as usize * in_box][3];
        let mut next = FIRST[0] + (HEADER / in_box) as u32 + octant * length;
        let (mut leaves, mut steps) = (Vec::new(), 0);
        while next < NOWHERE {
            let texel = &memory[next as usize * in_box];
            let is_jump =
                texel[0] & if exact { u32::MAX } else { 0xffff } == if exact { f32::MAX.to_bits() } else { 0xffff };
            let (is_met, is_leaf) = (!is_jump && meets(texel), texel[3] >= LEAF);
            if is_met && is_leaf {
                let count = (texel[3] >> COUNT_BITS & 3) + 1;
                let first = texel[3] & ((1 << COUNT_BITS) - 1);
                leaves.extend(first..first + count);
            }
            next = if is_met || is_leaf { next + 1 } else { texel[3] };
            steps += 1;
            assert!(steps < 100_000, "the lists lead in a circle");
        }
        leaves
    }

    pub(in super::super) fn place() -> impl Strategy<Value = Affine3A> {
        let near = (-9.0..9.0_f32, -9.0..9.0_f32, -9.0..9.0_f32).prop_map(|at| Affine3A::from_translation(at.into()));
        prop_oneof![9 => near, 1 => Just(Affine3A::from_translation(Vec3::NAN))]
    }

    proptest! {
        #[test]
        fn rays_come_by_every_triangle_once_and_back(
            mut places in prop::collection::vec(place(), 1..12),
            moved in (any::<prop::sample::Index>(), place()),
            exact in any::<bool>(),
            octant in 0..8_u32,
        ) {
            let mut bvh = SceneBvh::new(&scene(&places));
            let counts = bvh.counts_of_movers();
            let mut boxes = MovingBoxes::new(&counts, exact, FIRST);
            boxes.fit(&bvh.movers, 20.0);
            let (mut before, mut is_kept): (Option<Vec<Texel>>, bool) = (None, true);
            for _ in 0..2 {
                let memory = memory(&boxes, &bvh.movers);
                let mut found = walk(&memory, exact, octant, |_| true);
                found.sort_unstable();
                let is_there = |(object, place): (u32, &Affine3A)| place.is_finite().then_some(object);
                let there = (0..).zip(&places).filter_map(is_there);
                let expected = there.flat_map(|object| (0..TRIANGLES).map(move |t| FIRST[1] + TRIANGLES * object + t));
                prop_assert_eq!(found, expected.collect::<Vec<_>>());
                prop_assert!(walk(&memory, exact, octant, |_| false).is_empty());
                let mut turn = 0_u32;
                let some = walk(&memory, exact, octant, |_| { turn += 1; !turn.is_multiple_of(3) });
                prop_assert!(some.len() <= places.len() * TRIANGLES as usize);
                // What stands still keeps its lists.
                if let Some(before) = before.filter(|_| is_kept) {
                    let in_box = texels_of_box(exact);
                    for object in (0..places.len()).filter(|object| *object != moved.0.index(places.len())) {
                        let start = boxes.places[object].first_box as usize * in_box;
                        let end = start + boxes.lists_of(&bvh.movers.objects[object].bvh, object).len();
                        prop_assert_eq!(&before[start..end], &memory[start..end]);
                    }
                }
                before = Some(memory);
                places[moved.0.index(counts.len())] = moved.1;
                bvh.update(&scene(&places));
                is_kept = boxes.fit(&bvh.movers, 20.0);
            }
        }
    }

    #[test]
    fn a_frame_is_kept_while_it_fits() {
        let at = |x: f32| Aabb { min: Vec3::splat(x), max: Vec3::splat(x + 10.0) };
        let mut boxes = MovingBoxes::new(&[1], false, FIRST);
        assert!(!boxes.fit_frame(&at(0.0), 30.0) && boxes.fit_frame(&at(1.0), 30.0));
        // It has moved out, its scene has grown, and it has shrunk.
        assert!(!boxes.fit_frame(&at(2.0), 30.0) && boxes.fit_frame(&at(2.0), 50.0));
        assert!(!boxes.fit_frame(&at(2.0), 70.0));
        let small = Aabb { min: Vec3::splat(3.0), max: Vec3::splat(4.0) };
        assert!(!boxes.fit_frame(&small, 70.0) && !boxes.fit_frame(&Aabb::EMPTY, 70.0));
        assert!(boxes.fit_frame(&Aabb::EMPTY, 70.0));
    }
}
