//! Upload of textures with their mip levels.

use crate::assets::{Levels, Sampling, Texture, Wrap};
use crate::gpu::Gpu;
use std::borrow::Cow;
use std::sync::OnceLock;

/// A texture on the device with its sampler.
#[derive(Debug)]
pub(super) struct GpuTexture {
    pub(super) view: wgpu::TextureView,
    pub(super) sampler: wgpu::Sampler,
    pub(super) bytes: u64,
}

impl GpuTexture {
    /// Uploads all mip levels. Textures beyond the device's limit are halved until they fit.
    pub(super) fn new(gpu: &Gpu, texture: &Texture) -> Self {
        let limit = gpu.limits.max_texture_dimension_2d;
        let mut levels = mip_levels(texture);
        levels.retain(|level| level.width <= limit && level.height <= limit);
        if texture.sampling.minified().levels == Levels::Full {
            levels.truncate(1);
        }
        let size =
            |level: &Level| wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 };
        let format = if texture.srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm };
        let raw = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&texture.name),
            size: levels.first().map_or(wgpu::Extent3d::default(), size),
            mip_level_count: levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (level, mip_level) in levels.iter().zip(0..) {
            gpu.write_texture(
                wgpu::TexelCopyTextureInfo { mip_level, ..raw.as_image_copy() },
                &level.rgba,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * level.width),
                    rows_per_image: Some(level.height),
                },
                size(level),
            );
        }
        Self {
            view: raw.create_view(&Default::default()),
            sampler: sampler(gpu, &texture.sampling),
            bytes: levels.iter().map(|level| level.rgba.len() as u64).sum(),
        }
    }
}

/// The sampler of the settings; textures share those that are alike, since devices hold few (2,048 on some).
fn sampler(gpu: &Gpu, sampling: &Sampling) -> wgpu::Sampler {
    let address = |wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    };
    let filter = |nearest| if nearest { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear };
    let small = sampling.minified();
    let blends = small.levels == Levels::Blended;
    // Devices allow anisotropy with filters that are linear throughout alone.
    let is_smooth = blends && !sampling.nearest && !small.nearest;
    // That of Mesa's llvmpipe (22.3) takes single pixels from elsewhere in the texture.
    let is_sound = !gpu.is_software();
    gpu.sampler(&wgpu::SamplerDescriptor {
        label: Some("material"),
        address_mode_u: address(sampling.wrap_u),
        address_mode_v: address(sampling.wrap_v),
        mag_filter: filter(sampling.nearest),
        min_filter: filter(small.nearest),
        mipmap_filter: if blends { wgpu::MipmapFilterMode::Linear } else { wgpu::MipmapFilterMode::Nearest },
        // Not 0: a level of detail above 0 tells what is minified from what is magnified (Vulkan specification,
        // VkSamplerCreateInfo, on the filters of OpenGL without mip levels).
        lod_max_clamp: if small.levels == Levels::Full { 0.25 } else { 32.0 },
        anisotropy_clamp: if is_smooth && is_sound { 8 } else { 1 },
        ..Default::default()
    })
}

struct Level<'a> {
    width: u32,
    height: u32,
    rgba: Cow<'a, [u8]>,
}

/// The texture and its halved copies down to one texel.
fn mip_levels(texture: &Texture) -> Vec<Level<'_>> {
    let mut levels = vec![Level { width: texture.width, height: texture.height, rgba: Cow::from(&texture.rgba) }];
    while let Some(last) = levels.last()
        && last.width.max(last.height) > 1
    {
        let next = halved(last, texture.srgb);
        levels.push(next);
    }
    levels
}

/// Mean of two by two texels, in linear light. At an odd edge the last texel counts alone.
fn halved(level: &Level<'_>, srgb: bool) -> Level<'static> {
    let (width, height) = ((level.width / 2).max(1), (level.height / 2).max(1));
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    let at = |x: u32, y: u32, channel: usize| {
        let (x, y) = (x.min(level.width - 1), y.min(level.height - 1));
        level.rgba[4 * (x as usize + y as usize * level.width as usize) + channel]
    };
    let linear = linear_of_srgb();
    for y in 0..height {
        for x in 0..width {
            for channel in 0..4 {
                let texels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| at(2 * x + i, 2 * y + j, channel));
                rgba.push(if srgb && channel < 3 {
                    srgb_of_linear(texels.iter().map(|&t| linear[usize::from(t)]).sum::<f32>() / 4.0)
                } else {
                    ((texels.iter().map(|&t| u32::from(t)).sum::<u32>() + 2) / 4) as u8
                });
            }
        }
    }
    Level { width, height, rgba: Cow::from(rgba) }
}

/// Linear value of each sRGB byte (IEC 61966-2-1).
fn linear_of_srgb() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| {
        std::array::from_fn(|byte| {
            let c = byte as f32 / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    })
}

/// The nearest sRGB byte, by bisection in the table.
fn srgb_of_linear(value: f32) -> u8 {
    let table = linear_of_srgb();
    let above = table.partition_point(|&t| t < value);
    match above {
        0 => 0,
        256 => 255,
        _ if value - table[above - 1] < table[above] - value => (above - 1) as u8,
        _ => above as u8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::{AssetId, Sampling};

    #[test]
    fn mips_average_in_linear_light() {
        let texture = Texture {
            id: AssetId::fresh(),
            name: "checker".into(),
            width: 2,
            height: 2,
            rgba: [[0, 0, 0, 0], [255; 4], [255; 4], [0, 0, 0, 0]].concat(),
            srgb: true,
            sampling: Sampling::default(),
        };
        let levels = mip_levels(&texture);
        assert_eq!(levels.len(), 2);
        // Half the light is sRGB 188; half the alpha is 128.
        assert_eq!(levels[1].rgba[..], [188, 188, 188, 128]);
    }

    #[test]
    fn every_srgb_byte_comes_back() {
        for byte in 0..=255_u8 {
            assert_eq!(srgb_of_linear(linear_of_srgb()[usize::from(byte)]), byte);
        }
    }
}
