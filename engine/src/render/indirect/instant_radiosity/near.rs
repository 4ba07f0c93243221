//! The light that the bound on virtual lights leaves out, found by short rays. See `indirect/instant_radiosity/near.wgsl`.

use super::particles::{Lights, VirtualLights};
use super::trace_particles::{Particles, VirtualLight};
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{ComputeBuilder, Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::gloss;
use crate::render::rays::dispatch_rays;
use crate::world::{VirtualPlacement, VirtualShading, VirtualVisibility};
use encase::ShaderType;

/// Rays of one submit: a submit of a second may cost the device on desktop drivers.
const RAYS_A_SUBMIT: u64 = 1 << 18;

/// `Near` of `indirect/instant_radiosity/near.wgsl`.
#[derive(ShaderType)]
pub(crate) struct NearUniform {
    view: ViewUniform,
    root: u32,
    light_count: u32,
    virtual_count: u32,
    seed: u32,
    reach: f32,
    glow: f32,
    first_row: u32,
}

/// The contributions of the rays: what a white diffuse surface reflects, and what the specular lobe does.
#[derive(Clone, Copy)]
struct Contribution {
    diffuse: Handle<Texture>,
    specular: Handle<Texture>,
}

/// Declares the rays and the filter over their contributions; the result is `summed` with it. Where no ray is cast, the
/// reason is in the report.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    state: &'a VirtualLights,
    lights: Lights,
    summed: Handle<Texture>,
) -> Handle<Texture> {
    if let Some(why) = why_not(frame, state) {
        graph.skip("near light", why);
        return summed;
    }
    if let Some(warning) = beyond_binding(state.most_kept(), state.most_bound, &frame.scene.settings_names.vpl) {
        graph.warn(warning);
    }
    let work = Work { frame: frame.clone(), gbuffer: *gbuffer, state, lights };
    let brought = work.cast(graph);
    work.filter(graph, brought, summed)
}

fn why_not(frame: &Frame, state: &VirtualLights) -> Option<&'static str> {
    let settings = &state.settings;
    if settings.near_rays == 0 {
        Some("`near_rays` is 0: what the bound on near lights takes away is left out")
    } else if settings.near_bound <= 0.0 {
        Some("`near_bound` is 0: nothing is taken away from near lights")
    } else if settings.shading == VirtualShading::AsPublished {
        Some("the report's shading knows no distance, and no bound")
    } else if settings.visibility == VirtualVisibility::None {
        Some("virtual lights cast no shadows, as no ray finds light")
    } else if settings.placement == VirtualPlacement::Rsm {
        Some("lights from reflective shadow maps have a bound of their own each")
    } else if frame.settings.virtual_light.is_some() {
        Some("one virtual light is shown by itself")
    } else {
        None
    }
}

/// The loss where there may be more lights than the device binds at once.
fn beyond_binding(lights: u64, bound: u64, name: &str) -> Option<String> {
    let who = if name.is_empty() { "the scene's `vpl` component".to_owned() } else { format!("`{name}`") };
    (lights > bound).then(|| {
        format!(
            "{who}: short rays find the light of {bound} virtual lights and not of all {lights}, as this adapter binds no \
             more at once: surfaces close to each other may lack light; use fewer `particles`"
        )
    })
}

#[derive(Clone)]
struct Work<'a> {
    frame: Frame<'a>,
    gbuffer: GBuffer,
    state: &'a VirtualLights,
    lights: Lights,
}

impl<'a> Work<'a> {
    /// Declares the rays.
    fn cast(&self, graph: &mut Graph<'a>) -> Contribution {
        let frame = &self.frame;
        let brought = Contribution {
            diffuse: graph.texture("near diffuse", frame.image_desc()),
            specular: graph.texture("near specular", frame.image_desc()),
        };
        // By hand: the uniform and the part of the lights that is bound are known once the particles are traced.
        let mut pass = graph.pass("near light");
        let inputs = [self.gbuffer.base_color, self.gbuffer.normal, self.gbuffer.object, self.gbuffer.depth];
        inputs.into_iter().for_each(|handle| pass.read(handle));
        pass.read(self.lights.all);
        let brought = Contribution { diffuse: pass.write(brought.diffuse), specular: pass.write(brought.specular) };
        pass.key(&(self.state.settings.near_rays, frame.seed(), frame.view_key(), frame.geometry_key()));
        pass.key(&(frame.scene.revisions.lights, frame.media_key()));
        let work = self.clone();
        pass.execute(move |cx| work.run(cx, inputs, brought));
        brought
    }

