//! Primitives compressed by Draco: `KHR_draco_mesh_compression`.

use super::accessor::{Buffers, place};
use super::remarks::Remarks;
use crate::assets::{AssetError, parallel};
use draco_core::{DecodeLimits, DecoderBuffer, FaceIndex, MeshDecoder, PointAttribute, PointIndex};
use gltf::accessor::{Accessor, DataType};
use gltf::json::Value;
use gltf::mesh::{Mode, Primitive, Semantic};
use gltf::{Document, json};
use std::collections::{HashMap, HashSet};

/// Its name.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// Most points and triangles of a primitive, and most bytes of its attributes.
const LIMITS: [u64; 3] = [1 << 24, 1 << 25, 1 << 30];
/// Most bytes that all primitives may decode to together.
const MAX_BYTES: usize = 1 << 30;

/// A compressed primitive.
struct Packed<'a> {
    primitive: Primitive<'a>,
    place: String,
    bytes: &'a [u8],
    /// Draco's identity of each attribute.
    ids: HashMap<String, u32>,
}

/// What becomes of a primitive that cannot be decoded.
const UNPACKED: &str = "its uncompressed form is read, if there is one";

/// The content of accessors, tightly packed, by their index.
type Contents = HashMap<usize, Vec<u8>>;

/// Decodes all compressed primitives: what their accessors hold, and the accessors that hold nothing since their primitive is
/// broken.
pub(super) fn decode(
    document: &Document,
    buffers: &Buffers,
    remarks: &mut Remarks,
) -> Result<(Contents, HashSet<usize>), AssetError> {
    let (mut packed, mut lost) = (Vec::new(), HashSet::new());
    for (mesh, source) in document.meshes().zip(&document.as_json().meshes) {
        for (primitive, source) in mesh.primitives().zip(&source.primitives) {
            if let Some(found) = source.extensions.as_ref().and_then(|e| e.others.get(NAME)) {
                let place = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
                let document_primitive = primitive.clone();
                let result = read(primitive, found, place, document, buffers);
                match remarks.part(result, UNPACKED)? {
                    Some(one) => packed.push(one),
                    None => lost.extend(uncompressed(&document_primitive)),
                }
            }
        }
    }
    let fail = |one: &Packed, problem: String| AssetError::format(buffers.path, &one.place, problem);
    let total: usize = packed.iter().flat_map(Packed::accessors).map(|(_, a)| a.count().saturating_mul(a.size())).sum();
    if total > MAX_BYTES {
        let problem = format!("the compressed primitives decode to {total} bytes; at most {MAX_BYTES}");
        return Err(AssetError::format(buffers.path, "meshes", problem));
    }
    let decoded = parallel::map(&packed, |one| one.decode().map_err(|problem| fail(one, problem)));
    let mut contents = Contents::new();
    for (Packed { primitive, .. }, one) in packed.iter().zip(decoded) {
        match remarks.part(one, UNPACKED)? {
            Some(found) => contents.extend(found),
            None => lost.extend(uncompressed(primitive)),
        }
    }
    lost.retain(|index| !contents.contains_key(index));
    Ok((contents, lost))
}

/// The accessors of a primitive that have no uncompressed contents.
fn uncompressed(primitive: &Primitive) -> Vec<usize> {
    let attributes = primitive.attributes().map(|(_, accessor)| accessor);
    let all = attributes.chain(primitive.indices());
    all.filter(|accessor| accessor.view().is_none() && accessor.sparse().is_none()).map(|a| a.index()).collect()
}

fn read<'a>(
    primitive: Primitive<'a>,
    extension: &Value,
    place: String,
    document: &'a Document,
    buffers: &'a Buffers,
) -> Result<Packed<'a>, AssetError> {
    let fail = |problem: String| Err(AssetError::format(buffers.path, &place, problem));
    let index = extension.get("bufferView").and_then(Value::as_u64);
    let Some(view) = index.and_then(|i| document.views().nth(usize::try_from(i).ok()?)) else {
        return fail(format!("{NAME} names no buffer view of the file"));
    };
    let Some(attributes) = extension.get("attributes").and_then(Value::as_object) else {
        return fail(format!("{NAME} lists no attributes"));
    };
    if primitive.mode() != Mode::Triangles {
        return fail(format!("{NAME} with {:?} is not read: export it as triangles", primitive.mode()));
    }
    let mut ids = HashMap::new();
    for (name, id) in attributes {
        match id.as_u64().and_then(|id| u32::try_from(id).ok()) {
            Some(id) => ids.insert(name.clone(), id),
            None => return fail(format!("{NAME}: the identity of {name} is no number")),
        };
    }
    Ok(Packed { bytes: buffers.view(&view)?, primitive, place, ids })
}

