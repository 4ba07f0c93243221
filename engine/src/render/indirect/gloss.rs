//! Glossy reflection of the swept light, at the visible surfaces.

use super::light_volumes::{Field, Indirect};
use super::sky_reflection;
use crate::gpu::{Binding, ComputeKey};
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
    let Field::Swept { volume, .. } = field else {
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
    let mut pass = graph.pass(names.pass);
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth, diffuse];
    for input in inputs.into_iter().chain(sky) {
        pass.read(input);
    }
    field.buffers().iter().for_each(|&buffer| pass.read(buffer));
    let indirect = pass.write(indirect);
    pass.key(&(volume.key(), frame.view_key(), sky.is_some()));
    let (frame, field) = (frame.clone(), field.clone());
    pass.execute(move |cx| {
        let views = inputs.map(|handle| cx.view(handle));
        // Without a reflection of its own the sky is in the light; nothing is added.
        let sky = sky.map_or_else(|| zero_texture(cx.gpu, 1), |handle| cx.view(handle));
        let target = cx.view(indirect);
        let volume = field.bindings(cx);
        let view = frame.view_uniform(cx.gpu);
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut bindings = vec![
            ("view", Binding::Buffer(&view)),
            ("sky", Binding::Texture(&sky)),
            ("indirect", Binding::Texture(&target)),
        ];
        let names = ["base_color", "normal", "object", "depth", "diffuse"];
        bindings.extend(names.into_iter().zip(&views).map(|(name, view)| (name, Binding::Texture(view))));
        bindings.extend(volume.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
        cx.dispatch(
            &ComputeKey::new("indirect/gloss.wgsl", "main"),
            &bindings,
            [width.div_ceil(8), height.div_ceil(8), 1],
        )
    });
    indirect
}
