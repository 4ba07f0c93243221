//! How open the surroundings of surfels are. Cells tell what light there is about a surfel, but not what stands between:
//! under a bench there is less than above it. And scenes are put together of objects that stand within each other: a
//! column's foot in the floor, and the floor below it, would claim light that never reaches them.
//!
//! A few rays a surfel tell both, as for ambient obscurance (Zhukov, Iones and Kronin 1998, "An ambient light illumination
//! model"): what they meet within the reach of a cell gives back a part of the light.

use super::group::{Group, GroupKey};
use super::patches::{Occluders, Subject};
use super::still::Still;
use super::{CLOSED_SHIFT, HIDDEN, Surfel};
use crate::assets::{AlphaMode, AssetId, parallel};
use crate::bvh::{Ray, world_normal};
use crate::scene::{Aabb, Primitive, Scene};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Surfels that are looked at together.
const CHUNK: usize = 4096;
/// How far before a surfel its rays start \[cells\]: where two surfaces coincide, each is behind the other.
const BEFORE: f32 = 0.01;
/// Distance within which cells do not know what is in the way \[cells\]. It matters little, since what the surfels have is
/// calibrated by even light, in which the same is in their way: the error of `cathedral` at `Medium` without rays is .232
/// with 1 and .228 with 2, that of `meeting_room` .183 and .181.
const REACH: f32 = 2.0;
/// Share of the light that comes from what is in the way: its reflectance, of which nothing is known here, so that another
/// colour of one surface changes nothing around it.
const NEAR: f32 = 0.5;
/// Distance that some ray of a surfel must get to, or it lies in a crack or cavity that light hardly finds \[cells\].
const LEAST_REACH: f32 = 1.0;
/// Rays of a surfel.
const RAYS: u8 = 8;
/// Objects that come or go at once from which on all surfels are looked at anew, and not those alone that see them.
const MANY: usize = 16;

/// The surfels of objects that do not move, without those that no light can reach. Where what does not move changes, the
/// surfels are looked at anew that see the change, and none if it is the colour of a material.
#[derive(Debug, Default)]
pub(super) struct Exposed {
    scene: u64,
    cell: f32,
    still: Still,
    /// Boxes of what changed in the last update.
    changed: Vec<Aabb>,
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
    /// How much is closed, of 255; that is [`HIDDEN`].
    Closed(u8),
}

impl Exposed {
    /// How far before a surfel its rays start \[m\].
    pub fn before(&self) -> f32 {
        BEFORE * self.cell
    }

    /// What is left of `all` surfels of each group, for cells of a size \[m\].
    pub fn update(
        &mut self,
        scene: &Scene,
        cell: f32,
        groups: &[Group],
        keys: &[GroupKey],
        all: Vec<Arc<Vec<Surfel>>>,
    ) -> Vec<Arc<Vec<Surfel>>> {
        if self.scene != scene.identity || self.cell.to_bits() != cell.to_bits() {
            *self = Self { scene: scene.identity, cell, ..Self::default() };
        }
        let changed = self.still.update(scene);
        self.changed.clone_from(&changed);
        let mut before = std::mem::take(&mut self.groups);
        let (mut pieces, mut known) = (Vec::new(), Vec::with_capacity(groups.len()));
        for (index, (group, all)) in groups.iter().zip(&all).enumerate() {
            let spread = Spread::new(group, &keys[index]);
            // What bends may stand where something else does.
            let of_group = if is_still(group) { before.remove(&place(group)) } else { None };
            let of_group = of_group.filter(|known| known.is_of(&spread, all));
            if is_still(group) && !(of_group.is_some() && changed.is_empty()) {
                let firsts = (0..all.len()).step_by(CHUNK);
                pieces.extend(firsts.map(|first| (index, first..all.len().min(first + CHUNK))));
            }
            known.push(of_group);
        }
        // Many small objects share the cores as few large ones do.
        let look = |(index, piece): &(usize, Range<usize>)| {
            let known = known[*index].as_ref().filter(|_| changed.len() < MANY);
            let known = known.map(|known| &known.around[piece.clone()]);
            self.look(&all[*index], piece, &groups[*index].place, known, &changed)
        };
        let mut looked: HashMap<usize, Vec<Around>> = HashMap::new();
        for ((index, _), around) in pieces.iter().zip(parallel::map(&pieces, look)) {
            looked.entry(*index).or_default().extend(around);
        }
        let mut left = Vec::with_capacity(groups.len());
        for (index, ((group, all), known)) in groups.iter().zip(all).zip(known).enumerate() {
            if !is_still(group) {
                left.push(all);
                continue;
            }
            let known = match (known, looked.remove(&index)) {
                (Some(known), looked) if known.holds(&all, looked.as_deref()) => known,
                (known, looked) => {
                    let around = looked.or(known.map(|known| known.around)).unwrap_or_default();
                    let left = Arc::new(exposed(&all, &around));
                    Known { spread: Spread::new(group, &keys[index]), around, all, left }
                }
            };
            left.push(known.left.clone());
            self.groups.insert(place(group), known);
        }
        left
    }

