//! How open the surroundings of surfels are. Cells tell what light there is about a surfel, but not what stands between:
//! under a bench there is less than above it. And scenes are put together of objects that stand within each other: a
//! column's foot in the floor, and the floor below it, would claim light that never reaches them.
//!
//! A few rays a surfel tell both, as for ambient obscurance (Zhukov, Iones and Kronin 1998, "An ambient light illumination
//! model"): what they meet within the reach of a cell gives back a part of the light.

use super::{CLOSED_SHIFT, Group, GroupKey, Surfel};
use crate::assets::{AlphaMode, AssetId, Material, parallel};
use crate::bvh::{Ray, RayKind, SceneBvh, world_normal};
use crate::scene::{Primitive, Scene, SceneId};
use glam::{Affine3A, Vec3};
use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

/// Surfels that are looked at together.
const CHUNK: usize = 4096;
/// How far before a surfel its rays start \[cells\]: where two surfaces coincide, each is behind the other.
const BEFORE: f32 = 0.01;
/// Distance within which cells do not know what is in the way \[cells\]. With 0, 1, 2.5 the indirect light of `cathedral`
/// (`High`) is 9.1, 5.6, 4.1 % too dark, that of `courtyard` 5.5, 3.4, 2.6 % too bright, if what is near gives back its own
/// reflectance and not [`NEAR`].
const REACH: f32 = 2.0;
/// Share of the light that comes from what is in the way: its reflectance, of which nothing is known here, so that another
/// colour of one surface changes nothing around it.
const NEAR: f32 = 0.5;
/// Rays of a surfel.
const RAYS: u8 = 8;

/// The surfels of objects that do not move, without those that no light can reach. What is around them is looked at anew
/// where the geometry of what does not move changes, and not with the colour of a material. What has moved once counts as
/// moving from then on: or all would be looked at anew whenever somebody who walks about stands still.
#[derive(Debug, Default)]
pub(super) struct Exposed {
    scene: u64,
    moved: HashSet<SceneId>,
    state: Option<[u64; 3]>,
    /// By the places of groups.
    groups: HashMap<[u32; 12], Known>,
}

/// What is known of a group.
#[derive(Debug)]
struct Known {
    spread: Spread,
    around: Vec<Around>,
    all: Arc<Vec<Surfel>>,
    left: Arc<Vec<Surfel>>,
}

/// All that it depends on where the surfels of a group lie.
#[derive(Debug, PartialEq)]
struct Spread {
    /// Meshes, whether they have two sides, and the materials that cut holes into them.
    members: Vec<(AssetId, bool, Option<AssetId>)>,
    linear: [u32; 9],
    fineness: [u32; 2],
}

impl Spread {
    fn new(group: &Group, key: &GroupKey) -> Self {
        let member = |member: &&Primitive| {
            let material = &member.material;
            let holes = (material.alpha_mode != AlphaMode::Opaque).then_some(material.id);
            (member.mesh.id, material.double_sided, holes)
        };
        Self { members: group.members.iter().map(member).collect(), linear: key.linear, fineness: key.fineness }
    }
}

/// What is around a surfel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Around {
    /// Nothing but the inside of solids: no light ever comes here.
    Solid,
    /// How much is closed, of 255.
    Closed(u8),
}

impl Exposed {
    /// What is left of `all` surfels of each group, for cells of a size \[m\].
    pub fn update(
        &mut self,
        scene: &Scene,
        cell: f32,
        groups: &[Group],
        keys: &[GroupKey],
        all: Vec<Arc<Vec<Surfel>>>,
    ) -> Vec<Arc<Vec<Surfel>>> {
        if self.scene != scene.identity {
            *self = Self { scene: scene.identity, ..Self::default() };
        }
        self.moved.extend(scene.primitives.iter().filter(|primitive| primitive.moving).map(|primitive| primitive.id));
        let state = self.state(scene, cell);
        if self.state != Some(state) {
            self.groups.clear();
            self.state = Some(state);
        }
        let mut missing: Vec<(usize, Range<usize>)> = Vec::new();
        for (index, (group, all)) in groups.iter().zip(&all).enumerate() {
            let spread = Spread::new(group, &keys[index]);
            let is_known = self.groups.get(&place(group)).is_some_and(|known| known.is_of(&spread, all));
            if self.is_still(group) && !is_known {
                let firsts = (0..all.len()).step_by(CHUNK);
                missing.extend(firsts.map(|first| (index, first..all.len().min(first + CHUNK))));
            }
        }
        let mut found = if missing.is_empty() {
            Vec::new()
        } else {
            log::debug!("surroundings of {} objects' surfels", groups.len());
            let surroundings = Surroundings::new(scene, &self.moved, cell);
            // Many small objects share the cores as few large ones do.
            let look = |(index, chunk): &(usize, Range<usize>)| {
                surroundings.of(&all[*index], chunk.clone(), &groups[*index].place)
            };
            parallel::map(&missing, look)
        };
        let mut around: HashMap<usize, Vec<Around>> = HashMap::new();
        for ((index, _), chunk) in missing.iter().zip(found.drain(..)) {
            around.entry(*index).or_default().extend(chunk);
        }
        groups
            .iter()
            .zip(keys)
            .zip(all)
            .enumerate()
            .map(
                |(index, ((group, key), all))| {
                    if self.is_still(group) { self.left(group, key, all, around.remove(&index)) } else { all }
                },
            )
            .collect()
    }

