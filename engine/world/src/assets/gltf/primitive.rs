//! Mesh primitives: triangles of any topology as indexed lists, with normals and tangents for every vertex.

use super::accessor::{is_index, place};
use super::attribute::{self, Format};
use super::face_normal::face_normal;
use super::reader::{Job, Reader};
use super::remarks::Remarks;
use super::{tangents, thin};
use crate::assets::{AssetError, Deform, Mesh, Vertex, VertexExtra};
use glam::Vec3;
use gltf::accessor::{Accessor, DataType};
use gltf::mesh::{Mode, Semantic};
use std::sync::Arc;

/// A mesh, or none for what has no triangles, and remarks.
pub(super) type Loaded = (Option<Mesh>, Remarks);

struct Attributes {
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    tangents: Option<Vec<[f32; 4]>>,
    uvs: [Option<Vec<[f32; 2]>>; 2],
    colors: Option<Vec<[f32; 4]>>,
}

impl Reader<'_> {
    /// Reads a primitive.
    ///
    /// # Errors
    /// Why it cannot be drawn.
    pub fn load(&self, job: &Job) -> Result<Loaded, AssetError> {
        let mut warnings = Remarks::default();
        let mode = job.primitive.mode();
        let Some(positions) = job.primitive.get(&Semantic::Positions) else {
            return Err(self.wrong(job, "has no positions and is not drawn".into()));
        };
        let mut attributes = self.attributes(job, &positions, &mut warnings)?;
        let strips = self.strips(job, attributes.positions.len(), &mut warnings)?;
        let (corners, each) = match mode {
            Mode::Points => (strips.concat(), 1),
            mode if thin::is_thin(mode) => {
                (strips.iter().flat_map(|strip| thin::segments(mode, strip)).flatten().collect(), 2)
            }
            mode => {
                let lists = strips.into_iter().map(|strip| triangles(mode, strip, &mut warnings, &job.place));
                (lists.flatten().collect(), 3)
            }
        };
        let mut indices = self.sound_corners(job, &attributes.positions, corners, each, &mut warnings);
        // No corner reads them any more.
        attributes.positions.iter_mut().filter(|p| !Vec3::from(**p).is_finite()).for_each(|p| *p = [0.0; 3]);
        if thin::is_thin(mode) {
            let mode = if mode == Mode::Points { mode } else { Mode::Lines };
            return self.load_thin(job, mode, attributes, &indices, warnings);
        }
        if indices.is_empty() {
            warnings.push(format!("{}: has no triangle and is not drawn", job.place));
            return Ok((None, warnings));
        }
        let flat = attributes.normals.is_none();
        let has_tangents = attributes.tangents.is_some() && !flat;
        let given_tangents = has_tangents && !self.lost_tangents(job, &attributes, &indices, &mut warnings);
        let mut own = Mesh::new("", Vec::new(), Vec::new());
        own.extras = extras(&attributes).map(Arc::new);
        own.deform =
            self.deform(job, attributes.positions.len(), &mut warnings)?.map(|d| Arc::new(Deform { flat, ..d }));
        let mut vertices = weave(attributes);
        // Vertices are copied and reordered below; this is where each was.
        let mut origins: Vec<u32> = (0..vertices.len() as u32).collect();
        if flat {
            vertices = indices.iter().map(|i| vertices[*i as usize]).collect();
            origins = std::mem::replace(&mut indices, (0..vertices.len() as u32).collect());
            flat_normals(&mut vertices);
        } else if let Some(repaired) = repair_normals(&mut vertices, &indices) {
            warnings.fault(format!("{}: {repaired} normals are not finite or have no length; replaced", job.place));
        }
        match job.uv.normal.filter(|_| !given_tangents) {
            None => vertices.iter_mut().for_each(|v| v.tangent = tangents::sound(v.normal, v.tangent)),
            Some(map) => {
                let second = |vertex: usize| own.extra(origins[vertex] as usize).uv;
                let uvs = vertices.iter().enumerate().map(|(i, v)| map.apply([v.uv, second(i)])).collect();
                let copies = tangents::generate(&mut vertices, &mut indices, uvs);
                origins.extend(copies.iter().map(|copy| origins[*copy as usize]).collect::<Vec<_>>());
            }
        }
        let mut mesh = Mesh::new(job.name.clone(), vertices, indices);
        mesh.carry(&own, &origins);
        Ok((Some(mesh), warnings))
    }

    /// Points and lines, as solids.
    fn load_thin(
        &self,
        job: &Job,
        mode: Mode,
        attributes: Attributes,
        corners: &[u32],
        mut warnings: Remarks,
    ) -> Result<Loaded, AssetError> {
        let mut own = Mesh::new("", Vec::new(), Vec::new());
        own.extras = extras(&attributes).map(Arc::new);
        own.deform =
            self.deform(job, attributes.positions.len(), &mut warnings)?.map(|d| Arc::new(Deform { flat: true, ..d }));
        let (mut vertices, origins) = thin::solids(mode, &weave(attributes), corners);
        if vertices.is_empty() {
            warnings.push(format!("{}: its lines have no length and are not drawn", job.place));
            return Ok((None, warnings));
        }
        vertices.iter_mut().for_each(|v| v.tangent = tangents::sound(v.normal, v.tangent));
        let indices = (0..vertices.len() as u32).collect();
        let mut mesh = Mesh::new(job.name.clone(), vertices, indices);
        mesh.carry(&own, &origins);
        Ok((Some(mesh), warnings))
    }

    /// The attributes of the vertices. One besides the positions that is broken is left out.
    fn attributes<'a>(
        &self,
        job: &Job<'a>,
        positions: &Accessor,
        remarks: &mut Remarks,
    ) -> Result<Attributes, AssetError> {
        let count = positions.count();
        let read = |semantic: Semantic, format: &Format<4>, remarks: &mut Remarks| {
            let values = self.attribute(job, semantic, count, format, remarks);
            Ok::<_, AssetError>(remarks.part(values, "ignored")?.flatten())
        };
        let normals = self.attribute(job, Semantic::Normals, count, &attribute::NORMAL, remarks);
        let mut colors = read(Semantic::Colors(0), &attribute::COLOR, remarks)?;
        if let Some(colors) = &mut colors {
            colors.as_flattened_mut().iter_mut().for_each(|c| *c = c.clamp(0.0, 1.0));
        }
        Ok(Attributes {
            positions: self.formatted(job, positions, count, &attribute::POSITION, remarks)?,
            normals: remarks.part(normals, "ignored")?.flatten(),
            tangents: read(Semantic::Tangents, &attribute::TANGENT, remarks)?,
            uvs: self.uvs(job, count, remarks)?,
            colors,
        })
    }

    /// The sets of texture coordinates that the material uses. One that is not there is taken from the other one.
    fn uvs(&self, job: &Job, count: usize, remarks: &mut Remarks) -> Result<[Option<Vec<[f32; 2]>>; 2], AssetError> {
        let [first, second] = job.uv.sets.map(|set| (set, Semantic::TexCoords(set)));
        let read = |(_, semantic): (u32, Semantic), remarks: &mut Remarks| {
            let uvs = self.attribute(job, semantic, count, &attribute::UV, remarks);
            Ok::<_, AssetError>(remarks.part(uvs, "ignored")?.flatten())
        };
        let sets = [first.0, second.0];
        let mut uvs = [read(first, remarks)?, if job.uv.uses[1] { read(second, remarks)? } else { None }];
        for i in 0..2 {
            if !job.uv.uses[i] || uvs[i].is_some() {
                continue;
            }
            let other = uvs[1 - i].clone().map(|uvs| (sets[1 - i], uvs));
            let other = match other {
                None if sets[i] != 0 => read((0, Semantic::TexCoords(0)), remarks)?.map(|uvs| (0, uvs)),
                other => other,
            };
            let outcome = other.as_ref().map_or("it has none".into(), |(set, _)| format!("TEXCOORD_{set} is taken"));
            remarks
                .fault(format!("{}: its material needs TEXCOORD_{}, which is missing; {outcome}", job.place, sets[i]));
            uvs[i] = other.map(|(_, uvs)| uvs);
        }
        Ok(uvs)
    }

    pub(super) fn wrong(&self, job: &Job, problem: String) -> AssetError {
        AssetError::format(self.buffers.path, &job.place, problem)
    }

    pub(super) fn fail(&self, job: &Job, accessor: &Accessor, problem: String) -> AssetError {
        AssetError::format(self.buffers.path, format!("{}, {}", job.place, place(accessor)), problem)
    }

    /// The vertices of the corners, in order: one list, or several where the largest index of the type begins a new strip, which
    /// it does elsewhere, and not in glTF.
    fn strips(&self, job: &Job, count: usize, remarks: &mut Remarks) -> Result<Vec<Vec<u32>>, AssetError> {
        let Some(accessor) = job.primitive.indices() else { return Ok(vec![(0..count as u32).collect()]) };
        let corners = self.buffers.indices(&accessor)?;
        if !is_index(accessor.data_type()) || accessor.normalized() {
            let problem = format!("indices must be unsigned integers, not {:?}", accessor.data_type());
            remarks.broken(&self.fail(job, &accessor, problem), "taken as such");
        }
        let largest = match accessor.data_type() {
            DataType::U8 => u32::from(u8::MAX),
            DataType::U16 => u32::from(u16::MAX),
            _ => u32::MAX,
        };
        if !corners.contains(&largest) {
            return Ok(vec![corners]);
        }
        let has_strips = !matches!(job.primitive.mode(), Mode::Points | Mode::Lines | Mode::Triangles);
        let begins_strip = has_strips && largest as usize >= count;
        let problem = format!("index {largest} is the largest of its type, which glTF does not allow");
        let outcome = if begins_strip { "taken for the beginning of a strip" } else { "taken for a vertex" };
        remarks.broken(&self.fail(job, &accessor, problem), outcome);
        match begins_strip {
            true => Ok(corners.split(|corner| *corner == largest).map(<[u32]>::to_vec).collect()),
            false => Ok(vec![corners]),
        }
    }

    /// Whether tangents are missing where there should be some, so that all are computed.
    fn lost_tangents(&self, job: &Job, attributes: &Attributes, corners: &[u32], remarks: &mut Remarks) -> bool {
        let Some(tangents) = attributes.tangents.as_ref().filter(|_| job.uv.normal.is_some()) else { return false };
        let is_lost = |corner: &&u32| {
            let [x, y, z, _] = tangents[**corner as usize];
            let direction = Vec3::new(x, y, z);
            !direction.is_finite() || direction.try_normalize().is_none()
        };
        let lost = corners.iter().filter(is_lost).count();
        if lost > 0 {
            let of = corners.len();
            remarks.fault(format!(
                "{}: tangents of {lost} of {of} corners have no direction; all are computed",
                job.place
            ));
        }
        lost > 0
    }

    /// The corners without those groups of which a vertex is not there or lies nowhere. `each`: corners of a group.
    fn sound_corners(
        &self,
        job: &Job,
        positions: &[[f32; 3]],
        mut corners: Vec<u32>,
        each: usize,
        remarks: &mut Remarks,
    ) -> Vec<u32> {
        let wrong = |corner: &u32| positions.get(*corner as usize).is_none_or(|p| !Vec3::from(*p).is_finite());
        let Some(first) = corners.iter().find(|corner| wrong(corner)).copied() else { return corners };
        let before = corners.len() / each;
        let sound = corners.chunks_exact(each).filter(|group| !group.iter().any(wrong));
        corners = sound.flatten().copied().collect();
        let lost = before - corners.len() / each;
        let what = match positions.get(first as usize) {
            Some(position) => format!("vertex {first} at {position:?} is no place: not a finite number"),
            None => format!("index {first} is out of range: there are {} vertices", positions.len()),
        };
        let accessor = match positions.get(first as usize) {
            Some(_) => job.primitive.get(&Semantic::Positions),
            None => job.primitive.indices(),
        };
        let at = accessor.map_or_else(|| job.place.clone(), |a| format!("{}, {}", job.place, place(&a)));
        let what = format!("{at}: {what}");
        remarks.fault(format!("{what}; {lost} of {before} {} left out", ["corners", "lines", "triangles"][each - 1]));
        corners
    }
}

