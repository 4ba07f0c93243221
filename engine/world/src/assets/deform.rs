//! Deformation of meshes: morph targets, then skins (glTF 2.0, sections 3.7.2.2 and 3.7.3.3).

use super::Vertex;
use glam::{Affine3A, Mat3A, Vec3A};

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
    pub(super) fn vertex(&self, rest: &Vertex, index: usize, pose: &Pose) -> (Vertex, bool) {
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
    pub(super) fn is_turned(
        &self,
        rest: &[Vertex],
        pose: &Pose,
        posed: &[Vertex],
        is_mirrored: &[bool],
        corners: [usize; 3],
    ) -> bool {
        let mirrored = corners.map(|corner| is_mirrored[corner]);
        if mirrored[0] == mirrored[1] && mirrored[1] == mirrored[2] {
            return mirrored[0];
        }
        let Some(skin) = &self.skin else { return false };
        let at_rest = area_normal(rest, corners);
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
pub(super) fn area_normal(vertices: &[Vertex], corners: [usize; 3]) -> Vec3A {
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
