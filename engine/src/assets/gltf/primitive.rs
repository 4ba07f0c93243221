//! Mesh primitives: triangles of any topology as indexed lists, with normals and tangents for every vertex.

use super::accessor::{Buffers, place};
use super::face_normal::face_normal;
use super::material::UvSource;
use super::{tangents, thin};
use crate::assets::{AssetError, Deform, Mesh, Vertex, VertexExtra};
use glam::Vec3;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::mesh::{Mode, Primitive, Semantic};
use std::sync::Arc;

/// How to read primitives.
pub(super) struct Reader<'a> {
    pub buffers: Buffers<'a>,
    /// `KHR_mesh_quantization`: integer positions, normals and tangents.
    pub quantized: bool,
}

/// A primitive with what its material asks for.
pub(super) struct Job<'a> {
    pub primitive: Primitive<'a>,
    pub name: String,
    /// Where messages say it is.
    pub place: String,
    pub uv: UvSource,
}

/// A mesh, or none for what has no triangles, and remarks.
pub(super) type Loaded = (Option<Mesh>, Vec<String>);

struct Attributes {
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    tangents: Option<Vec<[f32; 4]>>,
    uvs: [Option<Vec<[f32; 2]>>; 2],
    colors: Option<Vec<[f32; 4]>>,
}

impl Reader<'_> {
    /// Reads a primitive.
    pub fn load(&self, job: &Job) -> Result<Loaded, AssetError> {
        let mut warnings = Vec::new();
        let mode = job.primitive.mode();
        let Some(positions) = job.primitive.get(&Semantic::Positions) else {
            return Ok((None, vec![format!("{}: has no positions and is not drawn", job.place)]));
        };
        let attributes = self.attributes(job, &positions)?;
        let corners = self.corners(job, attributes.positions.len())?;
        if thin::is_thin(mode) {
            return self.load_thin(job, attributes, &corners);
        }
        let mut indices = triangles(mode, corners, &mut warnings, &job.place);
        if indices.is_empty() {
            return Ok((None, vec![format!("{}: has no triangle and is not drawn", job.place)]));
        }
        let flat = attributes.normals.is_none();
        let given_tangents = attributes.tangents.is_some() && !flat;
        let mut own = Mesh::new("", Vec::new(), Vec::new());
        own.extras = extras(&attributes).map(Arc::new);
        own.deform = self.deform(job, attributes.positions.len())?.map(|d| Arc::new(Deform { flat, ..d }));
        let mut vertices = weave(attributes);
        // Vertices are copied and reordered below; this is where each was.
        let mut origins: Vec<u32> = (0..vertices.len() as u32).collect();
        if flat {
            vertices = indices.iter().map(|i| vertices[*i as usize]).collect();
            origins = std::mem::replace(&mut indices, (0..vertices.len() as u32).collect());
            flat_normals(&mut vertices);
        } else if let Some(repaired) = repair_normals(&mut vertices, &indices) {
            warnings.push(format!("{}: {repaired} normals are not finite or have no length; replaced", job.place));
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
    fn load_thin(&self, job: &Job, attributes: Attributes, corners: &[u32]) -> Result<Loaded, AssetError> {
        let mut own = Mesh::new("", Vec::new(), Vec::new());
        own.extras = extras(&attributes).map(Arc::new);
        own.deform = self.deform(job, attributes.positions.len())?.map(|d| Arc::new(Deform { flat: true, ..d }));
        let (mut vertices, origins) = thin::solids(job.primitive.mode(), &weave(attributes), corners);
        if vertices.is_empty() {
            return Ok((None, vec![format!("{}: its lines have no length and are not drawn", job.place)]));
        }
        vertices.iter_mut().for_each(|v| v.tangent = tangents::sound(v.normal, v.tangent));
        let indices = (0..vertices.len() as u32).collect();
        let mut mesh = Mesh::new(job.name.clone(), vertices, indices);
        mesh.carry(&own, &origins);
        Ok((Some(mesh), Vec::new()))
    }

    fn attributes<'a>(&self, job: &Job<'a>, positions: &Accessor) -> Result<Attributes, AssetError> {
        let count = positions.count();
        let optional = |semantic: Semantic| self.counted(job, semantic, count);
        let directions = |semantic: Semantic| {
            let accessor = optional(semantic)?;
            accessor.as_ref().map_or(Ok(()), |a| self.float_only(job, a))?;
            Ok::<_, AssetError>(accessor)
        };
        self.float_only(job, positions)?;
        let normals = directions(Semantic::Normals)?;
        let tangents = directions(Semantic::Tangents)?;
        let uvs = [self.uvs(job, optional(Semantic::TexCoords(job.uv.sets[0]))?)?, {
            let second = if job.uv.uses_second { optional(Semantic::TexCoords(job.uv.sets[1]))? } else { None };
            self.uvs(job, second)?
        }];
        let colors = optional(Semantic::Colors(0))?;
        let found = Attributes {
            positions: self.buffers.vectors(positions)?,
            normals: normals.as_ref().map(|a| self.buffers.vectors(a)).transpose()?,
            tangents: tangents.as_ref().map(|a| self.buffers.vectors(a)).transpose()?,
            uvs,
            colors: colors.as_ref().map(|a| self.colors(job, a)).transpose()?,
        };
        self.finite(job, positions, &found.positions)?;
        Ok(found)
    }

    fn uvs(&self, job: &Job, accessor: Option<Accessor>) -> Result<Option<Vec<[f32; 2]>>, AssetError> {
        let Some(a) = accessor else { return Ok(None) };
        if !is_float_or_unit(&a) && !self.quantized {
            return Err(self.fail(
                job,
                &a,
                "texture coordinates must be floats or normalised unsigned integers".into(),
            ));
        }
        let values = self.buffers.vectors(&a)?;
        self.finite(job, &a, &values)?;
        Ok(Some(values))
    }

    /// Colours of three or four components, clamped to 0 to 1.
    fn colors(&self, job: &Job, accessor: &Accessor) -> Result<Vec<[f32; 4]>, AssetError> {
        if !is_float_or_unit(accessor) {
            return Err(self.fail(job, accessor, "colours must be floats or normalised unsigned integers".into()));
        }
        let mut colors: Vec<[f32; 4]> = match accessor.dimensions() {
            Dimensions::Vec3 => self.buffers.vectors::<3>(accessor)?.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
            _ => self.buffers.vectors::<4>(accessor)?,
        };
        self.finite(job, accessor, &colors)?;
        colors.as_flattened_mut().iter_mut().for_each(|c| *c = c.clamp(0.0, 1.0));
        Ok(colors)
    }

    /// An attribute, if it is there, with as many elements as there are vertices.
    pub(super) fn counted<'a>(
        &self,
        job: &Job<'a>,
        semantic: Semantic,
        count: usize,
    ) -> Result<Option<Accessor<'a>>, AssetError> {
        let accessor = job.primitive.get(&semantic);
        match &accessor {
            Some(a) if a.count() != count => {
                Err(self.fail(job, a, format!("{} elements, but {count} positions", a.count())))
            }
            _ => Ok(accessor),
        }
    }

    pub(super) fn wrong(&self, job: &Job, problem: String) -> AssetError {
        AssetError::format(self.buffers.path, &job.place, problem)
    }

    pub(super) fn fail(&self, job: &Job, accessor: &Accessor, problem: String) -> AssetError {
        AssetError::format(self.buffers.path, format!("{}, {}", job.place, place(accessor)), problem)
    }

    pub(super) fn float_only(&self, job: &Job, accessor: &Accessor) -> Result<(), AssetError> {
        if accessor.data_type() == DataType::F32 || self.quantized {
            return Ok(());
        }
        let problem = format!("{:?} components need the extension KHR_mesh_quantization", accessor.data_type());
        Err(self.fail(job, accessor, problem))
    }

    pub(super) fn finite<const N: usize>(
        &self,
        job: &Job,
        accessor: &Accessor,
        values: &[[f32; N]],
    ) -> Result<(), AssetError> {
        match values.iter().position(|v| v.iter().any(|x| !x.is_finite())) {
            Some(i) => Err(self.fail(job, accessor, format!("element {i} is {:?}: not a finite number", values[i]))),
            None => Ok(()),
        }
    }

    /// The vertex of each corner, in order.
    fn corners(&self, job: &Job, count: usize) -> Result<Vec<u32>, AssetError> {
        let Some(accessor) = job.primitive.indices() else {
            return Ok((0..count as u32).collect());
        };
        let indices = self.buffers.indices(&accessor)?;
        match indices.iter().position(|i| *i as usize >= count) {
            Some(at) => Err(self.fail(
                job,
                &accessor,
                format!("index {} at {at} is out of range: there are {count} vertices", indices[at]),
            )),
            None => Ok(indices),
        }
    }
}

