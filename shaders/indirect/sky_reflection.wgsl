// What the image of the sky adds to the sky's light in the lobes of glossy surfaces. The volumes hold the sky's light as
// irradiance E, too blurred for smooth surfaces: E/π gives way to the share of the sky that is seen around the lobe's
// direction, times the image as the lobe sees it. The share is E over the irradiance of an open place.

#import lightwell::color::luminance
#import lightwell::environment::lobe_direction
#import lightwell::gbuffer::{decode_normal, decode_normal_reflectance, world_position}
#import lightwell::sh::sh_basis_nine
#import lightwell::sweep_lookup::irradiance_around
#import lightwell::view::{View, toward_eye}
#import lightwell::volume::Volume

struct Reflection {
    irradiance: array<vec4f, 9>, // of open places, in spherical harmonics [W/m²]
    size: vec2u,           // of the first level [texels]
    levels: u32,
    mean: vec3f,           // radiance over all directions [W/(m² sr)]
    turn: f32,             // of the map [rad]
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(3) var<uniform> swept: Volume;
@group(0) @binding(4) var<uniform> reflection: Reflection;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var object: texture_2d<u32>;
@group(0) @binding(7) var depth: texture_depth_2d;
// The sky by direction; below one another each level as a roughness sees it, from 0 to 1, with half the texels along an
// edge of the one before. No mip levels: software drivers read one level for all threads that run together.
@group(0) @binding(8) var levels: texture_2d<f32>;
@group(0) @binding(9) var reflected: texture_storage_2d<rgba32float, write>;

fn at_level(place: vec2f, level: u32) -> vec3f {
    var size = vec2i(reflection.size);
    var above = 0;
    for (var i = 0u; i < level; i++) {
        above += size.y;
        size = max(size / 2, vec2i(1));
    }
    let at = place * vec2f(size) - 0.5;
    let low = vec2i(floor(at));
    let f = at - floor(at);
    let x = (vec2i(low.x, low.x + 1) + size.x) % size.x;
    let y = above + clamp(vec2i(low.y, low.y + 1), vec2i(0), vec2i(size.y - 1));
    let top = mix(textureLoad(levels, vec2i(x.x, y.x), 0).rgb, textureLoad(levels, vec2i(x.y, y.x), 0).rgb, f.x);
    let bottom = mix(textureLoad(levels, vec2i(x.x, y.y), 0).rgb, textureLoad(levels, vec2i(x.y, y.y), 0).rgb, f.x);
    return mix(top, bottom, f.y);
}

// The image as a lobe sees it [W/(m² sr)].
fn seen(d: vec3f, roughness: f32) -> vec3f {
    let u = fract(0.5 + (atan2(d.x, -d.z) + reflection.turn) / 6.28318531);
    let place = vec2f(u, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265);
    let last = reflection.levels - 1u;
    let level = saturate(roughness) * f32(last);
    let low = u32(level);
    return mix(at_level(place, low), at_level(place, min(low + 1u, last)), fract(level));
}

fn open_irradiance(d: vec3f) -> vec3f {
    let basis = sh_basis_nine(d);
    var e = vec3f(0.0);
    for (var i = 0u; i < 9u; i++) {
        e += reflection.irradiance[i].rgb * basis[i];
    }
    // The harmonics may swing below zero where hardly any sky is.
    return max(e, reflection.mean * 0.1);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= view.size) {
        return;
    }
    var added = vec3f(0.0);
    let z = textureLoad(depth, pixel, 0);
    let packed = textureLoad(normal, pixel, 0);
    let is_glossy = packed.w > 0u || any(decode_normal_reflectance(textureLoad(object, pixel, 0).xy) > vec3f(0.0));
    if z > 0.0 && is_glossy {
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let n = decode_normal(packed);
        let roughness = f32(packed.z) / 65535.0;
        let to_eye = normalize(toward_eye(view, point));
        let d = lobe_direction(n, to_eye, roughness);
        let e = irradiance_around(swept, point, n, d, to_eye);
        // The surface's own plane hides a part of the hemisphere around d, of even light (1 − n·d)/2; none of the lobe.
        let before = 0.5 + 0.5 * dot(n, d);
        let share = saturate(luminance(e) / max(before * luminance(open_irradiance(d)), 1e-30));
        added = share * seen(d, roughness) - e * 0.318309886;
    }
    textureStore(reflected, pixel, vec4f(clamp(added, vec3f(-1e32), vec3f(1e32)), 1.0));
}