    fn run(&self, cx: &mut PassContext, inputs: [Handle<Texture>; 4], brought: Contribution) -> Result<(), PassError> {
        let rays = u64::from(self.state.settings.near_rays);
        let [width, height] = self.frame.view.size;
        let pixels = u64::from(width) * u64::from(height);
        cx.counts().texels += pixels;
        cx.counts().paths += pixels * rays;
        // Whole workgroups, eight rows high.
        let step = (cx.work_a_submit(RAYS_A_SUBMIT) / (u64::from(width) * rays) / 8).clamp(1, 1 << 16) as usize * 8;
        for first_row in (0..height).step_by(step) {
            let rows = (height - first_row).min(step as u32);
            cx.work(u64::from(rows) * u64::from(width) * rays, RAYS_A_SUBMIT)?;
            self.dispatch(cx, inputs, brought, first_row, [width.div_ceil(8), rows.div_ceil(8), 1])?;
        }
        Ok(())
    }

    fn dispatch(
        &self,
        cx: &mut PassContext,
        inputs: [Handle<Texture>; 4],
        brought: Contribution,
        first_row: u32,
        groups: [u32; 3],
    ) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let rays = &self.state.rays;
        let particles = self.state.particles();
        // As many lights as can be bound; `beyond_binding` says where some are left out.
        let count = (particles.lights.len() as u64).min(self.state.most_bound);
        let near = gpu.uniform("near", &self.uniform(&particles, count as u32, first_row));
        let nearest = if particles.nearest.is_empty() { &[0.0][..] } else { &particles.nearest };
        let nearest = gpu.constants("nearest", nearest);
        let virtual_lights = cx.buffer(self.lights.all).clone();
        let size = count.max(1) * size_of::<VirtualLight>() as u64;
        let [base_color, normal, object, depth] = inputs.map(|handle| cx.view(handle));
        let [diffuse, specular] = [brought.diffuse, brought.specular].map(|handle| cx.view(handle));
        let group = [
            ("near", Binding::Buffer(&near)),
            ("nearest", Binding::Buffer(&nearest)),
            ("virtual_lights", Binding::BufferRange(&virtual_lights, 0, size)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("diffuse_out", Binding::Texture(&diffuse)),
            ("specular_out", Binding::Texture(&specular)),
        ];
        let mut key = rays
            .shader("indirect/instant_radiosity/near.wgsl", "main")
            .def("RAYS", ShaderDef::Uint(self.state.settings.near_rays));
        if !gloss::is_wanted(self.frame.scene) {
            key = key.def("MATTE", ShaderDef::Flag(true));
        }
        dispatch_rays(cx, &key, &group, rays, groups)
    }

    fn uniform(&self, particles: &Particles, count: u32, first_row: u32) -> NearUniform {
        let next = particles.lights.iter().map(|light| light.next).fold(0.0, f32::max);
        let first = particles.nearest.iter().copied().fold(particles.nearest_glow, f32::max);
        NearUniform {
            view: self.frame.view_values(),
            root: self.state.rays.root(),
            light_count: self.state.rays.light_count,
            virtual_count: if next > 0.0 { count } else { 0 },
            seed: self.frame.seed(),
            reach: first.max(next),
            glow: particles.nearest_glow,
            first_row,
        }
    }

    /// Declares the filter, along rows and columns; the result is `summed` with the near light.
    fn filter(&self, graph: &mut Graph<'a>, brought: Contribution, summed: Handle<Texture>) -> Handle<Texture> {
        let frame = &self.frame;
        let half = Contribution {
            diffuse: graph.texture("near diffuse, filtered along rows", frame.image_desc()),
            specular: graph.texture("near specular, filtered along rows", frame.image_desc()),
        };
        let mut pass = self.begin_filter(graph, ["near filter, horizontal", "horizontal"], brought);
        let half = Contribution {
            diffuse: pass.write("diffuse_out", half.diffuse),
            specular: pass.write("specular_out", half.specular),
        };
        pass.dispatch_over(frame.view.size);
        let indirect = graph.retained_texture("indirect radiance, near light added", frame.image_desc());
        let mut pass = self.begin_filter(graph, ["near filter, vertical", "vertical"], half);
        pass.read("base_color", self.gbuffer.base_color);
        pass.read("summed", summed);
        let indirect = pass.write("indirect", indirect);
        pass.dispatch_over(frame.view.size);
        indirect
    }

    fn begin_filter<'g>(
        &self,
        graph: &'g mut Graph<'a>,
        [name, entry]: [&'static str; 2],
        light: Contribution,
    ) -> ComputeBuilder<'g, 'a> {
        let mut pass = graph.compute(name, ComputeKey::new("indirect/instant_radiosity/near.wgsl", entry));
        pass.define("RADIUS", ShaderDef::Int(self.state.settings.near_filter.max(1) as i32));
        pass.uniform("near", &self.uniform(&Particles::default(), 0, 0));
        pass.read("normal", self.gbuffer.normal);
        pass.read("depth", self.gbuffer.depth);
        pass.read("diffuse", light.diffuse);
        pass.read("specular", light.specular);
        pass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_that_are_left_out_are_told() {
        assert_eq!(beyond_binding(7, 7, ""), None);
        let told = beyond_binding(8, 7, "Virtual lights").unwrap_or_default();
        assert!(told.contains("`Virtual lights`") && told.contains("7 virtual lights and not of all 8"), "{told}");
    }
}
