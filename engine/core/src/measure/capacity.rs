//! How many pixels a file can hold.

use crate::core::MAX_IMAGE_SIZE;

/// Whether a file may hold so many floating-point pixels: deflate packs 1,032 bytes into one at best, no other method of
/// such files packs more, and four times that is let pass.
#[doc(hidden)]
pub fn may_hold(bytes: &[u8], width: u64, height: u64) -> bool {
    const PACKED: u64 = 4096;
    let most = u64::from(MAX_IMAGE_SIZE);
    width <= most && height <= most && width * height * size_of::<[f32; 3]>() as u64 <= PACKED * bytes.len() as u64
}
