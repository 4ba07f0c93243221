//! The sum over all bounces, which ends in a geometric series.

use super::Irradiance;
use super::transport::Step;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, Handle, PassContext, PassError};
use crate::render::frame::linear_groups;
use encase::ShaderType;

/// `Sum` of `indirect/light_volumes/sweep/sum.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct SumUniform {
    bounce: u32,
    has_tail: u32,
    most: f32,
    padding: u32,
}

/// Bound on the factor from one bounce to the next in the series that ends the sum.
const LARGEST_RATIO: f32 = 0.98;

/// Adds a bounce to the sum.
pub(super) fn add(
    cx: &mut PassContext,
    bounce: Irradiance,
    sum: Irradiance,
    totals: Handle<Buffer>,
    step: Step,
) -> Result<(), PassError> {
    let handles = [totals, bounce.axes, bounce.facing, sum.axes, sum.facing];
    let [totals, axes, facing, all_axes, all_facing] = handles.map(|handle| cx.buffer(handle).clone());
    if step.bounce == 0 {
        for buffer in [&all_axes, &all_facing] {
            cx.encoder().clear_buffer(buffer, 0, None);
        }
    }
    let numbers = (all_axes.size() / 4) as u32;
    cx.dispatch(
        &ComputeKey::new("indirect/light_volumes/sweep/sum.wgsl", "main"),
        &[
            ("sum", Binding::Buffer(&cx.gpu.uniform("sum", &sum_uniform(step)))),
            ("totals", Binding::Buffer(&totals)),
            ("axes", Binding::Buffer(&axes)),
            ("facing", Binding::Buffer(&facing)),
            ("all_axes", Binding::Buffer(&all_axes)),
            ("all_facing", Binding::Buffer(&all_facing)),
        ],
        linear_groups(numbers),
    )
}

/// `Sum` of `indirect/light_volumes/sweep/sum.wgsl` for a bounce.
pub(super) fn sum_uniform(step: Step) -> SumUniform {
    let Step { bounce, bounces, .. } = step;
    let has_tail = u32::from(bounces.has_tail && bounce + 1 == bounces.swept);
    SumUniform { bounce, has_tail, most: LARGEST_RATIO, padding: 0 }
}