/// Turns strips and fans into lists (glTF 2.0, section 3.7.2.1), keeping the winding.
fn triangles(mode: Mode, mut corners: Vec<u32>, warnings: &mut Remarks, place: &str) -> Vec<u32> {
    match mode {
        Mode::TriangleStrip => {
            (2..corners.len()).flat_map(|i| [corners[i - 2], corners[i - 1 + i % 2], corners[i - i % 2]]).collect()
        }
        Mode::TriangleFan => (2..corners.len()).flat_map(|i| [corners[i - 1], corners[i], corners[0]]).collect(),
        _ => {
            let surplus = corners.len() % 3;
            if surplus > 0 {
                warnings.fault(format!("{place}: the last {surplus} corners make no triangle"));
                corners.truncate(corners.len() - surplus);
            }
            corners
        }
    }
}

/// Second texture coordinates and colours, if there are any.
fn extras(attributes: &Attributes) -> Option<Vec<VertexExtra>> {
    let (uvs, colors) = (&attributes.uvs[1], &attributes.colors);
    if uvs.is_none() && colors.is_none() {
        return None;
    }
    let extra = |i: usize| VertexExtra {
        uv: uvs.as_ref().map_or([0.0; 2], |u| u[i]),
        color: colors.as_ref().map_or([u16::MAX; 4], |c| c[i].map(|x| (x * 65535.0).round() as u16)),
    };
    Some((0..attributes.positions.len()).map(extra).collect())
}

