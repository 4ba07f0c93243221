// One light and one point a thread: whether the light is accepted there, and whether its range holds the point. For
// tests: no frame runs it.

#import lightwell::slc::{VirtualLight, LightRange, lobe_intensity, acceptance, light_range, squeezed}

// Point [m], and ξ.
@group(0) @binding(0) var<storage, read> points: array<vec4f>;
@group(0) @binding(1) var<storage, read> virtual_lights: array<VirtualLight>;
// δ and bounds.
@group(0) @binding(2) var<storage, read> choice: vec2f;
@group(0) @binding(3) var<storage, read_write> ranges: array<LightRange>;
// p of the diffuse and of the specular lobe; 1 where the range holds the point.
@group(0) @binding(4) var<storage, read_write> found: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let i = thread.x;
    if i >= arrayLength(&points) {
        return;
    }
    let light = virtual_lights[i];
    let range = light_range(light, choice.x, points[i].w, u32(choice.y));
    ranges[i] = range;
    let offset = points[i].xyz - light.position;
    let distance_squared = dot(offset, offset);
    let direction = offset * inverseSqrt(distance_squared);
    let from_diffuse = points[i].xyz - range.diffuse_center;
    let from_specular = squeezed(points[i].xyz - range.specular_center, range.axis, range.squeeze);
    let holds_diffuse = range.diffuse_radius > 0.0 && length(from_diffuse) <= range.diffuse_radius;
    let holds_specular = range.specular_radius > 0.0 && length(from_specular) <= range.specular_radius;
    found[i] = vec4f(
        acceptance(lobe_intensity(light, 0u, direction), choice.x, distance_squared + light.spread),
        acceptance(lobe_intensity(light, 1u, direction), choice.x, distance_squared + light.spread),
        select(0.0, 1.0, holds_diffuse),
        select(0.0, 1.0, holds_specular),
    );
}
