//! Surfels that no light can reach: those of a column's foot in the floor, or of the floor below it. Scenes are put
//! together of objects that stand within each other; what is buried would claim a part of the light for itself.

use super::{Group, Surfel};
use crate::assets::{AlphaMode, parallel};
use crate::bvh::{Ray, RayKind, SceneBvh, world_normal};
use crate::scene::{Primitive, Scene};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Surfels that are looked at together.
const CHUNK: usize = 4096;
/// How far before a surfel its rays start \[cells\]: where two surfaces coincide, each is behind the other.
const BEFORE: f32 = 0.01;
/// Cosine of the rays that lean.
const COSINE: f32 = 0.5;
/// So many of them around the normal.
const LEANING: u8 = 5;

/// The surfels of objects that do not move without those that are buried, kept as long as nothing changes but what moves.
#[derive(Debug, Default)]
pub(super) struct Exposed {
    state: Option<[u64; 4]>,
    /// All surfels of a group and those that are not buried, by its place.
    groups: HashMap<[u32; 12], [Arc<Vec<Surfel>>; 2]>,
}

impl Exposed {
    /// What is left of the surfels of each group, for cells of a size \[m\].
    pub fn update(
        &mut self,
        scene: &Scene,
        cell: f32,
        groups: &[Group],
        all: Vec<Arc<Vec<Surfel>>>,
    ) -> Vec<Arc<Vec<Surfel>>> {
        let state = state(scene, cell);
        if self.state != Some(state) {
            self.groups.clear();
            self.state = Some(state);
        }
        let mut burial = None;
        let left = |(group, all): (&Group, Arc<Vec<Surfel>>)| {
            if group.members.iter().any(|member| member.moving) {
                return all;
            }
            let place = group.place.to_cols_array().map(f32::to_bits);
            if let Some([_, left]) = self.groups.get(&place).filter(|[known, _]| Arc::ptr_eq(known, &all)) {
                return left.clone();
            }
            let buried = burial.get_or_insert_with(|| Burial::new(scene, cell)).of(&all, &group.place);
            let left = match buried.contains(&true) {
                true => Arc::new(all.iter().zip(&buried).filter(|(_, buried)| !**buried).map(|(s, _)| *s).collect()),
                false => all.clone(),
            };
            self.groups.insert(place, [all, left.clone()]);
            left
        };
        groups.iter().zip(all).map(left).collect()
    }
}

/// All that it depends on which surfels are buried.
fn state(scene: &Scene, cell: f32) -> [u64; 4] {
    let revisions = scene.revisions;
    // A scene that does not tell what moves is still as a whole.
    let still = if revisions.statics == 0 { revisions.geometry } else { revisions.statics };
    [scene.identity, still, revisions.materials, u64::from(cell.to_bits())]
}

/// All that does not move, ready for rays.
struct Burial<'a> {
    scene: &'a Scene,
    still: SceneBvh,
    /// Which primitive of the scene each of those is that do not move.
    indices: Vec<usize>,
    before: f32,
}

impl<'a> Burial<'a> {
    fn new(scene: &'a Scene, cell: f32) -> Self {
        let is_still = |primitive: &Primitive| !primitive.moving && primitive.casts_shadow;
        let indices: Vec<usize> =
            (0..scene.primitives.len()).filter(|&index| is_still(&scene.primitives[index])).collect();
        let primitives = indices.iter().map(|&index| scene.primitives[index].clone()).collect();
        let still = SceneBvh::new(&Scene { primitives, ..Scene::default() });
        Self { scene, still, indices, before: BEFORE * cell }
    }

    /// Whether each of the surfels is buried, at their places.
    fn of(&self, surfels: &[Surfel], place: &Affine3A) -> Vec<bool> {
        let chunks: Vec<Range<usize>> =
            (0..surfels.len()).step_by(CHUNK).map(|first| first..surfels.len().min(first + CHUNK)).collect();
        let buried = |chunk: &Range<usize>| -> Vec<bool> {
            surfels[chunk.clone()].iter().map(|surfel| self.is_buried(surfel, place)).collect()
        };
        parallel::map(&chunks, buried).concat()
    }

    /// Whether all rays that leave a surfel meet the back of a surface first: it lies within a solid, where all that light
    /// ever meets is black. A few rays do: one that finds a way out is enough.
    fn is_buried(&self, surfel: &Surfel, place: &Affine3A) -> bool {
        let normal = world_normal(place, surfel.normal.into());
        if normal == Vec3::ZERO {
            return false;
        }
        let point = place.transform_point3(surfel.position.into());
        let start = point + normal * (self.before + 1e-5 * point.abs().max_element());
        let [u, v] = normal.any_orthonormal_pair().into();
        let leaning = (0..LEANING).map(|index| {
            let (sin, cos) = (std::f32::consts::TAU * f32::from(index) / f32::from(LEANING)).sin_cos();
            COSINE * normal + (1.0 - COSINE * COSINE).sqrt() * (cos * u + sin * v)
        });
        std::iter::once(normal).chain(leaning).all(|direction| self.meets_a_back(&Ray::new(start, direction)))
    }

