//! Wide hierarchies on the device, in the layout of `lib/wide_nodes.wgsl`.
//!
//! ```text
//! root | nodes over static and moving objects | nodes of static objects | nodes of each moving object
//! ```
//!
//! A node's children lie side by side. So the root of each object lies among the nodes over the objects, which are written
//! again when anything moves, and what is below it in a place of its own, which is written when the object moves.

use super::moving_boxes::runs;
use super::wide_tree::{Leaves, TEXELS, WideNode, WideTree, can_hold, most_nodes};
use super::words::Texel;
use super::{RayError, check_size};
use crate::assets::parallel;
use crate::bvh::{Bvh, Node};
use crate::gpu::{Gpu, changed};
use crate::scene::{Movers, SceneBvh, ScenePart};

/// Nodes whose encoding a thread of its own is worth.
const WORTH_A_THREAD: usize = 1024;
/// Nodes between two objects that are rather written again than left out.
const GAP: usize = 64;

/// Where what is below the root of an object lies.
#[derive(Clone, Copy, Debug)]
struct Place {
    first_triangle: u32,
    triangles: u32,
    first_node: u32,
    /// Nodes that there is room for.
    room: u32,
}

/// All nodes on the device.
pub(super) struct WideNodes {
    buffer: wgpu::Buffer,
    /// Where those of static objects begin.
    statics: u32,
    /// Where those of moving objects begin.
    movers: u32,
    places: Vec<Place>,
    static_root: Option<[Texel; TEXELS]>,
    /// The roots of moving objects, as far as they have any.
    roots: Vec<Option<[Texel; TEXELS]>>,
    /// Their trees, and in which version the hierarchies were built that these are of: boxes that are fitted again stay in
    /// their slots.
    trees: Vec<(Option<u64>, WideTree)>,
    /// All before the nodes of static objects, as the device has it.
    over: Vec<Texel>,
}

/// Whether a scene's hierarchies can be encoded.
pub(super) fn suit(bvh: &SceneBvh) -> bool {
    can_hold(&bvh.statics.bounds()) && can_hold(&bvh.movers.bounds())
}

/// Nodes of an object: its root, and what is below it.
struct Encoded {
    root: Option<[Texel; TEXELS]>,
    rest: Vec<Texel>,
}

/// An object's nodes, and its tree if that is another one than before.
struct Changed {
    object: usize,
    tree: Option<WideTree>,
    encoded: Encoded,
}

impl Encoded {
    /// What is below the root begins at a node, and the triangles at a triangle.
    fn new(tree: &WideTree, bvh: &Bvh, first_node: u32, first_triangle: u32) -> Self {
        // Its own root is not among its nodes here.
        let nodes = first_node.wrapping_sub(1);
        let mut encoded = tree.nodes.iter().map(|node| node.encode(bvh, nodes, first_triangle));
        Self { root: encoded.next(), rest: encoded.flatten().collect() }
    }
}

