//! The sum over all virtual lights at what the camera sees.

use super::particles::{Lights, VirtualLights};
use super::trace_particles::VirtualLight;
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::gloss;
use crate::render::rays::dispatch_rays;
use crate::world::{InstantRadiosity, VirtualShading, VirtualVisibility};
use encase::ShaderType;

/// `Shade` of `indirect/instant_radiosity/shade.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ShadeUniform {
    first: u32,
    end: u32,
    root: u32,
    begin: u32,
    finish: u32,
    scale: f32,
}

/// Pixels times lights of one submit: a submit of a second may cost the device on desktop drivers. Rays take longer.
const PAIRS_A_SUBMIT: u64 = 1 << 27;
const RAYS_A_SUBMIT: u64 = 1 << 23;
/// Lights of one dispatch. lavapipe ends all loops of a thread after 65,535 turns together, without a word, and a ray
/// takes some hundred of them in a large scene.
const LIGHTS_A_DISPATCH: u64 = 1 << 15;
const RAYS_A_DISPATCH: u64 = 1 << 7;
/// Ranges of a buffer begin at multiples of this many lights: 80 bytes times 16 are five times 256.
const ALIGNMENT: u32 = 16;

/// Declares the pass; the result is reflected radiance.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    state: &'a VirtualLights,
    lights: Lights,
) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let sums = TextureDesc::d2_array(width, height, 3, wgpu::TextureFormat::R32Float, usage);
    let sums = graph.texture("virtual light sums", sums);
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let indirect = graph.retained_texture("indirect radiance", desc);
    // By hand: the number of lights, and so of dispatches, is known once the particles are traced.
    let mut pass = graph.pass("vpl shade");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
    for input in inputs {
        pass.read(input);
    }
    pass.read(lights.buffer);
    let (sums, indirect) = (pass.write(sums), pass.write(indirect));
    let settings = &state.settings;
    pass.key(&(frame.view_key(), settings.visibility, settings.shading, frame.settings.virtual_light));
    pass.key(&surfaces_key(frame, settings));
    let work = Work { frame: frame.clone(), state, inputs, lights, sums, indirect };
    pass.execute(move |cx| work.run(cx));
    indirect
}

/// What shadow rays meet: surfaces that may be in no image that the pass reads. And which terms of the surfaces' shading
/// there are at all.
pub(super) fn surfaces_key(frame: &Frame, settings: &InstantRadiosity) -> impl std::hash::Hash + use<> {
    let shadowed = settings.visibility == VirtualVisibility::ShadowRays;
    (shadowed.then(|| (frame.geometry_key(), frame.media_key())), gloss::is_wanted(frame.scene))
}

struct Work<'a> {
    frame: Frame<'a>,
    state: &'a VirtualLights,
    inputs: [Handle<Texture>; 4],
    lights: Lights,
    sums: Handle<Texture>,
    indirect: Handle<Texture>,
}

/// The lights to sum: all, or the one that is asked for.
pub(super) fn range(
    state: &VirtualLights,
    lights: &Lights,
    only: Option<u32>,
) -> Result<std::ops::Range<u32>, PassError> {
    let count = state.count(lights);
    match only {
        None => Ok(0..count),
        Some(index) if index < count => Ok(index..index + 1),
        Some(index) => {
            Err(PassError::message(format!("there is no virtual light {index}: there are {count}, counted from 0")))
        }
    }
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        let range = range(self.state, &self.lights, self.frame.settings.virtual_light)?;
        let [width, height] = self.frame.view.size.map(u64::from);
        let rays = self.state.settings.visibility == VirtualVisibility::ShadowRays;
        let (submit, dispatch) = match rays {
            true => (RAYS_A_SUBMIT, RAYS_A_DISPATCH),
            false => (PAIRS_A_SUBMIT, LIGHTS_A_DISPATCH),
        };
        let most = (submit / (width * height)).min(dispatch);
        let most_bound = cx.gpu.limits.max_storage_buffer_binding_size / size_of::<VirtualLight>() as u64;
        let step = (most.min(most_bound).min(1 << 24) as u32 / ALIGNMENT).max(1) * ALIGNMENT;
        let counts = cx.counts();
        counts.lights += u64::from(range.end - range.start);
        counts.texels += width * height;
        if rays {
            counts.paths += width * height * u64::from(range.end - range.start);
        }
        let mut first = range.start;
        loop {
            let end = (first / ALIGNMENT * ALIGNMENT).saturating_add(step).min(range.end);
            let pairs = |lights: u32| u64::from(lights) * width * height;
            // How many lights a dispatch sums decides how the sums are rounded: only the submits follow the time.
            cx.work(pairs(end - first), pairs(step))?;
            self.dispatch(cx, first..end, [first == range.start, end == range.end])?;
            if end == range.end {
                return Ok(());
            }
            first = end;
        }
    }

    fn dispatch(
        &self,
        cx: &mut PassContext,
        lights: std::ops::Range<u32>,
        [begin, finish]: [bool; 2],
    ) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let [base_color, normal, object, depth] = self.inputs.map(|handle| cx.view(handle));
        let (sums, indirect) = (cx.view(self.sums), cx.view(self.indirect));
        let origin = lights.start / ALIGNMENT * ALIGNMENT;
        let size = u64::from((lights.end - origin).max(1)) * size_of::<VirtualLight>() as u64;
        let offset = u64::from(origin) * size_of::<VirtualLight>() as u64;
        let shade = ShadeUniform {
            first: lights.start - origin,
            end: lights.end - origin,
            root: self.state.rays.root(),
            begin: u32::from(begin),
            finish: u32::from(finish),
            scale: 1.0,
        };
        let buffer = cx.buffer(self.lights.buffer).clone();
        let (view, shade) = (self.frame.view_uniform(gpu), gpu.uniform("shade", &shade));
        let group = [
            ("view", Binding::Buffer(&view)),
            ("shade", Binding::Buffer(&shade)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("virtual_lights", Binding::BufferRange(&buffer, offset, size)),
            ("sums", Binding::Texture(&sums)),
            ("indirect", Binding::Texture(&indirect)),
        ];
        let [width, height] = self.frame.view.size;
        let groups = [width.div_ceil(8), height.div_ceil(8), 1];
        let published = self.state.settings.shading == VirtualShading::AsPublished;
        let matte = !gloss::is_wanted(self.frame.scene);
        let with = |key: ComputeKey, name: &'static str, set: bool| {
            if set { key.def(name, ShaderDef::Flag(true)) } else { key }
        };
        if self.state.settings.visibility == VirtualVisibility::ShadowRays && !published {
            let key = with(self.state.rays.shader("indirect/instant_radiosity/shade.wgsl", "main"), "MATTE", matte);
            return dispatch_rays(cx, &key, &group, &self.state.rays, groups);
        }
        let key =
            ComputeKey::new("indirect/instant_radiosity/shade.wgsl", "main").def("UNSHADOWED", ShaderDef::Flag(true));
        let key = with(key, "MATTE", matte);
        cx.dispatch(&with(key, "PUBLISHED", published), &group, groups)
    }
}