    /// The surfels of groups for patches of a size \[m\], with what stands around each.
    pub fn subjects<'a>(&'a self, groups: &[Group], surfels: &'a [Arc<Vec<Surfel>>], size: f32) -> Vec<Subject<'a>> {
        groups.iter().zip(surfels).map(|(group, surfels)| self.subject(group, surfels, size)).collect()
    }

    fn subject<'a>(&'a self, group: &Group, surfels: &'a Arc<Vec<Surfel>>, size: f32) -> Subject<'a> {
        let occluders = is_still(group).then(|| Occluders::new(&self.still, group.place, size, self.before()));
        let bounds = group.members.iter().fold(Aabb::EMPTY, |sum, member| sum.union(&member.bounds));
        let reach = Vec3::splat(size);
        let near = Aabb { min: bounds.min - reach, max: bounds.max + reach };
        let is_changed = occluders.is_some() && self.changed.iter().any(|other| !near.intersection(other).is_empty());
        Subject { surfels, shape: group.shape(), occluders, is_changed }
    }

    /// What is around a piece of a group's surfels, of which something may be known from before a change.
    fn look(
        &self,
        surfels: &[Surfel],
        piece: &Range<usize>,
        place: &Affine3A,
        known: Option<&[Around]>,
        changed: &[Aabb],
    ) -> Vec<Around> {
        let look = |index: usize| {
            let rays = rays(&surfels[index], index, place, self.cell);
            let sees = |ray: &Ray| changed.iter().any(|bounds| ray.enters(bounds, f32::INFINITY).is_some());
            match known {
                Some(known) if !rays.iter().flatten().any(sees) => known[index - piece.start],
                _ => self.around(rays),
            }
        };
        piece.clone().map(look).collect()
    }

    fn around(&self, rays: Option<[Ray; RAYS as usize]>) -> Around {
        let Some(rays) = rays else { return Around::Closed(0) };
        let looks = rays.map(|ray| self.along(&ray));
        if looks.iter().all(|look| look.is_back) {
            return Around::Solid;
        }
        if looks.iter().all(|look| look.distance < LEAST_REACH * self.cell) {
            return Around::Closed(HIDDEN);
        }
        let open = looks.iter().map(|look| look.light).sum::<f32>() / f32::from(RAYS);
        Around::Closed(((255.0 * (1.0 - open)).round() as u8).min(HIDDEN - 1))
    }

    fn along(&self, ray: &Ray) -> Look {
        let Some(met) = self.still.closest(ray) else {
            return Look { distance: f32::INFINITY, is_back: false, light: 1.0 };
        };
        let light = match met.is_back {
            _ if met.t >= REACH * self.cell => 1.0,
            true => 0.0,
            false => NEAR,
        };
        Look { distance: met.t, is_back: met.is_back, light }
    }
}

impl Known {
    /// Whether what is around these surfels is known, or was before a change.
    fn is_of(&self, spread: &Spread, all: &[Surfel]) -> bool {
        self.spread == *spread && self.around.len() == all.len()
    }

    /// Whether these are the surfels, and what was looked at anew is as before.
    fn holds(&self, all: &Arc<Vec<Surfel>>, looked: Option<&[Around]>) -> bool {
        Arc::ptr_eq(&self.all, all) && looked.is_none_or(|looked| looked == self.around)
    }
}

