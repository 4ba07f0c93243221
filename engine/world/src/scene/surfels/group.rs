//! Objects: primitives that stand at the same place, whose surfels are made together.

use super::surfel::{Fineness, has_surfels};
use crate::assets::{AssetId, Mesh};
use crate::scene::{Primitive, Scene};
use glam::{Affine3A, Mat3A, Vec3};
use std::collections::HashMap;

/// Primitives that stand at the same place make one object: a solid may be split by its materials. Those that bend make
/// another one there.
pub(super) struct Group<'a> {
    pub place: Affine3A,
    pub members: Vec<&'a Primitive>,
    /// Whether skins or morph targets pose it. Its surfels are those of the meshes at rest, see [`super::bending`].
    pub is_bending: bool,
    /// How much larger it is posed than at rest, as the nearest power of two: skins may change the unit of length. 1 if it
    /// does not bend.
    stretch: f32,
}

/// All that the surfels of a group depend on. Neither turning and moving it nor a pose changes any of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct GroupKey {
    members: Vec<(AssetId, AssetId)>,
    /// Bits of the linear part that the surfels are made with.
    pub linear: [u32; 9],
    pub fineness: [u32; 2],
    is_bending: bool,
}

/// Cosine up to which two axes are at right angles, and relative difference up to which they are equally long.
const RIGHT_ANGLE: f32 = 1e-5;

/// The groups, and of which one each primitive of the scene is.
pub(super) fn groups(scene: &Scene) -> (Vec<Group<'_>>, Vec<u32>) {
    let mut members: Vec<(Affine3A, bool, Vec<&Primitive>)> = Vec::new();
    let mut group_of = vec![u32::MAX; scene.primitives.len()];
    let mut known: HashMap<([u32; 12], bool), usize> = HashMap::new();
    for (primitive, group) in scene.primitives.iter().zip(&mut group_of).filter(|(p, _)| has_surfels(p)) {
        let place = primitive.world_from_object;
        let index = *known.entry((place_bits(&place), bends(primitive))).or_insert_with(|| {
            members.push((place, bends(primitive), Vec::new()));
            members.len() - 1
        });
        members[index].2.push(primitive);
        *group = index as u32;
    }
    let group = |(place, is_bending, members)| Group::new(place, is_bending, members);
    (members.into_iter().map(group).collect(), group_of)
}

/// Whether a primitive changes its shape.
pub(super) fn bends(primitive: &Primitive) -> bool {
    primitive.moving && (primitive.mesh.rest.is_some() || primitive.mesh.deform.is_some())
}

/// Bits of a place: equal for objects that stand at the same one.
pub(super) fn place_bits(place: &Affine3A) -> [u32; 12] {
    place.to_cols_array().map(f32::to_bits)
}

impl<'a> Group<'a> {
    pub fn new(place: Affine3A, is_bending: bool, members: Vec<&'a Primitive>) -> Self {
        let mut group = Self { place, members, is_bending, stretch: 1.0 };
        if is_bending {
            let area = |mesh: fn(&Primitive) -> &Mesh| -> f64 {
                let areas = group.members.iter().flat_map(|p| triangles(mesh(p)));
                areas.map(|t| f64::from(world_area(&place.matrix3, &t.corners))).sum()
            };
            group.stretch = nearest_power(area(|p| &p.mesh) / area(rest));
        }
        group
    }

    /// The mesh of a member that the surfels are made for.
    pub fn mesh<'b>(&self, member: &'b Primitive) -> &'b Mesh {
        if self.is_bending { rest(member) } else { &member.mesh }
    }

    /// Area of all sides that may have surfels \[m²\].
    pub fn area(&self) -> f64 {
        let linear = self.place.matrix3 * self.stretch;
        let area = |p: &&Primitive| {
            let sides = if p.material.double_sided { 2.0 } else { 1.0 };
            triangles(self.mesh(p)).map(|t| sides * f64::from(world_area(&linear, &t.corners))).sum()
        };
        self.members.iter().map(area).fold(0.0, |sum: f64, area: f64| sum + area)
    }

    pub fn key(&self, fineness: Fineness) -> GroupKey {
        let members = self.members.iter().map(|p| (self.mesh(p).id, p.material.id)).collect();
        let linear = self.shape().to_cols_array().map(f32::to_bits);
        GroupKey { members, linear, fineness: fineness.bits(), is_bending: self.is_bending }
    }

    /// Factor from lengths of the surfels' mesh to lengths in the world; see [`shape`].
    pub fn shape(&self) -> Mat3A {
        shape(&self.place) * self.stretch
    }
}

/// The mesh of a primitive before it was posed.
fn rest(primitive: &Primitive) -> &Mesh {
    primitive.mesh.rest.as_ref().unwrap_or(&primitive.mesh)
}

/// The power of two that is nearest to the root of a ratio of areas; 1 if there is none.
fn nearest_power(areas: f64) -> f32 {
    if areas > 0.0 && areas.is_finite() { (0.5 * areas.log2()).round().clamp(-60.0, 60.0).exp2() as f32 } else { 1.0 }
}