impl WideNodes {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            buffer: buffer(gpu, 1),
            statics: 1,
            movers: 1,
            places: Vec::new(),
            static_root: None,
            roots: Vec::new(),
            trees: Vec::new(),
            over: Vec::new(),
        }
    }

    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Whether rays can meet anything.
    pub(super) fn hold_anything(&self) -> bool {
        self.static_root.is_some() || self.places.iter().any(|place| place.triangles > 0)
    }

    /// First triangle of a moving object.
    pub(super) fn first_triangle(&self, object: usize) -> u32 {
        self.places[object].first_triangle
    }

    /// Uploads all static objects, and makes room for moving ones, which are to be uploaded next.
    ///
    /// # Errors
    /// If the device cannot bind a buffer of that size.
    pub(super) fn update_statics(&mut self, gpu: &Gpu, statics: &Bvh, movers: &[usize]) -> Result<(), RayError> {
        let objects = movers.len();
        self.statics = if objects > 0 { most_nodes(objects + 1) as u32 + 1 } else { 1 };
        let tree = WideTree::new(statics, Leaves::Triangles);
        let Encoded { root, rest } = Encoded::new(&tree, statics, self.statics, 0);
        self.movers = self.statics + (rest.len() / TEXELS) as u32;
        let room: usize = movers.iter().map(|count| most_nodes(*count)).sum();
        self.reserve(gpu, self.movers as usize + room)?;
        let mut first_triangle = statics.order.len() as u32;
        let place = |&count: &usize| {
            let place = Place { first_triangle, triangles: count as u32, first_node: 0, room: 0 };
            first_triangle += place.triangles;
            place
        };
        self.places = movers.iter().map(place).collect();
        self.roots = vec![None; objects];
        self.trees = (0..objects).map(|_| Default::default()).collect();
        self.static_root = root;
        self.over.clear();
        self.write(gpu, self.statics as usize, &rest);
        if movers.iter().sum::<usize>() == 0 {
            self.write(gpu, 0, root.as_ref().map_or(&[][..], |root| &root[..]));
        }
        Ok(())
    }

    /// Uploads moving objects that have changed since a version which the device holds (none: all), and the nodes over
    /// the objects.
    pub(super) fn update_movers(&mut self, gpu: &Gpu, statics: &Bvh, movers: &Movers, since: Option<u64>) {
        let is_new = |object: &ScenePart| since.is_none_or(|since| object.version > since);
        let new: Vec<usize> = (0..movers.objects.len()).filter(|&index| is_new(&movers.objects[index])).collect();
        let mut changed_objects = self.encode_objects(movers, new);
        self.keep_trees(movers, &mut changed_objects);
        if !changed_objects.iter().all(|changed| self.has_room(changed)) {
            changed_objects = self.encode_objects(movers, (0..movers.objects.len()).collect());
            self.keep_trees(movers, &mut changed_objects);
            self.lay_out(&changed_objects);
            changed_objects = self.encode_objects(movers, (0..movers.objects.len()).collect());
        }
        self.write_objects(gpu, changed_objects);
        let over = self.over_objects(statics, movers);
        for range in changed(&self.over, &over, GAP * TEXELS) {
            gpu.write_buffer(
                &self.buffer,
                (range.start * size_of::<Texel>()) as u64,
                bytemuck::cast_slice(&over[range]),
            );
        }
        self.over = over;
    }

    fn encode_objects(&self, movers: &Movers, objects: Vec<usize>) -> Vec<Changed> {
        let nodes: usize = objects.iter().map(|&object| movers.objects[object].bvh.nodes.len()).sum();
        let encode = |object: usize| {
            let (part, place, (built, kept)) = (&movers.objects[object], &self.places[object], &self.trees[object]);
            let tree = (*built != Some(part.built)).then(|| WideTree::new(&part.bvh, Leaves::Triangles));
            let current = tree.as_ref().unwrap_or(kept);
            let encoded = Encoded::new(current, &part.bvh, place.first_node, place.first_triangle);
            Changed { object, tree, encoded }
        };
        parallel::consume(objects, nodes / WORTH_A_THREAD, encode)
    }

    /// Keeps trees that are new for when their boxes are fitted again.
    fn keep_trees(&mut self, movers: &Movers, changed: &mut [Changed]) {
        for changed in changed {
            if let Some(tree) = changed.tree.take() {
                self.trees[changed.object] = (Some(movers.objects[changed.object].built), tree);
            }
        }
    }

    fn has_room(&self, changed: &Changed) -> bool {
        let place = &self.places[changed.object];
        // Nothing lies at the first node of all.
        place.first_node > 0 && changed.encoded.rest.len() <= place.room as usize * TEXELS
    }

    /// Gives each object as much room as it needs, and a little more: another pose may have another hierarchy.
    fn lay_out(&mut self, objects: &[Changed]) {
        let mut next = self.movers;
        for (place, changed) in self.places.iter_mut().zip(objects) {
            let nodes = (changed.encoded.rest.len() / TEXELS) as u32;
            place.room = (nodes + nodes / 8).min(most_nodes(place.triangles as usize) as u32);
            place.first_node = next;
            next += place.room;
        }
    }

    /// Uploads objects: those that lie close to each other at once.
    fn write_objects(&mut self, gpu: &Gpu, objects: Vec<Changed>) {
        let place = |object: usize| self.places[object].first_node as usize;
        let new: Vec<usize> = objects.iter().map(|changed| changed.object).collect();
        let mut rests = objects.iter().map(|changed| &changed.encoded.rest);
        for run in runs(&new, |before, object| place(object) - place(before + 1) <= GAP) {
            let mut texels = Vec::new();
            for (object, rest) in run.clone().zip(&mut rests) {
                texels.resize((place(object) - place(run.start)) * TEXELS, Texel::default());
                texels.extend_from_slice(rest);
            }
            self.write(gpu, place(run.start), &texels);
        }
        for changed in objects {
            self.roots[changed.object] = changed.encoded.root;
        }
    }

    /// The nodes over all objects, the static ones being one more.
    fn over_objects(&self, statics: &Bvh, movers: &Movers) -> Vec<Texel> {
        let objects = self.places.len();
        let top = joined(statics, &movers.top, objects as u32);
        let tree = WideTree::new(&top, Leaves::Nodes);
        let root_of = |source: u32| {
            let leaf = Some(&top.nodes[source as usize]).filter(|node| node.count > 0)?;
            let object = top.order[leaf.first as usize] as usize;
            if object == objects { self.static_root } else { self.roots[object] }
        };
        let encode = |node: &WideNode| root_of(node.source).unwrap_or_else(|| node.encode(&top, 0, 0));
        // A root that leads nowhere, if there is nothing.
        let nothing = tree.nodes.is_empty().then_some([Texel::default(); TEXELS]);
        tree.nodes.iter().map(encode).chain(nothing).flatten().collect()
    }

    fn reserve(&mut self, gpu: &Gpu, nodes: usize) -> Result<(), RayError> {
        let bytes = (nodes.max(1) * TEXELS * size_of::<Texel>()) as u64;
        check_size(gpu, "hierarchies", bytes)?;
        if self.buffer.size() != bytes {
            self.buffer = buffer(gpu, nodes.max(1));
        }
        Ok(())
    }

    /// Writes from a node on.
    fn write(&self, gpu: &Gpu, first: usize, texels: &[Texel]) {
        if !texels.is_empty() {
            let offset = first * TEXELS * size_of::<Texel>();
            gpu.write_buffer(&self.buffer, offset as u64, bytemuck::cast_slice(texels));
        }
    }
}