    fn is_still(&self, group: &Group) -> bool {
        !group.members.iter().any(|member| self.moved.contains(&member.id))
    }

    /// All that the surroundings of what does not move depend on.
    fn state(&self, scene: &Scene, cell: f32) -> [u64; 3] {
        let revisions = scene.revisions;
        let mut still = DefaultHasher::new();
        // A scene that does not tell what moves is still as a whole.
        (scene.identity, (revisions.statics == 0).then_some(revisions.geometry)).hash(&mut still);
        for primitive in scene.primitives.iter().filter(|primitive| !self.moved.contains(&primitive.id)) {
            let sides = (has_back(&primitive.material), primitive.casts_shadow);
            (primitive.id, primitive.geometry_revision, sides).hash(&mut still);
        }
        [scene.identity, still.finish(), u64::from(cell.to_bits())]
    }

    /// What is left of the surfels of a group, with what was looked at anew.
    fn left(
        &mut self,
        group: &Group,
        key: &GroupKey,
        all: Arc<Vec<Surfel>>,
        looked: Option<Vec<Around>>,
    ) -> Arc<Vec<Surfel>> {
        let known = match (self.groups.remove(&place(group)), looked) {
            (Some(known), None) if Arc::ptr_eq(&known.all, &all) => known,
            (known, looked) => {
                let around = looked.or(known.map(|known| known.around)).unwrap_or_default();
                Known { spread: Spread::new(group, key), left: Arc::new(exposed(&all, &around)), around, all }
            }
        };
        let left = known.left.clone();
        self.groups.insert(place(group), known);
        left
    }
}

impl Known {
    /// Whether what is around these surfels is known.
    fn is_of(&self, spread: &Spread, all: &[Surfel]) -> bool {
        self.spread == *spread && self.around.len() == all.len()
    }
}

/// Bits of where a group stands; no other one stands there.
fn place(group: &Group) -> [u32; 12] {
    group.place.to_cols_array().map(f32::to_bits)
}

/// The surfels that light can reach, with how closed their surroundings are.
fn exposed(surfels: &[Surfel], around: &[Around]) -> Vec<Surfel> {
    let exposed = surfels.iter().zip(around).filter_map(|(surfel, around)| match around {
        Around::Solid => None,
        Around::Closed(closed) => Some(Surfel { place: surfel.place | u32::from(*closed) << CLOSED_SHIFT, ..*surfel }),
    });
    exposed.collect()
}

/// Whether what lies behind a surface of it is the inside of something.
fn has_back(material: &Material) -> bool {
    !material.double_sided && material.alpha_mode == AlphaMode::Opaque
}

/// All that does not move, ready for rays.
struct Surroundings {
    still: SceneBvh,
    /// Of each of its primitives, see [`has_back`].
    backs: Vec<bool>,
    cell: f32,
}

impl Surroundings {
    fn new(scene: &Scene, moved: &HashSet<SceneId>, cell: f32) -> Self {
        let is_still = |primitive: &&Primitive| primitive.casts_shadow && !moved.contains(&primitive.id);
        let primitives: Vec<Primitive> = scene.primitives.iter().filter(is_still).cloned().collect();
        let backs = primitives.iter().map(|primitive| has_back(&primitive.material)).collect();
        Self { still: SceneBvh::new(&Scene { primitives, ..Scene::default() }), backs, cell }
    }