/// The linear part of a place without its turn, where it leaves the axes of the object at right angles, and rounded: the
/// same for all turned copies of an object, to the last bit. With M = R·S it is S, which is diagonal and has the sign of
/// the determinant. Objects that are sheared or squeezed flat have M itself.
pub(super) fn shape(place: &Affine3A) -> Mat3A {
    let m = place.matrix3;
    let square = m.transpose() * m;
    let squares = Vec3::new(square.x_axis.x, square.y_axis.y, square.z_axis.z);
    let lengths = squares.map(f32::sqrt);
    let products = Vec3::new(square.x_axis.y, square.y_axis.z, square.z_axis.x);
    let cosines = products / lengths / Vec3::new(lengths.y, lengths.z, lengths.x);
    let is_invertible = squares.min_element() > 0.0 && m.inverse().is_finite();
    if !is_invertible || !(cosines.abs().max_element() <= RIGHT_ANGLE) {
        return m;
    }
    let mean = squares.element_sum() / 3.0;
    let is_even = (squares - mean).abs().max_element() <= RIGHT_ANGLE * mean;
    let squares = if is_even { Vec3::splat(mean) } else { squares };
    let rounded = |square: f32| ((f64::from(square).sqrt().log2() * 65536.0).round() / 65536.0).exp2() as f32;
    Mat3A::from_diagonal(squares.to_array().map(|square| rounded(square).copysign(m.determinant())).into())
}

/// A triangle in object space.
pub(super) struct Triangle {
    pub corners: [Vec3; 3],
    pub uvs: [[f32; 2]; 3],
    /// Indices of the vertices.
    pub vertices: [usize; 3],
}

pub(super) fn triangles(mesh: &Mesh) -> impl Iterator<Item = Triangle> {
    (0..mesh.triangle_count()).map(move |index| triangle(mesh, index))
}

pub(super) fn triangle(mesh: &Mesh, index: usize) -> Triangle {
    let vertices = [0, 1, 2].map(|corner| mesh.indices[3 * index + corner] as usize);
    let [a, b, c] = vertices.map(|vertex| &mesh.vertices[vertex]);
    Triangle { corners: [a, b, c].map(|v| v.position.into()), uvs: [a.uv, b.uv, c.uv], vertices }
}

/// Area in the world of a triangle; 0 if it is no number.
pub(super) fn world_area(linear: &Mat3A, corners: &[Vec3; 3]) -> f32 {
    let edge = |i: usize| *linear * (corners[i] - corners[0]);
    let area = 0.5 * edge(1).cross(edge(2)).length();
    if area.is_finite() { area } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{nearest_power, shape};
    use glam::{Affine3A, Mat3A, Quat, Vec3};

    #[test]
    fn a_turn_leaves_the_shape_as_it_is() {
        for scale in [Vec3::splat(0.3), Vec3::new(2.0, 0.7, 31.0), Vec3::new(-1.1, 0.4, 5.0), Vec3::splat(-3.0)] {
            let of = |turn: Quat| shape(&Affine3A::from_scale_rotation_translation(scale, turn, Vec3::splat(9.0)));
            let straight = of(Quat::IDENTITY);
            for step in 1..40 {
                let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.37 * step as f32, 1.9 * step as f32, 0.2);
                assert_eq!(of(turn), straight, "{scale} in turn {step}");
            }
            let lengths = [straight.x_axis.x, straight.y_axis.y, straight.z_axis.z].map(|v| v * scale.x.signum());
            assert!(Vec3::from_array(lengths).abs_diff_eq(scale.abs(), 1e-3), "{straight}");
            assert_eq!(straight.determinant() < 0.0, scale.x < 0.0);
        }
    }

    #[test]
    fn what_is_sheared_or_flat_keeps_its_matrix() {
        let sheared = Affine3A::from_rotation_y(0.4) * Affine3A::from_scale(Vec3::new(3.0, 1.0, 1.0));
        let sheared = sheared * Affine3A::from_rotation_z(0.5);
        let matrices = [Vec3::new(1.0, 0.0, 1.0), Vec3::ZERO, Vec3::NAN].map(Affine3A::from_scale);
        for place in matrices.into_iter().chain([sheared]) {
            let same = |a: Mat3A, b: Mat3A| a.to_cols_array().map(f32::to_bits) == b.to_cols_array().map(f32::to_bits);
            assert!(same(shape(&place), place.matrix3), "{place}");
        }
    }

    #[test]
    fn units_of_length_are_told_and_poses_are_not() {
        assert_eq!([0.3, 0.6, 1.0, 1.9].map(nearest_power), [0.5, 1.0, 1.0, 1.0]);
        // A skin that makes metres of centimetres.
        assert_eq!([1e-4, 0.9e-4, 1.2e-4].map(nearest_power), [1.0 / 128.0; 3]);
        assert_eq!([0.0, f64::NAN, f64::INFINITY, -1.0].map(nearest_power), [1.0; 4]);
    }
}
