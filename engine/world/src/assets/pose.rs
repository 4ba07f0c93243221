//! Poses of whole meshes: their vertices, and which way their triangles wind.

use super::deform::area_normal;
use super::{AssetId, Mesh, Pose, Vertex, parallel};
use crate::core::Aabb;
use glam::Vec3;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Vertices that one piece of work poses.
const PIECE: usize = 8192;

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
        let is_turned = |corners| deform.is_turned(&rest.vertices, pose, &vertices, &is_mirrored, corners);
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
    use crate::assets::{Deform, Influences, MorphTarget};
    use glam::Quat;
    use glam::{Affine3A, Vec3A};

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
