//! Limits that files, textures and images share.

/// Largest width and height of an image \[texels\].
pub const MAX_IMAGE_SIZE: u32 = 16384;
