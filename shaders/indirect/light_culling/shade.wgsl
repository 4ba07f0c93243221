// Light of the accepted virtual lights at the pixels of one subset. Lights come in the order of their numbers, so that
// tiles, clusters and all bounds give the same bits.
//   SKY_MAP       the sky differs by direction; others as in lib/slc_shading.wgsl
//   NO_DIFFUSE, NO_SPECULAR   without that lobe of the lights

#import lightwell::slc::{DIFFUSE_LOBE, SLICES, SPECULAR_LOBE, mask_stride}
#ifdef RAYS
#import lightwell::brdf::PI
#import lightwell::ray_scene::NONE
#import lightwell::rays::{Ray, SHADOW}
#import lightwell::walk::{passed, trace}
#import lightwell::sampling::{cosine_direction, hash, unit_float}
#import lightwell::slc::brightest
#ifdef SKY_MAP
#import lightwell::sky::sky_radiance
#endif
#endif
#import lightwell::slc_shading::{Pixel, MAX_RADIANCE, culling, depth, load_pixel, may_accept, take_light}

@group(0) @binding(9) var<storage, read> masks: array<u32>;
@group(0) @binding(10) var<storage, read> slices: array<u32>;
// Irradiance that the diffuse reflection answers to [W/m²], and the number of lights tested.
@group(0) @binding(11) var diffuse: texture_storage_2d<rgba32float, write>;
// Radiance of the specular reflection [W/(m² sr)], and the number of lights accepted.
@group(0) @binding(12) var specular: texture_storage_2d<rgba32float, write>;

// By direction, as lib/sky.wgsl reads it.
@group(0) @binding(13) var sky: texture_2d<f32>;

#ifdef UNCULLED

// Four a turn, as LIGHTS_A_TURN of light_culling/mod.rs: software drivers end loops of many turns.
fn shade(pixel: ptr<function, Pixel>, first: u32, lobe: u32) {
    (*pixel).tested += f32(culling.lights);
#ifdef RAYS
    for (var i = 0u; i < culling.lights; i++) {
        take_light(pixel, first + i, lobe);
    }
#else
    let whole = culling.lights & ~3u;
    for (var i = 0u; i < whole; i += 4u) {
        take_light(pixel, first + i, lobe);
        take_light(pixel, first + i + 1u, lobe);
        take_light(pixel, first + i + 2u, lobe);
        take_light(pixel, first + i + 3u, lobe);
    }
    for (var i = whole; i < culling.lights; i++) {
        take_light(pixel, first + i, lobe);
    }
#endif
}

#else

// Lights that passed the first test and wait for the rest, so that threads that run together do the long part together.
const QUEUE: u32 = 15u;
var<workgroup> queue: array<u32, 3840>;

// Lights of a tile's slice, from the bits of its mask.
fn shade(pixel: ptr<function, Pixel>, first: u32, lobe: u32, mask: u32, thread: u32) {
    for (var group = 0u; 32u * group < culling.words; group++) {
        var summary = masks[mask + culling.words + group];
        var bits = 0u;
        var word = 0u;
        while (summary | bits) != 0u {
            var count = 0u;
            while (summary | bits) != 0u && count < QUEUE {
                if bits == 0u {
                    word = 32u * group + firstTrailingBit(summary);
                    summary &= summary - 1u;
                    bits = masks[mask + word];
                }
                let index = first + 32u * word + firstTrailingBit(bits);
                bits &= bits - 1u;
                (*pixel).tested += 1.0;
                if may_accept(*pixel, index, lobe) {
                    queue[256u * count + thread] = index;
                    count += 1u;
                }
            }
            for (var i = 0u; i < count; i++) {
                take_light(pixel, queue[256u * i + thread], lobe);
            }
        }
    }
}

#endif

#ifdef RAYS

// Light of the sky: rays around the normal with density cosθ/π, of which each subset casts others, so that filtered
// they are many (Hammersley's set, turned at random from frame to frame). Reflected diffusely alone.
fn add_sky(pixel: ptr<function, Pixel>, subset: u32) {
    let subsets = culling.interleave * culling.interleave;
    let rays = select(0u, culling.sky_rays, any(culling.sky > vec3f(0.0)));
    let normal = (*pixel).surface.normal;
    let shift = unit_float(hash(culling.seed));
    for (var i = 0u; i < rays; i++) {
        let index = i * subsets + subset;
        let u = vec2f((f32(index) + 0.5) / f32(rays * subsets), fract(unit_float(reverseBits(index)) + shift));
        let direction = cosine_direction(normal, u);
        let ray = Ray((*pixel).origin, direction);
        let hit = trace(culling.root, ray, 3e38, SHADOW);
        if hit.triangle == NONE {
            let f = (*pixel).surface.normal_reflectance;
#ifdef SKY_MAP
            let radiance = sky_radiance(sky, direction, culling.sky_turn);
#else
            let radiance = culling.sky;
#endif
            (*pixel).diffuse += passed(ray, hit) * radiance * (PI * (1.0 - brightest(f)) / f32(rays * subsets));
        }
    }
}

#endif

@compute @workgroup_size(16, 16)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let n = culling.interleave;
    let subset = culling.first_subset + group.z;
    // Eight threads that run together take 4 × 2 pixels, which have more lights in common than eight in a row.
    let place = vec2u((thread & 3u) | ((thread >> 1u) & 12u), ((thread >> 2u) & 1u) | ((thread >> 4u) & 14u));
    let at = (16u * group.xy + place) * n + vec2u(subset % n, subset / n);
    if any(at >= culling.view.size) {
        return;
    }
    let z = textureLoad(depth, at, 0);
    if z <= 0.0 {
        textureStore(diffuse, at, vec4f(0.0));
        textureStore(specular, at, vec4f(0.0));
        return;
    }
    var pixel = load_pixel(at, z);
    let first = subset * culling.lights;
    // One call a lobe: each is compiled on its own.
#ifdef UNCULLED
#ifndef NO_DIFFUSE
    shade(&pixel, first, DIFFUSE_LOBE);
#endif
#ifndef NO_SPECULAR
    shade(&pixel, first, SPECULAR_LOBE);
#endif
#else
    let tile = (subset * culling.tiles.y + group.y) * culling.tiles.x + group.x;
    let stride = mask_stride(culling.words);
    let mask = 2u * (tile * SLICES + slices[at.y * culling.view.size.x + at.x]) * stride;
#ifndef NO_DIFFUSE
    shade(&pixel, first, DIFFUSE_LOBE, mask, thread);
#endif
#ifndef NO_SPECULAR
    shade(&pixel, first, SPECULAR_LOBE, mask + stride, thread);
#endif
#endif
#ifdef RAYS
    add_sky(&pixel, subset);
#endif
    // Each subset stands for all.
    let share = f32(n * n);
    textureStore(diffuse, at, vec4f(min(pixel.diffuse * share, vec3f(MAX_RADIANCE)), pixel.tested));
    textureStore(specular, at, vec4f(min(pixel.specular * share, vec3f(MAX_RADIANCE)), pixel.accepted));
}
