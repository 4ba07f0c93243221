//! A key of everything that a traced image depends on, the same in every process.

use super::TraceSettings;
use crate::assets::{AlphaMode, AssetId, Material, Mesh, Texture};
use crate::render::scene_gpu::MaterialLayers;
use crate::scene::{LightShape, Scene, SceneCamera, SceneLight, SceneMedium, SceneView, ViewProjection};
use crate::world::Lens;
use std::collections::HashMap;
use std::sync::Arc;
use xxhash_rust::xxh3::Xxh3;

/// Changes with every change of how paths are traced that is more than rounding: stored images of older versions are
/// then no references any more.
const VERSION: u32 = 1;

/// A hash (XXH3, 128 bits) of the scene's content, the view and the settings. It does not depend on where files lie,
/// on names, or on the order in which things were loaded beyond that of their identities.
pub fn content_key(scene: &Scene, view: &SceneView, settings: &TraceSettings) -> u128 {
    let mut hasher = Content { hash: Xxh3::new(), assets: HashMap::new() };
    hasher.u32s([VERSION, settings.bounces.unwrap_or(u32::MAX), settings.seed]);
    hasher.view(view);
    match &scene.sky_map {
        None => hasher.f32s(scene.sky.to_array()),
        Some(map) => {
            hasher.u32s([map.width, map.height]);
            hasher.f32s([map.turn]);
            map.texels.iter().for_each(|texel| hasher.f32s(texel.to_array()));
        }
    }
    if let Some(sun) = &scene.sun_disc {
        hasher.f32s(sun.toward.to_array());
        hasher.f32s(sun.radiance.extend(sun.half_angle).to_array());
    }
    for primitive in &scene.primitives {
        hasher.f32s(primitive.world_from_object.to_cols_array());
        hasher.u32s([u32::from(primitive.casts_shadow)]);
        hasher.mesh(&primitive.mesh);
        hasher.material(&primitive.material);
    }
    hasher.u32s([scene.lights.len() as u32]);
    scene.lights.iter().for_each(|light| hasher.light(light));
    // Keys of scenes without media are those of versions that had none.
    scene.media.iter().for_each(|medium| hasher.medium(medium));
    hasher.hash.digest128()
}

/// The view without what only the display makes of its light.
pub(super) fn traced_view(view: &SceneView) -> SceneView {
    let depth_of_field = view.camera.lens.depth_of_field.filter(|_| !view.camera.is_orthographic());
    let lens = Lens { depth_of_field, ..Lens::default() };
    SceneView { camera: SceneCamera { lens, grading: None, ..view.camera.clone() }, ..view.clone() }
}

struct Content {
    hash: Xxh3,
    /// Hashes of the assets that came by already.
    assets: HashMap<AssetId, u128>,
}

impl Content {
    fn u32s<const N: usize>(&mut self, values: [u32; N]) {
        values.iter().for_each(|value| self.hash.update(&value.to_le_bytes()));
    }

    fn f32s<const N: usize>(&mut self, values: [f32; N]) {
        // Adding zero makes one zero of the two.
        self.u32s(values.map(|value| (value + 0.0).to_bits()));
    }

    fn view(&mut self, view: &SceneView) {
        let camera = &view.camera;
        self.f32s(camera.world_from_view.to_cols_array());
        let lens = match camera.projection {
            ViewProjection::Perspective { vertical_fov } => vertical_fov,
            ViewProjection::Orthographic { height } => {
                self.f32s([height]);
                0.0
            }
        };
        self.f32s([lens, camera.near, camera.far.unwrap_or(0.0), view.jitter[0], view.jitter[1]]);
        self.u32s(view.size);
        // Keys of views without a lens are those of versions that had none.
        if let Some((radius, lens)) = camera.lens_radius().zip(camera.lens.depth_of_field) {
            self.f32s([radius, lens.focus]);
        }
    }

