//! Structs that Rust writes and WGSL reads are the same size on both sides.

use super::debug::{CellsUniform, CoverageUniform, Line, PointsUniform, TileUniform};
use super::direct::RegionUniform;
use super::direct::area::AreaUniform;
use super::direct::area_shadows::ShadowsUniform;
use super::direct::area_tiles::TilesUniform;
use super::direct::tiled::LightsUniform;
use super::frame::ViewUniform;
use super::haze::HazeUniform;
use super::indirect::accumulate::AverageUniform;
use super::indirect::instant_radiosity::{
    LetterUniform, MainLightUniform, MapPlaceUniform, NearUniform, ShadeUniform, VirtualLight,
};
use super::indirect::light_culling::{
    ChancesUniform, CullingUniform, DeltaUniform, ParticleLight, PlaceUniform, PlacingUniform,
};
use super::indirect::light_volumes::sweep::{
    CollectUniform, EmitUniform, GatherUniform, LookupUniform, MarchUniform, MirrorFilterUniform, MirrorUniform,
    ReachUniform, ShiftUniform, SumUniform, UpsampleUniform,
};
use super::indirect::light_volumes::{
    CameraSamplesUniform, DrawUniform, EmissionUniform, FirstBounceUniform, LinksUniform, OcclusionUniform,
    PropagationUniform, RelightUniform, RelitRegionUniform, VolumeUniform,
};
use super::indirect::mirror_average::MirrorAverageUniform;
use super::indirect::path_tracer::{ResolveUniform, TraceUniform};
use super::indirect::sky_reflection::ReflectionUniform;
use super::indirect::variance_filter::VarianceFilterUniform;
use super::post::bloom::BloomUniform;
use super::post::compare::CompareUniform;
use super::post::compose::ComposeUniform;
use super::post::depth_of_field::FocusUniform;
use super::post::film::FilmUniform;
use super::post::temporal_antialiasing::SmoothUniform;
use super::post::tone_map::ToneMapUniform;
use super::rays::{Emitter, GlassBoxUniform, RayMaterial};
use super::scene_gpu::light_uniform::LightUniform;
use super::scene_gpu::media::MediumUniform;
use super::scene_gpu::surfels::PatchGrid;
use super::scene_gpu::{Instance, MaterialUniform};
use super::shadows::reflective::{RsmLayerUniform, RsmViewUniform};
use super::shadows::shadow_map::{ShadowUniform, ShadowViewUniform};
use super::shadows::through_glass::ThroughGlassUniform;
use super::transparency::blend::BlendUniform;
use super::transparency::glass::SeenThroughUniform;
use crate::assets::Ball;
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
    check(&gpu, LinksUniform::min_size().get(), "indirect/light_volumes/radiosity/links.wgsl", "Links");
    check(
        &gpu,
        FirstBounceUniform::min_size().get(),
        "indirect/light_volumes/radiosity/first_bounce.wgsl",
        "FirstBounce",
    );
    check(&gpu, HazeUniform::min_size().get(), "haze/integrate.wgsl", "Haze");
    check(&gpu, MediumUniform::min_size().get(), "haze/integrate.wgsl", "Medium");
    check(&gpu, MirrorUniform::min_size().get(), "indirect/light_volumes/sweep/mirror.wgsl", "Mirror");
    check(
        &gpu,
        MirrorFilterUniform::min_size().get(),
        "indirect/light_volumes/sweep/mirror_filter.wgsl",
        "MirrorFilter",
    );
    check(&gpu, MirrorAverageUniform::min_size().get(), "indirect/mirror_average.wgsl", "MirrorAverage");
    check(&gpu, ViewUniform::min_size().get(), "geometry/gbuffer.wgsl", "View");
    check(&gpu, MaterialUniform::min_size().get(), "geometry/gbuffer.wgsl", "Material");
    check(&gpu, size_of::<Instance>() as u64, "geometry/gbuffer.wgsl", "Instance");
    check(&gpu, ShadowViewUniform::min_size().get(), "shadows/shadow_map.wgsl", "ShadowView");
    check(&gpu, ShadowUniform::min_size().get(), "direct/direct.wgsl", "Shadow");
    check(&gpu, LightUniform::min_size().get(), "direct/direct.wgsl", "Light");
    check(&gpu, RegionUniform::min_size().get(), "direct/direct.wgsl", "Region");
    check(&gpu, LightsUniform::min_size().get(), "direct/tiled.wgsl", "Lights");
    check(&gpu, AreaUniform::min_size().get(), "direct/area.wgsl", "Area");
    check(&gpu, ShadowsUniform::min_size().get(), "direct/area_shadows.wgsl", "Shadows");
    check(&gpu, TilesUniform::min_size().get(), "direct/area_tiles.wgsl", "Tiles");
    check(&gpu, LightUniform::min_size().get(), "direct/tiled.wgsl", "Light");
    check(&gpu, ComposeUniform::min_size().get(), "post/compose.wgsl", "Compose");
    check(&gpu, AverageUniform::min_size().get(), "indirect/accumulate.wgsl", "Average");
    check(&gpu, VarianceFilterUniform::min_size().get(), "indirect/variance_filter.wgsl", "VarianceFilter");
    check(&gpu, ReflectionUniform::min_size().get(), "indirect/sky_reflection.wgsl", "Reflection");
    check(&gpu, BlendUniform::min_size().get(), "transparency/blend.wgsl", "Blend");
    check(&gpu, SeenThroughUniform::min_size().get(), "transparency/glass.wgsl", "SeenThrough");
    check(&gpu, GlassBoxUniform::min_size().get(), "transparency/glass.wgsl", "GlassBox");
    check(&gpu, ThroughGlassUniform::min_size().get(), "shadows/through_glass.wgsl", "ThroughGlass");
    check(&gpu, RsmViewUniform::min_size().get(), "shadows/reflective.wgsl", "RsmView");
    check(&gpu, RsmLayerUniform::min_size().get(), "indirect/light_volumes/diffusion/inject.wgsl", "RsmLayer");
    check(&gpu, VolumeUniform::min_size().get(), "indirect/light_volumes/diffusion/inject.wgsl", "Volume");
    check(
        &gpu,
        CameraSamplesUniform::min_size().get(),
        "indirect/light_volumes/diffusion/blockers.wgsl",
        "CameraSamples",
    );
    check(&gpu, PropagationUniform::min_size().get(), "indirect/light_volumes/diffusion/propagate.wgsl", "Propagation");
    let emitters = "indirect/light_volumes/diffusion/inject_emitters.wgsl";
    check(&gpu, EmissionUniform::min_size().get(), emitters, "Emission");
    let printed = "indirect/light_volumes/diffusion/propagate_printed.wgsl";
    check(&gpu, PropagationUniform::min_size().get(), printed, "Propagation");
    check(&gpu, RelightUniform::min_size().get(), "indirect/light_volumes/diffusion/relight.wgsl", "Relight");
    check(&gpu, RelightUniform::min_size().get(), "indirect/light_volumes/diffusion/gloss_march.wgsl", "Relight");
    check(&gpu, RelitRegionUniform::min_size().get(), "indirect/light_volumes/diffusion/relight.wgsl", "Region");
    let occlusion = "indirect/light_volumes/diffusion/ambient_occlusion.wgsl";
    check(&gpu, OcclusionUniform::min_size().get(), occlusion, "Occlusion");
    check(&gpu, TraceUniform::min_size().get(), "indirect/path_tracer/path_trace.wgsl", "Trace");
    check(&gpu, GatherUniform::min_size().get(), "indirect/light_volumes/sweep/gather.wgsl", "Gather");
    check(&gpu, ReachUniform::min_size().get(), "indirect/light_volumes/sweep/gather_filter.wgsl", "Reach");
    check(&gpu, ShiftUniform::min_size().get(), "indirect/light_volumes/sweep/gather_shift.wgsl", "Shift");
    check(&gpu, UpsampleUniform::min_size().get(), "indirect/light_volumes/sweep/gather_upsample.wgsl", "Upsample");
    check(&gpu, DrawUniform::min_size().get(), "indirect/light_volumes/diffusion/inject_samples.wgsl", "Draw");
    check(&gpu, DrawUniform::min_size().get(), "indirect/light_volumes/sweep/rsm_samples.wgsl", "Draw");
    check(&gpu, ResolveUniform::min_size().get(), "indirect/path_tracer/resolve.wgsl", "Resolve");
    let particle_lights = "indirect/light_culling/particle_lights.wgsl";
    check(&gpu, PlacingUniform::min_size().get(), particle_lights, "Placing");
    check(&gpu, size_of::<ParticleLight>() as u64, particle_lights, "ParticleLight");
    check(&gpu, size_of::<Ball>() as u64, "transparency/particles.wgsl", "Ball");
    let rays = "indirect/path_tracer/path_trace.wgsl";
    check(&gpu, size_of::<RayMaterial>() as u64, rays, "Material");
    check(&gpu, size_of::<Emitter>() as u64, rays, "Emitter");
    check(&gpu, EmitUniform::min_size().get(), "indirect/light_volumes/sweep/emit.wgsl", "Emit");
    check(&gpu, LookupUniform::min_size().get(), "indirect/light_volumes/sweep/irradiance.wgsl", "Lookup");
    check(&gpu, MarchUniform::min_size().get(), "indirect/light_volumes/sweep/transport.wgsl", "March");
    check(&gpu, CollectUniform::min_size().get(), "indirect/light_volumes/sweep/collect.wgsl", "Collect");
    check(&gpu, SumUniform::min_size().get(), "indirect/light_volumes/sweep/sum.wgsl", "Sum");
    check(&gpu, size_of::<PatchGrid>() as u64, "indirect/light_volumes/radiosity/links.wgsl", "PatchGrid");
    check(&gpu, size_of::<Surfel>() as u64, "indirect/light_volumes/sweep/emit.wgsl", "Surfel");
    check(&gpu, ShadeUniform::min_size().get(), "indirect/instant_radiosity/shade.wgsl", "Shade");
    check(&gpu, NearUniform::min_size().get(), "indirect/instant_radiosity/near.wgsl", "Near");
    check(&gpu, LetterUniform::min_size().get(), "indirect/instant_radiosity/published.wgsl", "Letter");
    check(&gpu, MainLightUniform::min_size().get(), "indirect/instant_radiosity/main_light.wgsl", "MainLight");
    check(&gpu, MapPlaceUniform::min_size().get(), "indirect/instant_radiosity/place.wgsl", "Place");
    check(&gpu, size_of::<VirtualLight>() as u64, "indirect/instant_radiosity/shade.wgsl", "VirtualLight");
    check(&gpu, PlaceUniform::min_size().get(), "indirect/light_culling/lights.wgsl", "Place");
    for shader in ["cull", "shade", "splat", "frames", "filter"] {
        let shader = &format!("indirect/light_culling/{shader}.wgsl");
        check(&gpu, CullingUniform::min_size().get(), shader, "Culling");
    }
    check(&gpu, DeltaUniform::min_size().get(), "indirect/light_culling/delta.wgsl", "Delta");
    check(&gpu, ChancesUniform::min_size().get(), "indirect/light_culling/range.wgsl", "Chances");
    check(&gpu, 96, "indirect/light_culling/lights.wgsl", "VirtualLight");
    check(&gpu, 64, "indirect/light_culling/range.wgsl", "LightRange");
    check(&gpu, 48, "indirect/light_culling/frames.wgsl", "TestFrame");
    check(&gpu, CompareUniform::min_size().get(), "post/compare.wgsl", "Compare");
    check(&gpu, size_of::<Line>() as u64, "debug/lines.wgsl", "Line");
    check(&gpu, CellsUniform::min_size().get(), "debug/cells.wgsl", "Cells");
    check(&gpu, CoverageUniform::min_size().get(), "debug/coverage.wgsl", "Coverage");
    check(&gpu, PointsUniform::min_size().get(), "debug/points.wgsl", "Points");
    check(&gpu, TileUniform::min_size().get(), "debug/targets.wgsl", "Tile");
    check(&gpu, SmoothUniform::min_size().get(), "post/temporal_antialiasing.wgsl", "Smooth");
    check(&gpu, BloomUniform::min_size().get(), "post/bloom.wgsl", "Bloom");
    check(&gpu, FocusUniform::min_size().get(), "post/depth_of_field.wgsl", "Focus");
    check(&gpu, FilmUniform::min_size().get(), "post/film.wgsl", "Film");
    check(&gpu, ToneMapUniform::min_size().get(), "post/tone_map.wgsl", "ToneMap");
}