fn is_still(group: &Group) -> bool {
    !group.members.iter().any(|member| member.moving)
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

/// The rays of a surfel; none if it has no normal.
fn rays(surfel: &Surfel, index: usize, place: &Affine3A, cell: f32) -> Option<[Ray; RAYS as usize]> {
    let normal = world_normal(place, surfel.normal.into());
    if normal == Vec3::ZERO {
        return None;
    }
    let point = place.transform_point3(surfel.position.into());
    let start = point + normal * (BEFORE * cell + 1e-5 * point.abs().max_element());
    // A tangent of the object, so that its turned copies are looked at alike.
    let tangent = place.transform_vector3(Vec3::from(surfel.normal).any_orthonormal_vector());
    let u = tangent.reject_from_normalized(normal).try_normalize().unwrap_or(normal.any_orthonormal_vector());
    let axes = [u, normal.cross(u), normal];
    Some(std::array::from_fn(|ray| Ray::new(start, direction(axes, ray as u8, index))))
}

/// What a ray found.
struct Look {
    /// \[m\].
    distance: f32,
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
    use super::super::fixture;
    use crate::assets::{AlphaMode, Material, Shape};
    use crate::scene::{Primitive, Revisions, Scene, Surfel, SurfelCloud};
    use glam::{Affine3A, Vec3};
    use std::sync::Arc;

    fn box_at(id: u64, size: [f32; 3], at: Vec3, material: Material) -> Primitive {
        let mesh = Arc::new(Shape::Box { size }.mesh().expect("a valid shape"));
        let place = Affine3A::from_translation(at);
        Primitive { material: Arc::new(material), ..fixture::primitive(id, mesh, place) }
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
        // No ray gets out of a crack.
        assert_eq!(share(0.01), 0.0);
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
        let scaled = |primitive: &Primitive, scale: Vec3| {
            let world_from_object = primitive.world_from_object * Affine3A::from_scale(scale);
            let bounds = primitive.mesh.bounds.transformed(&world_from_object);
            Primitive { world_from_object, bounds, ..primitive.clone() }
        };
        let stone_at = |id: u64, at: Vec3| box_at(id, [0.2; 3], at, stone());
        let many = (10..30).map(|id| stone_at(id, Vec3::new(0.1 * id as f32 - 2.0, 0.2, 1.5)));
        let states = [
            vec![floor.clone(), column.clone()],
            vec![floor.clone(), of(Material::diffuse("paint", Vec3::X))],
            vec![floor.clone(), raised(&column)],
            vec![floor.clone(), raised(&of(Material { double_sided: true, ..stone() }))],
            vec![floor.clone(), Primitive { moving: true, ..raised(&column) }],
            vec![floor.clone(), column.clone()],
            vec![floor.clone(), column.clone(), stone_at(3, Vec3::new(1.5, 0.1, 1.5))],
            vec![floor.clone(), column.clone(), stone_at(3, Vec3::new(0.6, 0.05, 0.0)), stone_at(5, Vec3::ZERO)],
            [floor.clone(), column.clone()].into_iter().chain(many).collect(),
            vec![floor.clone(), scaled(&column, Vec3::new(-1.0, 1.0, 1.0))],
            vec![floor.clone(), scaled(&column, Vec3::new(1.0, 1.0, 0.0))],
            vec![column.clone()],
        ];
        let mut kept = SurfelCloud::default();
        for (revision, primitives) in (1_u64..).zip(states) {
            let statics = revision.div_ceil(2);
            let revisions = Revisions { geometry: revision, materials: revision, statics, ..Default::default() };
            let scene = Scene { identity: 1, revisions, primitives, ..Default::default() };
            kept.update(&scene, 0.1);
            let mut fresh = SurfelCloud::default();
            fresh.update(&scene, 0.1);
            assert!(kept.surfels == fresh.surfels, "state {revision}");
        }
    }

    /// The wall behind a block on a floor: rays within the block end where its faces and the others' coincide.
    #[test]
    fn neither_turns_nor_the_order_of_objects_change_what_is_left() {
        let left = |degrees: f32, ids: [u64; 3]| {
            let turn =
                Affine3A::from_rotation_y(degrees.to_radians()) * Affine3A::from_rotation_x(degrees.to_radians());
            let floor = box_at(ids[0], [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
            let wall = box_at(ids[1], [4.0, 3.0, 0.5], Vec3::new(0.0, 1.5, -0.75), stone());
            let block = box_at(ids[2], [1.0; 3], Vec3::new(0.2, 0.5, 0.0), stone());
            let mut all = vec![floor, wall, block];
            all.sort_by_key(|primitive| primitive.id);
            for primitive in &mut all {
                primitive.world_from_object = turn * primitive.world_from_object;
                primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
            }
            let found = areas(all);
            let mut order: Vec<usize> = vec![0, 1, 2];
            order.sort_by_key(|index| ids[*index]);
            let of = |object: usize| found[order.iter().position(|index| *index == object).unwrap_or(0)];
            [of(0), of(1), of(2)]
        };
        let straight = left(0.0, [1, 2, 3]);
        // Of the 31 m² of the wall two lie on the floor and one behind the block; of the six of the block two are covered.
        assert!(within(straight[1], 28.0) && within(straight[2], 4.0), "{straight:?}");
        for (degrees, ids) in [(0.0, [3, 2, 1]), (0.0, [2, 3, 1]), (17.0, [1, 2, 3]), (45.0, [3, 1, 2])] {
            let other = left(degrees, ids);
            let same = straight.iter().zip(other).all(|(a, b)| (a - b).abs() < 0.005 * a);
            assert!(same, "{degrees}°, {ids:?}: {straight:?}, {other:?}");
        }
    }

    #[test]
    fn a_mirrored_solid_buries_as_well_and_a_flattened_one_nothing() {
        let lower = box_at(1, [2.0; 3], Vec3::new(0.0, -1.0, 0.0), stone());
        let buried = |scale: Vec3| {
            let upper = box_at(2, [1.0; 3], Vec3::new(0.0, 0.5, 0.0), stone());
            let world_from_object = upper.world_from_object * Affine3A::from_scale(scale);
            let bounds = upper.mesh.bounds.transformed(&world_from_object);
            let found = areas(vec![lower.clone(), Primitive { world_from_object, bounds, ..upper }]);
            24.0 - found[0]
        };
        assert!((buried(Vec3::new(1.0, 1.0, -1.0)) - 1.0).abs() < 0.05);
        assert!(buried(Vec3::new(1.0, 0.0, 1.0)).abs() < 0.05);
    }
}
