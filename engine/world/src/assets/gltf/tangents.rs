//! Tangent spaces by MikkTSpace, as glTF asks for where a file has none.

use crate::assets::Vertex;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

struct Corners<'a> {
    vertices: &'a [Vertex],
    /// Texture coordinates of the normal map.
    uvs: Vec<[f32; 2]>,
    indices: &'a [u32],
    tangents: Vec<Option<[f32; 4]>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> &Vertex {
        &self.vertices[self.indices[3 * face + corner] as usize]
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.indices.len() / 3
    }
    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).position
    }
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertex(face, corner).normal
    }
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.indices[3 * face + corner] as usize]
    }
    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        // MikkTSpace points the bitangent along +v, which is down the image in glTF, but a glTF normal map's green
        // axis points up: so the handedness is turned round.
        self.tangents[3 * face + corner] = space.map(|s| s.tangent_encoded()).map(|[x, y, z, w]| [x, y, z, -w]);
    }
}

/// Computes all tangents. Vertices whose corners need different ones (mirrored or split texture coordinates) are
/// duplicated, at the end; which ones is returned. `uvs` are the normal map's texture coordinates.
pub(super) fn generate(vertices: &mut Vec<Vertex>, indices: &mut [u32], uvs: Vec<[f32; 2]>) -> Vec<u32> {
    let mut copied = Vec::new();
    let mut corners = Corners { vertices, uvs, indices, tangents: vec![None; indices.len()] };
    let done = generate_tangents(&mut corners).is_ok();
    let tangents = corners.tangents;
    let mut first: Vec<Option<[f32; 4]>> = vec![None; vertices.len()];
    let mut copies: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (index, tangent) in indices.iter_mut().zip(tangents) {
        let normal = vertices[*index as usize].normal;
        let tangent = tangent.filter(|_| done).map_or([0.0; 4], |t| t);
        let tangent = sound(normal, tangent);
        let slot = &mut first[*index as usize];
        match slot {
            None => {
                *slot = Some(tangent);
                vertices[*index as usize].tangent = tangent;
            }
            Some(t) if *t == tangent => {}
            Some(_) => {
                let copy = *copies.entry((*index, tangent.map(f32::to_bits))).or_insert_with(|| {
                    copied.push(*index);
                    vertices.push(Vertex { tangent, ..vertices[*index as usize] });
                    vertices.len() as u32 - 1
                });
                *index = copy;
            }
        }
    }
    copied
}

/// The tangent made unit length with handedness ±1; any one perpendicular to the normal where it is unusable.
pub(super) fn sound(normal: [f32; 3], tangent: [f32; 4]) -> [f32; 4] {
    let w = if tangent[3] < 0.0 { -1.0 } else { 1.0 };
    let direction = Vec4::from(tangent).truncate();
    let unit = if direction.is_finite() { direction.try_normalize() } else { None };
    let unit = unit.unwrap_or_else(|| {
        let n = Vec3::from(normal);
        if n.is_normalized() { n.any_orthonormal_vector() } else { Vec3::X }
    });
    unit.extend(w).to_array()
}
