//! Import of glTF 2.0 (`.gltf` and `.glb`): node hierarchy, triangle meshes with skins
//! and morph targets, materials, cameras, punctual lights and animations.
//!
//! The file is not trusted: sizes, ranges, references and paths are checked before they are used, so that a broken or
//! hostile file gives an [`AssetError`] and nothing else.

mod accessor;
mod animation;
mod attribute;
mod content;
mod document;
mod draco;
mod face_normal;
#[cfg(test)]
mod fuzz_tests;
mod import;
mod instances;
mod layers;
mod material;
mod mend;
mod meshopt;
#[cfg(test)]
mod model_tests;
mod nodes;
mod primitive;
mod reader;
mod remarks;
#[cfg(test)]
pub(crate) mod rig_tests;
mod skin;
mod source;
mod specular_glossiness;
mod tangents;
#[cfg(test)]
mod tests;
mod texture_use;
mod thin;
mod units;
mod uri;

pub use content::{GltfCamera, GltfLight, GltfNode, GltfPrimitive, GltfSkin};
pub use import::{ImportFault, ImportSettings, Normals, Parts, UpAxis};
pub use units::{LightConversion, LightUnits};

use super::{AssetError, Clip, Meter, parallel, read_file};
use accessor::Buffers;
use reader::{Job, Reader};
use remarks::Remarks;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most vertices and corners of all meshes of a file together.
const MAX_CORNERS: usize = 1 << 27;

/// The content of a glTF file.
#[derive(Clone, Debug)]
pub struct Gltf {
    /// The file.
    pub path: PathBuf,
    /// The program that wrote it, by its own account; empty if the file does not say.
    pub generator: String,
    /// All nodes, by their index in the file, those outside the scene too.
    pub nodes: Vec<GltfNode>,
    /// The top nodes of the file's default scene; of its first scene if it names none; else all that have no parent.
    pub roots: Vec<usize>,
    /// Skins, by their index in the file.
    pub skins: Vec<Arc<GltfSkin>>,
    /// Animations, by their index in the file.
    pub clips: Arc<Vec<Clip>>,
    /// Buffers and images beside the file that it was made from.
    pub files: Vec<PathBuf>,
    /// Warnings of what was changed on import. They were logged too.
    pub warnings: Vec<String>,
    /// Those that say what was broken, and mended or left out.
    pub faults: Vec<String>,
}

impl Gltf {
    /// Loads a `.gltf` or `.glb` file with all buffers and images it uses, on all cores.
    ///
    /// # Errors
    /// A file that is missing, truncated or not glTF 2.0, needs an extension that is not supported, refers to what is
    /// not there (or is outside its folder), or holds positions that are not finite. The message names file and place.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, AssetError> {
        Self::load_within(path.as_ref(), &Meter::default())
    }

    /// As [`Gltf::load`], within the budget of a load.
    pub(crate) fn load_within(path: &Path, meter: &Meter) -> Result<Self, AssetError> {
        let bytes = read_file(path, meter)?;
        Self::read(path, &bytes, meter)
    }

    /// As [`Gltf::load`], from the content of the file. `path` is used for messages and to find the files beside it.
    ///
    /// # Errors
    /// As [`Gltf::load`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, AssetError> {
        Self::read(path, bytes, &Meter::default())
    }

    fn read(path: &Path, bytes: &[u8], meter: &Meter) -> Result<Self, AssetError> {
        let mut remarks = Remarks::default();
        let mut beside = source::Beside { files: Vec::new(), meter };
        let container = source::split(path, bytes, &mut remarks)?;
        let (document, quantized) = document::parse(path, container.json, &mut remarks)?;
        let data = document::load_buffers(path, &document, container.bin, &mut beside, &mut remarks)?;
        let mut reader = Reader { buffers: Buffers::new(path, data), quantized };
        reader.buffers.decoded = meshopt::decode(&document, &reader.buffers, &mut remarks)?;
        let (replaced, lost) = draco::decode(&document, &reader.buffers, &mut remarks)?;
        (reader.buffers.replaced, reader.buffers.lost) = (replaced, lost);
        let (mut nodes, roots) = nodes::read(path, &document, &mut remarks);
        let image_bytes = |view: &gltf::buffer::View| reader.buffers.view(view).map(<[u8]>::to_vec);
        let materials = material::load(path, &document, &image_bytes, &mut beside, &mut remarks)?;
        let meshes = load_meshes(&document, &reader, &materials, meter, &mut remarks)?;
        for (node, json) in nodes.iter_mut().zip(&document.as_json().nodes) {
            let mesh = json.mesh.map(|m| m.value());
            node.primitives = mesh.and_then(|m| meshes.get(m)).cloned().unwrap_or_default();
            node.skin = json.skin.map(|s| s.value());
            let copies = instances::read(&document, &reader.buffers, json, &format!("node \"{}\"", node.name));
            node.instances = remarks.part(copies, "it is drawn once")?.unwrap_or_default();
            if instances::has_more(json) {
                remarks.push(format!("node \"{}\": its instances have attributes that are not used", node.name));
            }
            node.weights = weights(node, json, mesh.map(|m| &document.as_json().meshes[m]), &mut remarks);
        }
        let skins = skin::read(&document, &reader.buffers, &mut remarks)?;
        skin::check(&mut nodes, &skins, &mut remarks);
        let clips = Arc::new(animation::read(&document, &reader.buffers, &nodes, &mut remarks)?);
        document::check_data(&document, &reader.buffers, &mut remarks);
        if !document.as_json().meshes.is_empty() && meshes.iter().all(Vec::is_empty) {
            remarks.fault("the file has meshes, but nothing of them can be drawn".into());
        }
        let generator = document.as_json().asset.generator.clone().unwrap_or_default();
        let (warnings, faults) = remarks.finish(path);
        let files = beside.files;
        Ok(Self { path: path.to_path_buf(), generator, nodes, roots, skins, clips, files, warnings, faults })
    }

    /// The first node of that name.
    pub fn node(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|n| n.name == name)
    }

    /// Triangles of the scene: of all nodes below the roots, shared meshes counted each time.
    pub fn triangle_count(&self) -> usize {
        let mut open = self.roots.clone();
        let mut count = 0;
        while let Some(node) = open.pop() {
            let node = &self.nodes[node];
            let triangles: usize = node.primitives.iter().map(|(mesh, _)| mesh.triangle_count()).sum();
            count += triangles * node.instances.len().max(1);
            open.extend(&node.children);
        }
        count
    }
}

