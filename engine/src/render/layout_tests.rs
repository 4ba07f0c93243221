//! Structs that Rust writes and WGSL reads are the same size on both sides.

use super::average::AverageUniform;
use super::blend::BlendUniform;
use super::compare::CompareUniform;
use super::compose::ComposeUniform;
use super::debug::{CellsUniform, CoverageUniform, Line, PointsUniform};
use super::direct::Region;
use super::direct_tiled::LightsUniform;
use super::frame::ViewUniform;
use super::gpu_scene::{Instance, MaterialUniform};
use super::light_uniform::LightUniform;
use super::lpv::sweep::{DrawUniform, EmitUniform, GatherUniform, LookupUniform, SliceUniform, SumUniform};
use super::lpv::{CameraSamplesUniform, PropagationUniform, RelightUniform, VolumeUniform};
use super::post::tone_map::ToneMapUniform;
use super::ray_scene::{Emitter, RayMaterial};
use super::reference::{ResolveUniform, TraceUniform};
use super::rsm::{RsmLayerUniform, RsmViewUniform};
use super::shadow::{ShadowUniform, ShadowViewUniform};
use super::sky_light::ReflectionUniform;
use super::slc::{ChancesUniform, CullingUniform, DeltaUniform, PlaceUniform};
use super::vpl::{LetterUniform, MainLightUniform, MapPlaceUniform, NearUniform, ShadeUniform, VirtualLight};
use crate::gpu::{Gpu, GpuOptions, default_shader_dir};
use crate::scene::Surfel;
use encase::ShaderType;

fn gpu() -> Gpu {
    let options = GpuOptions { adapter: None, shader_dir: default_shader_dir().expect("shaders") };
    Gpu::headless(&options).expect("a Vulkan driver")
}

fn check(gpu: &Gpu, size: u64, shader: &str, name: &str) {
    let layout = gpu.shaders.struct_layout(shader, name).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(size, u64::from(layout.size), "{name} of {shader}: {layout:?}");
}

#[test]
fn rust_and_wgsl_agree_on_every_struct() {
    let gpu = gpu();
    check(&gpu, ViewUniform::min_size().get(), "gbuffer.wgsl", "View");
    check(&gpu, MaterialUniform::min_size().get(), "gbuffer.wgsl", "Material");
    check(&gpu, size_of::<Instance>() as u64, "gbuffer.wgsl", "Instance");
    check(&gpu, ShadowViewUniform::min_size().get(), "shadow.wgsl", "ShadowView");
    check(&gpu, ShadowUniform::min_size().get(), "direct.wgsl", "Shadow");
    check(&gpu, LightUniform::min_size().get(), "direct.wgsl", "Light");
    check(&gpu, Region::min_size().get(), "direct.wgsl", "Region");
    check(&gpu, LightsUniform::min_size().get(), "direct_tiled.wgsl", "Lights");
    check(&gpu, LightUniform::min_size().get(), "direct_tiled.wgsl", "Light");
    check(&gpu, ComposeUniform::min_size().get(), "compose.wgsl", "Compose");
    check(&gpu, AverageUniform::min_size().get(), "average.wgsl", "Average");
    check(&gpu, ReflectionUniform::min_size().get(), "sky_reflection.wgsl", "Reflection");
    check(&gpu, BlendUniform::min_size().get(), "blend.wgsl", "Blend");
    check(&gpu, RsmViewUniform::min_size().get(), "rsm.wgsl", "RsmView");
    check(&gpu, RsmLayerUniform::min_size().get(), "lpv/inject.wgsl", "RsmLayer");
    check(&gpu, VolumeUniform::min_size().get(), "lpv/inject.wgsl", "Volume");
    check(&gpu, CameraSamplesUniform::min_size().get(), "lpv/blockers.wgsl", "CameraSamples");
    check(&gpu, PropagationUniform::min_size().get(), "lpv/propagate.wgsl", "Propagation");
    check(&gpu, RelightUniform::min_size().get(), "lpv/relight.wgsl", "Relight");
    check(&gpu, TraceUniform::min_size().get(), "reference/path_trace.wgsl", "Trace");
    check(&gpu, GatherUniform::min_size().get(), "lpv/sweep/gather.wgsl", "Gather");
    check(&gpu, DrawUniform::min_size().get(), "lpv/sweep/lit_points.wgsl", "Draw");
    check(&gpu, ResolveUniform::min_size().get(), "reference/resolve.wgsl", "Resolve");
    let rays = "reference/path_trace.wgsl";
    check(&gpu, size_of::<RayMaterial>() as u64, rays, "Material");
    check(&gpu, size_of::<Emitter>() as u64, rays, "Emitter");
    check(&gpu, EmitUniform::min_size().get(), "lpv/sweep/emit.wgsl", "Emit");
    check(&gpu, LookupUniform::min_size().get(), "lpv/sweep/irradiance.wgsl", "Lookup");
    check(&gpu, SliceUniform::min_size().get(), "lpv/sweep/transport.wgsl", "Slice");
    check(&gpu, SumUniform::min_size().get(), "lpv/sweep/sum.wgsl", "Sum");
    check(&gpu, size_of::<Surfel>() as u64, "lpv/sweep/emit.wgsl", "Surfel");
    check(&gpu, ShadeUniform::min_size().get(), "vpl/shade.wgsl", "Shade");
    check(&gpu, NearUniform::min_size().get(), "vpl/near.wgsl", "Near");
    check(&gpu, LetterUniform::min_size().get(), "vpl/letter.wgsl", "Letter");
    check(&gpu, MainLightUniform::min_size().get(), "vpl/main_light.wgsl", "MainLight");
    check(&gpu, MapPlaceUniform::min_size().get(), "vpl/place.wgsl", "Place");
    check(&gpu, size_of::<VirtualLight>() as u64, "vpl/shade.wgsl", "VirtualLight");
    check(&gpu, PlaceUniform::min_size().get(), "slc/lights.wgsl", "Place");
    for shader in ["slc/cull.wgsl", "slc/shade.wgsl", "slc/splat.wgsl", "slc/filter.wgsl"] {
        check(&gpu, CullingUniform::min_size().get(), shader, "Culling");
    }
    check(&gpu, DeltaUniform::min_size().get(), "slc/delta.wgsl", "Delta");
    check(&gpu, ChancesUniform::min_size().get(), "slc/range.wgsl", "Chances");
    check(&gpu, 96, "slc/lights.wgsl", "VirtualLight");
    check(&gpu, 64, "slc/range.wgsl", "LightRange");
    check(&gpu, CompareUniform::min_size().get(), "compare.wgsl", "Compare");
    check(&gpu, size_of::<Line>() as u64, "debug/lines.wgsl", "Line");
    check(&gpu, CellsUniform::min_size().get(), "debug/cells.wgsl", "Cells");
    check(&gpu, CoverageUniform::min_size().get(), "debug/coverage.wgsl", "Coverage");
    check(&gpu, PointsUniform::min_size().get(), "debug/points.wgsl", "Points");
    check(&gpu, ToneMapUniform::min_size().get(), "post/tone_map.wgsl", "ToneMap");
}