    fn light(&mut self, light: &SceneLight) {
        let (kind, [first, second]) = match light.shape {
            LightShape::Directional => (0, [0.0; 2]),
            LightShape::Point => (1, [0.0; 2]),
            LightShape::Spot { inner, outer } => (2, [inner, outer]),
            LightShape::Sun { half_angle } => (3, [half_angle, 0.0]),
            LightShape::Sphere { radius } => (4, [radius, 0.0]),
            LightShape::Disc { radius } => (5, [radius, 0.0]),
            LightShape::Rectangle { half_size } => (6, half_size.to_array()),
            LightShape::Tube { half_length, radius } => (7, [half_length, radius]),
        };
        self.u32s([kind, u32::from(light.casts_shadow), u32::from(light.indirect)]);
        self.f32s([first, second, light.range.unwrap_or(0.0)]);
        if light.shape.is_area() {
            self.f32s(light.axis.to_array());
        }
        self.f32s(light.intensity.to_array());
        self.f32s(light.position.to_array());
        self.f32s(light.direction.to_array());
    }

    fn medium(&mut self, medium: &SceneMedium) {
        self.u32s([medium.shape as u32]);
        self.f32s(medium.local_from_world.to_cols_array());
        self.f32s(medium.base.to_array());
        self.f32s(medium.up.to_array());
        self.f32s(medium.albedo.to_array());
        self.f32s([medium.extinction, medium.anisotropy, medium.falloff]);
    }

    fn asset(&mut self, id: AssetId, bytes: impl FnOnce() -> u128) {
        let key = *self.assets.entry(id).or_insert_with(bytes);
        self.hash.update(&key.to_le_bytes());
    }

    fn mesh(&mut self, mesh: &Mesh) {
        self.asset(mesh.id, || {
            let mut hash = Xxh3::new();
            hash.update(bytemuck::cast_slice(&mesh.vertices));
            hash.update(bytemuck::cast_slice(&mesh.indices));
            if let Some(extras) = &mesh.extras {
                hash.update(bytemuck::cast_slice(extras));
            }
            hash.digest128()
        });
    }

    fn material(&mut self, material: &Material) {
        /// Textures of materials without layers.
        const OLDER: usize = 7;
        let alpha = match material.alpha_mode {
            AlphaMode::Opaque => (0, 0.0),
            AlphaMode::Mask(cutoff) => (1, cutoff),
            // 2 were those that were cut off at half of it.
            AlphaMode::Blend => (3, 0.0),
        };
        self.u32s([alpha.0, u32::from(material.double_sided)]);
        self.f32s(material.base_color.to_array());
        self.f32s(material.dielectric_reflectance().to_array());
        self.f32s(material.emissive.to_array());
        self.f32s([material.metallic, material.roughness, material.specular, material.normal_scale, alpha.1]);
        let textures = material.textures();
        textures[..4].iter().for_each(|(texture, _)| self.texture(*texture));
        // Keys of materials without these are those of versions that did not know them.
        if !material.is_plain() {
            textures[4..OLDER].iter().for_each(|(texture, _)| self.texture(*texture));
            material.uv_rows().into_iter().take(2 * OLDER).for_each(|row| self.f32s(row));
        }
        if material.has_layers() {
            let layers = MaterialLayers::of(material);
            self.f32s(layers.clearcoat);
            self.f32s(layers.sheen);
            self.f32s(layers.anisotropy);
            self.f32s(layers.iridescence);
            textures[OLDER..].iter().for_each(|(texture, _)| self.texture(*texture));
            material.uv_rows().into_iter().skip(2 * OLDER).for_each(|row| self.f32s(row));
        }
        if material.is_glass() {
            let volume = material.volume.map_or([-1.0; 3], |volume| volume.absorption().to_array());
            self.f32s([material.transmission, material.ior]);
            self.f32s(volume);
            if material.dispersion != 0.0 {
                self.f32s([material.dispersion]);
            }
        }
    }

    fn texture(&mut self, texture: Option<&Arc<Texture>>) {
        let Some(texture) = texture else { return self.u32s([0]) };
        self.u32s([1, texture.width, texture.height, u32::from(texture.srgb)]);
        let sampling = texture.sampling;
        self.u32s([sampling.wrap_u as u32, sampling.wrap_v as u32, u32::from(sampling.nearest)]);
        self.asset(texture.id, || {
            let mut hash = Xxh3::new();
            hash.update(&texture.rgba);
            hash.digest128()
        });
    }
}
