//! The frame as a list of stages.
//!
//! ```text
//! scene ─ gbuffer ──────────────┬─ direct (a pass a light) ─┬─ compose ─ lens ─ tone map
//!      ├─ shadow (a map a light) ┘                           │
//!      ├─ what the method of indirect light declares ─ accumulate, mirror average ─┤
//!      ├─ sky sweep ─ relight, gloss (for methods that have no light of the sky) ┤
//!      ├─ haze scatter ─ haze integrate (where there are media) ─┤
//!      ├─ particle discs (where there are any) ─┤
//!      ├─ second lobe ─ direct and mirror again (clear coats and stretched highlights) ─┤
//!      ├─ compose opaque ─ glass (where there is any: what is seen through it and in it) ─┤
//!      └─ blend (blended surfaces and glass, over all others) ─────────┘
//! ```
//! Nothing is drawn that the image does not read: the layers that show no light ask for no light passes at all,
//! and passes whose inputs have not changed keep their last result (see [`crate::graph`]).

use super::debug;
use super::direct::{self, DirectLight, lamps::Lamps};
use super::error::RenderError;
use super::frame::Frame;
use super::geometry::{GBuffer, gbuffer, second_lobe};
use super::haze;
use super::indirect::light_volumes::Field;
use super::indirect::path_tracer::{self, PathTracer};
use super::indirect::{
    IndirectLight, IndirectMethod, Scattered, accumulate, ambient, lost_light, mirror_average, second_lobe_reflection,
    variance_filter,
};
use super::post::compose::{self, Lights, Purpose, SecondLobe};
use super::post::tone_map::{DISPLAY, TONE_MAPPED};
use super::post::{bloom, compare, depth_of_field, film, mlaa, tone_map};
use super::settings::{Beside, Layer, RenderSettings};
use super::sky::sky_light;
use super::transparency::blend::{self, Behind, Source};
use super::transparency::glass;
use super::transparency::particles;
use crate::gpu::Gpu;
use crate::graph::{Graph, Handle, Texture};
use crate::scene::SceneView;

/// Results of a frame before it is shown.
pub(super) struct Drawn {
    pub gbuffer: GBuffer,
    pub radiance: Handle<Texture>,
    /// Whether there are blended surfaces in it.
    pub has_blended: bool,
}

/// Declares everything up to the radiance.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    method: &'a dyn IndirectMethod,
    gpu: &Gpu,
) -> Result<Drawn, RenderError> {
    let gbuffer = gbuffer::declare(graph, frame);
    let second_lobe = second_lobe::declare(graph, frame, &gbuffer);
    let has_blended = blend::is_needed(graph, frame);
    let surfaces = Drawing { gbuffer: &gbuffer, second_lobe: second_lobe.as_ref(), has_blended };
    let (direct, direct_lights) = declare_direct(graph, frame, method, &surfaces);
    let shows_direct = matches!(frame.settings.only, Layer::Total | Layer::Direct);
    let indirect = declare_indirect(graph, frame, &gbuffer, method, gpu)?;
    let scattered = indirect.as_ref().map(|light| light.scattered).unwrap_or_default();
    let (indirect, mirrored, field) = match indirect {
        Some(light) => {
            let mirrored = light.mirrored.map(|mirrored| mirror_average::declare(graph, frame, &gbuffer, mirrored));
            (Some(declare_mean(graph, frame, &gbuffer, method, &light)), mirrored, light.field)
        }
        None => (None, None, None),
    };
    let sky = sky_light::declare(graph, frame, &gbuffer, method);
    let lobes = second_lobe.as_ref().filter(|_| indirect.is_some() || sky.is_some());
    let second_lobe = lobes.and_then(|lobes| {
        let reflected = second_lobe_reflection::declare(graph, frame, lobes, scattered)?;
        Some(SecondLobe { reflected, gbuffer: *lobes })
    });
    let sky_radiance = sky.as_ref().map(|sky| sky.radiance);
    let sky_field = sky.and_then(|sky| sky.field);
    let lamps = Lamps::of(graph, frame).filter(|_| shows_direct);
    let haze = haze::declare(graph, frame, &gbuffer, lamps, field.clone().or_else(|| sky_field.clone()));
    let particles = particles::declare(graph, frame, &gbuffer, gpu, haze);
    let mut lights =
        Lights { direct, indirect, mirrored, second_lobe, sky: sky_radiance, blended: None, particles, haze };
    if has_blended {
        let source = scattered.patches.map(Source::Patches);
        let source = source.or_else(|| source_of_blended(graph, &gbuffer, [field, sky_field], &lights));
        let direct_lights = if shows_direct { direct_lights } else { Vec::new() };
        let seen_through = declare_glass(graph, frame, &gbuffer, lights, scattered);
        let behind = Behind { source, haze, seen_through };
        lights.blended = Some(blend::declare(graph, frame, &gbuffer, gpu, direct_lights, behind));
    }
    let has_focus = depth_of_field::is_wanted(graph, frame);
    let mut radiance =
        compose::declare(graph, frame, &gbuffer, lights, if has_focus { Purpose::Sharp } else { Purpose::Final });
    if has_focus {
        radiance = depth_of_field::declare(graph, frame, &gbuffer, radiance);
    }
    if frame.settings.only.is_light() {
        radiance = method.declare_overlay(graph, frame, &gbuffer, radiance);
    }
    Ok(Drawn { gbuffer, radiance, has_blended })
}

