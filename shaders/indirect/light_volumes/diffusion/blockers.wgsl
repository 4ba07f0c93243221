// Blockers: how much of the light through a cell-sized patch the surfaces there stop, by direction, and how they
// reflect it. They lie on the corners of the light cells.
//   PRINTED  as Šefčík 2016 has it: reflectances and merged views are aggregated by the maximum of each number (section
//            3.10.2), and the camera's samples are means over their pixels (section 5.2)

#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::lights::Light
#import lightwell::rsm::{RsmLayer, texel_received, texel_solid_angle}
#import lightwell::sh::{sh_cosine_lobe, BAND_ZERO, COSINE_ZERO}
#import lightwell::view::{View, toward_eye}
#import lightwell::volume::{Volume, corner_index, BEHIND}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> rsm: RsmLayer;
@group(0) @binding(3) var base_color: texture_2d_array<u32>;
@group(0) @binding(4) var normal: texture_2d_array<u32>;
@group(0) @binding(5) var depth: texture_depth_2d_array;
// A view's sums in fixed point, eight a corner: B_lm, ρ·A (RGB), A; areas in h².
@group(0) @binding(6) var<storage, read_write> fixed: array<atomic<i32>>;
// All views merged, two vectors a corner: B_lm; Σρ·A and Σ A.
@group(0) @binding(7) var<storage, read_write> merged: array<vec4f>;
@group(0) @binding(8) var<uniform> view: View;
@group(0) @binding(9) var<uniform> camera: CameraSamples;
@group(0) @binding(10) var camera_base_color: texture_2d<u32>;
@group(0) @binding(11) var camera_normal: texture_2d<u32>;
@group(0) @binding(12) var camera_depth: texture_depth_2d;

struct CameraSamples {
    stride: u32,           // [pixels] from sample to sample
    half_height: f32,      // of what is seen, at distance 1 in a perspective, at all [m] if lines of sight are parallel
}

// 64 faces of a cell are more area than one view can show in it: the sum stays below 2³⁰.
const FIXED_SCALE: f32 = 16777216.0;
// A surface at a grazing angle counts as if seen at 84°, else one texel would block whole cells.
const LEAST_COSINE: f32 = 0.1;

fn add_surface(position: vec3f, n: vec3f, albedo: vec3f, area_across: f32, cosine: f32) {
    let at = (position - volume.origin) / volume.cell + 0.5 - BEHIND * n;
    if any(at < vec3f(0.0)) || any(at >= vec3f(volume.cells + 1u)) {
        return;
    }
    // A texel larger than a cell's face fills the face, and no more.
    let area = min(area_across / volume.cell / volume.cell / max(cosine, LEAST_COSINE), 1.0);
    let first = 8u * corner_index(volume, vec3u(at));
    let blocked = vec4i(round(sh_cosine_lobe(n) * (area * FIXED_SCALE)));
#ifdef PRINTED
    let reflected = vec4i(round(vec4f(albedo, 1.0) * FIXED_SCALE));
#else
    let reflected = vec4i(round(vec4f(albedo, 1.0) * (area * FIXED_SCALE)));
#endif
    for (var i = 0u; i < 4u; i++) {
        atomicAdd(&fixed[first + i], blocked[i]);
#ifdef PRINTED
        atomicMax(&fixed[first + 4u + i], reflected[i]);
#else
        atomicAdd(&fixed[first + 4u + i], reflected[i]);
#endif
    }
}

@compute @workgroup_size(8, 8)
fn from_rsm(@builtin(global_invocation_id) thread: vec3u) {
    let texel = thread.xy;
    if any(texel >= vec2u(rsm.size)) {
        return;
    }
    let z = textureLoad(depth, texel, rsm.layer, 0);
    if z <= 0.0 {
        return;
    }
    let position = world_position(texel, vec2u(rsm.size), z, rsm.world_from_clip);
    let n = decode_normal(textureLoad(normal, texel, rsm.layer, 0));
    let received = texel_received(rsm, light, texel, position);
    let albedo = decode_albedo(textureLoad(base_color, texel, rsm.layer, 0));
    add_surface(position, n, albedo, received.area, dot(n, received.to_light));
}

