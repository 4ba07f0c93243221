//! Textures and buffers back on the CPU.

use super::Gpu;
use bytemuck::Pod;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use wgpu::TextureFormat;

/// Why nothing came back.
#[derive(Debug, thiserror::Error)]
pub enum ReadbackError {
    /// The device failed or was lost.
    #[error("the graphics device gave no data back: {0}")]
    Device(String),
    /// There is no such mip level or layer.
    #[error("the texture has no mip level {mip} of layer {layer}")]
    Missing {
        /// Asked for.
        mip: u32,
        /// Asked for.
        layer: u32,
    },
    /// A format that has no plain numbers.
    #[error("cannot read numbers from a texture of format {0:?}")]
    Format(TextureFormat),
}

/// An image of four floats a pixel, row 0 on top. Missing channels are 0, missing alpha is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageF32 {
    /// Width \[pixels\].
    pub width: u32,
    /// Height \[pixels\].
    pub height: u32,
    /// Pixels, row by row.
    pub rgba: Vec<[f32; 4]>,
}

/// Bytes of one layer of one mip level, rows without padding.
///
/// # Errors
/// No such level, or a device that fails.
pub fn read_texture(gpu: &Gpu, texture: &wgpu::Texture, mip: u32, layer: u32) -> Result<Vec<u8>, ReadbackError> {
    begin_read_texture(gpu, texture, mip, layer)?.finish(gpu)
}

/// A copy of a texture on its way back from the device.
///
/// Between [`begin_read_texture`] and [`PendingTexture::finish`] other work may be submitted, such as the next frame:
/// it is not waited for, and changes nothing of what comes back.
pub struct PendingTexture {
    pending: Pending,
    row: usize,
    padded_row: usize,
}

impl PendingTexture {
    /// Waits until the copy is there, and gives its rows without padding.
    ///
    /// # Errors
    /// A device that fails.
    pub fn finish(self, gpu: &Gpu) -> Result<Vec<u8>, ReadbackError> {
        let rows = |padded: &[u8]| padded.chunks(self.padded_row).flat_map(|row| &row[..self.row]).copied().collect();
        self.pending.finish(gpu, rows)
    }
}

/// Begins to read one layer of one mip level back.
///
/// # Errors
/// No such level, or a device that fails.
pub fn begin_read_texture(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    mip: u32,
    layer: u32,
) -> Result<PendingTexture, ReadbackError> {
    let size = texture.size();
    let layers = match texture.dimension() {
        wgpu::TextureDimension::D3 => (size.depth_or_array_layers >> mip.min(31)).max(1),
        _ => size.depth_or_array_layers,
    };
    if mip >= texture.mip_level_count() || layer >= layers {
        return Err(ReadbackError::Missing { mip, layer });
    }
    let (width, height) = ((size.width >> mip).max(1), (size.height >> mip).max(1));
    let aspect =
        if texture.format().has_depth_aspect() { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All };
    let texel = texture.format().block_copy_size(Some(aspect)).ok_or(ReadbackError::Format(texture.format()))?;
    let row = width * texel;
    let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let size = u64::from(padded_row) * u64::from(height);
    let pending = Pending::begin(gpu, size, |encoder, staging| {
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: mip,
                origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
                aspect,
            },
            wgpu::TexelCopyBufferInfo {
                buffer: staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row),
                    rows_per_image: Some(height),
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        )
    })?;
    Ok(PendingTexture { pending, row: row as usize, padded_row: padded_row as usize })
}

/// Layer 0 of mip level 0 as floats. sRGB-encoded bytes come back as the bytes over 255, undecoded.
///
/// # Errors
/// A format without plain numbers, or a device that fails.
pub fn read_texture_f32(gpu: &Gpu, texture: &wgpu::Texture) -> Result<ImageF32, ReadbackError> {
    read_layer_f32(gpu, texture, 0, 0)
}

/// A layer, or a slice of a volume, of a mip level as floats; integers as their numbers.
///
/// # Errors
/// Those of [`read_texture_f32`], and if the texture has no such level.
pub fn read_layer_f32(gpu: &Gpu, texture: &wgpu::Texture, mip: u32, layer: u32) -> Result<ImageF32, ReadbackError> {
    let bytes = read_texture(gpu, texture, mip, layer)?;
    let rgba = floats_of(texture.format(), &bytes)?;
    let [width, height] = [texture.width(), texture.height()].map(|edge| (edge >> mip.min(31)).max(1));
    Ok(ImageF32 { width, height, rgba })
}

