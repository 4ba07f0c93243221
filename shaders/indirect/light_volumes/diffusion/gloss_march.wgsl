// Gloss march: what GGX lobes reflect of the propagated light, found along the reflected ray in steps of one cell of the
// finest cascade (Šefčík 2016, sections 3.10.4 and 5.6), and the diffuse reflection without what they took.
//   INVERSE_SQUARE  steps are weighted by 1/d² (section 3.10.4) in place of 1/d (section 5.6)

#import lightwell::environment::lobe_reflectance
#import lightwell::gbuffer::{decode_surface, world_position}
#import lightwell::relight::{relight, sample, share}
#import lightwell::sh::sh_basis
#import lightwell::view::{View, toward_eye}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
@group(0) @binding(9) var indirect: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var object: texture_2d<u32>;
@group(0) @binding(11) var diffuse: texture_2d<f32>;

// Steps along a mirror's ray; rough surfaces take fewer, down to one. The thesis says "up to and over 24 texture fetches",
// three a step.
const MOST_STEPS: f32 = 10.0;

struct Marched {
    radiance: vec3f,
    is_inside: bool,       // of the finest cascade
}

// Mean radiance along a ray from a point, by the weights of its steps: I(−r)/h² in each.
fn march(point: vec3f, n: vec3f, direction: vec3f, roughness: f32) -> Marched {
    let volume = relight.cascades[0].volume;
    let steps = 1u + u32(round((1.0 - saturate(roughness)) * (MOST_STEPS - 1.0)));
    let basis = sh_basis(-direction);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = 1u; i <= steps; i++) {
        let d = f32(i);
        let at = point + n * (relight.offset * volume.cell) + direction * (d * volume.cell);
        if share(0u, at) <= 0.0 {
            break;
        }
        let cell = sample(0u, volume, at);
#ifdef INVERSE_SQUARE
        let weight = 1.0 / (d * d);
#else
        let weight = 1.0 / d;
#endif
        sum += weight * max(vec3f(dot(cell.red, basis), dot(cell.green, basis), dot(cell.blue, basis)), vec3f(0.0));
        weights += weight;
    }
    return Marched(sum / max(weights, 1e-6), weights > 0.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= view.size) {
        return;
    }
    var radiance = textureLoad(diffuse, pixel, 0).rgb;
    let z = textureLoad(depth, pixel, 0);
    if z > 0.0 {
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let s = decode_surface(
            textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, point,
        );
        if any(s.normal_reflectance > vec3f(0.0)) || s.grazing_reflectance > 0.0 {
            let to_eye = normalize(toward_eye(view, point));
            let n_dot_v = max(dot(s.normal, to_eye), 1e-4);
            let marched = march(point, s.normal, reflect(-to_eye, s.normal), s.roughness);
            if marched.is_inside {
                let reflected = lobe_reflectance(s.normal_reflectance, s.grazing_reflectance, s.roughness, n_dot_v);
                let kept = 1.0 - max(reflected.r, max(reflected.g, reflected.b));
                radiance = min(kept * radiance + reflected * marched.radiance, vec3f(1e32));
            }
        }
    }
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
}
