//! Deformation of meshes: morph targets, then skins (glTF 2.0, sections 3.7.2.2 and 3.7.3.3).

use super::{AssetId, Mesh, Vertex, parallel};
use crate::core::Aabb;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Vertices that one piece of work poses.
const PIECE: usize = 8192;

/// Data for posing a mesh, beside its own vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deform {
    /// Which joints each vertex follows.
    pub skin: Option<Influences>,
    /// Offsets at full weight.
    pub targets: Vec<MorphTarget>,
    /// Triangles share no vertices, and normals are those of the triangles: they follow the posed triangles.
    pub flat: bool,
}

/// Joints and weights of all vertices, any number each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Influences {
    /// Where each vertex begins in `pairs`, and the end of the last one.
    starts: Vec<u32>,
    /// Joint and weight; the weights of a vertex sum to 1.
    pairs: Vec<(u16, f32)>,
}

/// Displacements of all vertices at full weight, each list empty or as long as the mesh has vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Of positions \[m\].
    pub positions: Vec<[f32; 3]>,
    /// Of normals.
    pub normals: Vec<[f32; 3]>,
    /// Of tangents.
    pub tangents: Vec<[f32; 3]>,
}

impl Influences {
    /// Adds a vertex. Weights that are zero, negative or not finite are left out and the others made to sum to 1; a
    /// vertex without any follows the first joint that it names, or joint 0.
    pub fn push(&mut self, pairs: impl Iterator<Item = (u16, f32)>) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        let first = self.pairs.len();
        let mut first_joint = None;
        self.pairs.extend(pairs.filter(|(joint, weight)| {
            first_joint.get_or_insert(*joint);
            *weight > 0.0 && weight.is_finite()
        }));
        let sum: f32 = self.pairs[first..].iter().map(|(_, weight)| weight).sum();
        if sum > 0.0 && sum.is_finite() {
            self.pairs[first..].iter_mut().for_each(|(_, weight)| *weight /= sum);
        } else {
            self.pairs.truncate(first);
            self.pairs.push((first_joint.unwrap_or(0), 1.0));
        }
        self.starts.push(self.pairs.len() as u32);
    }

    /// The same without the joints beyond the first `joints`.
    pub(crate) fn within(&self, joints: usize) -> Self {
        let mut limited = Self::default();
        for vertex in 1..self.starts.len() {
            let pairs = self.of(vertex - 1).iter().copied();
            limited.push(pairs.filter(|(joint, _)| usize::from(*joint) < joints));
        }
        limited
    }

    /// Joints and weights of a vertex.
    pub fn of(&self, vertex: usize) -> &[(u16, f32)] {
        let [start, end] = [vertex, vertex + 1].map(|i| self.starts.get(i).map_or(0, |start| *start as usize));
        self.pairs.get(start..end).unwrap_or(&[])
    }

    /// The largest joint index that is used.
    pub fn highest_joint(&self) -> usize {
        self.pairs.iter().map(|(joint, _)| usize::from(*joint)).max().unwrap_or(0)
    }

    /// The mean of the joints' matrices at a vertex.
    fn matrix(&self, vertex: usize, palette: &[Affine3A]) -> Affine3A {
        let of = |joint: u16| palette.get(usize::from(joint)).copied().unwrap_or(Affine3A::IDENTITY);
        if let [(joint, _)] = self.of(vertex) {
            return of(*joint);
        }
        let mut sum = Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO };
        for (joint, weight) in self.of(vertex) {
            let m = of(*joint);
            sum.matrix3 += m.matrix3 * *weight;
            sum.translation += m.translation * *weight;
        }
        sum
    }
}

impl Deform {
    /// The same for vertices that were copied or reordered: where each of the new ones was.
    pub fn reordered(&self, origins: &[u32]) -> Self {
        let pick = |list: &Vec<[f32; 3]>| match list.is_empty() {
            true => Vec::new(),
            false => origins.iter().map(|i| list[*i as usize]).collect(),
        };
        let target = |t: &MorphTarget| MorphTarget {
            positions: pick(&t.positions),
            normals: pick(&t.normals),
            tangents: pick(&t.tangents),
        };
        let skin = self.skin.as_ref().map(|skin| {
            let mut reordered = Influences::default();
            origins.iter().for_each(|i| reordered.push(skin.of(*i as usize).iter().copied()));
            reordered
        });
        Self { skin, targets: self.targets.iter().map(target).collect(), flat: self.flat }
    }

