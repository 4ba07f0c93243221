//! Binds resources by the names that they have in the shader.

use super::context::Gpu;
use super::pipeline::{BindError, Binding, Pipeline};
use super::reflect::BindingInfo;
use super::reuse::{BindKey, BoundResource};

impl Pipeline {
    /// The bind group of resources by their WGSL names: the same one as long as frames bind the same resources. A resource that the shader declares but does not use
    /// (any more) is left out, so that an edit of the shader needs none of the program.
    ///
    /// # Errors
    /// A name that the shader does not declare, one that is missing, or a resource that does not fit.
    pub fn bind(&self, gpu: &Gpu, group: u32, resources: &[(&str, Binding)]) -> Result<wgpu::BindGroup, BindError> {
        let error = |what: String| BindError { shader: self.shader.into(), group, what };
        let used: Vec<&BindingInfo> = self.bindings.iter().filter(|b| b.group == group).collect();
        if let Some((name, _)) = resources.iter().find(|(name, _)| !self.knows(group, name)) {
            let names: Vec<&str> = used.iter().map(|b| b.name.as_str()).collect();
            return Err(error(format!("it declares no `{name}`; it uses {}", names.join(", "))));
        }
        let mut entries = Vec::with_capacity(used.len());
        for info in used {
            let (_, resource) = resources
                .iter()
                .find(|(name, _)| *name == info.name)
                .ok_or_else(|| error(format!("`{}` is not bound", info.name)))?;
            let resource = resource.fitting(info).map_err(|what| error(format!("`{}` {what}", info.name)))?;
            entries.push(wgpu::BindGroupEntry { binding: info.binding, resource });
        }
        let layout = self.layouts.get(group as usize).ok_or_else(|| error("it has no such group".into()))?;
        let descriptor = wgpu::BindGroupDescriptor { label: Some(self.shader), layout, entries: &entries };
        let bound = |entry: &wgpu::BindGroupEntry| Some((entry.binding, BoundResource::of(&entry.resource)?));
        let resources = entries.iter().map(bound).collect::<Option<_>>();
        let resources = resources.ok_or_else(|| error("it binds an array of resources".into()))?;
        // Formats, dimensions, usages and limits are left for the device to compare.
        gpu.kept_bind_group(BindKey { layout: layout.clone(), resources }, &descriptor)
            .map_err(|refused| error(self.named(group, refused)))
    }

    fn knows(&self, group: u32, name: &str) -> bool {
        self.declares(group, name) || self.unused.iter().any(|(g, unused)| *g == group && unused == name)
    }

    /// The device speaks of binding numbers: adds their names.
    fn named(&self, group: u32, refused: String) -> String {
        let of_group = self.bindings.iter().filter(|b| b.group == group);
        let names: Vec<String> = of_group.map(|b| format!("{} is `{}`", b.binding, b.name)).collect();
        format!("the device refused it: {refused} (binding {})", names.join(", "))
    }
}

impl<'a> Binding<'a> {
    fn fitting(self, info: &BindingInfo) -> Result<wgpu::BindingResource<'a>, String> {
        use wgpu::BindingType as Type;
        match (self, info.ty) {
            (Binding::Texture(view), Type::Texture { .. } | Type::StorageTexture { .. }) => {
                Ok(wgpu::BindingResource::TextureView(view))
            }
            (Binding::Sampler(sampler), Type::Sampler(_)) => Ok(wgpu::BindingResource::Sampler(sampler)),
            (Binding::Buffer(buffer), Type::Buffer { min_binding_size, .. }) => match min_binding_size {
                Some(least) if buffer.size() < least.get() => {
                    Err(format!("takes {least} bytes; the buffer has {}", buffer.size()))
                }
                _ => Ok(buffer.as_entire_binding()),
            },
            (Binding::BufferRange(buffer, offset, size), Type::Buffer { .. }) => {
                let size = std::num::NonZeroU64::new(size).ok_or("was given an empty range")?;
                if offset.checked_add(size.get()).is_none_or(|end| end > buffer.size()) {
                    return Err(format!("was given {size} bytes from {offset} on; the buffer has {}", buffer.size()));
                }
                Ok(wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size: Some(size) }))
            }
            (given, declared) => Err(format!("is declared as {declared:?}, but was given {}", given.kind())),
        }
    }

    fn kind(self) -> &'static str {
        match self {
            Binding::Texture(_) => "a texture",
            Binding::Buffer(_) | Binding::BufferRange(..) => "a buffer",
            Binding::Sampler(_) => "a sampler",
        }
    }
}
