// Splatting: every light is drawn over the pixels of its subset that its range covers, and added. The image of a subset
// is one part of an atlas of n × n. What is drawn are the back faces of an icosahedron around the range: a range
// that the eye is in has them too, and a pixel is covered once.

#import lightwell::slc::squeezed
#import lightwell::slc_shading::{MAX_RADIANCE, culling, depth, ranges, load_pixel, may_accept, take_light}

// The atlas, for the way back.
@group(0) @binding(9) var diffuse_atlas: texture_2d<f32>;
@group(0) @binding(10) var specular_atlas: texture_2d<f32>;
@group(0) @binding(11) var diffuse: texture_storage_2d<rgba32float, write>;
@group(0) @binding(12) var specular: texture_storage_2d<rgba32float, write>;

struct Splat {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) light: u32,
    @location(1) @interpolate(flat) lobe: u32,
}

struct Sum {
    @location(0) diffuse: vec4f,
    @location(1) specular: vec4f,
}

// Radius of the corners over that of the sphere that touches the faces, rounded up.
const AROUND: f32 = 1.2585;

// Corner of a face of the unit icosahedron, counter-clockwise seen from outside.
fn icosahedron(index: u32) -> vec3f {
    var corners = array<vec3f, 12>(
        vec3f(-0.525731, 0.0, 0.850651), vec3f(0.525731, 0.0, 0.850651), vec3f(-0.525731, 0.0, -0.850651),
        vec3f(0.525731, 0.0, -0.850651), vec3f(0.0, 0.850651, 0.525731), vec3f(0.0, 0.850651, -0.525731),
        vec3f(0.0, -0.850651, 0.525731), vec3f(0.0, -0.850651, -0.525731), vec3f(0.850651, 0.525731, 0.0),
        vec3f(-0.850651, 0.525731, 0.0), vec3f(0.850651, -0.525731, 0.0), vec3f(-0.850651, -0.525731, 0.0),
    );
    var faces = array<vec3u, 20>(
        vec3u(0u, 4u, 1u), vec3u(0u, 9u, 4u), vec3u(9u, 5u, 4u), vec3u(4u, 5u, 8u), vec3u(4u, 8u, 1u),
        vec3u(8u, 10u, 1u), vec3u(8u, 3u, 10u), vec3u(5u, 3u, 8u), vec3u(5u, 2u, 3u), vec3u(2u, 7u, 3u),
        vec3u(7u, 10u, 3u), vec3u(7u, 6u, 10u), vec3u(7u, 11u, 6u), vec3u(11u, 0u, 6u), vec3u(0u, 1u, 6u),
        vec3u(6u, 1u, 10u), vec3u(9u, 0u, 11u), vec3u(9u, 11u, 2u), vec3u(9u, 2u, 5u), vec3u(7u, 2u, 11u),
    );
    let face = faces[index / 3u];
    let a = corners[face.x];
    let outward = dot(cross(corners[face.y] - a, corners[face.z] - a), a) > 0.0;
    let which = index % 3u;
    if which == 0u {
        return a;
    }
    return corners[select(face.z, face.y, (which == 1u) == outward)];
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Splat {
    var splat: Splat;
    splat.lobe = instance / culling.lights;
    splat.light = culling.first_subset * culling.lights + instance % culling.lights;
    let range = ranges[splat.light];
    var center = range.diffuse_center;
    var radius = range.diffuse_radius;
    var squeeze = 1.0;
    if splat.lobe == 1u {
        center = range.specular_center;
        radius = range.specular_radius;
        squeeze = range.squeeze;
    }
    // Outside of the image.
    splat.position = vec4f(2.0, 2.0, 2.0, 1.0);
    if radius > 0.0 {
        let offset = squeezed(icosahedron(index) * (AROUND * radius), range.axis, 1.0 / squeeze);
        var clip = culling.view.clip_from_world * vec4f(center + offset, 1.0);
        // From the pixels of the image to those of the subset: X = x·n + i, both counted at their middles.
        let n = f32(culling.interleave);
        let subset = vec2f(f32(culling.first_subset % culling.interleave), f32(culling.first_subset / culling.interleave));
        let size = vec2f(culling.view.size);
        let part = ceil(size / n);
        let pixel = (vec2f(clip.x, -clip.y) + clip.w) * 0.5 * size;
        let place = (pixel - (subset + 0.5) * clip.w) / n + 0.5 * clip.w;
        let ndc = 2.0 * place / part - clip.w;
        // No face is cut by the planes of depth.
        splat.position = vec4f(ndc.x, -ndc.y, 0.5 * clip.w, clip.w);
    }
    return splat;
}

@fragment
fn fragment(splat: Splat) -> Sum {
    let n = culling.interleave;
    let part = (culling.view.size + n - 1u) / n;
    let at = (vec2u(splat.position.xy) % part) * n + vec2u(culling.first_subset % n, culling.first_subset / n);
    var z = 0.0;
    if all(at < culling.view.size) {
        z = textureLoad(depth, at, 0);
    }
    if z <= 0.0 {
        discard;
    }
    var pixel = load_pixel(at, z);
    pixel.tested = 1.0;
    if may_accept(pixel, splat.light, splat.lobe) {
        take_light(&pixel, splat.light, splat.lobe);
    }
    return Sum(vec4f(pixel.diffuse, pixel.tested), vec4f(pixel.specular, pixel.accepted));
}

// From the atlas back to the image.
@compute @workgroup_size(8, 8)
fn gather(@builtin(global_invocation_id) thread: vec3u) {
    let at = thread.xy;
    if any(at >= culling.view.size) {
        return;
    }
    let n = culling.interleave;
    let part = (culling.view.size + n - 1u) / n;
    let place = at / n + (at % n) * part;
    let share = vec4f(vec3f(f32(n * n)), 1.0);
    let limit = vec4f(MAX_RADIANCE);
    textureStore(diffuse, at, min(textureLoad(diffuse_atlas, place, 0) * share, limit));
    textureStore(specular, at, min(textureLoad(specular_atlas, place, 0) * share, limit));
}