/// Declares what is seen through glass, and before it the image of what is opaque, without haze and particles: rays find them
/// anew.
fn declare_glass<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    lights: Lights,
    scattered: Scattered,
) -> Option<Handle<Texture>> {
    let place = glass::region(graph, frame).zip(frame.shadow_rays)?;
    let opaque =
        compose::declare(graph, frame, gbuffer, Lights { haze: None, particles: None, ..lights }, Purpose::Opaque);
    Some(glass::declare(graph, frame, gbuffer.depth, opaque, scattered, place))
}

/// The surfaces that direct light meets.
struct Drawing<'g> {
    gbuffer: &'g GBuffer,
    second_lobe: Option<&'g GBuffer>,
    has_blended: bool,
}

/// Declares the lights' own light, and finds those that blended surfaces and media need.
fn declare_direct<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    method: &'a dyn IndirectMethod,
    surfaces: &Drawing,
) -> (Option<Handle<Texture>>, Vec<DirectLight<'a>>) {
    let has_haze = haze::is_needed(frame);
    if !matches!(frame.settings.only, Layer::Total | Layer::Direct) {
        graph.skip("direct", "the layer that is shown holds no direct light");
        let lamps = if has_haze { direct::direct_lights(graph, frame) } else { Vec::new() };
        return (None, lamps);
    }
    let own = method.declare_direct(graph, frame, surfaces.gbuffer);
    let is_needed = own.is_none() || surfaces.has_blended || surfaces.second_lobe.is_some() || has_haze;
    let direct_lights = if is_needed { direct::direct_lights(graph, frame) } else { Vec::new() };
    let mut direct = own.unwrap_or_else(|| direct::declare(graph, frame, surfaces.gbuffer, &direct_lights));
    if let Some(lobes) = surfaces.second_lobe {
        direct = direct::add(graph, frame, lobes, direct, &direct_lights);
    }
    (Some(direct), direct_lights)
}

fn declare_indirect<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &'a dyn IndirectMethod,
    gpu: &Gpu,
) -> Result<Option<IndirectLight>, RenderError> {
    if frame.settings.only.shows_indirect() {
        lost_light::of(frame, method).into_iter().for_each(|warning| graph.warn(warning));
        return method.declare(graph, frame, gbuffer, gpu);
    }
    graph.skip("indirect", "the layer that is shown holds no indirect light");
    Ok(None)
}

