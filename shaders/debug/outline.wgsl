// The silhouette of what is selected: a line around all pixels that show it, whatever lies between them.

// How many identities get an outline, and those, ascending.
@group(0) @binding(0) var<storage, read> outlined: array<u32>;
@group(0) @binding(1) var object: texture_2d<u32>;
@group(0) @binding(2) var mask_out: texture_storage_2d<r32uint, write>;
@group(0) @binding(3) var mask: texture_2d<u32>;
// Identities of blended surfaces before those of `object`; `object` itself where there are none.
@group(0) @binding(4) var blended: texture_2d<u32>;

const COLOR: vec3f = vec3f(1.0, 0.62, 0.15);
// Reach of the line around the silhouette [pixels].
const WIDTH: i32 = 2;

fn is_outlined(id: u32) -> bool {
    let end = outlined[0] + 1u;
    var low = 1u;
    var high = end;
    while low < high {
        let middle = (low + high) / 2u;
        if outlined[middle] < id {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low < end && outlined[low] == id;
}

@compute @workgroup_size(8, 8)
fn mark(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(object)) {
        return;
    }
    let before = textureLoad(blended, thread.xy, 0).x;
    let id = select(textureLoad(object, thread.xy, 0).x, before, before != 0u);
    textureStore(mask_out, thread.xy, vec4u(u32(id != 0u && is_outlined(id))));
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u));
    return vec4f(corner * 4.0 - 1.0, 0.5, 1.0);
}

// Outside of the silhouette, as strong as the nearest pixel of it is near.
@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let size = vec2i(textureDimensions(mask));
    if textureLoad(mask, pixel, 0).x != 0u {
        discard;
    }
    var nearest = 1e9;
    for (var y = -WIDTH; y <= WIDTH; y++) {
        for (var x = -WIDTH; x <= WIDTH; x++) {
            let at = pixel + vec2i(x, y);
            if all(at >= vec2i(0)) && all(at < size) && textureLoad(mask, at, 0).x != 0u {
                nearest = min(nearest, length(vec2f(f32(x), f32(y))));
            }
        }
    }
    let alpha = saturate(f32(WIDTH) + 0.5 - nearest);
    if alpha <= 0.0 {
        discard;
    }
    return vec4f(COLOR, alpha);
}
