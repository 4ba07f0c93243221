#define_import_path lightwell::strays

// The queue of pixels that no gathered pixel beside them has light for. It is cut into slices, which are dispatched one after
// the other, each over workgroups of 64. Their order is left to chance; no pixel depends on it.

@group(0) @binding(20) var<storage, read_write> stray_pixels: array<u32>;
// The number of pixels, and for each slice that of its workgroups along three axes.
@group(0) @binding(21) var<storage, read_write> stray_counts: array<atomic<u32>>;

// `SLICE` of sweep/strays.rs.
const SLICE: u32 = 524288u;

fn push_stray(pixel: vec2u) {
    let index = atomicAdd(&stray_counts[0], 1u);
    stray_pixels[index] = pixel.x | (pixel.y << 16u);
    let groups = 1u + 3u * (index / SLICE);
    atomicMax(&stray_counts[groups], (index % SLICE) / 64u + 1u);
    atomicMax(&stray_counts[groups + 1u], 1u);
    atomicMax(&stray_counts[groups + 2u], 1u);
}
