// Light of the accepted virtual lights at the pixels of one subset. Lights come in the order of their numbers, so that
// tiles, clusters and all bounds give the same bits.

#import lightwell::slc_shading::{Pixel, MAX_RADIANCE, view, culling, depth, load_pixel, test_light}

@group(0) @binding(9) var<storage, read> masks: array<u32>;
@group(0) @binding(10) var<storage, read> slices: array<u32>;
// Irradiance that the diffuse reflection answers to [W/m²], and the number of lights tested.
@group(0) @binding(11) var diffuse: texture_storage_2d<rgba32float, write>;
// Radiance of the specular reflection [W/(m² sr)], and the number of lights accepted.
@group(0) @binding(12) var specular: texture_storage_2d<rgba32float, write>;

fn shade(pixel: ptr<function, Pixel>, subset: u32, tile: u32, slice: u32) {
    let first = subset * culling.lights;
#ifdef UNCULLED
    for (var lobe = 0u; lobe < 2u; lobe++) {
        for (var i = 0u; i < culling.lights; i++) {
            test_light(pixel, first + i, lobe);
        }
    }
#else
    for (var lobe = 0u; lobe < 2u; lobe++) {
        let mask = ((tile * culling.slices + slice) * 2u + lobe) * culling.words;
        for (var word = 0u; word < culling.words; word++) {
            var bits = masks[mask + word];
            while bits != 0u {
                let bit = firstTrailingBit(bits);
                bits &= bits - 1u;
                test_light(pixel, first + 32u * word + bit, lobe);
            }
        }
    }
#endif
}

@compute @workgroup_size(16, 16)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let n = culling.interleave;
    let subset = culling.first_subset + group.z;
    let at = (16u * group.xy + local.xy) * n + vec2u(subset % n, subset / n);
    if any(at >= view.size) {
        return;
    }
    let z = textureLoad(depth, at, 0);
    if z <= 0.0 {
        textureStore(diffuse, at, vec4f(0.0));
        textureStore(specular, at, vec4f(0.0));
        return;
    }
    var pixel = load_pixel(at, z);
    let tile = (subset * culling.tiles.y + group.y) * culling.tiles.x + group.x;
#ifdef UNCULLED
    let slice = 0u;
#else
    let slice = slices[at.y * view.size.x + at.x];
#endif
    shade(&pixel, subset, tile, slice);
    // Each subset stands for all.
    let share = f32(n * n);
    textureStore(diffuse, at, vec4f(min(pixel.diffuse * share, vec3f(MAX_RADIANCE)), pixel.tested));
    textureStore(specular, at, vec4f(min(pixel.specular * share, vec3f(MAX_RADIANCE)), pixel.accepted));
}
