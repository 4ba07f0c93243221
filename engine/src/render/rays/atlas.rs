//! All textures of a scene in the layers of one array, since not every adapter binds textures by index. Filtering
//! and wrapping are done in the shader, so that any size fits without being resampled.

use super::RayError;
use crate::assets::{AssetId, Texture, Wrap};
use crate::gpu::Gpu;
use crate::scene::Scene;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Edge of a layer, unless a texture is larger.
const LAYER_SIZE: u32 = 4096;

/// Where a texture lies, as the shader reads it: origin x and y, width and height (16 bits each), layer and flags,
/// and 1 for "there is one".
pub(super) type Slot = [u32; 4];

/// The textures on the device.
pub(super) struct Atlas {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    slots: HashMap<AssetId, Slot>,
}

impl Atlas {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let texture = layers(gpu, 1, 1);
        let view = view(&texture);
        Self { texture, view, slots: HashMap::new() }
    }

    pub(super) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    pub(super) fn holds_textures(&self) -> bool {
        !self.slots.is_empty()
    }

    pub(super) fn slot(&self, texture: AssetId) -> Slot {
        self.slots.get(&texture).copied().unwrap_or([0; 4])
    }

    /// Uploads the scene's textures, unless they are those that are there.
    pub(super) fn update(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RayError> {
        let textures = textures_of(scene);
        if textures.len() == self.slots.len() && textures.keys().all(|id| self.slots.contains_key(id)) {
            return Ok(());
        }
        let limit = gpu.limits.max_texture_dimension_2d;
        let sizes: Vec<[u32; 2]> = textures.values().map(|t| [t.width.min(limit), t.height.min(limit)]).collect();
        let packing = pack(&sizes, limit);
        let possible = gpu.limits.max_texture_array_layers;
        if packing.layers > possible {
            return Err(RayError::Textures { needed: packing.layers, size: packing.size, limit: possible });
        }
        self.slots.clear();
        self.texture = layers(gpu, packing.size, packing.layers);
        self.view = view(&self.texture);
        for ((&id, texture), (place, size)) in textures.iter().zip(packing.places.iter().zip(&sizes)) {
            upload(gpu, &self.texture, texture, *place, *size);
            self.slots.insert(id, slot(texture, *place, *size));
        }
        Ok(())
    }
}

fn textures_of(scene: &Scene) -> BTreeMap<AssetId, &Arc<Texture>> {
    let of_material = scene.primitives.iter().flat_map(|primitive| primitive.material.textures());
    of_material.filter_map(|(texture, _)| texture).map(|texture| (texture.id, texture)).collect()
}

/// Origin x and y, and the layer.
type Place = [u32; 3];

/// Where everything goes.
struct Packing {
    places: Vec<Place>,
    size: u32,
    layers: u32,
}

/// Packs rectangles on shelves, tall ones first.
fn pack(sizes: &[[u32; 2]], limit: u32) -> Packing {
    let largest = sizes.iter().flatten().copied().max().unwrap_or(1);
    let area: u64 = sizes.iter().map(|&[w, h]| u64::from(w) * u64::from(h)).sum();
    let square = (area as f64).sqrt().ceil() as u32;
    let size = square.next_power_of_two().min(LAYER_SIZE).max(largest).min(limit);
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i][1]), std::cmp::Reverse(sizes[i][0]), i));
    let mut places = vec![[0; 3]; sizes.len()];
    let (mut x, mut y, mut shelf, mut layer) = (0, 0, 0, 0);
    for index in order {
        let [width, height] = sizes[index];
        if x + width > size {
            (x, y, shelf) = (0, y + shelf, 0);
        }
        if y + height > size {
            (x, y, shelf, layer) = (0, 0, 0, layer + 1);
        }
        places[index] = [x, y, layer];
        x += width;
        shelf = shelf.max(height);
    }
    Packing { places, size, layers: layer + 1 }
}

fn slot(texture: &Texture, [x, y, layer]: Place, [width, height]: [u32; 2]) -> Slot {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let sampling = &texture.sampling;
    let flags = u32::from(texture.srgb)
        | u32::from(sampling.nearest) << 1
        | wrap(sampling.wrap_u) << 2
        | wrap(sampling.wrap_v) << 4;
    [x | y << 16, width | height << 16, layer | flags << 16, 1]
}

fn layers(gpu: &Gpu, size: u32, count: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("texture atlas"),
        size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: count },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    let dimension = Some(wgpu::TextureViewDimension::D2Array);
    texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
}

/// Copies the texels. What is larger than the device can hold keeps every second, third … row and column.
fn upload(gpu: &Gpu, atlas: &wgpu::Texture, texture: &Texture, [x, y, layer]: Place, [width, height]: [u32; 2]) {
    let picked: Vec<u8>;
    let texels = if (width, height) == (texture.width, texture.height) {
        &texture.rgba
    } else {
        let at = |x: u32, y: u32| {
            let column = (u64::from(x) * u64::from(texture.width) / u64::from(width)) as usize;
            let row = (u64::from(y) * u64::from(texture.height) / u64::from(height)) as usize;
            let at = 4 * (row * texture.width as usize + column);
            [texture.rgba[at], texture.rgba[at + 1], texture.rgba[at + 2], texture.rgba[at + 3]]
        };
        picked = (0..height).flat_map(|y| (0..width).flat_map(move |x| at(x, y))).collect();
        &picked
    };
    gpu.write_texture(
        wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: layer }, ..atlas.as_image_copy() },
        texels,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: Some(height) },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn textures_lie_side_by_side_within_their_layers(sizes in prop::collection::vec([1_u32..300, 1_u32..300], 0..40)) {
            let packing = pack(&sizes, 512);
            prop_assert!(packing.size <= 512);
            let rectangles: Vec<_> = packing.places.iter().zip(&sizes).collect();
            for (i, ([x, y, layer], [w, h])) in rectangles.iter().enumerate() {
                prop_assert!(x + w <= packing.size && y + h <= packing.size && *layer < packing.layers);
                for ([x2, y2, layer2], [w2, h2]) in &rectangles[..i] {
                    let apart = layer != layer2 || x + w <= *x2 || x2 + w2 <= *x || y + h <= *y2 || y2 + h2 <= *y;
                    prop_assert!(apart);
                }
            }
        }
    }
}
