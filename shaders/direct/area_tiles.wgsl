// Which tiles of the image lie wholly in the light or wholly in the shadow of a light with a surface, as far as one shadow ray a
// pixel tells. Where a share v of the light arrives, 64 points of it are all seen by chance with v⁶⁴: taking that for all of it
// makes the mean of the light too bright by (1 − v)·v⁶⁴, which is less than 0.6 %.

#import lightwell::shadow_tiles::{TILE, kinds_of, tile_of}

struct Tiles {
    origin: vec2u,         // first pixel of the region
    size: vec2u,           // [pixels]
    image: vec2u,          // [pixels]
}

@group(0) @binding(0) var<uniform> region: Tiles;
@group(0) @binding(1) var samples: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> tiles: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let first = region.origin / TILE;
    let last = (region.origin + region.size - 1u) / TILE;
    let width = last.x - first.x + 1u;
    let tile = first + vec2u(thread.x % width, thread.x / width);
    if tile.y > last.y {
        return;
    }
    let low = max(tile * TILE, region.origin);
    let high = min((tile + 1u) * TILE, region.origin + region.size);
    var kinds = 0u;
    for (var y = low.y; y < high.y; y++) {
        for (var x = low.x; x < high.x; x++) {
            kinds |= kinds_of(textureLoad(samples, vec2u(x, y), 0));
        }
    }
    tiles[tile_of(low, region.image)] = kinds;
}