// What the camera sees at a sample.
struct CameraSurface {
    position: vec3f,
    normal: vec3f,
    albedo: vec3f,
    is_hit: bool,
}

fn camera_surface(pixel: vec2u) -> CameraSurface {
    var surface: CameraSurface;
    if any(pixel >= view.size) {
        return surface;
    }
    let z = textureLoad(camera_depth, pixel, 0);
    surface.is_hit = z > 0.0;
    if surface.is_hit {
        surface.position = world_position(pixel, view.size, z, view.world_from_clip);
        surface.normal = decode_normal(textureLoad(camera_normal, pixel, 0));
        surface.albedo = decode_albedo(textureLoad(camera_base_color, pixel, 0));
    }
    return surface;
}

#ifdef PRINTED
// The mean of a sample's pixels: that of halving the image again and again.
fn camera_sample(sample: vec2u) -> CameraSurface {
    var sum: CameraSurface;
    var count = 0.0;
    for (var i = 0u; i < camera.stride * camera.stride; i++) {
        let surface = camera_surface(sample * camera.stride + vec2u(i % camera.stride, i / camera.stride));
        if surface.is_hit {
            sum.position += surface.position;
            sum.normal += surface.normal;
            sum.albedo += surface.albedo;
            count += 1.0;
        }
    }
    let size = length(sum.normal);
    sum.is_hit = size > 1e-3 * count && count > 0.0;
    return CameraSurface(sum.position / max(count, 1.0), sum.normal / max(size, 1e-6), sum.albedo / max(count, 1.0), sum.is_hit);
}
#else
// The pixel in its middle.
fn camera_sample(sample: vec2u) -> CameraSurface {
    return camera_surface(sample * camera.stride + camera.stride / 2u);
}
#endif

@compute @workgroup_size(8, 8)
fn from_camera(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy * camera.stride >= view.size) {
        return;
    }
    let surface = camera_sample(thread.xy);
    if !surface.is_hit {
        return;
    }
    let offset = toward_eye(view, surface.position);
    let d = max(length(offset), 1e-18);
    // The sample stands for stride² pixels.
    let size = vec2f(view.size);
    let extent = vec2f(camera.half_height * size.x / size.y, camera.half_height);
    let low = (2.0 * (vec2f(thread.xy * camera.stride)) / size - 1.0) * extent;
    let high = (2.0 * (vec2f((thread.xy + 1u) * camera.stride)) / size - 1.0) * extent;
    let parallel = (high - low).x * (high - low).y;
    let across = select(parallel, texel_solid_angle(low, high) * d * d, view.eye.w > 0.0);
    add_surface(surface.position, surface.normal, surface.albedo, across, dot(surface.normal, offset / d));
}

// One view into the merged volume. Of two views the one that sees more area counts, with its whole vector: a
// maximum of each coefficient for itself would lose the negative ones, and with them half of all orientations.
@compute @workgroup_size(64)
fn merge(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    let corners = volume.cells + 1u;
    if index >= corners.x * corners.y * corners.z {
        return;
    }
    var blocked: vec4f;
    var reflected: vec4f;
    for (var i = 0u; i < 4u; i++) {
        blocked[i] = f32(atomicLoad(&fixed[8u * index + i])) / FIXED_SCALE;
        reflected[i] = f32(atomicLoad(&fixed[8u * index + 4u + i])) / FIXED_SCALE;
    }
#ifdef PRINTED
    merged[2u * index] = max(merged[2u * index], blocked);
    merged[2u * index + 1u] = max(merged[2u * index + 1u], reflected);
#else
    if blocked.x > merged[2u * index].x {
        merged[2u * index] = blocked;
    }
    merged[2u * index + 1u] += reflected;
#endif
}

// The projected area of what a view sees is at most one face. Limited after all views are merged, so that two views
// that both fill the face do not tie.
@compute @workgroup_size(64)
fn limit(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    let corners = volume.cells + 1u;
    if index >= corners.x * corners.y * corners.z {
        return;
    }
    let blocked = merged[2u * index];
    merged[2u * index] = blocked * min(1.0, COSINE_ZERO * BAND_ZERO / max(blocked.x, 1e-12));
}
