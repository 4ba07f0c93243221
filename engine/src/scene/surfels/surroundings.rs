//! How open the surroundings of surfels are. Cells tell what light there is about a surfel, but not what stands between:
//! under a bench there is less than above it. And scenes are put together of objects that stand within each other: a
//! column's foot in the floor, and the floor below it, would claim light that never reaches them.
//!
//! A few rays a surfel tell both, as for ambient obscurance (Zhukov, Iones and Kronin 1998, "An ambient light illumination
//! model"): what they meet within the reach of a cell gives back a part of the light, its reflectance.

use super::{CLOSED_SHIFT, Group, Surfel};
use crate::assets::{AlphaMode, Material, parallel};
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
/// Distance within which cells do not know what is in the way \[cells\]. With 0, 1, 2.5 the indirect light of `cathedral`
/// (`High`) is 9.1, 5.6, 4.1 % too dark, that of `courtyard` 5.5, 3.4, 2.6 % too bright.
const REACH: f32 = 2.0;
/// Rays of a surfel.
const RAYS: u8 = 8;

/// The surfels of objects that do not move, without those that no light can reach; kept as long as nothing changes but
/// what moves.
#[derive(Debug, Default)]
pub(super) struct Exposed {
    state: Option<[u64; 4]>,
    /// All surfels of a group and those that are left, by its place.
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
        let mut surroundings = None;
        let left = |(group, all): (&Group, Arc<Vec<Surfel>>)| {
            if group.members.iter().any(|member| member.moving) {
                return all;
            }
            let place = group.place.to_cols_array().map(f32::to_bits);
            if let Some([_, left]) = self.groups.get(&place).filter(|[known, _]| Arc::ptr_eq(known, &all)) {
                return left.clone();
            }
            let surroundings = surroundings.get_or_insert_with(|| Surroundings::new(scene, cell));
            let left = Arc::new(surroundings.exposed(&all, &group.place));
            self.groups.insert(place, [all, left.clone()]);
            left
        };
        groups.iter().zip(all).map(left).collect()
    }
}

/// All that the surroundings of what does not move depend on.
fn state(scene: &Scene, cell: f32) -> [u64; 4] {
    let revisions = scene.revisions;
    // A scene that does not tell what moves is still as a whole.
    let still = if revisions.statics == 0 { revisions.geometry } else { revisions.statics };
    [scene.identity, still, revisions.materials, u64::from(cell.to_bits())]
}

/// What is around a surfel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Around {
    /// Nothing but the inside of solids: no light ever comes here.
    Solid,
    /// The share of the light about it that it gets.
    Open(f32),
}

/// All that does not move, ready for rays.
struct Surroundings {
    still: SceneBvh,
    /// Materials of those primitives.
    materials: Vec<Arc<Material>>,
    cell: f32,
}

impl Surroundings {
    fn new(scene: &Scene, cell: f32) -> Self {
        let is_still = |primitive: &&Primitive| !primitive.moving && primitive.casts_shadow;
        let primitives: Vec<Primitive> = scene.primitives.iter().filter(is_still).cloned().collect();
        let materials = primitives.iter().map(|primitive| primitive.material.clone()).collect();
        Self { still: SceneBvh::new(&Scene { primitives, ..Scene::default() }), materials, cell }
    }

    /// The surfels that light can reach, at their places, with how closed their surroundings are.
    fn exposed(&self, surfels: &[Surfel], place: &Affine3A) -> Vec<Surfel> {
        let chunks: Vec<Range<usize>> =
            (0..surfels.len()).step_by(CHUNK).map(|first| first..surfels.len().min(first + CHUNK)).collect();
        let exposed = |chunk: &Range<usize>| -> Vec<Surfel> {
            let known = |index: usize| match self.around(&surfels[index], index, place) {
                Around::Solid => None,
                Around::Open(share) => {
                    let closed = (255.0 * (1.0 - share)).round() as u32;
                    Some(Surfel { place: surfels[index].place | closed << CLOSED_SHIFT, ..surfels[index] })
                }
            };
            chunk.clone().filter_map(known).collect()
        };
        parallel::map(&chunks, exposed).concat()
    }

