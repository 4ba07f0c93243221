// A virtual light for each texel of a layer of a reflective shadow map. Lights of a subset lie side by side: texel
// (x, y) belongs to subset (x mod n, y mod n) of n × n, so that each holds an even choice of all.

#import lightwell::gbuffer::{decode_albedo, decode_normal, decode_normal_reflectance}
#import lightwell::lights::Light
#import lightwell::rsm::{RsmLayer, texel_position, texel_received}
#import lightwell::slc::VirtualLight

// One block, see lib/slc.wgsl.
struct Place {
    light: Light,
    rsm: RsmLayer,
    first: u32,            // light of the layer in each subset
    lights: u32,           // of a subset
    interleave: u32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> place: Place;
@group(0) @binding(3) var base_color: texture_2d_array<u32>;
@group(0) @binding(4) var normal: texture_2d_array<u32>;
@group(0) @binding(5) var specular: texture_2d_array<u32>;
@group(0) @binding(6) var depth: texture_depth_2d_array;
@group(0) @binding(7) var<storage, read_write> virtual_lights: array<VirtualLight>;

// Grazing surfaces are not counted as larger than this times what the light sees of them.
const MAX_STRETCH: f32 = 16.0;

fn virtual_light(texel: vec2u, z: f32) -> VirtualLight {
    var result: VirtualLight;
    let base = textureLoad(base_color, texel, place.rsm.layer, 0);
    let surface = textureLoad(normal, texel, place.rsm.layer, 0);
    let n = decode_normal(surface);
    let position = texel_position(place.rsm, texel, z, n);
    let received = texel_received(place.rsm, place.light, texel, position);
    let cosine = dot(n, received.to_light);
    if cosine <= 0.0 || all(received.flux <= vec3f(0.0)) {
        return result;
    }
    let roughness = f32(surface.z) / 65535.0;
    result.position = position;
    result.area = received.area * min(1.0 / cosine, MAX_STRETCH);
    result.spread = result.area * 0.318309886;
    result.to_light = received.to_light;
    result.alpha = max(roughness * roughness, 1e-3);
    result.normal = n;
    result.grazing_reflectance = f32(surface.w) / 65535.0;
    result.flux = min(received.flux, vec3f(1e30));
    result.albedo = decode_albedo(base);
    result.normal_reflectance = decode_normal_reflectance(vec2u(0u, textureLoad(specular, texel, place.rsm.layer, 0).x));
    return result;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let texel = thread.xy;
    if any(texel >= vec2u(place.rsm.size)) {
        return;
    }
    let n = place.interleave;
    let subset = (texel.y % n) * n + texel.x % n;
    let index = subset * place.lights + place.first + (texel.y / n) * (place.rsm.size / n) + texel.x / n;
    let z = textureLoad(depth, texel, place.rsm.layer, 0);
    var result: VirtualLight;
    if z > 0.0 {
        result = virtual_light(texel, z);
    }
    virtual_lights[index] = result;
}
