//! Bindings, entry points and struct layouts as the shader declares them: the one place where they stand.

use super::compose::CompiledShader;
use wgpu::naga::{self, AddressSpace, ImageClass, ImageDimension, ScalarKind, StorageAccess, TypeInner};

/// A variable that a shader binds.
#[derive(Clone, Debug)]
pub struct BindingInfo {
    /// Its name in WGSL.
    pub name: String,
    /// `@group`.
    pub group: u32,
    /// `@binding`.
    pub binding: u32,
    /// Kind, as a layout entry has it.
    pub ty: wgpu::BindingType,
    /// Stages that use it.
    pub visibility: wgpu::ShaderStages,
}

impl BindingInfo {
    /// Takes in what another stage needs of the same variable.
    pub(super) fn join(&mut self, other: &Self) {
        self.visibility |= other.visibility;
        if let (Some(true), wgpu::BindingType::Texture { sample_type, .. }) = (is_filtered(other.ty), &mut self.ty) {
            *sample_type = wgpu::TextureSampleType::Float { filterable: true };
        }
    }
}

fn is_filtered(ty: wgpu::BindingType) -> Option<bool> {
    match ty {
        wgpu::BindingType::Texture { sample_type: wgpu::TextureSampleType::Float { filterable }, .. } => {
            Some(filterable)
        }
        _ => None,
    }
}

/// An entry point with the bindings that it uses.
#[derive(Clone, Debug)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// Stage.
    pub stage: wgpu::ShaderStages,
    /// Compute: threads of a workgroup.
    pub workgroup_size: [u32; 3],
    /// Bindings, in order of group and binding.
    pub bindings: Vec<BindingInfo>,
}

/// Memory layout of a WGSL struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// Size \[bytes\].
    pub size: u32,
    /// Members: name and offset \[bytes\].
    pub members: Vec<(String, u32)>,
}

/// All entry points. The error says which binding is of no kind that a pipeline can hold.
pub(super) fn entry_points(shader: &CompiledShader) -> Result<Vec<EntryPoint>, String> {
    let described = |(index, entry): (usize, &naga::EntryPoint)| {
        let stage = match entry.stage {
            naga::ShaderStage::Vertex => wgpu::ShaderStages::VERTEX,
            naga::ShaderStage::Fragment => wgpu::ShaderStages::FRAGMENT,
            _ => wgpu::ShaderStages::COMPUTE,
        };
        let bindings = bindings(shader, index, stage)?;
        Ok(EntryPoint { name: entry.name.clone(), stage, workgroup_size: entry.workgroup_size, bindings })
    };
    shader.module.entry_points.iter().enumerate().map(described).collect()
}

fn bindings(shader: &CompiledShader, index: usize, stage: wgpu::ShaderStages) -> Result<Vec<BindingInfo>, String> {
    let info = shader.info.get_entry_point(index);
    let mut found = Vec::new();
    for (handle, variable) in shader.module.global_variables.iter() {
        let (Some(place), false) = (&variable.binding, info[handle].is_empty()) else { continue };
        let name = plain_name(variable.name.as_deref().unwrap_or_default()).to_string();
        let filtered =
            info.sampling_set.iter().any(|key| key.image == handle && !is_comparison(&shader.module, key.sampler));
        let ty = binding_type(&shader.module, variable, filtered).map_err(|what| format!("`{name}`: {what}"))?;
        found.push(BindingInfo { name, group: place.group, binding: place.binding, ty, visibility: stage });
    }
    found.sort_by_key(|binding| (binding.group, binding.binding));
    Ok(found)
}

fn is_comparison(module: &naga::Module, sampler: naga::Handle<naga::GlobalVariable>) -> bool {
    matches!(module.types[module.global_variables[sampler].ty].inner, TypeInner::Sampler { comparison: true })
}

fn binding_type(
    module: &naga::Module,
    variable: &naga::GlobalVariable,
    filtered: bool,
) -> Result<wgpu::BindingType, String> {
    let inner = &module.types[variable.ty].inner;
    match variable.space {
        AddressSpace::Uniform => Ok(buffer(wgpu::BufferBindingType::Uniform, inner.size(module.to_ctx()))),
        AddressSpace::Storage { access } => {
            let read_only = !access.contains(StorageAccess::STORE);
            Ok(buffer(wgpu::BufferBindingType::Storage { read_only }, inner.size(module.to_ctx())))
        }
        _ => match *inner {
            TypeInner::Sampler { comparison: true } => {
                Ok(wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison))
            }
            TypeInner::Sampler { comparison: false } => {
                Ok(wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering))
            }
            TypeInner::Image { dim, arrayed, class } => image(dim, arrayed, class, filtered),
            _ => Err("a binding must be a buffer, a texture or a sampler".into()),
        },
    }
}

fn buffer(ty: wgpu::BufferBindingType, size: u32) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: std::num::NonZeroU64::new(size.into()),
    }
}

