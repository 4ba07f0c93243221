// Virtual lights: a disc on the surface that each stands for.

#import lightwell::view::{View, is_behind}

struct Points {
    stride: u32,           // vectors of a light
    normal: u32,           // which of them
    light: u32,
    is_culled: u32,        // of stochastic light culling: the fifth vector is the reflectance
    radius: f32,           // [m]
    count: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> points: Points;
@group(0) @binding(2) var<storage, read> lights: array<vec4f>;
@group(0) @binding(3) var depth: texture_depth_2d;

// A disc this much farther away than a surface still lies on it.
const BIAS: f32 = 8e-3;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) color: vec3f,
    @location(1) at: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varying {
    let first = instance * points.stride;
    let place = lights[first].xyz;
    let n = lights[first + points.normal].xyz;
    var light = lights[first + points.light].rgb;
    var is_distant = false;
    if points.is_culled != 0u {
        light *= lights[first + 4u].rgb;
    } else {
        is_distant = bitcast<u32>(lights[first].w) == 1u;
    }
    var out: Varying;
    let brightest = max(light.r, max(light.g, light.b));
    if is_distant || brightest <= 0.0 || dot(n, n) < 0.5 {
        out.clip = vec4f(0.0, 0.0, 2.0, 1.0);
        return out;
    }
    let helper = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(n.x) > 0.7);
    let x = normalize(cross(n, helper));
    let y = cross(n, x);
    let corner = select(index, 6u - index, index >= 3u) % 4u;
    out.at = vec2f(select(-1.0, 1.0, (corner & 1u) != 0u), select(-1.0, 1.0, corner >= 2u));
    // In the colour of its light, as bright as a screen can show it: strengths differ by powers of ten.
    out.color = pow(light / brightest, vec3f(1.0 / 2.2));
    var radius = points.radius;
    if points.is_culled != 0u {
        // They lie as densely as the texels of a map.
        radius = min(radius, 0.4 * sqrt(lights[first + 3u].w));
    }
    let position = place + n * (0.1 * radius) + (x * out.at.x + y * out.at.y) * radius;
    out.clip = view.clip_from_world * vec4f(position, 1.0);
    return out;
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    let surface = textureLoad(depth, vec2i(in.clip.xy), 0);
    let off = length(in.at);
    if off > 1.0 || is_behind(view, in.clip.z, surface, BIAS) {
        discard;
    }
    return vec4f(select(in.color, 0.3 * in.color, off > 0.8), 0.95);
}
