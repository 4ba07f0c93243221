//! Constant ambient light: the same irradiance for every surface, whatever stands around it.

use encase::ShaderType;
use glam::Vec3;
use lightwell::gpu::{ComputeKey, Gpu};
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

    fn shaders(&self) -> &'static [(&'static str, &'static str)] {
        &[("constant_ambient.wgsl", include_str!("constant_ambient.wgsl"))]
    }

    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        _: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        let indirect = graph.retained_texture("constant ambient", frame.image_desc());
        let mut pass = graph.compute("constant ambient", ComputeKey::new("constant_ambient.wgsl", "main"));
        pass.uniform("ambient", &AmbientUniform { irradiance: self.irradiance });
        pass.read("base_color", gbuffer.base_color);
        pass.read("depth", gbuffer.depth);
        let radiance = pass.write("indirect", indirect);
        pass.dispatch_over(frame.view.size);
        Ok(Some(IndirectLight::at_pixels(radiance)))
    }
}