fn image(dim: ImageDimension, arrayed: bool, class: ImageClass, filtered: bool) -> Result<wgpu::BindingType, String> {
    let view_dimension = match (dim, arrayed) {
        (ImageDimension::D1, _) => wgpu::TextureViewDimension::D1,
        (ImageDimension::D2, false) => wgpu::TextureViewDimension::D2,
        (ImageDimension::D2, true) => wgpu::TextureViewDimension::D2Array,
        (ImageDimension::D3, _) => wgpu::TextureViewDimension::D3,
        (ImageDimension::Cube, false) => wgpu::TextureViewDimension::Cube,
        (ImageDimension::Cube, true) => wgpu::TextureViewDimension::CubeArray,
    };
    match class {
        ImageClass::Sampled { kind, multi } => {
            let sample_type = match kind {
                ScalarKind::Float => wgpu::TextureSampleType::Float { filterable: filtered },
                ScalarKind::Sint => wgpu::TextureSampleType::Sint,
                ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                _ => return Err("textures hold floats or integers".into()),
            };
            Ok(wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: multi })
        }
        ImageClass::Depth { multi } => Ok(wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension,
            multisampled: multi,
        }),
        ImageClass::Storage { format, access } => {
            let read = access.contains(StorageAccess::LOAD);
            let write = access.contains(StorageAccess::STORE);
            let access = match (read, write) {
                _ if access.contains(StorageAccess::ATOMIC) => wgpu::StorageTextureAccess::Atomic,
                (true, true) => wgpu::StorageTextureAccess::ReadWrite,
                (true, false) => wgpu::StorageTextureAccess::ReadOnly,
                _ => wgpu::StorageTextureAccess::WriteOnly,
            };
            Ok(wgpu::BindingType::StorageTexture { access, format: storage_format(format)?, view_dimension })
        }
        ImageClass::External => Err("external textures are not supported".into()),
    }
}

fn storage_format(format: naga::StorageFormat) -> Result<wgpu::TextureFormat, String> {
    use naga::StorageFormat as From;
    use wgpu::TextureFormat as To;
    Ok(match format {
        From::R8Unorm => To::R8Unorm,
        From::R8Snorm => To::R8Snorm,
        From::R8Uint => To::R8Uint,
        From::R8Sint => To::R8Sint,
        From::Rg8Unorm => To::Rg8Unorm,
        From::R16Uint => To::R16Uint,
        From::R16Sint => To::R16Sint,
        From::R16Float => To::R16Float,
        From::Rg16Uint => To::Rg16Uint,
        From::Rg16Sint => To::Rg16Sint,
        From::Rg11b10Ufloat => To::Rg11b10Ufloat,
        From::Rgb10a2Unorm => To::Rgb10a2Unorm,
        From::Rg32Sint => To::Rg32Sint,
        From::Rgba8Sint => To::Rgba8Sint,
        From::R32Uint => To::R32Uint,
        From::R32Sint => To::R32Sint,
        From::R32Float => To::R32Float,
        From::Rg16Float => To::Rg16Float,
        From::Rg32Uint => To::Rg32Uint,
        From::Rg32Float => To::Rg32Float,
        From::Rgba8Unorm => To::Rgba8Unorm,
        From::Rgba8Snorm => To::Rgba8Snorm,
        From::Rgba8Uint => To::Rgba8Uint,
        From::Rgba16Uint => To::Rgba16Uint,
        From::Rgba16Sint => To::Rgba16Sint,
        From::Rgba16Float => To::Rgba16Float,
        From::Rgba32Uint => To::Rgba32Uint,
        From::Rgba32Sint => To::Rgba32Sint,
        From::Rgba32Float => To::Rgba32Float,
        other => {
            return Err(format!(
                "storage format {other:?} is not supported; use one of 32 bits a channel, r16float, rgba8 or rgba16"
            ));
        }
    })
}

/// Group and name of the variables that are bound but not among these.
pub(super) fn unused(module: &naga::Module, used: &[BindingInfo]) -> Vec<(u32, String)> {
    let bound = module.global_variables.iter().filter_map(|(_, variable)| {
        let place = variable.binding.as_ref()?;
        Some((place.group, plain_name(variable.name.as_deref()?).to_string()))
    });
    bound.filter(|(group, name)| !used.iter().any(|b| b.group == *group && b.name == *name)).collect()
}

/// The name as the file has it: what is imported carries its module's name too.
fn plain_name(name: &str) -> &str {
    name.split_once(IMPORT_MARK).map_or(name, |(plain, _)| plain)
}

const IMPORT_MARK: &str = "X_naga_oil_mod_X";

/// The struct of that name, whether declared in the file or imported (then its name carries the module's).
pub(super) fn struct_layout(module: &naga::Module, name: &str) -> Option<StructLayout> {
    module.types.iter().find_map(|(_, ty)| {
        let own = ty.name.as_deref()?;
        match &ty.inner {
            TypeInner::Struct { members, span } if plain_name(own) == name => Some(StructLayout {
                size: *span,
                members: members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect(),
            }),
            _ => None,
        }
    })
}
