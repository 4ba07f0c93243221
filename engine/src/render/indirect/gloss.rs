//! Glossy reflection of the swept light, at the visible surfaces.

use super::light_volumes::{Field, Indirect};
use super::sky_reflection;
use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::zero_texture::zero_texture;
use crate::scene::Scene;

/// Names of the pass and its image.
#[derive(Clone, Copy)]
pub(in crate::render) struct Names {
    pass: &'static str,
    image: &'static str,
}

impl Names {
    /// Of the method's light.
    pub(in crate::render) const ALL: Self = Self { pass: "gloss", image: "glossy radiance" };
    /// Of the sky's light.
    pub(in crate::render) const SKY: Self = Self { pass: "gloss, sky", image: "glossy sky radiance" };
}

/// Whether any surface is glossy.
pub(in crate::render) fn is_wanted(scene: &Scene) -> bool {
    scene.primitives.iter().any(|p| p.material.specular != 0.0 || p.material.metallic != 0.0)
}

/// Declares the pass; the result is the light with what glossy surfaces reflect, and without what that takes from the
/// diffuse reflection. Propagated light keeps what it had: the thesis marches for gloss.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    light: &Indirect,
    names: Names,
) -> Handle<Texture> {
    let (diffuse, field) = (light.radiance, &light.field);
    if light.is_glossy {
        graph.skip(names.pass, "the method found what glossy surfaces reflect itself");
        return diffuse;
    }
    let Field::Swept { .. } = field else {
        graph.skip(names.pass, "propagated light is reflected diffusely alone");
        return diffuse;
    };
    if !is_wanted(frame.scene) {
        graph.skip(names.pass, "no surface of the scene is glossy");
        return diffuse;
    }
    let sky = light.sky.as_ref().and_then(|sky| sky_reflection::reflection(graph, frame, gbuffer, sky));
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let indirect = graph.retained_texture(names.image, desc);
    let mut pass = graph.compute(names.pass, ComputeKey::new("indirect/gloss.wgsl", "main"));
    frame.bind_view(&mut pass);
    gbuffer.bind(&mut pass);
    pass.read("diffuse", diffuse);
    match sky {
        Some(sky) => pass.read("sky", sky),
        // Without a reflection of its own the sky is in the light; nothing is added.
        None => pass.stand_in("sky", |gpu| zero_texture(gpu, 1)),
    }
    field.bind_swept(&mut pass);
    let indirect = pass.write("indirect", indirect);
    pass.dispatch_over([width, height]);
    indirect
}
