// Lines with smooth edges; what lies behind a surface is dim, but for lines that lie before all surfaces.

#import lightwell::view::{View, is_behind}

struct Line {
    from_point: vec3f,     // [m]
    color: u32,            // sRGB-encoded bytes, red lowest; alpha highest
    to_point: vec3f,       // [m]
    width: f32,            // [pixels]; below 0: before all surfaces
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> lines: array<Line>;
@group(0) @binding(2) var depth: texture_depth_2d;

// How much of a line shows through a surface.
const HIDDEN: f32 = 0.18;
// A line this much farther away than a surface still lies on it.
const BIAS: f32 = 4e-3;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
    @location(1) across: f32,      // from the middle [pixels]
    @location(2) half_width: f32,  // [pixels]
    @location(3) @interpolate(flat) is_on_top: u32,
}

// A point of the line, cut off where z = w, which is the near plane.
fn cut(here: vec4f, other: vec4f) -> vec4f {
    let a = here.w - here.z;
    let b = other.w - other.z;
    let least = 1e-4 * max(abs(here.w), abs(other.w));
    if a >= least || b <= least {
        return here;
    }
    return mix(here, other, (least - a) / (b - a));
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varying {
    let line = lines[instance];
    let first = view.clip_from_world * vec4f(line.from_point, 1.0);
    let second = view.clip_from_world * vec4f(line.to_point, 1.0);
    let a = cut(first, second);
    let b = cut(second, first);
    var out: Varying;
    out.half_width = 0.5 * abs(line.width);
    out.is_on_top = u32(line.width < 0.0);
    out.color = unpack4x8unorm(line.color);
    if a.w <= 0.0 || b.w <= 0.0 || a.z > a.w || b.z > b.w {
        out.clip = vec4f(0.0, 0.0, 2.0, 1.0);
        return out;
    }
    let half_size = 0.5 * vec2f(view.size);
    let start = a.xy / a.w * half_size;
    let end = b.xy / b.w * half_size;
    let along = end - start;
    let distance = length(along);
    let forward = select(vec2f(1.0, 0.0), along / distance, distance > 1e-4);
    // Two triangles: 0 1 2, 2 1 3.
    let corner = select(index, 6u - index, index >= 3u) % 4u;
    let is_end = corner == 1u || corner == 3u;
    let side = select(-1.0, 1.0, corner >= 2u);
    out.across = side * (out.half_width + 1.0);
    let at = select(start, end, is_end) + out.across * vec2f(-forward.y, forward.x);
    out.clip = vec4f(at / half_size, select(a.z / a.w, b.z / b.w, is_end), 1.0);
    return out;
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    let surface = textureLoad(depth, vec2i(in.clip.xy), 0);
    let hidden = in.is_on_top == 0u && is_behind(view, in.clip.z, surface, BIAS);
    let edge = saturate(in.half_width + 0.5 - abs(in.across));
    return vec4f(in.color.rgb, in.color.a * edge * select(1.0, HIDDEN, hidden));
}
