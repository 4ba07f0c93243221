// Tiled culling: which lights of a subset may reach which depth slices of a tile. A workgroup does one tile of
// 16 × 16 pixels in the image of one subset: those pixels of the whole image that are the subset's. Two slices are the
// halves of the tile's depth range (HalfZ, Harada 2012); 32 are clustered shading (Olsson et al. 2012), each as many times
// as deep as the one before. Either is tightened to the depths that occur.
//
// A slice is the part of the tile's pyramid between two depths. It is tested by its box in the space in which the
// light's spheroid is a sphere (Tokuyoshi and Harada 2017, eqs. 16 and 17): squeezed along the spheroid's axis, then
// turned so that planes of equal depth lie across an axis of the box, where it is tight.
//   SLICES   of depth; without it two

#import lightwell::gbuffer::world_position
#import lightwell::slc::{LightRange, Culling, SLICES, TestFrame, mask_stride, view_frame}
#import lightwell::view::view_depth

@group(0) @binding(1) var<uniform> culling: Culling;
@group(0) @binding(2) var depth: texture_depth_2d;
@group(0) @binding(3) var<storage, read> ranges: array<LightRange>;
// A bit a light, `words` words a lobe, then their summaries; two lobes a slice.
@group(0) @binding(4) var<storage, read_write> masks: array<u32>;
// The slice of every pixel.
@group(0) @binding(5) var<storage, read_write> slices: array<u32>;
// Of the lights' GGX lobes, as `frames.wgsl` has stored them.
@group(0) @binding(6) var<storage, read> frames: array<TestFrame>;

const GROUP_WORDS: u32 = 8u; // of the lights that a workgroup tests at once

var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;
var<workgroup> deepest: atomic<u32>;
var<workgroup> shallowest: atomic<u32>;
// Depths as integers, which are ordered as the floats are.
var<workgroup> slice_near: array<atomic<u32>, SLICES>;
var<workgroup> slice_far: array<atomic<u32>, SLICES>;
var<workgroup> found: array<atomic<u32>, 2u * SLICES * GROUP_WORDS>;
// Which words of 32 of a mask are not zero.
var<workgroup> summaries: array<atomic<u32>, 2u * SLICES>;
// Corners of the tile's pyramid between its depths, and the extents of the slices between them in 0..1.
var<workgroup> near_corners: array<vec3f, 4>;
var<workgroup> far_corners: array<vec3f, 4>;

fn slice_at(w: f32, near: f32, far: f32) -> u32 {
    if !(far > near) {
        return 0u;
    }
    if SLICES == 2u {
        return select(0u, 1u, w > 0.5 * (near + far));
    }
    let t = log(w / near) / log(far / near);
    return min(u32(max(t, 0.0) * f32(SLICES)), SLICES - 1u);
}

// A corner of the tile at a stored depth.
fn corner(tile: vec2u, subset: vec2u, which: u32, z: f32) -> vec3f {
    let n = culling.interleave;
    let step = vec2u(which & 1u, which >> 1u) * 15u;
    let pixel = min((16u * tile + step) * n + subset, culling.view.size - 1u);
    return world_position(pixel, culling.view.size, z, culling.view.world_from_clip);
}

// Bits of the slices that a spheroid may touch.
fn touched(center: vec3f, radius: f32, frame: TestFrame, near: f32, far: f32) -> u32 {
    var starts: array<vec3f, 4>;
    var ways: array<vec3f, 4>;
    var largest = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let a = near_corners[i] - center;
        let b = far_corners[i] - center;
        starts[i] = vec3f(dot(a, frame.right), dot(a, frame.up), dot(a, frame.forward));
        ways[i] = vec3f(dot(b, frame.right), dot(b, frame.up), dot(b, frame.forward)) - starts[i];
        let size = abs(near_corners[i]) + abs(far_corners[i]) + abs(center);
        largest = max(largest, max(size.x, max(size.y, size.z)));
    }
    // What rounding may have moved the corners by.
    let margin = 4e-6 * largest;
    let scale = select(0.0, 1.0 / (far - near), far > near);
    var bits = 0u;
    for (var s = 0u; s < SLICES; s++) {
        let first = bitcast<f32>(atomicLoad(&slice_near[s]));
        let last = bitcast<f32>(atomicLoad(&slice_far[s]));
        if last < first {
            continue;
        }
        let from_t = (first - near) * scale;
        let to_t = (last - near) * scale;
        var low = vec3f(3e38);
        var high = vec3f(-3e38);
        for (var i = 0u; i < 4u; i++) {
            let a = starts[i] + from_t * ways[i];
            let b = starts[i] + to_t * ways[i];
            low = min(low, min(a, b));
            high = max(high, max(a, b));
        }
        // From the sphere's centre to the box.
        let away = max(vec3f(0.0), max(low - margin, -high - margin));
        if dot(away, away) <= radius * radius {
            bits |= 1u << s;
        }
    }
    return bits;
}

