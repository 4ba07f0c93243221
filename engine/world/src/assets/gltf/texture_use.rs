//! How materials use textures.

use crate::assets::Texture;
use glam::{Affine2, Mat2, Vec2};
use std::collections::HashMap;
use std::sync::Arc;

/// A texture as a material uses it: its index, and whether its colours are sRGB.
pub(super) type TextureUse = (usize, bool);

/// Textures as materials use them.
pub(super) type Textures = HashMap<TextureUse, Arc<Texture>>;

/// The transform of texture coordinates of `KHR_texture_transform`; none if it is not finite.
pub(super) fn affine(offset: [f32; 2], rotation: f32, scale: [f32; 2]) -> Affine2 {
    // The extension rotates counter-clockwise in a space whose v points down.
    let (sin, cos) = rotation.sin_cos();
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let transform =
        Affine2::from_mat2_translation(rotation * Mat2::from_diagonal(Vec2::from(scale)), Vec2::from(offset));
    if transform.is_finite() { transform } else { Affine2::IDENTITY }
}
