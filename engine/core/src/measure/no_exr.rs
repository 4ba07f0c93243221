//! Replacements for OpenEXR functions in builds without them.

use super::Image;

const MISSING: &str = "this program was built without OpenEXR: build it with the feature `exr` of `lightwell-game`";

/// Says that there is no way to check a file.
#[doc(hidden)]
pub fn check_exr(_: &[u8]) -> Result<(), &'static str> {
    Err(MISSING)
}

/// Says that there is no way to read a file.
pub(super) fn decode_exr(_: &[u8]) -> Result<Image, &'static str> {
    Err(MISSING)
}

/// Says that there is no way to make a file.
pub(super) fn encode_exr(_: &Image) -> Result<Vec<u8>, &'static str> {
    Err(MISSING)
}
