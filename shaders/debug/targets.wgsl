// A target of another pass as a tile of the image: black at the least value and white at the largest one; magenta is not
// finite.

struct Tile {
    corner: vec2f,         // upper left, in the image [pixels]
    size: vec2f,           // [pixels]
    view: vec2u,           // of the image [pixels]
    texels: vec2u,         // of the mip level
    channel: u32,          // 0 to 3; 4: the first three as a colour
    slice: u32,            // of a volume
    index: u32,            // of its range
    is_range_given: u32,
    range: vec2f,          // values that become black and white, if given
}

@group(0) @binding(0) var<uniform> tile: Tile;

#ifdef VOLUME
    #ifdef UNSIGNED
        @group(0) @binding(1) var source: texture_3d<u32>;
    #else ifdef SIGNED
        @group(0) @binding(1) var source: texture_3d<i32>;
    #else
        @group(0) @binding(1) var source: texture_3d<f32>;
    #endif
#else ifdef DEPTH
    @group(0) @binding(1) var source: texture_depth_2d;
#else ifdef UNSIGNED
    @group(0) @binding(1) var source: texture_2d<u32>;
#else ifdef SIGNED
    @group(0) @binding(1) var source: texture_2d<i32>;
#else
    @group(0) @binding(1) var source: texture_2d<f32>;
#endif

@group(0) @binding(2) var<storage, read_write> measured: array<vec2f>;
@group(0) @binding(3) var<storage, read> ranges: array<vec2f>;

const THREADS: u32 = 256u;
const GRID: u32 = 128u;           // samples along each axis, at most
const LARGEST: f32 = 3.4e38;

var<workgroup> extents: array<vec2f, THREADS>;   // least, largest

// The channels that are shown.
fn load(texel: vec2u) -> vec3f {
#ifdef VOLUME
    let value = vec4f(textureLoad(source, vec3u(texel, tile.slice), 0));
#else ifdef DEPTH
    let value = vec4f(textureLoad(source, texel, 0));
#else
    let value = vec4f(textureLoad(source, texel, 0));
#endif
    if tile.channel < 4u {
        return vec3f(value[tile.channel]);
    }
    return value.rgb;
}

// Infinity and NaN have all bits of the exponent set. Comparisons may be compiled as if there were neither.
fn is_finite(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7f800000u) != 0x7f800000u;
}

// The least and the largest value on a grid of texels.
@compute @workgroup_size(THREADS)
fn measure(@builtin(local_invocation_index) thread: u32) {
    let count = min(tile.texels, vec2u(GRID));
    var extent = vec2f(LARGEST, -LARGEST);
    for (var i = thread; i < count.x * count.y; i += THREADS) {
        let cell = vec2u(i % count.x, i / count.x);
        let value = load((cell * tile.texels + tile.texels / 2u) / count);
        for (var channel = 0u; channel < 3u; channel++) {
            if is_finite(value[channel]) {
                extent = vec2f(min(extent.x, value[channel]), max(extent.y, value[channel]));
            }
        }
    }
    extents[thread] = extent;
    for (var half = THREADS / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if thread < half {
            let other = extents[thread + half];
            extents[thread] = vec2f(min(extents[thread].x, other.x), max(extents[thread].y, other.y));
        }
    }
    if thread == 0u {
        measured[tile.index] = select(vec2f(0.0, 1.0), extents[0], extents[0].x <= extents[0].y);
    }
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = select(index, 6u - index, index >= 3u) % 4u;
    // A pixel more on each side for the frame.
    let at = tile.corner - 1.0 + vec2f(f32(corner & 1u), f32(corner >> 1u)) * (tile.size + 2.0);
    let clip = at / vec2f(tile.view) * 2.0 - 1.0;
    return vec4f(clip.x, -clip.y, 0.5, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = (position.xy - tile.corner) / tile.size;
    if any(at < vec2f(0.0)) || any(at >= vec2f(1.0)) {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let value = load(min(vec2u(at * vec2f(tile.texels)), tile.texels - 1u));
    if !(is_finite(value.x) && is_finite(value.y) && is_finite(value.z)) {
        return vec4f(1.0, 0.0, 1.0, 1.0);
    }
    let range = select(ranges[tile.index], tile.range, tile.is_range_given != 0u);
    return vec4f(saturate((value - range.x) / max(range.y - range.x, 1e-30)), 1.0);
}