impl Packed<'_> {
    /// The accessors that Draco's data replaces, with Draco's identity; none for the indices.
    fn accessors(&self) -> impl Iterator<Item = (Option<u32>, Accessor<'_>)> {
        let attribute = |(semantic, accessor): (Semantic, _)| {
            let name = json::mesh::Semantic::to_string(&semantic);
            self.ids.get(&name).map(|id| (Some(*id), accessor))
        };
        self.primitive.attributes().filter_map(attribute).chain(self.primitive.indices().map(|a| (None, a)))
    }

    fn decode(&self) -> Result<Contents, String> {
        let [points, faces, bytes] = LIMITS;
        let limits =
            DecodeLimits::default().with_max_points(points).with_max_faces(faces).with_max_decoded_bytes(bytes);
        let mut buffer = DecoderBuffer::new(self.bytes).with_limits(limits);
        let mut mesh = draco_core::Mesh::new();
        let broken = |error| format!("the compressed data is broken: {error}");
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(broken)?;
        let mut contents = Contents::new();
        for (id, accessor) in self.accessors() {
            let count = if id.is_some() { mesh.num_points() } else { 3 * mesh.num_faces() };
            if accessor.count() != count {
                let wanted = accessor.count();
                return Err(format!("{} has {wanted} elements, but the compressed data {count}", place(&accessor)));
            }
            let bytes = match id {
                None => indices(&mesh, accessor.data_type())?,
                Some(id) => {
                    let attribute = mesh.attribute_by_unique_id(id);
                    let attribute = attribute.ok_or_else(|| format!("the compressed data has no attribute {id}"))?;
                    values(attribute, &accessor, count)?
                }
            };
            contents.insert(accessor.index(), bytes);
        }
        Ok(contents)
    }
}

/// Corners of all triangles, in the type of the accessor.
fn indices(mesh: &draco_core::Mesh, kind: DataType) -> Result<Vec<u8>, String> {
    let size = kind.size();
    let most = u32::MAX >> (32 - 8 * size as u32);
    let mut bytes = Vec::with_capacity(3 * size * mesh.num_faces());
    for face in 0..mesh.num_faces() {
        for corner in mesh.face(FaceIndex(face as u32)) {
            if corner.0 > most || corner.0 as usize >= mesh.num_points() {
                return Err(format!("the compressed data has the index {}", corner.0));
            }
            bytes.extend(&corner.0.to_le_bytes()[..size]);
        }
    }
    Ok(bytes)
}