fn mark(bits: u32, lobe: u32, thread: u32) {
    var rest = bits;
    while rest != 0u {
        let s = firstTrailingBit(rest);
        rest &= rest - 1u;
        atomicOr(&found[(2u * s + lobe) * GROUP_WORDS + thread / 32u], 1u << (thread & 31u));
    }
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let n = culling.interleave;
    let subset_index = group.z;
    let subset = vec2u(subset_index % n, subset_index / n);
    let pixel = (16u * group.xy + local.xy) * n + subset;
    if thread == 0u {
        atomicStore(&nearest, 0x7f7fffffu);
        atomicStore(&shallowest, 0x7f7fffffu);
        atomicStore(&farthest, 0u);
        atomicStore(&deepest, 0u);
    }
    if thread < 2u * SLICES {
        atomicStore(&summaries[thread], 0u);
    }
    if thread < SLICES {
        atomicStore(&slice_near[thread], 0x7f7fffffu);
        atomicStore(&slice_far[thread], 0u);
    }
    for (var i = thread; i < 2u * SLICES * GROUP_WORDS; i += 256u) {
        atomicStore(&found[i], 0u);
    }
    workgroupBarrier();

    var z = 0.0;
    if all(pixel < culling.view.size) {
        z = textureLoad(depth, pixel, 0);
    }
    var w = 0.0;
    if z > 0.0 {
        // Bits of what is above zero are ordered as the numbers are.
        w = max(view_depth(culling.view, world_position(pixel, culling.view.size, z, culling.view.world_from_clip)), 1e-30);
        atomicMin(&nearest, bitcast<u32>(w));
        atomicMax(&farthest, bitcast<u32>(w));
        atomicMin(&shallowest, bitcast<u32>(z));
        atomicMax(&deepest, bitcast<u32>(z));
    }
    workgroupBarrier();

    let near = bitcast<f32>(atomicLoad(&nearest));
    let far = bitcast<f32>(atomicLoad(&farthest));
    if z > 0.0 {
        let slice = slice_at(w, near, far);
        slices[pixel.y * culling.view.size.x + pixel.x] = slice;
        atomicMin(&slice_near[slice], bitcast<u32>(w));
        atomicMax(&slice_far[slice], bitcast<u32>(w));
    }
    if thread < 4u && far > 0.0 {
        // Depth is reversed: the largest is the nearest.
        near_corners[thread] = corner(group.xy, subset, thread, bitcast<f32>(atomicLoad(&deepest)));
        far_corners[thread] = corner(group.xy, subset, thread, bitcast<f32>(atomicLoad(&shallowest)));
    }
    workgroupBarrier();

    let tile = (subset_index * culling.tiles.y + group.y) * culling.tiles.x + group.x;
    let stride = mask_stride(culling.words);
    let first_word = tile * SLICES * 2u * stride;
    for (var chunk = 0u; chunk < culling.words; chunk += GROUP_WORDS) {
        let index = 32u * chunk + thread;
        if index < culling.lights && far > 0.0 {
            let light = subset_index * culling.lights + index;
            let range = ranges[light];
            if range.diffuse_radius > 0.0 {
                mark(touched(range.diffuse_center, range.diffuse_radius, view_frame(culling.view), near, far), 0u, thread);
            }
            if range.specular_radius > 0.0 {
                mark(touched(range.specular_center, range.specular_radius, frames[light], near, far), 1u, thread);
            }
        }
        workgroupBarrier();
        for (var i = thread; i < 2u * SLICES * GROUP_WORDS; i += 256u) {
            let word = chunk + i % GROUP_WORDS;
            let bits = atomicLoad(&found[i]);
            masks[first_word + (i / GROUP_WORDS) * stride + word] = bits;
            atomicOr(&summaries[i / GROUP_WORDS], select(0u, 1u, bits != 0u) << (word & 31u));
            atomicStore(&found[i], 0u);
        }
        workgroupBarrier();
        let end = chunk + GROUP_WORDS;
        if (end % 32u == 0u || end == culling.words) && thread < 2u * SLICES {
            masks[first_word + thread * stride + culling.words + chunk / 32u] = atomicExchange(&summaries[thread], 0u);
        }
        workgroupBarrier();
    }
}