    /// What is around some of the surfels, at their places.
    fn of(&self, surfels: &[Surfel], some: Range<usize>, place: &Affine3A) -> Vec<Around> {
        some.map(|index| self.around(&surfels[index], index, place)).collect()
    }

    fn around(&self, surfel: &Surfel, index: usize, place: &Affine3A) -> Around {
        let normal = world_normal(place, surfel.normal.into());
        if normal == Vec3::ZERO {
            return Around::Closed(0);
        }
        let point = place.transform_point3(surfel.position.into());
        let start = point + normal * (BEFORE * self.cell + 1e-5 * point.abs().max_element());
        // A tangent of the object, so that its turned copies are looked at alike.
        let tangent = place.transform_vector3(Vec3::from(surfel.normal).any_orthonormal_vector());
        let u = tangent.reject_from_normalized(normal).try_normalize().unwrap_or(normal.any_orthonormal_vector());
        let directions = (0..RAYS).map(|ray| direction([u, normal.cross(u), normal], ray, index));
        let looks: Vec<Look> = directions.map(|direction| self.look(&Ray::new(start, direction))).collect();
        if looks.iter().all(|look| look.is_back) {
            return Around::Solid;
        }
        let open = looks.iter().map(|look| look.light).sum::<f32>() / f32::from(RAYS);
        Around::Closed((255.0 * (1.0 - open)).round() as u8)
    }

    fn look(&self, ray: &Ray) -> Look {
        let Some(hit) = self.still.closest_hit(ray, f32::INFINITY, RayKind::Light) else {
            return Look { is_back: false, light: 1.0 };
        };
        let triangle = &self.still.triangles[hit.triangle as usize];
        let is_back = self.backs[triangle.primitive as usize] && !triangle.is_front(ray);
        let light = match is_back {
            _ if hit.t >= REACH * self.cell => 1.0,
            true => 0.0,
            false => NEAR,
        };
        Look { is_back, light }
    }
}

/// What a ray found.
struct Look {
    /// The back of a surface of which only the front can be seen.
    is_back: bool,
    /// Share of the light that comes from there.
    light: f32,
}

/// One of the directions about the last axis of a frame, distributed as their cosines: a spiral, turned from surfel to
/// surfel.
fn direction([u, v, normal]: [Vec3; 3], ray: u8, index: usize) -> Vec3 {
    // Fractions of a turn: the golden ratio along the spiral, and the plastic number from one spiral to the next.
    let turn = f32::from(ray) * 0.618_034 + (index % 4096) as f32 * 0.754_877_7;
    let (sin, cos) = (std::f32::consts::TAU * turn.fract()).sin_cos();
    let share = (f32::from(ray) + 0.5) / f32::from(RAYS);
    (1.0 - share).sqrt() * normal + share.sqrt() * (cos * u + sin * v)
}

#[cfg(test)]
mod tests {
    use crate::assets::{AlphaMode, Material, Shape};
    use crate::scene::{Primitive, Revisions, Scene, SceneId, Surfel, SurfelCloud};
    use glam::{Affine3A, Vec3};
    use std::sync::Arc;

