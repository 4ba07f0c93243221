//! Constant ambient light: the same irradiance for every surface, whatever stands around it.

use encase::ShaderType;
use glam::Vec3;
use lightwell::gpu::{Binding, ComputeKey, Gpu};
use lightwell::graph::Graph;
use lightwell::render::frame::Frame;
use lightwell::render::{GBuffer, GiMethod, IndirectLight, IndirectMethod, RenderError};

/// What [`RenderSettings::gi`](lightwell::render::RenderSettings::gi) calls it.
pub const CONSTANT_AMBIENT: GiMethod = GiMethod::named("constant-ambient");

/// `Ambient` of `constant_ambient.wgsl`.
#[derive(ShaderType)]
struct AmbientUniform {
    irradiance: Vec3,
}

/// The method with its setting.
pub struct ConstantAmbient {
    /// Irradiance of every surface [W/m²].
    pub irradiance: Vec3,
}

impl IndirectMethod for ConstantAmbient {
    fn id(&self) -> GiMethod {
        CONSTANT_AMBIENT
    }

    fn title(&self) -> &'static str {
        "Constant ambient light"
    }

    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        _: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        let [width, height] = frame.view.size;
        let (base_color, depth) = (gbuffer.base_color, gbuffer.depth);
        let indirect = graph.retained_texture("constant ambient", frame.image_desc());
        let mut pass = graph.pass("constant ambient");
        pass.read(base_color);
        pass.read(depth);
        let radiance = pass.write(indirect);
        pass.key(&self.irradiance.to_array().map(f32::to_bits));
        let uniform = AmbientUniform { irradiance: self.irradiance };
        pass.execute(move |cx| {
            let uniform = cx.gpu.uniform("ambient", &uniform);
            let [base_color, target] = [base_color, radiance].map(|handle| cx.view(handle));
            let depth = cx.view(depth);
            let group = [
                ("ambient", Binding::Buffer(&uniform)),
                ("base_color", Binding::Texture(&base_color)),
                ("depth", Binding::Texture(&depth)),
                ("indirect", Binding::Texture(&target)),
            ];
            let key = ComputeKey::new("constant_ambient.wgsl", "main");
            cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
        });
        Ok(Some(IndirectLight::at_pixels(radiance)))
    }
}
