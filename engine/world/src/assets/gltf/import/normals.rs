//! Normals from the triangles themselves.

use super::super::face_normal::face_normal;
use super::split::{Groups, places};
use crate::assets::Vertex;
use glam::Vec3;
use std::collections::HashMap;

/// One normal a triangle, and so three vertices of its own.
pub(super) fn flat(vertices: &mut Vec<Vertex>, indices: &mut [u32]) -> Vec<u32> {
    let faces: Vec<Vec3> = indices.chunks_exact(3).map(|triangle| normal(triangle, vertices)).collect();
    let corner_normals: Vec<Vec3> = faces.into_iter().flat_map(|face| [face; 3]).collect();
    rewrite(vertices, indices, &corner_normals)
}

/// One normal for all triangles around a vertex that are joined by edges of no more than `crease` \[rad\].
pub(super) fn smooth(vertices: &mut Vec<Vertex>, indices: &mut [u32], crease: f32) -> Vec<u32> {
    let places = places(vertices);
    let faces: Vec<Vec3> = indices.chunks_exact(3).map(|triangle| normal(triangle, vertices)).collect();
    let groups = smoothing_groups(indices, &places, &faces, crease);
    let mut sums = vec![Vec3::ZERO; indices.len()];
    for corner in 0..indices.len() {
        sums[groups[corner] as usize] += faces[corner / 3] * angle_at(corner, vertices, indices);
    }
    let normal = |corner: usize| sums[groups[corner] as usize].try_normalize().unwrap_or(faces[corner / 3]);
    let corner_normals: Vec<Vec3> = (0..indices.len()).map(normal).collect();
    rewrite(vertices, indices, &corner_normals)
}

/// For each corner the first corner whose normal it shares: corners at one place are joined across the edges that
/// their triangles share, where these are not sharp.
fn smoothing_groups(indices: &[u32], places: &[u32], faces: &[Vec3], crease: f32) -> Vec<u32> {
    let least_cosine = crease.cos() - 1e-5;
    let mut groups = Groups::new(indices.len());
    // The last triangle met at each edge, with its corners at the edge's lower and higher place.
    let mut edges: HashMap<(u32, u32), [usize; 2]> = HashMap::new();
    for corner in 0..indices.len() {
        let triangle = corner / 3;
        let next = 3 * triangle + (corner + 1) % 3;
        let mut ends = [corner, next];
        ends.sort_by_key(|end| places[indices[*end] as usize]);
        let [low, high] = ends.map(|end| places[indices[end] as usize]);
        let Some(other) = edges.insert((low, high), ends) else { continue };
        if faces[other[0] / 3].dot(faces[triangle]) >= least_cosine {
            groups.join(other[0] as u32, ends[0] as u32);
            groups.join(other[1] as u32, ends[1] as u32);
        }
    }
    (0..indices.len() as u32).map(|corner| groups.find(corner)).collect()
}

fn normal(triangle: &[u32], vertices: &[Vertex]) -> Vec3 {
    face_normal([0, 1, 2].map(|i| vertices[triangle[i] as usize].position))
}

/// Angle of the triangle at one of its corners \[rad\].
fn angle_at(corner: usize, vertices: &[Vertex], indices: &[u32]) -> f32 {
    let first = corner - corner % 3;
    let at = |offset: usize| Vec3::from(vertices[indices[first + (corner + offset) % 3] as usize].position);
    let (a, b) = (at(1) - at(0), at(2) - at(0));
    // Of unit length first: the product of two tiny edges is no number any more.
    a.normalize_or_zero().dot(b.normalize_or_zero()).clamp(-1.0, 1.0).acos()
}

/// Gives every corner its normal; corners that differ in nothing share a vertex. Returns which vertex each was.
fn rewrite(vertices: &mut Vec<Vertex>, indices: &mut [u32], normals: &[Vec3]) -> Vec<u32> {
    let mut origins = Vec::with_capacity(vertices.len());
    let mut made: Vec<Vertex> = Vec::with_capacity(vertices.len());
    let mut known = HashMap::new();
    for (index, normal) in indices.iter_mut().zip(normals) {
        let next = made.len() as u32;
        let place = *known.entry((*index, normal.to_array().map(f32::to_bits))).or_insert(next);
        if place == next {
            origins.push(*index);
            made.push(Vertex { normal: normal.to_array(), ..vertices[*index as usize] });
        }
        *index = place;
    }
    *vertices = made;
    origins
}