    fn box_at(id: u64, size: [f32; 3], at: Vec3, material: Material) -> Primitive {
        let mesh = Arc::new(Shape::Box { size }.mesh().expect("a valid shape"));
        let place = Affine3A::from_translation(at);
        Primitive {
            id: SceneId(id),
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

    fn cloud(primitives: Vec<Primitive>) -> SurfelCloud {
        let revisions = Revisions { geometry: 1, ..Default::default() };
        let scene = Scene { identity: 1, revisions, primitives, ..Default::default() };
        let mut cloud = SurfelCloud::default();
        cloud.update(&scene, 0.1);
        cloud
    }

    /// Area of the surfels of each primitive, which stand at places of their own.
    fn areas(primitives: Vec<Primitive>) -> Vec<f32> {
        let count = primitives.len();
        let cloud = cloud(primitives);
        (0..count).map(|place| cloud.surfels.iter().filter(|s| s.group() == place).map(|s| s.area).sum()).collect()
    }

    fn within(value: f32, expected: f32) -> bool {
        (value / expected - 1.0).abs() < 0.03
    }

    #[test]
    fn what_stands_in_something_else_is_buried_and_what_looks_out_is_not() {
        let floor = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
        // A quarter of it in the floor: 7 of 10 m² are left.
        let column = box_at(2, [1.0, 2.0, 1.0], Vec3::new(0.0, 0.5, 0.0), stone());
        let found = areas(vec![floor, column]);
        assert!(within(found[1], 7.0), "{found:?}");
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
            let found = areas(vec![shell, box_at(2, [1.0; 3], Vec3::splat(0.1), stone())]);
            assert!(within(found[1], 6.0), "{found:?}");
        }
        // Its faces look inwards.
        let mut mesh = Shape::Box { size: [3.0; 3] }.mesh().expect("a valid shape");
        mesh.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
        let room = Primitive { mesh: Arc::new(mesh), ..box_at(1, [3.0; 3], Vec3::ZERO, stone()) };
        let found = areas(vec![room, box_at(2, [1.0; 3], Vec3::splat(0.1), stone())]);
        assert!(within(found[1], 6.0), "{found:?}");
    }

    #[test]
    fn what_moves_buries_nothing_and_is_not_buried() {
        let wall = box_at(1, [3.0; 3], Vec3::ZERO, stone());
        let mover = Primitive { moving: true, ..box_at(2, [1.0; 3], Vec3::splat(0.1), stone()) };
        let still = box_at(3, [0.5; 3], Vec3::new(5.0, 0.0, 0.0), stone());
        let around = Primitive { moving: true, ..box_at(4, [1.0; 3], Vec3::new(5.1, 0.0, 0.0), stone()) };
        let found = areas(vec![wall, mover, still, around]);
        assert!(within(found[1], 6.0) && within(found[2], 1.5), "{found:?}");
    }

    /// Two floors of which the upper one leaves a gap, and what a surfel in the middle of the gap gets: all that comes from
    /// far away, and half of the rest.
    #[test]
    fn a_narrow_gap_is_closed_and_a_wide_one_is_open() {
        let share = |gap: f32| {
            let lower = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
            let upper = box_at(2, [4.0, 1.0, 4.0], Vec3::new(0.0, 0.5 + gap, 0.0), stone());
            let cloud = cloud(vec![lower, upper]);
            let is_within = |s: &&Surfel| {
                let [x, y, z] = s.position;
                s.group() == 0 && y > 0.499 && x.abs().max(z.abs()) < 1.0
            };
            let within: Vec<f32> = cloud.surfels.iter().filter(is_within).map(Surfel::openness).collect();
            within.iter().sum::<f32>() / within.len() as f32
        };
        // Cells of 0.1 m: the rays see 0.2 m.
        assert_eq!(share(0.25), 1.0);
        // Those that meet the other floor within 0.2 m have cos² > ¼: three quarters of them.
        assert!((share(0.1) - 0.625).abs() < 0.02, "{}", share(0.1));
        assert!((share(0.01) - 0.5).abs() < 0.02, "{}", share(0.01));
    }

    /// What is kept from state to state is what a cloud of its own would have.
    #[test]
    fn changes_leave_what_is_made_anew() {
        let floor = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
        let column = box_at(2, [1.0, 2.0, 1.0], Vec3::new(0.0, 0.5, 0.0), stone());
        let of = |material: Material| Primitive { material: Arc::new(material), ..column.clone() };
        let raised = |primitive: &Primitive| {
            let world_from_object = Affine3A::from_translation(Vec3::new(0.0, 0.8, 0.0));
            Primitive { world_from_object, ..primitive.clone() }
        };
        let states = [
            [floor.clone(), column.clone()],
            [floor.clone(), of(Material::diffuse("paint", Vec3::X))],
            [floor.clone(), raised(&column)],
            [floor.clone(), raised(&of(Material { double_sided: true, ..stone() }))],
            [floor.clone(), Primitive { moving: true, ..raised(&column) }],
            [floor.clone(), column.clone()],
        ];
        let mut kept = SurfelCloud::default();
        for (revision, primitives) in (1_u64..).zip(states) {
            let revisions = Revisions {
                geometry: revision,
                materials: revision,
                statics: revision.div_ceil(2),
                ..Default::default()
            };
            let scene = Scene { identity: 1, revisions, primitives: primitives.to_vec(), ..Default::default() };
            kept.update(&scene, 0.1);
            let mut fresh = SurfelCloud::default();
            fresh.update(&scene, 0.1);
            assert!(kept.surfels == fresh.surfels, "state {revision}");
        }
    }
}
