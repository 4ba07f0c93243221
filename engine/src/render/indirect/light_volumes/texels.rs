//! Work for each texel of reflective shadow maps, which both ways of transport begin with.

use crate::graph::{ComputeBuilder, Counts, Step};
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::reflective::Rsm;
use std::ops::Range;

/// Declares a step for each of some layers of an RSM, at an entry point with a thread for each texel. `scale` turns flux into
/// the fixed point of its sums, `light` is the RSM's light as the shader needs it, and `bind` binds the rest of the shader's inputs.
pub(super) fn declare_steps<'g, 'a>(
    pass: &mut ComputeBuilder<'g, 'a>,
    entry: &'static str,
    (rsm, layers): (&Rsm<'a>, Range<usize>),
    (scale, light): (f32, LightUniform),
    bind: impl Fn(&mut Step<'_, 'g, 'a>),
) {
    pass.count(Counts { injections: layers.len() as u64 * rsm.layer_texels(), ..Counts::default() });
    for layer in layers {
        let mut step = pass.step(entry);
        step.uniform("light", &light);
        step.uniform("rsm", &rsm.layer_uniform(layer, scale));
        step.read("base_color", rsm.base_color);
        step.read("normal", rsm.normal);
        step.read("depth", rsm.depth);
        bind(&mut step);
        step.over_uncounted([rsm.size; 2]);
    }
}
