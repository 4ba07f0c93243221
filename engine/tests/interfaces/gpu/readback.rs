use super::open;
use lightwell::gpu::{Gpu, ReadbackError, read_texture, read_texture_f32};
use wgpu::{TextureFormat, TextureUsages};

/// A texture with one mip level that can be read back.
pub fn texture(gpu: &Gpu, width: u32, height: u32, format: TextureFormat, usage: TextureUsages) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("test"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn filled(gpu: &Gpu, format: TextureFormat, bytes: &[u8]) -> wgpu::Texture {
    let texel = format.block_copy_size(None).expect("plain format");
    let (width, height) = (37, 3);
    assert_eq!(bytes.len() as u32, width * height * texel);
    let texture = texture(gpu, width, height, format, TextureUsages::COPY_DST);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * texel), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
    texture
}

#[test]
fn rows_that_are_no_multiple_of_256_bytes_come_back_tight() {
    let (_dir, gpu) = open();
    let bytes: Vec<u8> = (0..37 * 3 * 4).map(|i| (i % 251) as u8).collect();
    let texture = filled(&gpu, TextureFormat::Rgba8Unorm, &bytes);
    assert_eq!(read_texture(&gpu, &texture, 0, 0).expect("read"), bytes);
    let image = read_texture_f32(&gpu, &texture).expect("read");
    assert_eq!((image.width, image.height), (37, 3));
    assert_eq!(image.rgba[1], [4.0, 5.0, 6.0, 7.0].map(|byte| byte / 255.0));
}

#[test]
fn float_formats_give_their_numbers() {
    let (_dir, gpu) = open();
    let numbers: Vec<f32> = (0..37 * 3 * 4).map(|i| i as f32 * 0.25).collect();
    let four = read_texture_f32(&gpu, &filled(&gpu, TextureFormat::Rgba32Float, bytemuck::cast_slice(&numbers)));
    assert_eq!(four.expect("read").rgba[36], [36.0, 36.25, 36.5, 36.75]);
    let one = &numbers[..37 * 3];
    let one = read_texture_f32(&gpu, &filled(&gpu, TextureFormat::R32Float, bytemuck::cast_slice(one)));
    assert_eq!(one.expect("read").rgba[40], [10.0, 0.0, 0.0, 1.0]);
    let halves = [0x3c00_u16, 0x4000, 0xb800, 0x7bff].repeat(37 * 3);
    let half = read_texture_f32(&gpu, &filled(&gpu, TextureFormat::Rgba16Float, bytemuck::cast_slice(&halves)));
    assert_eq!(half.expect("read").rgba, [[1.0, 2.0, -0.5, 65504.0]; 37 * 3]);
    let whole: Vec<u32> = (0..37 * 3).collect();
    let whole = read_texture_f32(&gpu, &filled(&gpu, TextureFormat::R32Uint, bytemuck::cast_slice(&whole)));
    assert_eq!(whole.expect("read").rgba[110][0], 110.0);
}

#[test]
fn a_cleared_depth_buffer_reads_as_its_value() {
    let (_dir, gpu) = open();
    let depth = texture(&gpu, 9, 2, TextureFormat::Depth32Float, TextureUsages::RENDER_ATTACHMENT);
    let view = depth.create_view(&Default::default());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.25), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    gpu.queue.submit([encoder.finish()]);
    let image = read_texture_f32(&gpu, &depth).expect("read");
    assert!(image.rgba.iter().all(|texel| texel[0] == 0.25), "{:?}", image.rgba[0]);
}

#[test]
fn what_cannot_be_read_is_an_error() {
    let (_dir, gpu) = open();
    let plain = texture(&gpu, 4, 4, TextureFormat::Rgba8Unorm, TextureUsages::COPY_DST);
    assert!(matches!(read_texture(&gpu, &plain, 1, 0), Err(ReadbackError::Missing { mip: 1, layer: 0 })));
    let integers = texture(&gpu, 4, 4, TextureFormat::Rgba16Sint, TextureUsages::COPY_DST);
    assert!(matches!(read_texture_f32(&gpu, &integers), Err(ReadbackError::Format(_))));
    let unreadable = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("unreadable"),
        size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba8Unorm,
        usage: TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let error = read_texture(&gpu, &unreadable, 0, 0).expect_err("no COPY_SRC").to_string();
    assert!(error.contains("unreadable"), "{error}");
    assert_eq!(gpu.take_errors(), Vec::<String>::new());
}
