//! The sky's image in glossy surfaces, beside the sky's light that volumes hold. See `indirect/sky_reflection.wgsl`.

use super::gloss;
use super::light_volumes::Field;
use crate::assets::{REFLECTION_LEVELS, SkyMap};
use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::scene::Scene;
use encase::ShaderType;
use glam::{UVec2, Vec3, Vec4};

/// Whether surfaces show an image of the sky, beside its light.
pub(in crate::render) fn is_mirrored(scene: &Scene) -> bool {
    scene.sky_map.is_some() && gloss::is_wanted(scene)
}

/// `Reflection` of `indirect/sky_reflection.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct ReflectionUniform {
    irradiance: [Vec4; 9],
    size: UVec2,
    levels: u32,
    mean: Vec3,
    turn: f32,
}

/// Declares what the sky's image adds to the sky's light in the lobes of glossy surfaces: radiance that may be negative.
/// `field` holds the light of the sky alone.
pub(in crate::render) fn reflection<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    field: &Field,
) -> Option<Handle<Texture>> {
    let map = frame.scene.sky_map.as_deref()?;
    let Field::Swept { .. } = field else { return None };
    let levels = levels(graph, map);
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let reflected = graph.retained_texture("sky reflection", desc);
    let uniform = ReflectionUniform {
        irradiance: map.irradiance_harmonics().map(|c| c.extend(0.0)),
        size: map.reflection_size().into(),
        levels: REFLECTION_LEVELS,
        mean: frame.scene.sky,
        turn: map.turn,
    };
    let mut pass = graph.compute("sky reflection", ComputeKey::new("indirect/sky_reflection.wgsl", "main"));
    frame.bind_view(&mut pass);
    pass.uniform("reflection", &uniform);
    pass.read("normal", gbuffer.normal);
    pass.read("object", gbuffer.object);
    pass.read("depth", gbuffer.depth);
    pass.read("levels", levels);
    field.bind_swept(&mut pass);
    let reflected = pass.write("reflected", reflected);
    pass.dispatch_over([width, height]);
    Some(reflected)
}

/// Declares what glossy surfaces reflect of a map: a level for each roughness, below one another. Found on the host, once
/// for a map.
fn levels<'a>(graph: &mut Graph<'a>, map: &'a SkyMap) -> Handle<Texture> {
    let [width, height] = map.reflection_size();
    let rows = (0..REFLECTION_LEVELS).map(|level| (height >> level).max(1)).sum();
    let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let levels =
        graph.retained_texture("sky levels", TextureDesc::d2(width, rows, wgpu::TextureFormat::Rgba32Float, usage));
    // By hand: the host finds the texels and uploads them.
    let mut pass = graph.pass("sky levels");
    let levels = pass.write(levels);
    pass.key(&map.id);
    pass.execute(move |cx| {
        let mut texels: Vec<[f32; 4]> = Vec::with_capacity((width * rows) as usize);
        for level in map.reflections() {
            for row in level.texels.chunks_exact(level.width as usize) {
                texels.extend(row.iter().map(|texel| texel.extend(0.0).to_array()));
                texels.resize(texels.len() + (width - level.width) as usize, [0.0; 4]);
            }
        }
        let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * width), rows_per_image: Some(rows) };
        let texture = cx.texture(levels).as_image_copy();
        cx.gpu.write_texture(texture, bytemuck::cast_slice(&texels), layout, size);
        Ok(())
    });
    levels
}