/// The mean of the light over frames, without the noise that is left in it.
fn declare_mean<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &dyn IndirectMethod,
    light: &IndirectLight,
) -> Handle<Texture> {
    let mean = accumulate::declare(graph, frame, gbuffer, light);
    // While anything moves its time, .1 s of a processor for 512×512 pixels in software, is better spent on the next frame.
    if frame.history.step().is_none_or(|step| step.rested == 0) || !method.varies(frame.scene) {
        graph.skip("variance filter", "the image is not at rest, or has no noise");
        return mean;
    }
    variance_filter::declare(graph, frame, gbuffer, mean)
}

/// Where blended surfaces find indirect light: in a field of the method or else of the sky, if that is all there is;
/// otherwise at the pixels behind them.
fn source_of_blended(
    graph: &mut Graph,
    gbuffer: &GBuffer,
    [field, sky]: [Option<Field>; 2],
    lights: &Lights,
) -> Option<Source> {
    let sources = [lights.indirect, lights.sky].into_iter().flatten().collect::<Vec<_>>();
    match (field, sky) {
        (Some(field), None) => Some(Source::Field(Box::new(field))),
        (None, Some(sky)) if lights.indirect.is_none() => Some(Source::Field(Box::new(sky))),
        _ if sources.is_empty() => None,
        _ => Some(Source::Ambient(ambient::declare(graph, gbuffer, &sources))),
    }
}

/// Continues the reference, and shows it beside the drawn image.
pub(super) fn declare_beside<'a>(
    graph: &mut Graph<'a>,
    settings: &RenderSettings,
    radiance: Handle<Texture>,
    tracer: &'a mut PathTracer,
    beside: &Beside,
) -> Handle<Texture> {
    let traced = path_tracer::declare(graph, tracer, "traced radiance", settings.only, &beside.reference);
    compare::declare(graph, radiance, traced, beside.shown)
}

/// Asks for the radiance, and where it is wanted for the display image of `shown`, with what is drawn over it.
pub(super) fn finish<'a>(
    graph: &mut Graph<'a>,
    settings: &RenderSettings,
    radiance: Handle<Texture>,
    shown: Handle<Texture>,
    view: &SceneView,
    drawn: Option<(&Frame<'a>, &GBuffer, &'a dyn IndirectMethod)>,
) {
    graph.output(radiance);
    if !settings.display {
        graph.skip("tone map", "no display image is wanted");
        return;
    }
    let lens = &view.camera.lens;
    let shown = match &lens.bloom {
        Some(bloom) if tone_map::shows_light(settings) => bloom::declare(graph, bloom, shown, view.size),
        Some(_) => {
            graph.skip("bloom", "the layer that is shown holds no light");
            shown
        }
        None => shown,
    };
    let has_film = film::is_wanted(lens) && tone_map::shows_light(settings);
    let is_last = |name| if has_film { name } else { DISPLAY };
    let name = if settings.mlaa { TONE_MAPPED } else { is_last(TONE_MAPPED) };
    let mut display = tone_map::declare(graph, settings, &view.camera, shown, view.size, name);
    if settings.mlaa {
        let (edges, gbuffer) = (settings.mlaa_edges, drawn.map(|(_, gbuffer, _)| gbuffer));
        display = mlaa::declare(graph, display, is_last("smooth display"), view.size, edges, gbuffer);
    } else {
        graph.skip("mlaa", "anti-aliasing is off");
    }
    if has_film {
        display = film::declare(graph, lens, settings.moment, display, view.size);
    }
    match drawn {
        _ if settings.debug.is_empty() => {}
        Some((frame, gbuffer, method)) => display = debug::declare(graph, frame, gbuffer, method, display),
        None => graph.skip("debug", "a path-traced frame has no depth to draw over; use a drawn method"),
    }
    graph.output(display);
}
