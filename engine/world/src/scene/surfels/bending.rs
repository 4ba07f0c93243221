//! Objects that bend: those that skins and morph targets pose.
//!
//! Their surfels and patches are those of the mesh at rest. Each surfel stays on its triangle and each patch keeps its surfels,
//! so that links that end there, and what earlier frames know of a patch, hold in the next pose. Where surfels are now tells in
//! which cells their patch is looked for.

use super::group::{Group, GroupKey, bends, place_bits, shape};
use super::patches::{Arranged, Cell, Faces, cells_of, grid_normal};
use super::samples::Samples;
use super::surfel::{Fineness, Surfel, has_surfels};
use crate::scene::{Primitive, Scene};
use glam::Vec3;
use std::ops::Range;
use std::sync::Arc;

/// An object that bends.
#[derive(Debug)]
pub(super) struct Bending {
    /// Its place among the groups.
    pub group: usize,
    /// Its first patch among those of the scene.
    pub first_patch: u32,
    /// Its surfels among those of the scene.
    pub surfels: Range<usize>,
    /// The cells of its grid in which its patches are found now, counted from its first one.
    pub cells: Vec<([i32; 3], Faces)>,
    key: GroupKey,
    /// Indices of its primitives in the scene.
    members: Vec<usize>,
    samples: Arc<Samples>,
    arranged: Arc<Arranged>,
}

/// A pose of an object.
pub(super) struct Pose {
    pub surfels: Vec<Surfel>,
    pub cells: Vec<([i32; 3], Faces)>,
}

impl Bending {
    /// The groups that bend, not posed yet.
    pub fn all(
        scene: &Scene,
        groups: &[Group],
        keys: &[GroupKey],
        samples: &[Arc<Samples>],
        arranged: &[Arc<Arranged>],
    ) -> Vec<Self> {
        let index = |primitive: &&Primitive| scene.primitives.binary_search_by_key(&primitive.id, |p| p.id).ok();
        let (mut surfel, mut first_patch, mut all) = (0, 0, Vec::new());
        for (group, object) in arranged.iter().enumerate() {
            if groups[group].is_bending {
                all.push(Self {
                    group,
                    first_patch,
                    surfels: surfel..surfel + object.surfels.len(),
                    cells: Vec::new(),
                    key: keys[group].clone(),
                    members: groups[group].members.iter().filter_map(index).collect(),
                    samples: samples[group].clone(),
                    arranged: object.clone(),
                });
            }
            surfel += object.surfels.len();
            first_patch += object.patch_count();
        }
        all
    }

