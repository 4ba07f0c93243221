//! Hemisphere light: irradiance from an even sky and an even ground without shadows, which depends on the normal n of a
//! surface alone, E = E_ground + (E_sky − E_ground)·(1 + n.y)/2.

use bevy_ecs::prelude::Component;
use glam::Vec3;
use lightwell::files::SceneData;
use lightwell::gpu::{ComputeKey, Gpu};
use lightwell::graph::Graph;
use lightwell::render::frame::Frame;
use lightwell::render::{GBuffer, GiMethod, IndirectLight, IndirectMethod, RenderError};

/// Settings of hemisphere light. A scene without them gets the defaults.
#[derive(Component, SceneData, Clone, Debug, PartialEq)]
pub struct HemisphereLight {
    /// Irradiance of a surface that faces the sky, 0 to 100 [W/m²].
    pub sky: f32,
    /// Irradiance of a surface that faces the ground, 0 to 100 [W/m²].
    pub ground: f32,
    /// Share of blue that the ground absorbs, 0 to 1.
    pub warmth: f32,
}

impl Default for HemisphereLight {
    fn default() -> Self {
        Self { sky: 1.0, ground: 0.3, warmth: 0.4 }
    }
}

impl HemisphereLight {
    /// Irradiance from the sky and from the ground [W/m²]. Values out of range are clamped: a game may set them too.
    fn irradiance(&self) -> [Vec3; 2] {
        let [sky, ground] = [self.sky, self.ground].map(|value| value.clamp(0.0, 100.0));
        let warmth = self.warmth.clamp(0.0, 1.0);
        [Vec3::splat(sky), ground * Vec3::new(1.0, 1.0 - 0.5 * warmth, 1.0 - warmth)]
    }
}

/// The method. It keeps nothing between frames.
pub struct Hemisphere;

impl Hemisphere {
    /// Its name, which is `--gi hemisphere` and `gi: Hemisphere`.
    pub const ID: GiMethod = GiMethod::named("hemisphere");
}

impl IndirectMethod for Hemisphere {
    fn id(&self) -> GiMethod {
        Self::ID
    }

    fn title(&self) -> &'static str {
        "Hemisphere light"
    }

    fn about(&self) -> &'static str {
        "Even light from sky and ground, without shadows, as the scene's `HemisphereLight` component sets it"
    }

    fn shaders(&self) -> &'static [(&'static str, &'static str)] {
        &[("hemisphere.wgsl", include_str!("hemisphere.wgsl"))]
    }

    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        _: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        let settings = frame.scene.method_settings.get::<HemisphereLight>().cloned().unwrap_or_default();
        let indirect = graph.retained_texture("hemisphere light", frame.image_desc());
        let mut pass = graph.compute("hemisphere light", ComputeKey::new("hemisphere.wgsl", "main"));
        pass.uniform("irradiance", &settings.irradiance());
        pass.read("base_color", gbuffer.base_color);
        pass.read("normal", gbuffer.normal);
        pass.read("depth", gbuffer.depth);
        let radiance = pass.write("indirect", indirect);
        pass.dispatch_over(frame.view.size);
        Ok(Some(IndirectLight::at_pixels(radiance)))
    }
}
