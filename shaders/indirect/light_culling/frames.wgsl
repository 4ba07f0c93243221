// The space in which tiles are tested against the GGX lobe of each light, computed once a light (Tokuyoshi and Harada 2017,
// section 5.2). The paper stores B·S and B·S·c. Here the centre is subtracted from corners before, which keeps digits far
// from the origin, so that B·S is all.

#import lightwell::slc::{Culling, LightRange, TestFrame, depth_frame, view_frame}

@group(0) @binding(1) var<uniform> culling: Culling;
@group(0) @binding(2) var<storage, read> ranges: array<LightRange>;
@group(0) @binding(3) var<storage, read_write> frames: array<TestFrame>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index < arrayLength(&ranges) {
        let range = ranges[index];
        frames[index] = depth_frame(view_frame(culling.view), range.axis, range.squeeze);
    }
}
