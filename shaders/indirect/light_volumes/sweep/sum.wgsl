// Adds the irradiance of one bounce to the sum of all. After the last that is swept the rest follows as a geometric
// series: light spreads over the scene with each bounce, so that one soon differs from the next by a factor only.

#import lightwell::sweep::from_fixed

struct Sum {
    bounce: u32,
    has_tail: u32,         // this is the last bounce, and light would go on
    most: f32,             // bound on the factor from one bounce to the next
    padding: u32,
}

@group(0) @binding(0) var<uniform> sum: Sum;
@group(0) @binding(1) var<storage, read> totals: array<i32>;
@group(0) @binding(2) var<storage, read> axes: array<f32>;
@group(0) @binding(3) var<storage, read> facing: array<f32>;
@group(0) @binding(4) var<storage, read_write> all_axes: array<f32>;
@group(0) @binding(5) var<storage, read_write> all_facing: array<f32>;
// Irradiance of the surfels, of a bounce and of all [W/m²]; the fourth place is unused.
@group(0) @binding(6) var<storage, read> received: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> all_received: array<vec4f>;

fn sent(bounce: u32, channel: u32) -> f32 {
    let at = 6u * bounce + 2u * channel;
    return from_fixed(totals[at], totals[at + 1u]);
}

// What the bounce stands for: itself, or all that follow too.
fn of_series(channel: u32) -> f32 {
    if sum.has_tail == 0u || sum.bounce == 0u {
        return 1.0;
    }
    let ratio = min(sent(sum.bounce, channel) / max(sent(sum.bounce - 1u, channel), 1.0), sum.most);
    return 1.0 / (1.0 - ratio);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&all_axes) {
        return;
    }
    let factor = of_series(index % 3u);
    all_axes[index] += factor * axes[index];
    if index < arrayLength(&all_facing) {
        all_facing[index] += factor * facing[index];
    }
}

@compute @workgroup_size(64)
fn at_surfels(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index < arrayLength(&all_received) {
        let factors = vec3f(of_series(0u), of_series(1u), of_series(2u));
        all_received[index] += vec4f(factors * received[index].rgb, 0.0);
    }
}
