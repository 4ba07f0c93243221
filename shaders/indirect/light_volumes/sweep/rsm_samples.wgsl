// Surface points that lights reach, drawn from reflective shadow maps in proportion to the flux that each texel
// receives (Dachsbacher and Stamminger 2006, "Splatting indirect illumination"): lights that the final gather samples,
// see lib/rsm_samples.wgsl. lib/rsm_draw.wgsl draws them.
//   REFLECTED  texels are weighed by the flux that they reflect

#import lightwell::gbuffer::decode_normal
#import lightwell::rsm_samples::POINT_TEXELS
#import lightwell::rsm::texel_position
#import lightwell::rsm_draw::{
    STRIP, base_color, cumulative, depth, draw, draw_texel, normal, rsm, specular, strips_a_row, weigh_texel, weights,
}

@group(0) @binding(9) var<storage, read_write> points: array<vec4u>;

@compute @workgroup_size(64)
fn weigh(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let strip = thread.x + thread.y * groups.x * 64u;
    let a_row = strips_a_row();
    if strip >= a_row * rsm.size {
        return;
    }
    let first = STRIP * (strip % a_row);
    let end = min(first + STRIP, rsm.size);
    var sum = 0.0;
    for (var x = first; x < end; x++) {
        sum += weigh_texel(vec2u(x, strip / a_row));
    }
    weights[draw.first_strip + strip] = sum;
}

const THREADS: u32 = 256u;

var<workgroup> sums: array<f32, THREADS>;

// One workgroup: the sum is the same from run to run.
@compute @workgroup_size(THREADS)
fn sum_up(@builtin(local_invocation_index) thread: u32) {
    let share = (draw.strips + THREADS - 1u) / THREADS;
    let first = min(thread * share, draw.strips);
    let end = min(first + share, draw.strips);
    var sum = 0.0;
    for (var i = first; i < end; i++) {
        sum += weights[i];
    }
    sums[thread] = sum;
    workgroupBarrier();
    var running = 0.0;
    for (var i = 0u; i < thread; i++) {
        running += sums[i];
    }
    for (var i = first; i < end; i++) {
        running += weights[i];
        cumulative[i] = running;
    }
}

@compute @workgroup_size(64)
fn choose(@builtin(global_invocation_id) thread: vec3u) {
    let drawn = draw_texel(thread.x);
    if !drawn.is_here {
        return;
    }
    let texel = drawn.texel;
    let base = textureLoad(base_color, texel, rsm.layer, 0);
    let n = textureLoad(normal, texel, rsm.layer, 0);
    let position = texel_position(rsm, texel, textureLoad(depth, texel, rsm.layer, 0), decode_normal(n));
    let first = POINT_TEXELS * thread.x;
    points[first] = vec4u(bitcast<vec3u>(position), draw.light);
    points[first + 1u] = vec4u(base.xy | (base.zw << vec2u(16u)), n.xy | (n.zw << vec2u(16u)));
    let share = draw.scale / drawn.total;
    points[first + 2u] = vec4u(textureLoad(specular, texel, rsm.layer, 0).r, bitcast<u32>(share), 0u, 0u);
}
