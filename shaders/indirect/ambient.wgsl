// One irradiance for what no method of indirect light reaches: from what all visible surfaces reflect of theirs,
// E = π·ΣL/Σρ, the mean over the surfaces by their reflectance. (The "ambient term" of radiosity methods has the same
// form: Cohen et al. 1988.)

#import lightwell::gbuffer::decode_albedo

@group(0) @binding(0) var base_color: texture_2d<u32>;
@group(0) @binding(1) var depth: texture_depth_2d;
// Reflected radiance is the sum of both; one of them may be a single black texel.
@group(0) @binding(2) var first: texture_2d<f32>;
@group(0) @binding(4) var second: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> ambient: vec4f;

var<workgroup> light: array<vec3f, 256>;
var<workgroup> albedo: array<vec3f, 256>;

// Each thread takes every 256th pixel and a tree adds them: the same order, and the same bits, in every run.
@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) local: u32) {
    let size = textureDimensions(depth);
    var l = vec3f(0.0);
    var a = vec3f(0.0);
    for (var i = local; i < size.x * size.y; i += 256u) {
        let pixel = vec2u(i % size.x, i / size.x);
        if textureLoad(depth, pixel, 0) > 0.0 {
            l += textureLoad(first, min(pixel, textureDimensions(first) - 1u), 0).rgb
                + textureLoad(second, min(pixel, textureDimensions(second) - 1u), 0).rgb;
            a += decode_albedo(textureLoad(base_color, pixel, 0));
        }
    }
    light[local] = l;
    albedo[local] = a;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            light[local] += light[local + half];
            albedo[local] += albedo[local + half];
        }
    }
    if local == 0u {
        let mean = light[0] / max(albedo[0], vec3f(1e-3));
        ambient = vec4f(min(mean * 3.14159265, vec3f(1e32)), 1.0);
    }
}
