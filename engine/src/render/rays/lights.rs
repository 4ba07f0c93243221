//! Lights in the layout of `load_light` of `lib/ray_scene.wgsl`.

use super::words::Texel;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::scene::SceneLight;
use encase::ShaderType;

/// Texels of a light.
const TEXELS: usize = 5;

/// All lights: `Light` of `lib/lights.wgsl`, and in the two words at its end that are left, whether it casts shadows and
/// whether it lights more than what the camera sees.
pub(super) fn texels(lights: &[SceneLight]) -> Vec<Texel> {
    const { assert!(LightUniform::METADATA.min_size().get() == 16 * TEXELS as u64) };
    let mut texels = vec![Texel::default(); TEXELS * lights.len()];
    for (texels, light) in texels.chunks_exact_mut(TEXELS).zip(lights) {
        let mut bytes = encase::StorageBuffer::new([0; 16 * TEXELS]);
        if let Err(error) = bytes.write(&LightUniform::new(light)) {
            // It is as long as asserted above, so that there is nothing to fail; a message is all that is left to do.
            log::error!("light `{}`: {error}", light.name);
        }
        texels.copy_from_slice(bytemuck::cast_slice(&bytes.into_inner()));
        texels[4][2..].copy_from_slice(&[u32::from(light.casts_shadow), u32::from(light.indirect)]);
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LightShape, SceneId};
    use glam::Vec3;

    #[test]
    fn flags_follow_the_light() {
        let light = |casts_shadow: bool, indirect: bool| SceneLight {
            id: SceneId(1),
            name: String::new(),
            shape: LightShape::Point,
            intensity: Vec3::ONE,
            position: Vec3::new(1.0, 2.0, 3.0),
            direction: Vec3::NEG_Y,
            axis: Vec3::X,
            range: None,
            casts_shadow,
            indirect,
            shadow_size: 0,
            rsm_size: 0,
            revision: 0,
        };
        let texels = texels(&[light(true, false), light(false, true)]);
        assert_eq!(texels.len(), 10);
        assert_eq!(texels[5], [1.0_f32.to_bits(), 2.0_f32.to_bits(), 3.0_f32.to_bits(), 1]);
        assert_eq!((texels[4], texels[9]), ([0, 0, 1, 0], [0, 0, 0, 1]));
        assert_eq!(texels[2][0], 1.0_f32.to_bits());
    }
}