/// The texels of a format, one after the other, as four floats each.
///
/// # Errors
/// A format without plain numbers.
pub fn floats_of(format: TextureFormat, bytes: &[u8]) -> Result<Vec<[f32; 4]>, ReadbackError> {
    let f32_at = |c: &[u8], i: usize| f32::from_le_bytes([c[4 * i], c[4 * i + 1], c[4 * i + 2], c[4 * i + 3]]);
    let u32_at = |c: &[u8], i: usize| u32::from_le_bytes([c[4 * i], c[4 * i + 1], c[4 * i + 2], c[4 * i + 3]]);
    let u16_at = |c: &[u8], i: usize| u16::from_le_bytes([c[2 * i], c[2 * i + 1]]);
    Ok(match format {
        TextureFormat::Rgba32Float => bytes.chunks_exact(16).map(|c| std::array::from_fn(|i| f32_at(c, i))).collect(),
        TextureFormat::R32Float | TextureFormat::Depth32Float => {
            bytes.chunks_exact(4).map(|c| [f32_at(c, 0), 0.0, 0.0, 1.0]).collect()
        }
        TextureFormat::Rg32Float => bytes.chunks_exact(8).map(|c| [f32_at(c, 0), f32_at(c, 1), 0.0, 1.0]).collect(),
        TextureFormat::Rgba16Float => {
            bytes.chunks_exact(8).map(|c| std::array::from_fn(|i| f32_of_half(u16_at(c, i)))).collect()
        }
        TextureFormat::Rg11b10Ufloat => bytes.chunks_exact(4).map(|c| rgb_of_packed(u32_at(c, 0))).collect(),
        TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => {
            bytes.chunks_exact(4).map(|c| std::array::from_fn(|i| f32::from(c[i]) / 255.0)).collect()
        }
        TextureFormat::R32Uint => bytes.chunks_exact(4).map(|c| [u32_at(c, 0) as f32, 0.0, 0.0, 1.0]).collect(),
        TextureFormat::Rg32Uint => {
            bytes.chunks_exact(8).map(|c| [u32_at(c, 0) as f32, u32_at(c, 1) as f32, 0.0, 1.0]).collect()
        }
        TextureFormat::Rgba32Uint => {
            bytes.chunks_exact(16).map(|c| std::array::from_fn(|i| u32_at(c, i) as f32)).collect()
        }
        TextureFormat::Rgba16Uint => {
            bytes.chunks_exact(8).map(|c| std::array::from_fn(|i| f32::from(u16_at(c, i)))).collect()
        }
        other => return Err(ReadbackError::Format(other)),
    })
}

