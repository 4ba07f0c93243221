//! Splitting of a mesh into connected parts.

use crate::assets::{Mesh, Vertex};
use crate::core::Aabb;
use glam::Vec3;
use std::collections::HashMap;

/// Sets that are joined pair by pair (union-find with path halving).
pub(super) struct Groups(Vec<u32>);

impl Groups {
    /// So many sets of one element.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The element that stands for the set.
    pub fn find(&mut self, mut element: u32) -> u32 {
        while self.0[element as usize] != element {
            let above = self.0[self.0[element as usize] as usize];
            self.0[element as usize] = above;
            element = above;
        }
        element
    }

    /// Makes one set of two; the least element stands for it.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// One number for each place: vertices at the same position share it, whatever their normals.
pub(super) fn places(vertices: &[Vertex]) -> Vec<u32> {
    let mut known = HashMap::new();
    let place = |v: &Vertex| {
        let next = known.len() as u32;
        // −0 and 0 are the same place.
        *known.entry(v.position.map(|x| (x + 0.0).to_bits())).or_insert(next)
    };
    vertices.iter().map(place).collect()
}

/// The connected parts in the order of their first triangles. Triangles are connected where they share a position.
/// Parts of more than `most` triangles are halved until they have no more.
pub(super) fn split(whole: &Mesh, most: Option<u32>) -> Vec<Mesh> {
    let (name, vertices) = (&whole.name, &whole.vertices);
    let triangles: Vec<[u32; 3]> = whole.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let mut parts = connected(vertices, &triangles);
    if let Some(most) = most {
        parts = parts.into_iter().flat_map(|part| halved(part, vertices, most.max(1) as usize)).collect();
    }
    let is_whole = parts.len() == 1;
    let name_of = |i: usize| if is_whole { name.clone() } else { format!("{name} part {}", i + 1) };
    parts.iter().enumerate().map(|(i, part)| mesh(name_of(i), part, whole)).collect()
}

fn connected(vertices: &[Vertex], triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
    let places = places(vertices);
    let mut groups = Groups::new(places.len());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| places[corner as usize]);
        groups.join(a, b);
        groups.join(b, c);
    }
    let mut order = HashMap::new();
    let mut parts: Vec<Vec<[u32; 3]>> = Vec::new();
    for triangle in triangles {
        let next = parts.len();
        let part = *order.entry(groups.find(places[triangle[0] as usize])).or_insert(next);
        if part == next {
            parts.push(Vec::new());
        }
        parts[part].push(*triangle);
    }
    parts
}

/// Halves at the median along the longest axis, until no half has more than `most` triangles.
fn halved(part: Vec<[u32; 3]>, vertices: &[Vertex], most: usize) -> Vec<Vec<[u32; 3]>> {
    let middle = |triangle: &[u32; 3]| -> Vec3 {
        triangle.iter().map(|corner| Vec3::from(vertices[*corner as usize].position) / 3.0).sum()
    };
    let (mut open, mut done) = (vec![part], Vec::new());
    while let Some(mut part) = open.pop() {
        if part.len() <= most {
            done.push(part);
            continue;
        }
        let size = Aabb::from_points(part.iter().map(middle)).size();
        let axis = size.max_position();
        part.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        let upper = part.split_off(part.len() / 2);
        open.extend([upper, part]);
    }
    done
}

/// A mesh of the triangles with the vertices that they need.
fn mesh(name: String, triangles: &[[u32; 3]], whole: &Mesh) -> Mesh {
    let mut origins = Vec::new();
    let (mut vertices, mut indices, mut known) = (Vec::new(), Vec::new(), HashMap::new());
    for corner in triangles.as_flattened() {
        let next = vertices.len() as u32;
        let index = *known.entry(*corner).or_insert(next);
        if index == next {
            vertices.push(whole.vertices[*corner as usize]);
            origins.push(*corner);
        }
        indices.push(index);
    }
    let mut mesh = Mesh::new(name, vertices, indices);
    mesh.carry(whole, &origins);
    mesh
}
