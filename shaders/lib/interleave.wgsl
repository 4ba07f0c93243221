#define_import_path lightwell::interleave

// Which pixels rays are cast for: one of each square of `stride`² (interleaved sampling: Keller and Heidrich 2001).

struct Interleave {
    stride: u32,
    offset: vec2u,         // of the pixel in its square
    texels: vec2u,         // size of the image that holds one for each of those pixels
}

// The pixel of a texel. Squares that the image's border cuts have theirs on it.
fn pixel_of(interleave: Interleave, texel: vec2u, size: vec2u) -> vec2u {
    return min(texel * interleave.stride + interleave.offset, size - 1u);
}
