//! Deformation of meshes: morph targets, then skins (glTF 2.0, sections 3.7.2.2 and 3.7.3.3).

use super::{AssetId, Mesh, Vertex, parallel};
use crate::scene::Aabb;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};
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
    /// vertex without any follows joint 0.
    pub fn push(&mut self, pairs: impl Iterator<Item = (u16, f32)>) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        let first = self.pairs.len();
        self.pairs.extend(pairs.filter(|(_, weight)| *weight > 0.0 && weight.is_finite()));
        let sum: f32 = self.pairs[first..].iter().map(|(_, weight)| weight).sum();
        if sum > 0.0 && sum.is_finite() {
            self.pairs[first..].iter_mut().for_each(|(_, weight)| *weight /= sum);
        } else {
            self.pairs.truncate(first);
            self.pairs.push((0, 1.0));
        }
        self.starts.push(self.pairs.len() as u32);
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

    fn vertex(&self, rest: &Vertex, index: usize, pose: &Pose) -> Vertex {
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
            let (x, y, z) = (m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis);
            position = m.transform_point3a(position);
            // Normals keep at right angles to the surface: the cofactors, which exist for flat matrices too.
            let cofactors = Mat3A::from_cols(y.cross(z), z.cross(x), x.cross(y));
            turn = if x.dot(y.cross(z)) < 0.0 { -1.0 } else { 1.0 };
            normal = turn * (cofactors * normal);
            tangent = m.matrix3 * tangent;
        }
        let unit = |v: Vec3A, otherwise: [f32; 3]| {
            let largest = v.abs().max_element();
            let unit = if largest > 0.0 && largest.is_finite() { (v / largest).try_normalize() } else { None };
            unit.map_or(otherwise, |v| v.to_array())
        };
        let [x, y, z] = unit(tangent, [tx, ty, tz]);
        Vertex {
            position: if position.is_finite() { position.to_array() } else { rest.position },
            normal: unit(normal, rest.normal),
            tangent: [x, y, z, turn * handedness],
            uv: rest.uv,
        }
    }
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
        let Some(deform) = &mesh.deform else { return Vec::new() };
        range.clone().map(|index| deform.vertex(&mesh.vertices[index], index, pose)).collect::<Vec<Vertex>>()
    });
    let mut vertices: Vec<Vec<Vertex>> = work.iter().map(|_| Vec::new()).collect();
    for ((job, _), piece) in pieces.iter().zip(posed) {
        vertices[*job].extend(piece);
    }
    work.iter().zip(vertices).map(|((rest, pose), vertices)| finished(rest, pose, vertices)).collect()
}

fn pieces(index: usize, (mesh, pose): &(Arc<Mesh>, Pose)) -> Vec<(usize, Range<usize>)> {
    if mesh.deform.is_none() || pose.is_rest() {
        return Vec::new();
    }
    let count = mesh.vertices.len();
    (0..count).step_by(PIECE).map(|first| (index, first..(first + PIECE).min(count))).collect()
}

fn finished(rest: &Arc<Mesh>, pose: &Pose, mut vertices: Vec<Vertex>) -> Arc<Mesh> {
    let Some(deform) = rest.deform.as_ref().filter(|_| !pose.is_rest()) else { return rest.clone() };
    if deform.flat {
        for triangle in vertices.chunks_exact_mut(3) {
            let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(triangle[i].position));
            let normal = (b - a).cross(c - a).try_normalize();
            triangle.iter_mut().for_each(|v| v.normal = normal.map_or(v.normal, |n| n.to_array()));
        }
    }
    Arc::new(Mesh {
        id: AssetId::fresh(),
        name: rest.name.clone(),
        bounds: Aabb::from_points(vertices.iter().map(|v| Vec3::from(v.position))),
        vertices,
        indices: rest.indices.clone(),
        extras: rest.extras.clone(),
        deform: None,
        rest: Some(rest.clone()),
        hierarchy: OnceLock::new(),
    })
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
        // A quarter of four up; the others follow joint 0, which rests.
        assert_eq!(positions, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
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
