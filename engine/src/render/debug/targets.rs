//! Images that passes made, laid side by side over the image (thesis, section 6.8, `OverlayRenderTarget`).

use super::overlay;
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{BufferDesc, Contents, Graph, Handle, PassBindings, Texture, TextureDesc};
use crate::render::debug_settings::ShownTarget;
use crate::render::frame::Frame;
use encase::ShaderType;
use glam::{UVec2, Vec2};
use wgpu::{BufferUsages, TextureAspect, TextureDimension, TextureSampleType, TextureUsages};

const SHADER: &str = "debug/targets.wgsl";

/// Distance between tiles, and to the edge of the image \[pixels\].
const GAP: f32 = 4.0;

/// `Tile` of `debug/targets.wgsl`.
#[derive(ShaderType)]
pub(crate) struct TileUniform {
    /// Upper left corner in the image \[pixels\].
    corner: Vec2,
    /// \[pixels\]
    size: Vec2,
    /// Of the image \[pixels\].
    view: UVec2,
    /// Of the mip level that is shown \[texels\].
    texels: UVec2,
    /// 0 to 3; 4: the first three as a colour.
    channel: u32,
    /// Slice of a volume.
    slice: u32,
    /// Where its range is in the buffer of ranges.
    index: u32,
    is_range_given: u32,
    /// Values that become black and white, if they are given.
    range: Vec2,
}

/// A target that can be shown, with what is to be shown of it.
#[derive(Clone)]
struct Found {
    handle: Handle<Texture>,
    desc: TextureDesc,
    shown: ShownTarget,
}

impl Found {
    fn mip(&self) -> u32 {
        self.shown.mip.min(self.desc.mips - 1)
    }

    /// Size of the mip level, and its number of slices \[texels\].
    fn texels(&self) -> [u32; 3] {
        let extent = self.desc.extent().mip_level_size(self.mip(), self.desc.dimension);
        [extent.width, extent.height, extent.depth_or_array_layers]
    }

    /// The layer or slice, the last one beyond it.
    fn slice(&self) -> u32 {
        self.shown.slice.min(self.texels()[2] - 1)
    }

    fn is_volume(&self) -> bool {
        self.desc.dimension == TextureDimension::D3
    }

    /// The defines of the shader, for what the texture is.
    fn defs(&self) -> Vec<(&'static str, ShaderDef)> {
        let texels = match self.desc.format.sample_type(Some(TextureAspect::DepthOnly), None) {
            Some(TextureSampleType::Depth) => Some("DEPTH"),
            _ => match self.desc.format.sample_type(None, None) {
                Some(TextureSampleType::Uint) => Some("UNSIGNED"),
                Some(TextureSampleType::Sint) => Some("SIGNED"),
                _ => None,
            },
        };
        let names = self.is_volume().then_some("VOLUME").into_iter().chain(texels);
        names.map(|name| (name, ShaderDef::Flag(true))).collect()
    }

    /// Binds it to a step that shows it.
    fn bind(&self, step: &mut PassBindings, uniform: &TileUniform) {
        self.defs().into_iter().for_each(|(name, value)| step.define(name, value));
        step.uniform("tile", uniform);
        step.read_part("source", self.handle, self.part());
    }

    /// The mip level, and the layer of an array.
    fn part(&self) -> wgpu::TextureViewDescriptor<'static> {
        let is_volume = self.is_volume();
        let dimension = if is_volume { wgpu::TextureViewDimension::D3 } else { wgpu::TextureViewDimension::D2 };
        let aspect = if self.desc.format.has_depth_aspect() { TextureAspect::DepthOnly } else { TextureAspect::All };
        wgpu::TextureViewDescriptor {
            label: Some("shown target"),
            dimension: Some(dimension),
            aspect,
            base_mip_level: self.mip(),
            mip_level_count: Some(1),
            base_array_layer: if is_volume { 0 } else { self.slice() },
            array_layer_count: Some(1),
            ..Default::default()
        }
    }

    fn uniform(&self, index: usize, tile: Tile, view: [u32; 2]) -> TileUniform {
        let [width, height, _] = self.texels();
        TileUniform {
            corner: tile.corner,
            size: tile.size,
            view: view.into(),
            texels: UVec2::new(width, height),
            channel: self.shown.channel.map_or(4, u32::from),
            slice: self.slice(),
            index: index as u32,
            is_range_given: self.shown.range.is_some().into(),
            range: self.shown.range.unwrap_or_default().into(),
        }
    }
}

