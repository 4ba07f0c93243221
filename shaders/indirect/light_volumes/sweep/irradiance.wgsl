// Irradiance from the swept volumes: at the surfels, for the next bounce, and at the visible surfaces.

#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::sweep::{Surfel, openness, thickness_for}
#import lightwell::sweep_lookup::{irradiance, linked_irradiance}
#import lightwell::view::{View, toward_eye}
#import lightwell::volume::Volume

struct Cascade {
    volume: Volume,
    fade_center: vec3f,    // centre of the box before it was snapped [m]
    fade_cells: f32,       // width of the fade into the next coarser cascade [cells]
    fade_half: vec3f,      // half extent of that box [m]
    padding: f32,
}

// FIRST: the cascade is the finest, it starts the sum. LAST: the coarsest, it takes all that is left. CALIBRATED: by the white furnace. No uniforms: where a
// branch hangs on a uniform alone, Mesa's software driver (22.3) makes the shader anew in every frame, and keeps all.
struct Lookup {
    cascade: Cascade,
}

@group(0) @binding(0) var<uniform> lookup: Lookup;
@group(0) @binding(3) var<storage, read> surfels: array<Surfel>;
// Irradiance of the surfels [W/m²], and the share that coarser cascades still have to give.
@group(0) @binding(4) var<storage, read_write> received: array<vec4f>;
// Irradiance of the surfels where all surfaces and the sky have radiance 1 [W/m²].
@group(0) @binding(13) var<storage, read> white: array<vec4f>;
// Of this cascade, see `indirect/light_volumes/sweep/links.wgsl`.
@group(0) @binding(5) var<storage, read> links: array<u32>;
@group(0) @binding(6) var<uniform> view: View;
@group(0) @binding(7) var base_color: texture_2d<u32>;
@group(0) @binding(8) var normal: texture_2d<u32>;
@group(0) @binding(9) var depth: texture_depth_2d;
// As `received`, for the pixels.
@group(0) @binding(10) var<storage, read_write> partial: array<vec4f>;
@group(0) @binding(11) var indirect: texture_storage_2d<rgba32float, write>;

// The largest factor on light where the sweep finds too little: what hardly any light finds stays dark.
const MOST_GAIN: f32 = 2.0;

// What the light of a surfel is multiplied by. Where all surfaces send out radiance 1, irradiance is π whatever the scene
// (a white furnace); of what the sweep makes of it instead, known before, the inverse corrects all light of the surfel.
// So each bounce takes even light to even light times the reflectance, and as no weight is negative none can be brighter
// than the brightest of the bounce before it.
fn gain(white_light: f32) -> f32 {
    return min(MOST_GAIN, 3.14159265 / max(white_light, 1e-6));
}

// Share of the cascade at a point: 1 inside, falling to 0 over the fade; the coarsest is whole to its border.
fn share(point: vec3f) -> f32 {
    let cascade = lookup.cascade;
    let extent = vec3f(cascade.volume.cells) * cascade.volume.cell;
    let inside = min(point - cascade.volume.origin, cascade.volume.origin + extent - point);
    if any(inside < vec3f(-1e-3 * cascade.volume.cell)) {
        return 0.0;
    }
#ifdef LAST
    return 1.0;
#else
    if cascade.fade_cells <= 0.0 {
        return 1.0;
    }
    let margin = cascade.fade_half - abs(point - cascade.fade_center);
    let least = min(margin.x, min(margin.y, margin.z));
    return saturate(least / (cascade.fade_cells * cascade.volume.cell));
#endif
}

// The finest level that covers a point gives its light; over its border the next coarser takes over.
fn blend(so_far: vec4f, light: vec3f, w: f32) -> vec4f {
    return vec4f(so_far.rgb + w * light, so_far.a - w);
}

@compute @workgroup_size(64)
fn at_surfels(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index < arrayLength(&surfels) {
        let surfel = surfels[index];
        var e = vec4f(0.0, 0.0, 0.0, 1.0);
#ifndef FIRST
        e = received[index];
#endif
        let w = e.a * share(surfel.position);
        if w > 0.0 && surfel.area > 0.0 && thickness_for(surfel, lookup.cascade.volume.cell) >= 0.0 {
            e = blend(e, linked_irradiance(lookup.cascade.volume, surfel.position, surfel.normal, links[index]), w);
        }
#ifdef CALIBRATED
        e = vec4f(e.rgb * openness(surfel) * gain(white[index].r), e.a);
#endif
        received[index] = e;
    }
}

@compute @workgroup_size(8, 8)
fn relight(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= view.size) {
        return;
    }
    let index = pixel.y * view.size.x + pixel.x;
    var e = vec4f(0.0, 0.0, 0.0, 1.0);
#ifndef FIRST
    e = partial[index];
#endif
    let z = textureLoad(depth, pixel, 0);
    if z > 0.0 {
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let to_eye = normalize(toward_eye(view, point));
        let w = e.a * share(point);
        if w > 0.0 {
            let n = decode_normal(textureLoad(normal, pixel, 0));
            e = blend(e, irradiance(lookup.cascade.volume, point, n, to_eye), w);
        }
    }
#ifdef LAST
    let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
    let radiance = select(vec3f(0.0), min(albedo * e.rgb * 0.318309886, vec3f(1e32)), z > 0.0);
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
#else
    partial[index] = e;
#endif
}