    /// The posed vertex, and whether its joints mirror it.
    fn vertex(&self, rest: &Vertex, index: usize, pose: &Pose) -> (Vertex, bool) {
        let mut position = Vec3A::from(rest.position);
        let mut normal = Vec3A::from(rest.normal);
        let [tx, ty, tz, handedness] = rest.tangent;
        let mut tangent = Vec3A::new(tx, ty, tz);
        for (target, &weight) in self.targets.iter().zip(&pose.weights).filter(|(_, weight)| **weight != 0.0) {
            let delta = |list: &Vec<[f32; 3]>| list.get(index).map_or(Vec3A::ZERO, |d| Vec3A::from(*d)) * weight;
            position += delta(&target.positions);
            normal += delta(&target.normals);
            tangent += delta(&target.tangents);
        }
        let mut turn = 1.0;
        if let Some(skin) = self.skin.as_ref().filter(|_| !pose.palette.is_empty()) {
            let m = skin.matrix(index, &pose.palette);
            position = m.transform_point3a(position);
            turn = handedness_of(&m.matrix3);
            normal = turn * (cofactors(&m.matrix3) * normal);
            tangent = m.matrix3 * tangent;
        }
        let unit = |v: Vec3A, otherwise: [f32; 3]| {
            let largest = v.abs().max_element();
            let unit = if largest > 0.0 && largest.is_finite() { (v / largest).try_normalize() } else { None };
            unit.map_or(otherwise, |v| v.to_array())
        };
        let [x, y, z] = unit(tangent, [tx, ty, tz]);
        let posed = Vertex {
            position: if position.is_finite() { position.to_array() } else { rest.position },
            normal: unit(normal, rest.normal),
            tangent: [x, y, z, turn * handedness],
            uv: rest.uv,
        };
        (posed, turn < 0.0)
    }

    /// Whether a posed triangle winds the other way than at rest: its corners' joints mirror it. Where they mirror some
    /// corners and not others, its normal decides: that side stays the outer one that the normals of the corners are on.
    fn is_turned(&self, rest: &Mesh, pose: &Pose, posed: &[Vertex], is_mirrored: &[bool], corners: [usize; 3]) -> bool {
        let mirrored = corners.map(|corner| is_mirrored[corner]);
        if mirrored[0] == mirrored[1] && mirrored[1] == mirrored[2] {
            return mirrored[0];
        }
        let Some(skin) = &self.skin else { return false };
        let at_rest = area_normal(&rest.vertices, corners);
        let outside = |corner: usize| {
            let m = skin.matrix(corner, &pose.palette).matrix3;
            handedness_of(&m) * (cofactors(&m) * at_rest).normalize_or_zero()
        };
        let outside: Vec3A = corners.into_iter().map(outside).sum();
        area_normal(posed, corners).dot(outside) < 0.0
    }
}

/// What normals are transformed by, but for their sign and length: they keep at right angles to the surface. Matrices
/// without an inverse have cofactors too.
fn cofactors(m: &Mat3A) -> Mat3A {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    Mat3A::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

/// −1 for matrices that mirror, else 1.
fn handedness_of(m: &Mat3A) -> f32 {
    if m.x_axis.dot(m.y_axis.cross(m.z_axis)) < 0.0 { -1.0 } else { 1.0 }
}

/// Normal of a triangle on the side from which its corners run counter-clockwise, as long as twice its area.
fn area_normal(vertices: &[Vertex], corners: [usize; 3]) -> Vec3A {
    let [a, b, c] = corners.map(|corner| Vec3A::from(vertices[corner].position));
    (b - a).cross(c - a)
}

/// How a mesh is posed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// Weights of the morph targets; those that are not given are zero.
    pub weights: Vec<f32>,
    /// Object space as posed from object space as modelled, for each joint; empty: no skin.
    pub palette: Vec<Affine3A>,
}

impl Pose {
    /// Whether nothing moves: the mesh is its own pose.
    pub fn is_rest(&self) -> bool {
        self.palette.is_empty() && self.weights.iter().all(|weight| *weight == 0.0)
    }

    /// The same bits for the same pose.
    pub fn bits(&self) -> Vec<u32> {
        let matrices = self.palette.iter().flat_map(|m| m.to_cols_array());
        self.weights.iter().copied().chain(matrices).map(f32::to_bits).collect()
    }
}

/// Poses meshes, on all cores. A mesh without [`Mesh::deform`] stays as it is.
pub(crate) fn pose_all(work: &[(Arc<Mesh>, Pose)]) -> Vec<Arc<Mesh>> {
    let pieces: Vec<(usize, Range<usize>)> = work.iter().enumerate().flat_map(|(i, job)| pieces(i, job)).collect();
    let posed = parallel::map(&pieces, |(job, range)| {
        let (mesh, pose) = &work[*job];
        let Some(deform) = &mesh.deform else { return Vertices::default() };
        range.clone().map(|index| deform.vertex(&mesh.vertices[index], index, pose)).unzip()
    });
    let mut vertices: Vec<Vertices> = work.iter().map(|_| Vertices::default()).collect();
    for ((job, _), piece) in pieces.iter().zip(posed) {
        vertices[*job].0.extend(piece.0);
        vertices[*job].1.extend(piece.1);
    }
    work.iter().zip(vertices).map(|((rest, pose), vertices)| finished(rest, pose, vertices)).collect()
}