    /// The object as the scene has it now; none if it is no longer the same one.
    pub fn object<'a>(&self, scene: &'a Scene, fineness: Fineness) -> Option<Group<'a>> {
        let members: Vec<&Primitive> = self.members.iter().map(|&index| &scene.primitives[index]).collect();
        let place = members.first()?.world_from_object;
        let is_one =
            |p: &&Primitive| has_surfels(p) && bends(p) && place_bits(&p.world_from_object) == place_bits(&place);
        let group = members.iter().all(is_one).then(|| Group::new(place, true, members))?;
        (group.key(fineness) == self.key).then_some(group)
    }

    /// Its surfels, patch after patch, and the cells of size \[m\] in which the patches are found. Where several are in one cell
    /// the one with the most surfels there answers.
    pub fn posed(&self, group: &Group, size: f32) -> Pose {
        let posed = self.samples.posed(group);
        let surfels = self
            .arranged
            .order
            .iter()
            .map(|&index| Surfel { place: self.group as u32 | posed[index as usize].place, ..posed[index as usize] });
        let surfels: Vec<Surfel> = surfels.collect();
        let shape = shape(&group.place);
        let cell = |surfel: &Surfel| {
            let normal = grid_normal(&shape, surfel.normal.into());
            Cell::of(shape * Vec3::from(surfel.position) / size, normal)
        };
        let cells = cells_of(surfels.iter().map(cell).zip(self.arranged.patch_of_surfels()));
        Pose { surfels, cells }
    }

    pub fn has_changed(&self, scene: &Scene, since: u64) -> bool {
        self.members.iter().any(|&index| scene.primitives[index].geometry_revision > since)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use crate::assets::{Deform, Mesh, MorphTarget, Pose, Shape, Vertex, pose_all};
    use crate::scene::{Primitive, Revisions, Scene, SurfelCloud, cells_from_world};
    use glam::Affine3A;
    use glam::Vec3;
    use std::sync::Arc;

    const CELL: f32 = 0.2;

    /// A pole of 2 m whose top half moves aside by up to 1 m.
    fn pole() -> Arc<Mesh> {
        let mut mesh = Shape::Sphere { radius: 1.0, segments: 24, rings: 24 }.mesh().expect("a valid shape");
        for vertex in &mut mesh.vertices {
            vertex.position = [0.2 * vertex.position[0], vertex.position[1], 0.2 * vertex.position[2]];
        }
        let mut mesh = Mesh::new("pole", mesh.vertices, mesh.indices);
        let aside = |y: f32| [if y > 0.0 { y * y } else { 0.0 }, 0.0, 0.0];
        let positions = mesh.vertices.iter().map(|vertex| aside(vertex.position[1])).collect();
        let targets = vec![MorphTarget { positions, ..Default::default() }];
        mesh.deform = Some(Arc::new(Deform { targets, ..Default::default() }));
        Arc::new(mesh)
    }

    pub fn posed(mesh: &Arc<Mesh>, weight: f32) -> Arc<Mesh> {
        pose_all(&[(mesh.clone(), Pose { weights: vec![weight], palette: Vec::new() })]).remove(0)
    }

    fn primitive(id: u64, mesh: Arc<Mesh>, place: Affine3A, moving: bool) -> Primitive {
        Primitive { moving, ..fixture::primitive(id, mesh, place) }
    }

    /// A floor, a pole that bends, another one that stands at the place of the floor, and one that moves as a whole.
    fn scene() -> (Scene, Arc<Mesh>) {
        let floor = Arc::new(Shape::Box { size: [6.0, 0.2, 6.0] }.mesh().expect("a valid shape"));
        let pole = pole();
        let aside = Affine3A::from_translation(Vec3::X * 2.0);
        let primitives = vec![
            primitive(1, floor.clone(), Affine3A::IDENTITY, false),
            primitive(2, pole.clone(), aside, true),
            primitive(3, pole.clone(), Affine3A::IDENTITY, true),
            primitive(4, floor, Affine3A::from_translation(Vec3::Y * 3.0), true),
        ];
        let revisions = Revisions { geometry: 1, materials: 1, statics: 1, ..Revisions::default() };
        (Scene { identity: 1, primitives, revisions, ..Scene::default() }, pole)
    }

    fn pose(scene: &mut Scene, index: usize, mesh: Arc<Mesh>, place: Affine3A) {
        scene.revisions.geometry += 1;
        let primitive = &mut scene.primitives[index];
        *primitive = Primitive {
            geometry_revision: scene.revisions.geometry,
            material: primitive.material.clone(),
            ..self::primitive(primitive.id.0, mesh, place, primitive.moving)
        };
    }

    fn fresh(scene: &Scene) -> SurfelCloud {
        let mut cloud = SurfelCloud::default();
        cloud.update(scene, CELL);
        cloud
    }

    #[test]
    fn a_pose_leaves_surfels_and_patches_the_same_ones() {
        let (mut scene, pole) = scene();
        let mut cloud = fresh(&scene);
        let (layout, rebuilt, ranges) = (cloud.layout, cloud.rebuilt, cloud.patches.ranges.clone());
        let at_rest = cloud.surfels.clone();
        for (index, weight) in [(1, 0.5), (2, -0.3), (1, 1.0), (2, 0.0)] {
            let before = cloud.revision;
            let place = scene.primitives[index].world_from_object;
            pose(&mut scene, index, posed(&pole, weight), place);
            cloud.update(&scene, CELL);
            let told = [cloud.layout - layout, cloud.rebuilt - rebuilt, cloud.patches.bending().1.len() as u64];
            assert!(cloud.revision > before && told[..2] == [0, 0], "pose {weight} of {index}: {told:?}");
            let new = fresh(&scene);
            assert!(cloud.surfels == new.surfels && cloud.patches.ranges == new.patches.ranges);
            assert!(cloud.patches.table == new.patches.table && cloud.places == new.places);
            assert!(cloud.mean_albedo == new.mean_albedo && cloud.area() == new.area());
        }
        assert_eq!(cloud.patches.ranges, ranges);
        let moved = cloud.surfels.iter().zip(&at_rest).filter(|(now, then)| now.position != then.position).count();
        assert!(moved > 50, "{moved} surfels");
        // The floor that moves takes the slow way around when it is scaled, and the poles keep theirs.
        let scaled = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.5));
        let floor = scene.primitives[3].mesh.clone();
        pose(&mut scene, 3, floor, scaled);
        cloud.update(&scene, CELL);
        assert!(cloud.layout > layout && cloud.surfels == fresh(&scene).surfels);
    }

    #[test]
    fn points_of_a_posed_surface_find_a_patch_that_lies_there() {
        let (mut scene, pole) = scene();
        let turned = Affine3A::from_rotation_translation(glam::Quat::from_rotation_y(0.8), Vec3::new(2.0, 0.3, 0.0));
        let mut cloud = fresh(&scene);
        let layout = cloud.layout;
        pose(&mut scene, 1, posed(&pole, 1.0), turned);
        cloud.update(&scene, CELL);
        assert_eq!(cloud.layout, layout);
        let group = cloud.place_of_primitive[1];
        let grid = cells_from_world(&cloud.places[group as usize], cloud.patches.size);
        let mut facing = 0;
        let points: Vec<_> = scene.primitives[1].mesh.vertices.iter().collect();
        for vertex in &points {
            let point = turned.transform_point3(vertex.position.into());
            let normal = turned.transform_vector3(vertex.normal.into()).normalize();
            let in_grid = grid.transform_vector3(normal).normalize();
            let found = cloud.patches.at(group, grid.transform_point3(point), in_grid).expect("a patch");
            let [first, count] = cloud.patches.ranges[found as usize].map(|v| v as usize);
            let surfels = &cloud.surfels[first..first + count];
            assert!(surfels.iter().all(|surfel| surfel.group() == group as usize));
            let distance = |s: &super::Surfel| turned.transform_point3(s.position.into()).distance(point);
            let nearest = surfels.iter().map(distance).fold(f32::INFINITY, f32::min);
            assert!(nearest < 3.0 * cloud.patches.size, "{nearest} m off");
            let is_facing = |s: &super::Surfel| turned.transform_vector3(s.normal.into()).dot(normal) > 0.0;
            facing += usize::from(surfels.iter().any(is_facing));
        }
        assert!(facing as f32 > 0.9 * points.len() as f32, "{facing} of {}", points.len());
    }

    /// A skin may make metres of centimetres: surfels are as dense as those of a mesh in metres.
    #[test]
    fn density_follows_the_size_of_the_pose() {
        let (scene, _) = scene();
        let pole = pole();
        let count = fresh(&scene).bending().next().expect("one that bends").len();
        let small = pole.vertices.iter().map(|v| Vertex { position: v.position.map(|v| v / 128.0), ..*v });
        let rest = Some(Arc::new(Mesh::new("pole", small.collect(), pole.indices.clone())));
        let mut large = Mesh::new("pole", pole.vertices.clone(), pole.indices.clone());
        large.rest = rest;
        let mut other = scene;
        other.primitives[1].mesh = Arc::new(large);
        let cloud = fresh(&other);
        let range = cloud.bending().next().expect("one that bends");
        assert!(range.len().abs_diff(count) <= count / 10, "{} surfels, not {count}", range.len());
        let area: f32 = cloud.surfels[range].iter().map(|surfel| surfel.area).sum();
        assert!((1.5..2.5).contains(&area), "{area} m²");
    }
}
