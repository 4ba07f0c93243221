//! Decoded images.

/// A decoded image: four bytes a texel, row 0 on top.
#[derive(Clone, Debug)]
pub(super) struct Pixels {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<u8>,
}