/// Posed vertices, and which of them joints mirror.
type Vertices = (Vec<Vertex>, Vec<bool>);

fn pieces(index: usize, (mesh, pose): &(Arc<Mesh>, Pose)) -> Vec<(usize, Range<usize>)> {
    if mesh.deform.is_none() || pose.is_rest() {
        return Vec::new();
    }
    let count = mesh.vertices.len();
    (0..count).step_by(PIECE).map(|first| (index, first..(first + PIECE).min(count))).collect()
}

fn finished(rest: &Arc<Mesh>, pose: &Pose, (mut vertices, is_mirrored): Vertices) -> Arc<Mesh> {
    let Some(deform) = rest.deform.as_ref().filter(|_| !pose.is_rest()) else { return rest.clone() };
    let mut indices = rest.indices.clone();
    let winding = if is_mirrored.contains(&true) {
        let is_turned = |corners| deform.is_turned(rest, pose, &vertices, &is_mirrored, corners);
        turn(&mut indices, is_turned)
    } else {
        0
    };
    if deform.flat {
        for triangle in indices.chunks_exact(3) {
            let corners = [0, 1, 2].map(|i| triangle[i] as usize);
            let normal = area_normal(&vertices, corners).try_normalize();
            for corner in corners {
                vertices[corner].normal = normal.map_or(vertices[corner].normal, |n| n.to_array());
            }
        }
    }
    Arc::new(Mesh {
        id: AssetId::fresh(),
        name: rest.name.clone(),
        bounds: Aabb::from_points(vertices.iter().map(|v| Vec3::from(v.position))),
        vertices,
        indices,
        extras: rest.extras.clone(),
        deform: None,
        rest: Some(rest.clone()),
        winding,
        balls: None,
        hierarchy: OnceLock::new(),
    })
}

