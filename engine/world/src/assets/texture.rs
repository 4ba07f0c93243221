//! Textures on the CPU side: eight bits a channel, four channels.

use super::AssetId;
use crate::core::srgb_decode;
use glam::Vec3;

/// How texture coordinates outside 0..1 are treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// The texture repeats, mirrored every other time.
    Mirror,
    /// The border texel is repeated.
    Clamp,
}

/// Which copies of a texture are read where it is drawn small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Levels {
    /// The full size alone.
    Full,
    /// The nearest mip level.
    Nearest,
    /// The two nearest mip levels, blended.
    Blended,
}

/// How a texture is read where it is drawn small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Minification {
    /// Nearest texel instead of bilinear filtering.
    pub nearest: bool,
    /// Mip levels.
    pub levels: Levels,
}

/// Sampler settings of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sampling {
    /// Wrap along u.
    pub wrap_u: Wrap,
    /// Wrap along v.
    pub wrap_v: Wrap,
    /// Nearest texel instead of bilinear filtering when magnified.
    pub nearest: bool,
    /// How it is read where it is drawn small. None: bilinear and blended between mip levels, eightfold anisotropic; or
    /// nearest in all if it is so when magnified.
    pub minification: Option<Minification>,
}

impl Sampling {
    /// Filter where the texture is minified.
    pub fn minified(&self) -> Minification {
        let levels = if self.nearest { Levels::Nearest } else { Levels::Blended };
        self.minification.unwrap_or(Minification { nearest: self.nearest, levels })
    }
}

/// An image with its sampler. Immutable once made; share it by `Arc`. Mip levels are made at upload.
#[derive(Debug)]
pub struct Texture {
    /// Identity for caches: no two textures of a process share it.
    pub id: AssetId,
    /// Name for messages: mostly the file.
    pub name: String,
    /// Width \[texels\], at least 1.
    pub width: u32,
    /// Height \[texels\], at least 1.
    pub height: u32,
    /// Four bytes a texel, row 0 on top.
    pub rgba: Vec<u8>,
    /// Whether the colour channels are sRGB-encoded (alpha never is).
    pub srgb: bool,
    /// Sampler settings.
    pub sampling: Sampling,
}

impl Texture {
    /// Takes decoded pixels.
    pub(super) fn from_pixels(name: String, pixels: super::pixels::Pixels, srgb: bool, sampling: Sampling) -> Self {
        let super::pixels::Pixels { width, height, rgba } = pixels;
        Self { id: AssetId::fresh(), name, width, height, rgba, srgb, sampling }
    }

    /// Mean of the colour channels over all texels, in linear light.
    pub fn mean_color(&self) -> Vec3 {
        // The few values that a byte can have are counted first, so that no sum gets long.
        let mut counts = [[0_u32; 256]; 3];
        for texel in self.rgba.chunks_exact(4) {
            for (channel, &byte) in counts.iter_mut().zip(texel) {
                channel[usize::from(byte)] += 1;
            }
        }
        let value = |byte: usize| {
            let value = byte as f32 / 255.0;
            f64::from(if self.srgb { srgb_decode(value) } else { value })
        };
        let texels = f64::from(counts[0].iter().sum::<u32>().max(1));
        let mean = |counts: &[u32; 256]| {
            counts.iter().enumerate().map(|(byte, &count)| value(byte) * f64::from(count)).sum::<f64>() / texels
        };
        Vec3::from(counts.each_ref().map(|counts| mean(counts) as f32))
    }
}
