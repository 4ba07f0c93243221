//! Temporal anti-aliasing: smooth edges by the mean over frames whose pixel grids are shifted (Karis 2014, "High-quality
//! temporal supersampling"). A view that rests is the mean of its frames; where anything moves, what is remembered may not
//! leave what is seen around the pixel now. See `post/temporal_antialiasing.wgsl`.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::settings::{Layer, RenderSettings};
use crate::scene::SceneView;
use encase::ShaderType;
use glam::Mat4;

/// Frames before that count at most while anything moves.
const MOST_WHILE_CHANGING: f32 = 9.0;
/// Shifts before they come again.
const SHIFTS: u32 = 1 << 12;

/// `Smooth` of `post/temporal_antialiasing.wgsl`.
#[derive(ShaderType)]
pub(crate) struct SmoothUniform {
    view: ViewUniform,
    unshifted: Mat4,
    unshifted_before: Mat4,
    most: f32,
    exposure: f32,
    is_known: u32,
    is_still: u32,
    is_bounded: u32,
}

/// Whether the edges of a frame that is averaged may be smoothed so: of images that are looked at, without anything that is
/// drawn over them, which would tremble with the shifts, and without a reference beside, which has none.
pub(in crate::render) fn is_possible(settings: &RenderSettings, view: &SceneView) -> bool {
    settings.mlaa
        && settings.display
        && settings.only == Layer::Total
        && settings.debug.is_empty()
        && settings.beside.is_none()
        && view.jitter == [0.0; 2]
}

/// Shift of the pixel grid of a frame \[pixels\]: points of Halton's sequence in bases 2 and 3, less their mean.
pub(in crate::render) fn jitter(number: u32) -> [f32; 2] {
    [2, 3].map(|base| radical_inverse(number % SHIFTS + 1, base) - 0.5)
}

fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut place) = (0.0, 1.0 / f64::from(base));
    while index > 0 {
        value += f64::from(index % base) * place;
        index /= base;
        place /= f64::from(base);
    }
    value as f32
}

/// Declares the pass; the result is linear radiance with smooth edges, rgba32float. None if that is not wanted.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    radiance: Handle<Texture>,
) -> Option<Handle<Texture>> {
    let (step, colors) = frame.history.step().zip(frame.history.colors())?;
    let smooth = graph.retained_texture("smooth radiance", frame.image_desc());
    let mut pass = graph.pass("temporal anti-aliasing");
    [radiance, gbuffer.object, gbuffer.depth].into_iter().for_each(|handle| pass.read(handle));
    let smooth = pass.write(smooth);
    let exposure = frame.settings.exposure + frame.settings.show.exposure;
    let exposure = if exposure.is_finite() { exposure.clamp(-60.0, 60.0).exp2() } else { 1.0 };
    pass.key(&(step.row, step.number, frame.view_key(), exposure.to_bits(), colors.is_known()));
    let [width, height] = frame.view.size;
    let is_resting = step.is_still && step.tolerance == f32::MAX;
    let uniform = SmoothUniform {
        view: frame.view_values(),
        unshifted: step.unshifted[0],
        unshifted_before: step.unshifted[1],
        most: if is_resting { step.most } else { MOST_WHILE_CHANGING },
        exposure,
        is_known: u32::from(colors.is_known()),
        is_still: u32::from(step.is_still),
        is_bounded: u32::from(!is_resting),
    };
    let (gbuffer, frame) = (*gbuffer, frame.clone());
    pass.execute(move |cx| {
        let [now, before] = colors.now_and_before();
        let [radiance, object, depth, target] =
            [radiance, gbuffer.object, gbuffer.depth, smooth].map(|handle| cx.view(handle));
        let uniform = cx.gpu.uniform("smooth", &uniform);
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut key = ComputeKey::new("post/temporal_antialiasing.wgsl", "main");
        let mut group = vec![
            ("smooth_edges", Binding::Buffer(&uniform)),
            ("radiance", Binding::Texture(&radiance)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("color_before", Binding::Texture(before)),
            ("color_now", Binding::Texture(now)),
            ("smoothed", Binding::Texture(&target)),
        ];
        if let Some(moved) = frame.history.motions().buffer() {
            key = key.def("MOVED", ShaderDef::Flag(true));
            group.push(("moved", Binding::Buffer(moved)));
        }
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    Some(smooth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_stay_in_the_pixel_and_have_its_center_as_their_mean() {
        for count in [8, 64, 1000] {
            let shifts: Vec<[f32; 2]> = (0..count).map(jitter).collect();
            assert!(shifts.iter().flatten().all(|shift| (-0.5..=0.5).contains(shift)));
            for axis in 0..2 {
                let mean: f32 = shifts.iter().map(|shift| shift[axis]).sum::<f32>() / count as f32;
                assert!(mean.abs() < 0.7 / count as f32 + 0.02 * f32::from(u8::from(count < 100)), "{count}: {mean}");
            }
        }
    }
}
