// Light straight from the lights at surfels, by shadow rays.
//   SAMPLES  lights that a surfel looks at, each chosen from all by what it would bring if nothing were in its way

#import lightwell::next_event::{bounded, sample_light}
#import lightwell::rays::{Surface, NONE, SHADOW, trace}
#import lightwell::sampling::{Sampler, next_pair}
#import lightwell::sweep::Surfel

struct Direct {
    root: u32,             // of the hierarchy
    light_count: u32,
    seed: u32,
    first: u32,            // surfel of this dispatch
}

@group(0) @binding(0) var<uniform> direct: Direct;
@group(0) @binding(1) var<storage, read> surfels: array<Surfel>;
// Irradiance [W/m²].
@group(0) @binding(2) var<storage, read_write> lit: array<vec4f>;

#ifdef SAMPLES
const SAMPLES: u32 = #{SAMPLES}u;
#else
const SAMPLES: u32 = 1u;
#endif

const PI: f32 = 3.14159265358979;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = direct.first + thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    var surface: Surface;
    surface.position = surfel.position;
    surface.normal = surfel.normal;
    surface.geometric_normal = surfel.normal;
    surface.albedo = vec3f(1.0);
    surface.alpha = 1.0;
    let p = abs(surfel.position);
    surface.error = max(p.x, max(p.y, p.z)) * 0x1p-19f;
    var light = vec3f(0.0);
    for (var i = 0u; i < SAMPLES; i++) {
        var random = Sampler(direct.seed, index * SAMPLES + i, 0u);
        let sample = sample_light(surface, surfel.normal, direct.light_count, false, next_pair(&random).x);
        var is_lit = true;
        if sample.reach > 0.0 {
            is_lit = trace(direct.root, sample.ray, sample.reach, SHADOW).triangle == NONE;
        }
        light += select(vec3f(0.0), bounded(sample.light), is_lit);
    }
    lit[index] = vec4f(light * (PI / f32(SAMPLES)), 0.0);
}