/// Lets the triangles that are to be turned wind the other way, and returns the key of which these are.
fn turn(indices: &mut [u32], is_turned: impl Fn([usize; 3]) -> bool) -> u64 {
    let (mut key, mut count) = (DefaultHasher::new(), 0);
    for (number, triangle) in indices.chunks_exact_mut(3).enumerate() {
        if is_turned([0, 1, 2].map(|i| triangle[i] as usize)) {
            triangle.swap(1, 2);
            number.hash(&mut key);
            count += 1;
        }
    }
    if count > 0 { key.finish() } else { 0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use glam::Quat;

    fn triangle(deform: Deform) -> Arc<Mesh> {
        let at = |position| Vertex { position, normal: [0.0, 0.0, 1.0], tangent: [1.0, 0.0, 0.0, 1.0], uv: [0.0; 2] };
        let vertices = vec![at([0.0; 3]), at([1.0, 0.0, 0.0]), at([0.0, 1.0, 0.0])];
        let mut mesh = Mesh::new("triangle", vertices, vec![0, 1, 2]);
        mesh.deform = Some(Arc::new(deform));
        Arc::new(mesh)
    }

    fn posed(mesh: &Arc<Mesh>, weights: &[f32], palette: &[Affine3A]) -> Arc<Mesh> {
        let pose = Pose { weights: weights.to_vec(), palette: palette.to_vec() };
        pose_all(&[(mesh.clone(), pose)]).remove(0)
    }

    fn skin(pairs: &[&[(u16, f32)]]) -> Option<Influences> {
        let mut influences = Influences::default();
        pairs.iter().for_each(|p| influences.push(p.iter().copied()));
        Some(influences)
    }

    #[test]
    fn targets_add_up_by_weight_and_rest_is_the_mesh_itself() {
        let target = |d: [f32; 3]| MorphTarget { positions: vec![d; 3], ..Default::default() };
        let targets = vec![target([0.0, 0.0, 2.0]), target([4.0, 0.0, 0.0])];
        let mesh = triangle(Deform { targets, ..Default::default() });
        let moved = posed(&mesh, &[0.5, -0.25], &[]);
        assert_eq!(moved.vertices[1].position, [0.0, 0.0, 1.0]);
        assert_eq!((moved.vertices[1].normal, moved.bounds.max.z), ([0.0, 0.0, 1.0], 1.0));
        assert!(Arc::ptr_eq(moved.rest.as_ref().unwrap(), &mesh) && moved.topology() == mesh.id);
        assert!(Arc::ptr_eq(&posed(&mesh, &[0.0, 0.0], &[]), &mesh));
    }

    #[test]
    fn weights_that_are_no_weights_do_no_harm() {
        let mesh =
            triangle(Deform { skin: skin(&[&[(0, 3.0), (1, 1.0)], &[], &[(1, f32::NAN)]]), ..Default::default() });
        let up = Affine3A::from_translation(Vec3::Y * 4.0);
        let moved = posed(&mesh, &[], &[Affine3A::IDENTITY, up]);
        let positions: Vec<_> = moved.vertices.iter().map(|v| v.position).collect();
        // A quarter of four up; the second follows joint 0, which rests, and the third the joint that it names.
        assert_eq!(positions, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
    }

    #[test]
    fn matrices_without_volume_or_beyond_numbers_stay_finite() {
        let mesh = triangle(Deform { skin: skin(&[&[(0, 1.0)], &[(1, 1.0)], &[(7, 1.0)]]), ..Default::default() });
        let flat = Affine3A::from_scale(Vec3::ZERO);
        let wild = Affine3A::from_scale(Vec3::splat(f32::INFINITY));
        for v in &posed(&mesh, &[], &[flat, wild]).vertices {
            assert!(v.position.iter().chain(&v.normal).chain(&v.tangent).all(|x| x.is_finite()), "{v:?}");
        }
    }

    #[test]
    fn mirrored_joints_keep_normals_on_the_outside_of_the_triangle_they_had() {
        let mesh = triangle(Deform { skin: skin(&[&[(0, 1.0)][..]; 3]), ..Default::default() });
        let turned = Affine3A::from_quat(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
        let v = posed(&mesh, &[], &[turned]).vertices[2];
        assert!((Vec3::from(v.normal) - Vec3::NEG_Y).length() < 1e-6 && (v.position[2] - 1.0).abs() < 1e-6);
        let mirrored = posed(&mesh, &[], &[Affine3A::from_scale(Vec3::new(1.0, 1.0, -1.0))]).vertices[0];
        assert_eq!((mirrored.normal, mirrored.tangent[3]), ([0.0, 0.0, 1.0].map(|x: f32| -x), -1.0));
    }

    /// Whatever joints do, the outer side of a triangle is the one that its normals are on.
    #[test]
    fn triangles_wind_the_other_way_where_joints_mirror_them() {
        let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let beside = Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, -0.5, 2.0),
            Quat::from_rotation_y(0.4),
            Vec3::new(0.5, 3.0, 0.0),
        );
        let whole: &[(u16, f32)] = &[(0, 1.0)];
        let halves: &[(u16, f32)] = &[(0, 0.6), (1, 0.4)];
        let other: &[(u16, f32)] = &[(1, 1.0)];
        let cases =
            [([whole; 3], true), ([other; 3], false), ([whole, whole, other], true), ([other, whole, halves], true)];
        for ((weights, has_mirrored), place) in cases.into_iter().flat_map(|case| [(case, mirror), (case, beside)]) {
            for flat in [false, true] {
                let mesh = triangle(Deform { skin: skin(&weights), flat, ..Default::default() });
                let moved = posed(&mesh, &[], &[place, Affine3A::IDENTITY]);
                let corners = [0, 1, 2].map(|i| moved.indices[i] as usize);
                let outside: Vec3A = corners.map(|corner| Vec3A::from(moved.vertices[corner].normal)).iter().sum();
                assert!(area_normal(&moved.vertices, corners).dot(outside) > 0.0, "{weights:?}, {place}");
                assert!(has_mirrored || moved.winding == 0);
                assert_eq!(moved.winding == 0, moved.indices == mesh.indices, "{weights:?}");
                assert_eq!(moved.topology(), mesh.id);
            }
        }
    }

    #[test]
    fn reordering_keeps_what_belongs_to_a_vertex() {
        let positions = vec![[0.0; 3], [1.0; 3], [2.0; 3]];
        let deform = Deform {
            skin: skin(&[&[(0, 1.0)], &[(1, 1.0), (2, 1.0)], &[(3, 1.0)]]),
            targets: vec![MorphTarget { positions, ..Default::default() }],
            flat: false,
        };
        let reordered = deform.reordered(&[2, 2, 1]);
        assert_eq!(reordered.targets[0].positions, [[2.0; 3], [2.0; 3], [1.0; 3]]);
        let skin = reordered.skin.unwrap();
        assert_eq!((skin.of(0), skin.of(2), skin.highest_joint()), (&[(3, 1.0)][..], &[(1, 0.5), (2, 0.5)][..], 3));
    }
}
