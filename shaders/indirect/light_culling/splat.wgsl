// Splatting: every light is drawn over the pixels of its subset that its range covers, and added. The image of a subset
// is one part of an atlas of n × n. What is drawn are the back faces of 80 triangles around the range (Dachsbacher and
// Stamminger 2006, with the count of Tokuyoshi and Harada 2017): a range that the eye is in has them too, and a pixel is
// covered once.

#import lightwell::slc::squeezed
#import lightwell::slc_shading::{MAX_RADIANCE, culling, depth, ranges, load_pixel, may_accept, take_light}

// Corners of triangles around the unit sphere, three each.
@group(0) @binding(13) var<storage, read> corners: array<vec4f>;
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
        let offset = squeezed(corners[index].xyz * radius, range.axis, 1.0 / squeeze);
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
