// ξ and the range of every virtual light, and what shading reads of it.

#import lightwell::gbuffer::encode_octahedral
#import lightwell::sampling::{hash, unit_float}
#import lightwell::brdf::PI
#import lightwell::slc::{VirtualLight, LightRange, light_range, brightest}
#import lightwell::slc::{LIGHTS_A_ROW, PLACE, SHAPE, COLOR, INCIDENCE, NORMAL_FLUX, GRAZING_FLUX, SPHEROID, AXIS}

struct Chances {
    lights: u32,           // of a subset
    seed: u32,
    bounds: u32,
    lobes: u32,            // 1 diffuse, 2 specular, 3 both
    independent: u32,      // 1: each ξ is drawn for itself
}

@group(0) @binding(0) var<uniform> chances: Chances;
@group(0) @binding(1) var<storage, read> virtual_lights: array<VirtualLight>;
@group(0) @binding(2) var<storage, read> bound: vec4f;
@group(0) @binding(3) var<storage, read_write> ranges: array<LightRange>;
@group(0) @binding(4) var light_texels: texture_storage_2d_array<rgba32float, write>;

// Neighbouring lights shine alike, so that their numbers are spread evenly: Weyl's sequence with the golden ratio,
// shifted at random for each subset. Every single number is uniform over all seeds. Or each for itself, as published.
fn xi_of(index: u32) -> f32 {
    if chances.independent == 1u {
        return clamp(unit_float(hash(index ^ hash(chances.seed))), 0x1p-24f, 1.0 - 0x1p-24f);
    }
    let subset = index / chances.lights;
    let steps = (index % chances.lights) * 2654435769u;
    let bits = steps + hash(subset ^ hash(chances.seed));
    return clamp(unit_float(bits), 0x1p-24f, 1.0 - 0x1p-24f);
}

fn store_texels(index: u32, light: VirtualLight, range: LightRange) {
    let at = vec2u(index % LIGHTS_A_ROW, index / LIGHTS_A_ROW);
    let is_lit = dot(light.normal, light.to_light) > 0.0;
    let color = select(vec3f(0.0), light.flux * light.albedo / PI, is_lit);
    let flux = select(vec3f(0.0), light.flux, is_lit);
    let reach = clamp(brightest(color) / bound.x / range.xi, 0.0, 1e30);
    let depends_on_angle = light.grazing_reflectance > 0.0 || any(light.normal_reflectance > vec3f(0.0));
    // Zero has no sign to tell by.
    let spread = max(light.spread, 1e-36);
    textureStore(light_texels, at, PLACE, vec4f(light.position, select(spread, -spread, depends_on_angle)));
    textureStore(light_texels, at, SHAPE, vec4f(light.normal, reach));
    textureStore(light_texels, at, COLOR, vec4f(color, brightest(light.normal_reflectance)));
    let incidence = encode_octahedral(light.to_light);
    textureStore(light_texels, at, INCIDENCE, vec4f(incidence, light.grazing_reflectance, light.alpha));
    textureStore(light_texels, at, NORMAL_FLUX, vec4f(flux * light.normal_reflectance, range.xi));
    textureStore(light_texels, at, GRAZING_FLUX, vec4f(flux * light.grazing_reflectance, 0.0));
    textureStore(light_texels, at, SPHEROID, vec4f(range.specular_center, range.specular_radius));
    textureStore(light_texels, at, AXIS, vec4f(range.axis, range.squeeze));
}

// Lobes that do not shine reach nothing.
fn of_lobes(range: LightRange) -> LightRange {
    var result = range;
    result.diffuse_radius = select(-1.0, range.diffuse_radius, (chances.lobes & 1u) != 0u);
    result.specular_radius = select(-1.0, range.specular_radius, (chances.lobes & 2u) != 0u);
    return result;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index < arrayLength(&virtual_lights) {
        let light = virtual_lights[index];
        let range = of_lobes(light_range(light, bound.x, xi_of(index), chances.bounds));
        ranges[index] = range;
        store_texels(index, light, range);
    }
}