fn weave(attributes: Attributes) -> Vec<Vertex> {
    let Attributes { positions, normals, tangents, uvs: [uvs, _], .. } = attributes;
    let at = |i: usize, position: [f32; 3]| Vertex {
        position,
        normal: normals.as_ref().map_or([0.0; 3], |n| n[i]),
        tangent: tangents.as_ref().map_or([0.0; 4], |t| t[i]),
        uv: uvs.as_ref().map_or([0.0; 2], |u| u[i]),
    };
    positions.into_iter().enumerate().map(|(i, p)| at(i, p)).collect()
}

fn flat_normals(vertices: &mut [Vertex]) {
    for triangle in vertices.chunks_exact_mut(3) {
        let normal = face_normal([triangle[0].position, triangle[1].position, triangle[2].position]);
        triangle.iter_mut().for_each(|v| v.normal = normal.to_array());
    }
}

/// Makes all normals unit length; those that cannot be take that of their triangles. Returns how many, if any.
fn repair_normals(vertices: &mut [Vertex], indices: &[u32]) -> Option<usize> {
    let mut bad = vec![false; vertices.len()];
    for (v, bad) in vertices.iter_mut().zip(&mut bad) {
        let n = Vec3::from(v.normal);
        let unit = if n.is_finite() { n.try_normalize() } else { None };
        *bad = unit.is_none();
        v.normal = unit.unwrap_or(Vec3::ZERO).to_array();
    }
    let count = bad.iter().filter(|b| **b).count();
    if count == 0 {
        return None;
    }
    for t in indices.chunks_exact(3) {
        let face = face_normal([0, 1, 2].map(|i| vertices[t[i] as usize].position));
        for i in t.iter().map(|i| *i as usize).filter(|i| bad[*i]) {
            vertices[i].normal = (Vec3::from(vertices[i].normal) + face).to_array();
        }
    }
    for (v, _) in vertices.iter_mut().zip(&bad).filter(|(_, bad)| **bad) {
        v.normal = Vec3::from(v.normal).normalize_or_zero().to_array();
    }
    Some(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_the_winding() {
        let mut w = Remarks::default();
        let corners = vec![0, 1, 2, 3, 4];
        assert_eq!(triangles(Mode::TriangleStrip, corners.clone(), &mut w, ""), [0, 1, 2, 1, 3, 2, 2, 3, 4]);
        assert_eq!(triangles(Mode::TriangleFan, corners.clone(), &mut w, ""), [1, 2, 0, 2, 3, 0, 3, 4, 0]);
        assert!(w.clone().finish(std::path::Path::new("")).0.is_empty());
        assert_eq!(triangles(Mode::Triangles, corners, &mut w, ""), [0, 1, 2]);
        assert_eq!(w.finish(std::path::Path::new("")).0.len(), 1);
    }
}