/// The whole buffer; a rest shorter than one value is left out. The buffer needs usage COPY_SRC.
///
/// # Errors
/// A device that fails.
pub fn read_buffer<T: Pod>(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<T>, ReadbackError> {
    begin_read_buffer(gpu, buffer)?.finish(gpu)
}

/// A copy of a buffer on its way back from the device, as [`PendingTexture`] is of a texture.
pub struct PendingBuffer(Pending);

/// Begins to read a buffer back. The buffer needs usage COPY_SRC.
///
/// # Errors
/// A device that fails.
pub fn begin_read_buffer(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<PendingBuffer, ReadbackError> {
    let copy = |encoder: &mut wgpu::CommandEncoder, staging: &wgpu::Buffer| {
        encoder.copy_buffer_to_buffer(buffer, 0, staging, 0, buffer.size());
    };
    Ok(PendingBuffer(Pending::begin(gpu, buffer.size(), copy)?))
}

impl PendingBuffer {
    /// Waits until the copy is there, and gives the values; a rest shorter than one value is left out.
    ///
    /// # Errors
    /// A device that fails.
    pub fn finish<T: Pod>(self, gpu: &Gpu) -> Result<Vec<T>, ReadbackError> {
        self.0.finish(gpu, values)
    }

    /// The values if the copy is there, without a wait; none if it is not there yet. Not to be asked again after that.
    ///
    /// # Errors
    /// A device that fails.
    pub fn try_take<T: Pod>(&mut self, gpu: &Gpu) -> Option<Result<Vec<T>, ReadbackError>> {
        let arrived = self.0.mapping.arrived(gpu, false)?;
        Some(arrived.and_then(|()| take_mapped(&self.0.staging, values)))
    }
}

fn values<T: Pod>(bytes: &[u8]) -> Vec<T> {
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

/// A buffer that is being mapped for reading.
pub(super) struct Mapping(Receiver<Result<(), wgpu::BufferAsyncError>>);

impl Mapping {
    /// Asks for the whole buffer, after all that was submitted.
    pub fn begin(staging: &wgpu::Buffer) -> Self {
        let (sender, mapped) = channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // If the receiver is gone, nobody wants the answer.
            let _ = sender.send(result);
        });
        Self(mapped)
    }

    /// Whether the buffer is mapped; none if it is not yet, and is not waited for.
    pub fn arrived(&mut self, gpu: &Gpu, wait: bool) -> Option<Result<(), ReadbackError>> {
        if wait {
            gpu.wait();
        } else if let Err(error) = gpu.device.poll(wgpu::PollType::Poll) {
            return Some(Err(ReadbackError::Device(error.to_string())));
        }
        match self.0.try_recv() {
            Ok(result) => Some(result.map_err(|error| ReadbackError::Device(error.to_string()))),
            Err(TryRecvError::Empty) if !wait => None,
            Err(_) => Some(Err(ReadbackError::Device("it did not finish".into()))),
        }
    }
}

/// Takes what is wanted of a mapped buffer, and unmaps it.
pub(super) fn take_mapped<T>(staging: &wgpu::Buffer, take: impl FnOnce(&[u8]) -> T) -> Result<T, ReadbackError> {
    let view = staging.slice(..).get_mapped_range().map_err(|error| ReadbackError::Device(error.to_string()))?;
    let taken = take(&view);
    drop(view);
    staging.unmap();
    Ok(taken)
}

/// Bytes on their way into memory of the host.
struct Pending {
    staging: wgpu::Buffer,
    submission: wgpu::SubmissionIndex,
    mapping: Mapping,
}

impl Pending {
    /// Submits a copy into a buffer of so many bytes.
    fn begin(
        gpu: &Gpu,
        size: u64,
        copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
    ) -> Result<Self, ReadbackError> {
        let staging = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let submit = || {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            copy(&mut encoder, &staging);
            gpu.submit(Some(encoder))
        };
        let submission = gpu.checked(submit).map_err(ReadbackError::Device)?;
        let mapping = Mapping::begin(&staging);
        Ok(Self { staging, submission, mapping })
    }

    /// Waits for the copy, not for what was submitted after it, and takes what is wanted of the bytes.
    fn finish<T>(mut self, gpu: &Gpu, take: impl FnOnce(&[u8]) -> T) -> Result<T, ReadbackError> {
        gpu.count(|counts| counts.waits += 1);
        let poll = wgpu::PollType::Wait { submission_index: Some(self.submission), timeout: None };
        // A lost device knows nothing of submissions; that it is lost comes out when all are waited for.
        let waited = gpu.device.poll(poll).is_ok();
        let arrived = if waited { self.mapping.arrived(gpu, false) } else { None };
        match arrived.or_else(|| self.mapping.arrived(gpu, true)) {
            Some(arrived) => arrived?,
            None => return Err(ReadbackError::Device("it did not finish".into())),
        }
        take_mapped(&self.staging, take)
    }
}

/// IEEE 754 binary16 to binary32.
fn f32_of_half(half: u16) -> f32 {
    let sign = if half & 0x8000 == 0 { 1.0 } else { -1.0 };
    let exponent = i32::from((half >> 10) & 0x1f);
    let mantissa = f32::from(half & 0x3ff);
    sign * match exponent {
        0 => mantissa * (-24.0_f32).exp2(),
        31 if mantissa == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1.0 + mantissa / 1024.0) * ((exponent - 15) as f32).exp2(),
    }
}

/// Three unsigned floats of 11, 11 and 10 bits: halves without sign, their mantissas cut to 6, 6 and 5 bits.
fn rgb_of_packed(packed: u32) -> [f32; 4] {
    let half = |bits: u32, missing: u32| f32_of_half((bits << missing) as u16);
    [half(packed & 0x7ff, 4), half((packed >> 11) & 0x7ff, 4), half(packed >> 22, 5), 1.0]
}

#[cfg(test)]
mod tests {
    use super::{f32_of_half, rgb_of_packed};

    #[test]
    fn packed_floats_come_apart() {
        // 1.0 has exponent 15 and mantissa 0 in each field.
        let packed = (15 << 6) | (16 << 6 << 11) | (14 << 5 << 22);
        assert_eq!(rgb_of_packed(packed), [1.0, 2.0, 0.5, 1.0]);
    }

    #[test]
    fn halves_become_the_same_number() {
        let cases =
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 5.960_464_5e-8), (0x3555, 0.333_251_95)];
        for (half, value) in cases {
            assert_eq!(f32_of_half(half), value, "{half:#x}");
        }
        assert!(f32_of_half(0x7c00).is_infinite() && f32_of_half(0x7e00).is_nan());
    }
}
