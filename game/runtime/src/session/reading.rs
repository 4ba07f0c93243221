//! What the last frame left, read back from the device.

use super::render_state::RenderState;
use crate::writer::Picture;
use anyhow::{Context, Result};
use lightwell::gpu::{self, Gpu};
use lightwell::measure::Image;
use lightwell::render::GiMethod;
use lightwell::scene::{Scene, SceneId};

/// Identities of what is seen at each pixel of a drawn frame.
pub struct Objects {
    drawn: wgpu::Texture,
    blended: Option<wgpu::Texture>,
}

impl Objects {
    /// What is seen at a pixel.
    ///
    /// # Errors
    /// If the device fails.
    pub fn seen_at(&self, gpu: &Gpu, scene: &Scene, [x, y]: [u32; 2]) -> Result<Option<SceneId>> {
        let texture = &self.drawn;
        if x >= texture.width() || y >= texture.height() {
            return Ok(None);
        }
        // The first word of a texel is the identity, zero where there is nothing.
        let word_at = |texture: &wgpu::Texture, bytes_a_texel: usize| -> Result<u32> {
            let bytes = gpu::read_texture(gpu, texture, 0, 0)?;
            let at = bytes_a_texel * (y as usize * texture.width() as usize + x as usize);
            Ok(bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes))
        };
        let blended = self.blended.as_ref().map(|objects| word_at(objects, 4)).transpose()?;
        let word = match blended {
            Some(word) if word != 0 => word,
            _ => word_at(texture, 8)?,
        };
        Ok(scene.primitives.iter().map(|p| p.id).find(|id| word != 0 && id.0 as u32 == word))
    }
}

/// The picture of a drawn frame, on its way back from the device.
pub struct PendingPicture {
    texels: gpu::PendingTexture,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    linear: bool,
}

impl PendingPicture {
    /// Waits for it. Frames that were begun since then are not waited for.
    ///
    /// # Errors
    /// If the device fails.
    pub fn finish(self, gpu: &Gpu) -> Result<Picture> {
        let bytes = self.texels.finish(gpu)?;
        let [width, height] = self.size;
        if !self.linear {
            return Ok(Picture::Display { size: self.size, rgb: rgb_of(&bytes) });
        }
        // Zero has no sign, as in the mean of several frames.
        let rgba: Vec<_> = gpu::floats_of(self.format, &bytes)?.iter().map(|pixel| pixel.map(|c| c + 0.0)).collect();
        Ok(Picture::Linear(Image::from_rgba(width, height, &rgba).context("the frame came back incomplete")?))
    }
}

/// Three bytes a pixel of four.
fn rgb_of(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

impl RenderState {
    /// Begins to read the last frame back: its linear radiance, or what a screen shows.
    ///
    /// # Errors
    /// If no such image was drawn or the device is lost.
    pub fn begin_reading(&self, linear: bool) -> Result<PendingPicture> {
        let texture = if linear { self.renderer.radiance() } else { self.renderer.display() };
        let texture = texture.context("no frame was drawn")?;
        let texels = gpu::begin_read_texture(&self.gpu, texture, 0, 0)?;
        Ok(PendingPicture { texels, size: [texture.width(), texture.height()], format: texture.format(), linear })
    }

    /// What is seen where in the last frame; none if it was traced and not drawn.
    pub fn objects(&self) -> Option<Objects> {
        let drawn = self.renderer.target("gbuffer object")?.clone();
        Some(Objects { drawn, blended: self.renderer.blended_objects().cloned() })
    }

    /// A layer of a kept target as the last frame left it.
    ///
    /// # Errors
    /// If there is no such target, level or layer, or its format has no plain numbers.
    pub fn target(&self, name: &str, mip: u32, layer: u32) -> Result<gpu::ImageF32> {
        let texture = self.renderer.target(name).context("the last frames did not make it")?;
        Ok(gpu::read_layer_f32(&self.gpu, texture, mip, layer)?)
    }

    /// Linear radiance of the last frame.
    ///
    /// # Errors
    /// If nothing was drawn or the device is lost.
    pub fn radiance(&self) -> Result<Image> {
        let texture = self.renderer.radiance().context("no frame was drawn")?;
        let image = gpu::read_texture_f32(&self.gpu, texture)?;
        Image::from_rgba(image.width, image.height, &image.rgba).context("the frame came back incomplete")
    }

    /// Virtual lights that the last frame tested and accepted at a pixel with a surface, on average; none if it was
    /// not drawn with stochastic light culling.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn light_counts(&self, gi: GiMethod) -> Result<Option<[f64; 2]>> {
        Ok(self.lights_of_pixels(gi)?.map(|([tested, accepted], surfaces, _)| {
            let surfaces = surfaces.max(1) as f64;
            [tested / surfaces, accepted / surfaces]
        }))
    }

    /// The same at a pixel of the whole image, whatever it shows.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn light_counts_of_all_pixels(&self, gi: GiMethod) -> Result<Option<[f64; 2]>> {
        let counted = self.lights_of_pixels(gi)?;
        Ok(counted.map(|([tested, accepted], _, all)| [tested / all.max(1) as f64, accepted / all.max(1) as f64]))
    }

    /// Sums of the lights tested and accepted, the pixels that tested any, and all pixels.
    fn lights_of_pixels(&self, gi: GiMethod) -> Result<Option<([f64; 2], usize, usize)>> {
        let Some(names) = self.renderer.methods().get(gi)?.light_counts() else { return Ok(None) };
        let [Some(tested), Some(accepted)] = names.map(|name| self.renderer.target(name)) else { return Ok(None) };
        let tested = gpu::read_texture_f32(&self.gpu, tested)?;
        let accepted = gpu::read_texture_f32(&self.gpu, accepted)?;
        let surfaces = tested.rgba.iter().filter(|pixel| pixel[3] > 0.0).count();
        let sum = |image: &gpu::ImageF32| image.rgba.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>();
        Ok(Some(([sum(&tested), sum(&accepted)], surfaces, tested.rgba.len())))
    }

    /// The last frame as a screen shows it: sRGB bytes, three a pixel.
    ///
    /// # Errors
    /// If no display image was drawn or the device is lost.
    pub fn display_bytes(&self) -> Result<([u32; 2], Vec<u8>)> {
        let texture = self.display_texture().context("no frame was drawn for display")?;
        let bytes = gpu::read_texture(&self.gpu, texture, 0, 0)?;
        Ok(([texture.width(), texture.height()], rgb_of(&bytes)))
    }

    /// The texture of the last frame for display.
    pub fn display_texture(&self) -> Option<&wgpu::Texture> {
        self.renderer.display()
    }
}
