//! Decoded images.

/// Largest width and height \[texels\].
pub const MAX_IMAGE_SIZE: u32 = 16384;

/// A decoded image: four bytes a texel, row 0 on top.
#[derive(Clone, Debug)]
pub(super) struct Pixels {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<u8>,
}