/// Declares the pass, if any target is to be shown; the result is the display image with them.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, display: Handle<Texture>) -> Handle<Texture> {
    let wanted = &frame.settings.debug.targets;
    let found: Vec<Found> = wanted.iter().filter_map(|shown| find(graph, shown)).collect();
    if found.is_empty() {
        return display;
    }
    let ranges = BufferDesc::new(8 * found.len() as u64, BufferUsages::STORAGE);
    let ranges = graph.buffer("debug targets, ranges", ranges);
    let view = frame.view.size;
    let sizes: Vec<[u32; 2]> = found.iter().map(|target| [target.texels()[0], target.texels()[1]]).collect();
    let tiles: Vec<_> =
        found.iter().zip(layout(&sizes, view)).zip(0..).map(|((f, tile), i)| (f, f.uniform(i, tile, view))).collect();
    // Finds the least and the largest value, unless they are given.
    let mut pass = graph.compute("debug targets, ranges", ComputeKey::new(SHADER, "measure"));
    let ranges = pass.write_in_steps(ranges);
    for (target, uniform) in tiles.iter().filter(|(target, _)| target.shown.range.is_none()) {
        let mut step = pass.step("measure");
        target.bind(&mut step, uniform);
        step.read("measured", ranges);
        step.in_groups([1, 1, 1]);
    }
    pass.finish();
    let mut pass = graph.raster("debug targets");
    let display = pass.color(display, Contents::Kept);
    pass.read("ranges", ranges);
    for (target, uniform) in &tiles {
        let mut step = pass.step();
        target.bind(&mut step, uniform);
        step.draw(overlay::pipeline(SHADER, false), [6, 1]);
    }
    pass.finish();
    display
}

/// The target; none, with a warning: why it cannot be shown.
fn find(graph: &mut Graph, shown: &ShownTarget) -> Option<Found> {
    let handle = graph.latest::<Texture>(&shown.name);
    let desc = handle.and_then(|handle| graph.texture_desc(handle)).cloned();
    let (Some(handle), Some(desc)) = (handle, desc) else {
        graph.warn(format!(
            "the target `{}` is not shown: no pass of this frame makes it; `lightwell explain` lists those of a scene",
            shown.name
        ));
        return None;
    };
    if !desc.usage.contains(TextureUsages::TEXTURE_BINDING) || desc.dimension == TextureDimension::D1 {
        graph.warn(format!("the target `{}` is not shown: shaders cannot read it ({desc:?})", shown.name));
        return None;
    }
    Some(Found { handle, desc, shown: shown.clone() })
}

/// Place of a target in the image \[pixels\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tile {
    corner: Vec2,
    size: Vec2,
}

/// Places for images of these sizes: rows of one height from the lower left, as high as a quarter of the image or as
/// lets all of them fit.
fn layout(sizes: &[[u32; 2]], view: [u32; 2]) -> Vec<Tile> {
    let view = Vec2::new(view[0] as f32, view[1] as f32);
    let mut height = (0.25 * view.y).max(1.0);
    loop {
        let tiles = rows(sizes, view, height);
        if height <= 1.0 || tiles.iter().all(|tile| tile.corner.y >= 0.0) {
            return tiles;
        }
        height = (0.9 * height).max(1.0);
    }
}

fn rows(sizes: &[[u32; 2]], view: Vec2, height: f32) -> Vec<Tile> {
    let mut next = Vec2::new(GAP, view.y - GAP - height);
    let place = |&[width, rows]: &[u32; 2]| {
        let widest = (view.x - 2.0 * GAP).max(1.0);
        let width = (height * width as f32 / rows as f32).clamp(1.0, widest);
        if next.x > GAP && next.x + width + GAP > view.x {
            next = Vec2::new(GAP, next.y - GAP - height);
        }
        let tile = Tile { corner: next, size: Vec2::new(width, height) };
        next.x += width + GAP;
        tile
    };
    sizes.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tiles_lie_in_the_image_and_never_over_each_other(
            sizes in prop::collection::vec([1u32..3000, 1u32..3000], 1..24),
            view in [320u32..2000, 200u32..2000],
        ) {
            let tiles = layout(&sizes, view);
            prop_assert_eq!(tiles.len(), sizes.len());
            let (width, height) = (view[0] as f32, view[1] as f32);
            for (index, tile) in tiles.iter().enumerate() {
                let end = tile.corner + tile.size;
                prop_assert!(tile.corner.min_element() >= 0.0 && end.x <= width && end.y <= height, "{:?}", tile);
                for other in &tiles[..index] {
                    let apart = (tile.corner.cmpge(other.corner + other.size) | end.cmple(other.corner)).any();
                    prop_assert!(apart, "{:?} {:?}", tile, other);
                }
            }
        }
    }

    #[test]
    fn tiles_keep_their_shape() {
        let tiles = layout(&[[200, 100], [50, 100]], [800, 400]);
        assert_eq!(tiles[0], Tile { corner: Vec2::new(4.0, 296.0), size: Vec2::new(200.0, 100.0) });
        assert_eq!(tiles[1], Tile { corner: Vec2::new(208.0, 296.0), size: Vec2::new(50.0, 100.0) });
    }
}