fn buffer(gpu: &Gpu, nodes: usize) -> wgpu::Buffer {
    gpu.create_buffer(&wgpu::BufferDescriptor {
        label: Some("ray nodes"),
        size: (nodes * TEXELS * size_of::<Texel>()) as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

/// A hierarchy over moving objects and, as one more object of this index, all static ones.
fn joined(statics: &Bvh, top: &Bvh, index: u32) -> Bvh {
    let Some(root) = statics.nodes.first() else { return top.clone() };
    let mut order = top.order.clone();
    order.push(index);
    let leaf = Node { first: order.len() as u32 - 1, count: 1, ..*root };
    let Some(moving) = top.nodes.first() else { return Bvh { nodes: vec![leaf], order } };
    let whole = root.bounds().union(&moving.bounds());
    let whole = Node { min: whole.min.to_array(), max: whole.max.to_array(), first: 1, count: 0 };
    let below = top.nodes.iter().map(|node| match node.count {
        0 => Node { first: node.first + 2, ..*node },
        _ => *node,
    });
    Bvh { nodes: [whole, leaf].into_iter().chain(below).collect(), order }
}

#[cfg(test)]
mod tests {
    use super::super::moving_boxes::tests::{place, scene};
    use super::super::wide_tree::tests::walk;
    use super::*;
    use crate::assets::Shape;
    use crate::gpu::{GpuOptions, read_buffer};
    use crate::scene::Scene;
    use glam::Affine3A;
    use proptest::prelude::*;
    use std::sync::Arc;

    const TRIANGLES: u32 = 12;

    /// Boxes, of which the first ones stand still.
    fn boxes(places: &[Affine3A], standing: usize) -> Scene {
        let mut scene = scene(places);
        scene.primitives.iter_mut().take(standing).for_each(|primitive| primitive.moving = false);
        scene
    }

    fn place_at(scene: &mut Scene, index: usize, place: Affine3A) {
        let primitive = &mut scene.primitives[index];
        primitive.world_from_object = place;
        primitive.bounds = primitive.mesh.bounds.transformed(&place);
    }

    /// What the device holds.
    fn memory(gpu: &Gpu, nodes: &WideNodes) -> Vec<Texel> {
        read_buffer(gpu, nodes.buffer()).expect("it can be read")
    }

    fn made(gpu: &Gpu, bvh: &SceneBvh) -> WideNodes {
        let mut nodes = WideNodes::new(gpu);
        nodes.update_statics(gpu, &bvh.statics.bvh, &bvh.counts_of_movers()).expect("there is room");
        if bvh.moving_triangles() > 0 {
            nodes.update_movers(gpu, &bvh.statics.bvh, &bvh.movers, None);
        }
        nodes
    }

    /// The scene's triangles that a ray comes by, from places in the hierarchies.
    fn met(nodes: &WideNodes, bvh: &SceneBvh, memory: &[Texel], octant: usize) -> Vec<u32> {
        let statics = &bvh.statics.bvh.order;
        let orders = bvh.movers.objects.iter().map(|object| &object.bvh.order);
        let index = |place: u32| {
            let Some(behind) = (place as usize).checked_sub(statics.len()) else { return statics[place as usize] };
            let (object, at) = (behind / TRIANGLES as usize, behind % TRIANGLES as usize);
            assert_eq!(nodes.first_triangle(object) as usize, statics.len() + object * TRIANGLES as usize);
            orders.clone().nth(object).expect("an object")[at]
        };
        let mut found: Vec<u32> = walk(memory, octant, |_| true).0.into_iter().map(index).collect();
        found.sort_unstable();
        // Static triangles may be in several leaves.
        let are_static = |triangle: u32| (triangle as usize) < bvh.triangles.len() - bvh.moving_triangles();
        found.dedup_by(|a, b| a == b && are_static(*a));
        found
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn rays_come_by_all_objects_wherever_they_move(
            mut places in prop::collection::vec(place(), 1..12),
            standing in 0..3_usize,
            moved in (any::<prop::sample::Index>(), place()),
        ) {
            let gpu = Gpu::noop(&GpuOptions::default()).expect("a device");
            let standing = standing.min(places.len());
            let mut scene = boxes(&places, standing);
            let mut bvh = SceneBvh::new(&scene);
            let mut nodes = made(&gpu, &bvh);
            for octant in [0, 5, 7] {
                let memory = memory(&gpu, &nodes);
                let there = (0..).zip(&places).filter(|(_, place)| place.is_finite());
                let expected = there.flat_map(|(object, _): (u32, _)| TRIANGLES * object..TRIANGLES * (object + 1));
                prop_assert_eq!(met(&nodes, &bvh, &memory, octant), expected.collect::<Vec<_>>());
                prop_assert!(walk(&memory, octant, |_| false).0.is_empty());
                if standing == places.len() {
                    break;
                }
                let index = standing + moved.0.index(places.len() - standing);
                places[index] = moved.1;
                place_at(&mut scene, index, moved.1);
                let before = bvh.movers.version;
                bvh.update(&scene);
                nodes.update_movers(&gpu, &bvh.statics.bvh, &bvh.movers, Some(before));
            }
        }
    }

    #[test]
    fn what_stands_still_is_not_uploaded_again() {
        let gpu = Gpu::noop(&GpuOptions::default()).expect("a device");
        let ball = Arc::new(Shape::Sphere { radius: 1.0, segments: 64, rings: 32 }.mesh().expect("a valid shape"));
        let place = |i: u8| Affine3A::from_translation(glam::Vec3::new(3.0 * f32::from(i), 0.0, 0.0));
        let mut scene = boxes(&(0..20).map(place).collect::<Vec<_>>(), 2);
        scene.primitives.iter_mut().for_each(|primitive| primitive.mesh = ball.clone());
        let mut bvh = SceneBvh::new(&scene);
        let bytes = || gpu.counts().uploaded;
        let mut nodes = made(&gpu, &bvh);
        let (before, version) = (bytes(), bvh.movers.version);
        nodes.update_movers(&gpu, &bvh.statics.bvh, &bvh.movers, Some(version));
        assert_eq!(bytes(), before);
        place_at(&mut scene, 9, Affine3A::from_translation(glam::Vec3::new(27.0, 0.5, 0.0)));
        bvh.update(&scene);
        nodes.update_movers(&gpu, &bvh.statics.bvh, &bvh.movers, Some(version));
        let written = bytes() - before;
        assert!(written > 0 && written < before / 15, "{written} bytes after {before}");
    }
}
