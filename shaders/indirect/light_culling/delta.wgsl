// The error bound δ [W/m²]: absolute, or relative to the mean irradiance of what the lights see, ΣΦ/ΣA. Summed in a
// fixed order by one workgroup, so that the bits are the same in every run.

#import lightwell::slc::{VirtualLight, brightest}

struct Delta {
    relative: f32,         // δ over the mean irradiance; 0: δ is absolute
    absolute: f32,         // δ [W/m²]
}

@group(0) @binding(0) var<uniform> wanted: Delta;
@group(0) @binding(1) var<storage, read> virtual_lights: array<VirtualLight>;
// δ, mean irradiance, flux, area.
@group(0) @binding(2) var<storage, read_write> bound: vec4f;

var<workgroup> sums: array<vec2f, 256>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var sum = vec2f(0.0);
    for (var i = thread; i < arrayLength(&virtual_lights); i += 256u) {
        sum += vec2f(brightest(virtual_lights[i].flux), virtual_lights[i].area);
    }
    sums[thread] = sum;
    workgroupBarrier();
    for (var step = 128u; step > 0u; step /= 2u) {
        if thread < step {
            sums[thread] += sums[thread + step];
        }
        workgroupBarrier();
    }
    if thread == 0u {
        let mean = select(0.0, sums[0].x / sums[0].y, sums[0].y > 0.0);
        let delta = select(wanted.absolute, wanted.relative * mean, wanted.relative > 0.0);
        bound = vec4f(clamp(delta, 1e-30, 1e30), mean, sums[0]);
    }
}
