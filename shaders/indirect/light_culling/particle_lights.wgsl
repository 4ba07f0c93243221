// Virtual lights of particles, behind the others of each subset: diffuse surfaces whose radiance is their own. One that emits
// L over an area A shines as a white one that receives the flux π·L·A.

#import lightwell::slc::VirtualLight

struct ParticleLight {
    position: vec3f,       // world [m]
    area: f32,             // [m²]
    normal: vec3f,         // unit
    lit: f32,              // part of the surfaces around that it lights [m²]
    flux: vec3f,           // π·L·A [W]
}

struct Placing {
    first: u32,            // light of the particles in each subset
    lights: u32,           // of a subset
    count: u32,            // of them those of particles
    subsets: u32,
}

@group(0) @binding(0) var<uniform> placing: Placing;
@group(0) @binding(1) var<storage, read> particle_lights: array<ParticleLight>;
@group(0) @binding(2) var<storage, read_write> virtual_lights: array<VirtualLight>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= placing.count * placing.subsets {
        return;
    }
    let light = particle_lights[index];
    var result: VirtualLight;
    result.position = light.position;
    // The error bound is relative to the mean irradiance, which is far less than what leaves particles.
    result.area = light.lit;
    result.spread = light.area * 0.318309886;
    result.to_light = light.normal;
    result.alpha = 1.0;
    result.normal = light.normal;
    result.grazing_reflectance = 0.0;
    result.flux = min(light.flux, vec3f(1e30));
    result.albedo = vec3f(1.0);
    result.normal_reflectance = vec3f(0.0);
    // Neighbours in the list go to different subsets, so that each has an even choice of all.
    let subset = index % placing.subsets;
    virtual_lights[subset * placing.lights + placing.first + index / placing.subsets] = result;
}
