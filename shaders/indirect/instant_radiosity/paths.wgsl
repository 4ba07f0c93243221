// Ways of particles as lines: yellow from the light, redder with every reflection.

#import lightwell::view::View

@group(0) @binding(0) var<uniform> view: View;
// Ends of flights [m], and the number of reflections before.
@group(0) @binding(1) var<storage, read> ends: array<vec4f>;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) color: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varying {
    let end = ends[index];
    var out: Varying;
    out.clip = view.clip_from_world * vec4f(end.xyz, 1.0);
    let tint = 1.0 / (1.0 + end.w);
    out.color = vec3f(1.0, 0.85 * tint, 0.5 * (1.0 - tint));
    return out;
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    return vec4f(in.color, 1.0);
}
