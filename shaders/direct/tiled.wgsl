// Direct light of many lights without shadows, in one pass: each tile of 8 by 8 pixels finds the lights that reach the
// box around its surfaces (tiled shading, Olsson and Assarsson 2011; the box of the points themselves takes the place of
// the tile's frustum between two depths), and its pixels add up those.

#import lightwell::direct::{is_lit, reflected_light, through_media}
#import lightwell::gbuffer::{decode_surface, world_position}
#import lightwell::lights::{Light, is_distant, light_incidence}
#import lightwell::view::{View, toward_eye}

struct Lights {
    count: u32,
    padding: vec3u,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> some: Lights;
@group(0) @binding(2) var<storage, read> lights: array<Light>;
@group(0) @binding(3) var base_color: texture_2d<u32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var object: texture_2d<u32>;
@group(0) @binding(6) var depth: texture_depth_2d;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;

const TILE: u32 = 64u;
const FAR: f32 = 3e38;

var<workgroup> low: array<vec3f, 64>;
var<workgroup> high: array<vec3f, 64>;
// A bit for each of the lights that are tested together. Bits and no list: they are gone through in order, so that sums
// round the same way every time.
var<workgroup> reaching: array<atomic<u32>, 2>;

// The box around all points of the tile; it ends up in the first place.
fn bound(local: u32, position: vec3f, has_surface: bool) {
    low[local] = select(vec3f(FAR), position, has_surface);
    high[local] = select(vec3f(-FAR), position, has_surface);
    for (var half = TILE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            low[local] = min(low[local], low[local + half]);
            high[local] = max(high[local], high[local + half]);
        }
    }
    workgroupBarrier();
}

// Whether the sphere of a light's range meets a box (Arvo 1990).
fn reaches(light: Light, box_low: vec3f, box_high: vec3f) -> bool {
    if light.range <= 0.0 || is_distant(light) {
        return true;
    }
    let nearest = (clamp(light.position, box_low, box_high) - light.position) / light.range;
    return dot(nearest, nearest) < 1.0;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(local_invocation_index) local: u32) {
    let pixel = min(thread.xy, view.size - 1u);
    let z = textureLoad(depth, pixel, 0);
    let has_surface = z > 0.0 && all(thread.xy < view.size);
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    bound(local, position, has_surface);
    let box_low = low[0];
    let box_high = high[0];
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    var sum = vec3f(0.0);
    // None where there is nothing in the tile.
    let count = select(some.count, 0u, box_low.x > box_high.x);
    for (var first = 0u; first < count; first += TILE) {
        if local < 2u {
            atomicStore(&reaching[local], 0u);
        }
        workgroupBarrier();
        if first + local < count && reaches(lights[first + local], box_low, box_high) {
            atomicOr(&reaching[local / 32u], 1u << (local % 32u));
        }
        workgroupBarrier();
        for (var word = 0u; word < 2u; word++) {
            var bits = select(0u, atomicLoad(&reaching[word]), has_surface);
            while bits != 0u {
                let light = lights[first + 32u * word + firstTrailingBit(bits)];
                bits &= bits - 1u;
                let incidence = through_media(light_incidence(light, position), position);
                if is_lit(surface, incidence) {
                    sum += reflected_light(surface, toward_eye(view, position), incidence);
                }
            }
        }
        workgroupBarrier();
    }
    if has_surface {
        for (var channel = 0u; channel < 3u; channel++) {
            let before = textureLoad(radiance, pixel, channel).r;
            textureStore(radiance, pixel, channel, vec4f(before + sum[channel], 0.0, 0.0, 0.0));
        }
    }
}