/// Turns strips and fans into lists (glTF 2.0, section 3.7.2.1), keeping the winding.
fn triangles(mode: Mode, mut corners: Vec<u32>, warnings: &mut Vec<String>, place: &str) -> Vec<u32> {
    match mode {
        Mode::TriangleStrip => {
            (2..corners.len()).flat_map(|i| [corners[i - 2], corners[i - 1 + i % 2], corners[i - i % 2]]).collect()
        }
        Mode::TriangleFan => (2..corners.len()).flat_map(|i| [corners[i - 1], corners[i], corners[0]]).collect(),
        _ => {
            let surplus = corners.len() % 3;
            if surplus > 0 {
                warnings.push(format!("{place}: the last {surplus} corners make no triangle"));
                corners.truncate(corners.len() - surplus);
            }
            corners
        }
    }
}

fn is_float_or_unit(a: &Accessor) -> bool {
    a.data_type() == DataType::F32 || (a.normalized() && matches!(a.data_type(), DataType::U8 | DataType::U16))
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
        let mut w = Vec::new();
        let corners = vec![0, 1, 2, 3, 4];
        assert_eq!(triangles(Mode::TriangleStrip, corners.clone(), &mut w, ""), [0, 1, 2, 1, 3, 2, 2, 3, 4]);
        assert_eq!(triangles(Mode::TriangleFan, corners.clone(), &mut w, ""), [1, 2, 0, 2, 3, 0, 3, 4, 0]);
        assert!(w.is_empty());
        assert_eq!(triangles(Mode::Triangles, corners, &mut w, ""), [0, 1, 2]);
        assert_eq!(w.len(), 1);
    }
}