/// Weights of the node's morph targets: its own, or else its mesh's; zero where they are missing or not finite. There are as
/// many as the primitive with the most targets has.
fn weights(
    node: &GltfNode,
    json: &gltf::json::Node,
    mesh: Option<&gltf::json::Mesh>,
    remarks: &mut Remarks,
) -> Vec<f32> {
    let counts = node.primitives.iter().map(|(mesh, _)| mesh.deform.as_ref().map_or(0, |d| d.targets.len()));
    let most = counts.max().unwrap_or(0);
    let given = json.weights.as_ref().or(mesh.and_then(|m| m.weights.as_ref()));
    if let Some(given) = given.filter(|given| given.len() != most && !node.primitives.is_empty()) {
        remarks.fault(format!("node \"{}\": {} weights for {most} morph targets", node.name, given.len()));
    }
    let weight = |i: usize| given.and_then(|w| w.get(i)).copied().filter(|w| w.is_finite()).unwrap_or(0.0);
    (0..most).map(weight).collect()
}

/// Loads the primitives of all meshes in parallel; primitives that read the same data in the same way are one.
fn load_meshes(
    document: &gltf::Document,
    reader: &Reader,
    materials: &material::Materials,
    meter: &Meter,
    remarks: &mut Remarks,
) -> Result<Vec<Vec<GltfPrimitive>>, AssetError> {
    let (mut jobs, mut known, mut uses, mut corners) = (Vec::new(), HashMap::new(), Vec::new(), 0usize);
    for mesh in document.meshes() {
        let name = mesh.name().map_or(format!("mesh {}", mesh.index()), str::to_string);
        let targets = || mesh.primitives().map(|primitive| primitive.morph_targets().len());
        if let (Some(least), Some(most)) = (targets().min(), targets().max())
            && least != most
        {
            let problem = format!("has primitives with {least} and with {most} morph targets; all should have as many");
            remarks.fault(format!("mesh {} \"{name}\": {problem}", mesh.index()));
        }
        for primitive in mesh.primitives() {
            let (surface, uv) = materials.get(primitive.material().index());
            let attributes: Vec<_> = primitive.attributes().map(|(s, a)| (format!("{s:?}"), a.index())).collect();
            let targets: Vec<_> = primitive
                .morph_targets()
                .map(|t| [t.positions(), t.normals(), t.tangents()].map(|a| a.map(|a| a.index())))
                .collect();
            let shape = (attributes, targets, primitive.indices().map(|a| a.index()), primitive.mode().as_gl_enum());
            let next = jobs.len();
            let index = *known.entry((shape, uv.key())).or_insert(next);
            if index == next {
                let counts = primitive.get(&gltf::Semantic::Positions).map_or(0, |a| a.count());
                corners = corners.saturating_add(counts.saturating_mul(1 + primitive.morph_targets().len()));
                // A corner of a line becomes up to 48 of its solid.
                let each = if thin::is_thin(primitive.mode()) { 48 } else { 3 };
                let drawn = primitive.indices().map_or(counts, |a| a.count()).saturating_mul(each);
                meter.triangles(reader.buffers.path, drawn as u64 / 3)?;
                corners = corners.saturating_add(drawn);
                let place = format!("mesh {} \"{name}\", primitive {}", mesh.index(), primitive.index());
                if corners > MAX_CORNERS {
                    let problem = format!("the file's meshes are too large: over {MAX_CORNERS} corners");
                    return Err(AssetError::format(reader.buffers.path, place, problem));
                }
                let name = if primitive.index() == 0 { name.clone() } else { format!("{name}.{}", primitive.index()) };
                jobs.push(Job { primitive, name, place, uv });
            }
            uses.push((mesh.index(), index, surface));
        }
    }
    let mut loaded = Vec::with_capacity(jobs.len());
    for result in parallel::map(&jobs, |job| reader.load(job)) {
        let part = remarks.part(result, "left out")?;
        loaded.push(part.and_then(|(mesh, found)| {
            remarks.append(found);
            mesh.map(Arc::new)
        }));
    }
    let mut meshes = vec![Vec::new(); document.meshes().len()];
    for (mesh, index, surface) in uses {
        if let Some(triangles) = &loaded[index] {
            meshes[mesh].push((triangles.clone(), surface));
        }
    }
    Ok(meshes)
}
