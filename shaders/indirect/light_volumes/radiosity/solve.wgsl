// Radiosity of patches: how much light arrives at each from all others, bounce by bounce (Goral et al. 1984; gathered along
// links, which are Monte Carlo form factors).
//
//   ε₁ = E₀ + E₁, εₖ₊₁ = M·εₖ, E = Σ εₖ
// with the irradiance E₀ from emissive surfaces and the sky, E₁ of the lights' first bounce, and (M·x)_p the mean over the
// links of p's surfels of ρ·x at their ends. Sums go over surfels in their order, so that they do not depend on the device.
//   RAYS     links of a surfel

#import lightwell::patches::NO_PATCH
#import lightwell::radiosity::{RAYS, link_passing, link_patch, links_of}
#import lightwell::sweep::Surfel

// First surfel and number of surfels of a patch.
@group(0) @binding(0) var<storage, read> patches: array<vec2u>;
@group(0) @binding(1) var<storage, read> surfels: array<Surfel>;
@group(0) @binding(2) var<storage, read> surfel_links: array<vec2u>;
@group(0) @binding(3) var<storage, read> shone_on: array<vec4f>;
@group(0) @binding(4) var<storage, read> reflected_light: array<vec4f>;
// Irradiance of the patches in the last bounce and in this one [W/m²]; the fourth number is the area that is seen
// from afar [m²].
@group(0) @binding(5) var<storage, read> last_bounce: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> this_bounce: array<vec4f>;
// Irradiance of the patches of all bounces [W/m²].
@group(0) @binding(7) var<storage, read_write> patch_light: array<vec4f>;
// Flux that arrives in the last bounce and in this one [W], and what is left of light beyond, over that of this bounce.
@group(0) @binding(8) var<storage, read_write> rest: array<vec4f>;
// Irradiance of the surfels [W/m²].
@group(0) @binding(9) var<storage, read_write> received: array<vec4f>;

// Most that the series beyond the last bounce may add, over that bounce: an albedo of 0.98.
const MOST_REST: f32 = 49.0;

// How much a surfel counts in its patch: as much as it is seen from afar, which is as much as it sees. What lies in cracks
// has less light than the rest, and hardly any ray ends there.
fn weight_of(surfel: u32) -> f32 {
    return surfels[surfel].area * max(shone_on[surfel].w, 0.01);
}

fn linear_index(thread: vec3u, groups: vec3u) -> u32 {
    return thread.x + thread.y * groups.x * 64u;
}

// The first bounce.
@compute @workgroup_size(64)
fn start(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = linear_index(thread, groups);
    if index >= arrayLength(&patch_light) {
        return;
    }
    let range = patches[index];
    var light = vec3f(0.0);
    var weights = 0.0;
    for (var i = range.x; i < range.x + range.y; i++) {
        let weight = weight_of(i);
        light += weight * (shone_on[i].rgb + reflected_light[i].rgb);
        weights += weight;
    }
    this_bounce[index] = vec4f(light / max(weights, 1e-30), weights);
    patch_light[index] = this_bounce[index];
}

// What the links of a patch's surfels bring of the last bounce: irradiance times the area that is seen from afar [W].
fn gathered(range: vec2u) -> vec3f {
    var all = vec3f(0.0);
    for (var i = range.x; i < range.x + range.y; i++) {
        var sum = vec3f(0.0);
        for (var k = links_of(i); k < links_of(i) + RAYS; k++) {
            let link = surfel_links[k];
            let to = link_patch(link);
            if to != NO_PATCH {
                sum += link_passing(link) * last_bounce[to].rgb;
            }
        }
        all += (weight_of(i) / f32(RAYS)) * sum;
    }
    return all;
}

@compute @workgroup_size(64)
fn bounce(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = linear_index(thread, groups);
    if index >= arrayLength(&patch_light) {
        return;
    }
    let weights = last_bounce[index].w;
    let light = gathered(patches[index]) / max(weights, 1e-30);
    this_bounce[index] = vec4f(light, weights);
    patch_light[index] = vec4f(patch_light[index].rgb + light, weights);
}

// One bounce more of the light of the frame before, which stands in the last bounce: E = E₀ + E₁ + M·E. What it converges to
// is the light of all bounces.
@compute @workgroup_size(64)
fn go_on(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = linear_index(thread, groups);
    if index >= arrayLength(&patch_light) {
        return;
    }
    let range = patches[index];
    var all = gathered(range);
    var weights = 0.0;
    for (var i = range.x; i < range.x + range.y; i++) {
        let weight = weight_of(i);
        all += weight * (shone_on[i].rgb + reflected_light[i].rgb);
        weights += weight;
    }
    let light = all / max(weights, 1e-30);
    patch_light[index] = vec4f(light, weights);
    for (var i = range.x; i < range.x + range.y; i++) {
        received[i] = vec4f(light, 0.0);
    }
}

const THREADS: u32 = 256u;
// Of the light in sums over all patches, so that they stay in the range of floats.
const SCALE: f32 = 0x1p-64f;
var<workgroup> sums: array<array<vec3f, 2>, THREADS>;

// What is left after the last bounce is taken for a geometric series with the ratio of its last two members, which is what
// the light of many bounces comes to: the dominant eigenvector.
@compute @workgroup_size(256)
fn find_rest(@builtin(local_invocation_index) thread: u32) {
    var before = vec3f(0.0);
    var now = vec3f(0.0);
    for (var i = thread; i < arrayLength(&last_bounce); i += THREADS) {
        before += last_bounce[i].w * (SCALE * last_bounce[i].rgb);
        now += this_bounce[i].w * (SCALE * this_bounce[i].rgb);
    }
    sums[thread] = array(before, now);
    for (var stride = THREADS / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if thread < stride {
            sums[thread][0] += sums[thread + stride][0];
            sums[thread][1] += sums[thread + stride][1];
        }
    }
    if thread == 0u {
        let ratio = clamp(sums[0][1] / max(sums[0][0], vec3f(1e-37)), vec3f(0.0), vec3f(1.0));
        rest[0] = vec4f(min(ratio / max(1.0 - ratio, vec3f(1e-6)), vec3f(MOST_REST)), 0.0);
    }
}

@compute @workgroup_size(64)
fn finish(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = linear_index(thread, groups);
    if index >= arrayLength(&patch_light) {
        return;
    }
    let light = patch_light[index].rgb + rest[0].rgb * this_bounce[index].rgb;
    patch_light[index] = vec4f(light, this_bounce[index].w);
    let range = patches[index];
    for (var i = range.x; i < range.x + range.y; i++) {
        received[i] = vec4f(light, 0.0);
    }
}