    fn meets_a_back(&self, ray: &Ray) -> bool {
        self.still.closest_hit(ray, f32::INFINITY, RayKind::Light).is_some_and(|hit| {
            let triangle = &self.still.triangles[hit.triangle as usize];
            let primitive = &self.scene.primitives[self.indices[triangle.primitive as usize]];
            let material = &primitive.material;
            !material.double_sided && material.alpha_mode == AlphaMode::Opaque && !triangle.is_front(ray)
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::assets::{AlphaMode, Material, Shape};
    use crate::scene::{Primitive, Revisions, Scene, SceneId, SurfelCloud};
    use glam::{Affine3A, Vec3};
    use std::sync::Arc;

    fn box_at(id: u64, size: [f32; 3], at: Vec3, material: Material) -> Primitive {
        let mesh = Arc::new(Shape::Box { size }.mesh().expect("a valid shape"));
        let place = Affine3A::from_translation(at);
        Primitive {
            id: SceneId(id),
            name: String::new(),
            bounds: mesh.bounds.transformed(&place),
            world_from_object: place,
            material: Arc::new(material),
            mesh,
            casts_shadow: true,
            moving: false,
            geometry_revision: 0,
            material_revision: 0,
        }
    }

    fn stone() -> Material {
        Material::diffuse("stone", Vec3::splat(0.5))
    }

    /// Area of the surfels of each primitive, which stand at places of their own.
    fn areas(primitives: Vec<Primitive>) -> Vec<f32> {
        let count = primitives.len();
        let revisions = Revisions { geometry: 1, ..Default::default() };
        let scene = Scene { identity: 1, revisions, primitives, ..Default::default() };
        let mut cloud = SurfelCloud::default();
        cloud.update(&scene, 0.1);
        (0..count).map(|place| cloud.surfels.iter().filter(|s| s.place == place as u32).map(|s| s.area).sum()).collect()
    }

    fn within(value: f32, expected: f32) -> bool {
        (value / expected - 1.0).abs() < 0.03
    }

    #[test]
    fn what_stands_in_something_else_is_buried_and_what_looks_out_is_not() {
        let floor = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
        // Half of it in the floor: 5 of 10 m² are left.
        let column = box_at(2, [1.0, 2.0, 1.0], Vec3::ZERO, stone());
        let found = areas(vec![floor, column]);
        assert!(within(found[1], 5.0), "{found:?}");
        assert!(within(found[0], 48.0 - 1.0), "{found:?}");
    }

    #[test]
    fn a_face_on_a_face_is_buried() {
        let lower = box_at(1, [2.0; 3], Vec3::new(0.0, -1.0, 0.0), stone());
        let upper = box_at(2, [1.0; 3], Vec3::new(0.0, 0.5, 0.0), stone());
        let found = areas(vec![lower, upper]);
        assert!(within(found[0], 23.0) && within(found[1], 5.0), "{found:?}");
    }

    #[test]
    fn a_room_is_no_solid_and_neither_is_a_shell_with_two_sides_or_with_holes() {
        let two_sides = Material { double_sided: true, ..stone() };
        let holes = Material { alpha_mode: AlphaMode::Mask(0.5), ..stone() };
        for material in [two_sides, holes] {
            let shell = box_at(1, [3.0; 3], Vec3::ZERO, material);
            let found = areas(vec![shell, box_at(2, [1.0; 3], Vec3::ZERO, stone())]);
            assert!(within(found[1], 6.0), "{found:?}");
        }
        // Its faces look inwards.
        let mut room = box_at(1, [3.0; 3], Vec3::ZERO, stone());
        room.world_from_object.matrix3 *= -1.0;
        let mesh = Arc::make_mut(&mut room.mesh);
        mesh.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
        let found = areas(vec![room, box_at(2, [1.0; 3], Vec3::ZERO, stone())]);
        assert!(within(found[1], 6.0), "{found:?}");
    }

    #[test]
    fn what_moves_buries_nothing_and_is_not_buried() {
        let wall = box_at(1, [3.0; 3], Vec3::ZERO, stone());
        let mover = Primitive { moving: true, ..box_at(2, [1.0; 3], Vec3::ZERO, stone()) };
        let still = box_at(3, [0.5; 3], Vec3::new(5.0, 0.0, 0.0), stone());
        let around = Primitive { moving: true, ..box_at(4, [1.0; 3], Vec3::new(5.0, 0.0, 0.0), stone()) };
        let found = areas(vec![wall, mover, still, around]);
        assert!(within(found[1], 6.0) && within(found[2], 1.5), "{found:?}");
    }
}