    fn around(&self, surfel: &Surfel, index: usize, place: &Affine3A) -> Around {
        let normal = world_normal(place, surfel.normal.into());
        if normal == Vec3::ZERO {
            return Around::Open(1.0);
        }
        let point = place.transform_point3(surfel.position.into());
        let start = point + normal * (BEFORE * self.cell + 1e-5 * point.abs().max_element());
        let directions = (0..RAYS).map(|ray| direction(normal, ray, index));
        let looks: Vec<Look> = directions.map(|direction| self.look(&Ray::new(start, direction))).collect();
        if looks.iter().all(|look| look.is_back) {
            return Around::Solid;
        }
        Around::Open(looks.iter().map(|look| look.light).sum::<f32>() / f32::from(RAYS))
    }

    fn look(&self, ray: &Ray) -> Look {
        let Some(hit) = self.still.closest_hit(ray, f32::INFINITY, RayKind::Light) else {
            return Look { is_back: false, light: 1.0 };
        };
        let triangle = &self.still.triangles[hit.triangle as usize];
        let material = &self.materials[triangle.primitive as usize];
        let is_back = !material.double_sided && material.alpha_mode == AlphaMode::Opaque && !triangle.is_front(ray);
        let light = match is_back {
            _ if hit.t >= REACH * self.cell => 1.0,
            true => 0.0,
            false => reflectance(material),
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

/// One of the directions about a normal, distributed as their cosines: a spiral, turned from surfel to surfel.
fn direction(normal: Vec3, ray: u8, index: usize) -> Vec3 {
    // Fractions of a turn: the golden ratio along the spiral, and the plastic number from one spiral to the next.
    let turn = f32::from(ray) * 0.618_034 + (index % 4096) as f32 * 0.754_877_7;
    let (sin, cos) = (std::f32::consts::TAU * turn.fract()).sin_cos();
    let share = (f32::from(ray) + 0.5) / f32::from(RAYS);
    let [u, v] = normal.any_orthonormal_pair().into();
    (1.0 - share).sqrt() * normal + share.sqrt() * (cos * u + sin * v)
}

/// Mean diffuse reflectance, without textures.
fn reflectance(material: &Material) -> f32 {
    let reflectance = material.base_color.truncate().element_sum() / 3.0 * (1.0 - material.metallic);
    if reflectance.is_finite() { reflectance.clamp(0.0, 1.0) } else { 0.0 }
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
    /// far away, and of the rest what the other floor reflects.
    #[test]
    fn a_narrow_gap_is_closed_and_a_wide_one_is_open() {
        let share = |gap: f32, reflectance: f32| {
            let paint = || Material::diffuse("paint", Vec3::splat(reflectance));
            let lower = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), paint());
            let upper = box_at(2, [4.0, 1.0, 4.0], Vec3::new(0.0, 0.5 + gap, 0.0), paint());
            let cloud = cloud(vec![lower, upper]);
            let is_within = |s: &&Surfel| {
                let [x, y, z] = s.position;
                s.group() == 0 && y > 0.499 && x.abs().max(z.abs()) < 1.0
            };
            let within: Vec<f32> = cloud.surfels.iter().filter(is_within).map(Surfel::openness).collect();
            within.iter().sum::<f32>() / within.len() as f32
        };
        // Cells of 0.1 m: the rays see 0.2 m.
        assert_eq!(share(0.25, 0.5), 1.0);
        // Those that meet the other floor within 0.2 m have cos² > ¼: three quarters of them.
        for (reflectance, expected) in [(0.0, 0.25), (0.5, 0.625)] {
            let found = share(0.1, reflectance);
            assert!((found - expected).abs() < 0.02, "{found} for {expected}");
        }
        assert!(share(0.01, 0.0) < 0.02);
    }
}
