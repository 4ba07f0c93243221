//! Depth of field of a thin lens: what is out of focus is spread over its circle of confusion (Potmesil and Chakravarty
//! 1981). Near and far of the plane of focus are gathered apart, as games do (Jimenez 2014, "Next generation post processing
//! in Call of Duty: Advanced Warfare"): what is near covers what is behind it in part, and what is far never comes before
//! what is sharp.
//!
//! The image holds one surface a pixel, so what a blurred object before it hides is guessed from around it. The path tracer
//! has the same lens without that limit. See `post/depth_of_field.wgsl`.

use super::compose::RADIANCE;
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::scene::{SceneCamera, ViewProjection};
use encase::ShaderType;
use wgpu::{TextureFormat, TextureUsages};

/// Largest radius of a circle of confusion, in heights of the image. What is blurred more is blurred by this much.
pub const WIDEST: f32 = 1.0 / 12.0;
/// Edge of a tile of the image, for which one number says how far what is near spreads \[pixels\].
const TILE: u32 = 16;

/// `Focus` of `post/depth_of_field.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, ShaderType)]
pub(crate) struct FocusUniform {
    base: f32,
    slope: f32,
    limit: f32,
}

impl FocusUniform {
    /// The signed radius of the circle of confusion is K·(1 − s/d) pixels at the distance d along the axis, with the plane of
    /// focus at s: positive behind it. K = r/s · height/(2·tan(fov/2)) for a lens of radius r. The reversed depth z of a
    /// perspective has 1/d = (z + a)/b. None: nothing is out of focus.
    pub fn of(camera: &SceneCamera, height: u32) -> Option<Self> {
        let radius = camera.lens_radius()?;
        let focus = camera.lens.depth_of_field.as_ref()?.focus;
        let a = camera.far.map_or(0.0, |far| camera.near / (far - camera.near));
        let b = camera.near * (1.0 + a);
        let widest = radius / focus * 0.5 * height as f32 / camera.half_height();
        // Numbers that are larger blur everything by the limit anyway.
        let bound = |value: f32| if value.is_finite() { value.clamp(-1e30, 1e30) } else { 1e30 };
        let limit = (WIDEST * height as f32).max(1.0);
        Some(Self { base: bound(widest - widest * focus * a / b), slope: bound(widest * focus / b), limit })
    }
}

/// Whether the camera asks for it. An orthographic camera has no lens that focuses.
pub(in crate::render) fn is_wanted(graph: &mut Graph, frame: &Frame) -> bool {
    let camera = &frame.view.camera;
    if camera.lens.depth_of_field.is_none() {
        return false;
    }
    if !frame.settings.only.is_light() {
        graph.skip("depth of field", "the layer that is shown holds no light");
        return false;
    }
    if matches!(camera.projection, ViewProjection::Orthographic { .. }) {
        graph.skip("depth of field", "an orthographic camera has no lens that focuses");
        return false;
    }
    FocusUniform::of(camera, frame.view.size[1]).is_some()
}

/// Declares the passes; the result is rgba32float radiance [W/(m² sr)] as the lens focuses it.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    sharp: Handle<Texture>,
) -> Handle<Texture> {
    let size = frame.view.size;
    let Some(focus) = FocusUniform::of(&frame.view.camera, size[1]) else { return sharp };
    let tiles = size.map(|edge| edge.div_ceil(TILE));
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
    let of_tiles = TextureDesc::d2(tiles[0], tiles[1], TextureFormat::R32Float, usage);
    let circles = graph.texture("circles of confusion", frame.image_desc());
    let nearest = graph.texture("largest near circles", of_tiles.clone());
    let reach = graph.texture("reach of near circles", of_tiles);
    let behind = graph.texture("gathered behind focus", frame.image_desc());
    let near = graph.texture("gathered near of focus", frame.image_desc());
    let mut whole = frame.image_desc();
    if frame.settings.particle_paths > 0 {
        whole.usage |= TextureUsages::RENDER_ATTACHMENT;
    }
    let radiance = graph.retained_texture(RADIANCE, whole);
    let [circles, nearest] = declare_circles(graph, focus, [sharp, gbuffer.depth], [circles, nearest], size);
    let step = Step { name: "depth of field reach", entry: "reach_main", focus, size: tiles };
    let [reach] = step.declare(graph, &[("nearest", nearest)], [("largest", reach)]);
    let step = Step { name: "depth of field", entry: "gather_main", size, ..step };
    let inputs = [("circles", circles), ("reach", reach)];
    let [behind, near] = step.declare(graph, &inputs, [("result", behind), ("near_result", near)]);
    let step = Step { name: "depth of field filter", entry: "filter_main", ..step };
    let [radiance] = step.declare(graph, &[("behind", behind), ("near", near)], [("result", radiance)]);
    radiance
}

/// Declares the pass that writes the circle of each pixel beside its radiance, and the largest near circle of each tile.
fn declare_circles(
    graph: &mut Graph,
    focus: FocusUniform,
    [sharp, depth]: [Handle<Texture>; 2],
    [circles, nearest]: [Handle<Texture>; 2],
    size: [u32; 2],
) -> [Handle<Texture>; 2] {
    let mut pass = graph.compute("depth of field circles", ComputeKey::new("post/depth_of_field.wgsl", "circles_main"));
    pass.uniform("focus", &focus);
    pass.read("sharp", sharp);
    pass.read("depth", depth);
    let circles = pass.write("result", circles);
    let nearest = pass.write("largest", nearest);
    pass.dispatch_over(size);
    [circles, nearest]
}

/// A pass from images to images.
#[derive(Clone, Copy)]
struct Step {
    name: &'static str,
    entry: &'static str,
    focus: FocusUniform,
    /// Texels that it makes.
    size: [u32; 2],
}

type Named = (&'static str, Handle<Texture>);

impl Step {
    fn declare<const N: usize>(self, graph: &mut Graph, inputs: &[Named], outputs: [Named; N]) -> [Handle<Texture>; N] {
        let mut pass = graph.compute(self.name, ComputeKey::new("post/depth_of_field.wgsl", self.entry));
        // Tiles on each side that a circle may reach from.
        pass.define("TILES", ShaderDef::Uint((self.focus.limit / TILE as f32).ceil() as u32));
        inputs.iter().for_each(|&(name, input)| pass.read(name, input));
        let outputs = outputs.map(|(name, output)| pass.write(name, output));
        pass.dispatch_over(self.size);
        outputs
    }
}