/// The value of each point.
fn values(attribute: &PointAttribute, accessor: &Accessor, count: usize) -> Result<Vec<u8>, String> {
    let same = match accessor.data_type() {
        DataType::I8 => draco_core::DataType::Int8,
        DataType::U8 => draco_core::DataType::Uint8,
        DataType::I16 => draco_core::DataType::Int16,
        DataType::U16 => draco_core::DataType::Uint16,
        DataType::U32 => draco_core::DataType::Uint32,
        DataType::F32 => draco_core::DataType::Float32,
    };
    let components = usize::from(attribute.num_components());
    if attribute.data_type() != same || components != accessor.dimensions().multiplicity() {
        let found = format!("{components} components of {:?}", attribute.data_type());
        return Err(format!("{} is of another type than the compressed data, which has {found}", place(accessor)));
    }
    let (data, stride) = (attribute.buffer().data(), usize::try_from(attribute.byte_stride()).unwrap_or(0));
    let mut bytes = Vec::with_capacity(count * accessor.size());
    for point in 0..count {
        let first = attribute.mapped_index(PointIndex(point as u32)).0 as usize * stride;
        let value = data.get(first..first.saturating_add(accessor.size()));
        bytes.extend(value.ok_or("the compressed data ends too early")?);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::assets::Gltf;
    use draco_core::{EncoderBuffer, EncoderOptions, GeometryAttributeType, MeshEncoder, PointAttribute, PointIndex};
    use std::path::Path;

    /// A square of two triangles, compressed.
    fn square() -> Vec<u8> {
        let mut mesh = draco_core::Mesh::new();
        mesh.set_num_points(4);
        let mut position = PointAttribute::new();
        position.init(GeometryAttributeType::Position, 3, draco_core::DataType::Float32, false, 4);
        for (i, corner) in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]].iter().enumerate() {
            position.buffer_mut().write(12 * i, bytemuck::bytes_of(corner));
        }
        mesh.add_attribute(position);
        mesh.set_num_faces(2);
        mesh.set_face(draco_core::FaceIndex(0), [PointIndex(0), PointIndex(1), PointIndex(2)]);
        mesh.set_face(draco_core::FaceIndex(1), [PointIndex(2), PointIndex(1), PointIndex(3)]);
        let mut encoder = MeshEncoder::new();
        encoder.set_mesh(mesh);
        let mut out = EncoderBuffer::new();
        encoder.encode(&EncoderOptions::new(), &mut out).unwrap();
        out.data().to_vec()
    }

    fn load(data: &[u8], points: usize, attributes: &str) -> Result<Gltf, String> {
        let name = super::NAME;
        let mut json = format!(
            r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["{name}"],"extensionsRequired":["{name}"],
            "buffers":[{{"byteLength":{size}}}],"bufferViews":[{{"buffer":0,"byteLength":{size}}}],
            "accessors":[{{"componentType":5126,"count":{points},"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
              {{"componentType":5121,"count":6,"type":"SCALAR"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,
              "extensions":{{"{name}":{{"bufferView":0,"attributes":{attributes}}}}}}}]}}],"nodes":[{{"mesh":0}}]}}"#,
            size = data.len()
        );
        while !json.len().is_multiple_of(4) {
            json.push(' ');
        }
        let mut bin = data.to_vec();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let words = |list: &[usize]| list.iter().flat_map(|w| (*w as u32).to_le_bytes()).collect::<Vec<u8>>();
        let mut glb = words(&[0x4654_6C67, 2, 28 + json.len() + bin.len(), json.len(), 0x4E4F_534A]);
        glb.extend(json.as_bytes());
        glb.extend(words(&[bin.len(), 0x004E_4942]));
        glb.extend(bin);
        // What is left of a model that is broken has no triangle.
        let model = Gltf::from_bytes(Path::new("m.glb"), &glb).map_err(|e| e.to_string())?;
        match model.faults.is_empty() {
            true => Ok(model),
            false => Err(format!("{} triangles: {:?}", model.triangle_count(), model.faults)),
        }
    }

    #[test]
    fn compressed_triangles_are_read() {
        let model = load(&square(), 4, r#"{"POSITION":0}"#).unwrap();
        let mesh = &model.nodes[0].primitives[0].0;
        let area: f32 = mesh
            .indices
            .as_chunks::<3>()
            .0
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|i| glam::Vec3::from(mesh.vertices[i as usize].position));
                0.5 * (b - a).cross(c - a).z
            })
            .sum();
        assert_eq!(model.triangle_count(), 2);
        assert!((area - 1.0).abs() < 1e-3, "{area}");
    }

    #[test]
    fn faults_are_named() {
        for (points, attributes, said) in [
            (5, r#"{"POSITION":0}"#, "accessor 0 has 5 elements, but the compressed data 4"),
            (4, r#"{"POSITION":7}"#, "no attribute 7"),
            (4, r#"{"POSITION":"a"}"#, "is no number"),
            (4, "3", "lists no attributes"),
        ] {
            let message = load(&square(), points, attributes).unwrap_err();
            assert!(message.contains(said) && message.contains("mesh 0, primitive 0"), "{message}");
            assert!(message.starts_with("0 triangles"), "{message}");
        }
    }

    /// Whatever the compressed bytes are, there is an answer.
    #[test]
    fn broken_data_is_refused() {
        let data = square();
        let mut refused = 0;
        for at in 0..data.len() {
            for value in [0, 1, 0x7f, 0xff] {
                let mut broken = data.clone();
                broken[at] = value;
                refused += u32::from(load(&broken, 4, r#"{"POSITION":0}"#).is_err());
            }
            assert!(at == 0 || load(&data[..at], 4, r#"{"POSITION":0}"#).is_err(), "cut after {at} bytes");
        }
        assert!(refused > 50, "{refused} of {} refused", 4 * data.len());
    }
}
