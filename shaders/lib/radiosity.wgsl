#define_import_path lightwell::radiosity

// Links of surfels to what they see.
//   RAYS     those of a surfel

#import lightwell::gbuffer::{decode_octahedral, encode_octahedral}
#import lightwell::patches::NO_PATCH
#import lightwell::ray_scene::{NONE, load_triangle}
#import lightwell::rays::{Hit, hit_of}

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif

// How many links of a surfel remember where they ended, the first ones.
const ENDS: u32 = min(RAYS, 8u);

// Where the links of a surfel begin, which follow each other, and the ends after them, of three pairs of words each.
fn links_of(surfel: u32) -> u32 {
    return surfel * (RAYS + 3u * ENDS);
}

fn link_end_of(surfel: u32, link: u32) -> u32 {
    return links_of(surfel) + RAYS + 3u * link;
}

// The patch that light comes from, or NO_PATCH, and how much of what that reflects arrives, which has 15, 15 and 14 bits.
fn no_link() -> vec2u {
    return vec2u(NO_PATCH, 0u);
}

fn encode_link(patch_index: u32, passing: vec3f) -> vec2u {
    let code = vec3u(round(saturate(passing) * vec3f(32767.0, 32767.0, 16383.0)));
    let low = code & vec3u(15u);
    let high = code >> vec3u(4u);
    return vec2u(
        (patch_index & NO_PATCH) | (low.x << 20u) | (low.y << 24u) | (low.z << 28u),
        high.x | (high.y << 11u) | (high.z << 22u),
    );
}

fn link_patch(link: vec2u) -> u32 {
    return link.x & NO_PATCH;
}

fn link_passing(link: vec2u) -> vec3f {
    let low = vec3u(link.x >> 20u, link.x >> 24u, link.x >> 28u) & vec3u(15u);
    let high = vec3u(link.y & 0x7ffu, (link.y >> 11u) & 0x7ffu, link.y >> 22u);
    return vec3f(low | (high << vec3u(4u))) / vec3f(32767.0, 32767.0, 16383.0);
}

// Most surfaces that a link meets, one after the other.
const MOST_MET: u32 = 6u;

// A surface on the way of a link, for the lights' light there.
struct LinkEnd {
    seen: vec2u,           // triangle, or NONE: the sky, or the back of something; barycentrics of its second and third corner
    ray: vec2u,            // direction in which the ray came, octahedral; distance that it came [m], as bits
    weight: vec2u,         // of light that is sent back along the ray, over MOST_MET
}

// The ray that met it: where it began, its unit direction, and what it met.
struct LinkRay {
    start: vec3f,          // [m]
    direction: vec3f,
    hit: Hit,
}

fn no_link_end() -> LinkEnd {
    return LinkEnd(vec2u(NONE, 0u), vec2u(0u), vec2u(0u));
}

fn encode_link_end(ray: LinkRay, weight: vec3f) -> LinkEnd {
    let share = saturate(weight / f32(MOST_MET));
    return LinkEnd(
        vec2u(ray.hit.triangle, pack2x16unorm(ray.hit.barycentric)),
        vec2u(pack2x16snorm(encode_octahedral(ray.direction)), bitcast<u32>(ray.hit.t)),
        vec2u(pack2x16unorm(share.rg), pack2x16unorm(vec2f(share.b, 0.0))),
    );
}

fn link_end_weight(end: LinkEnd) -> vec3f {
    return f32(MOST_MET) * vec3f(unpack2x16unorm(end.weight.x), unpack2x16unorm(end.weight.y).x);
}

fn link_ray(end: LinkEnd) -> LinkRay {
    let barycentric = unpack2x16unorm(end.seen.y);
    let distance = bitcast<f32>(end.ray.y);
    let triangle = load_triangle(end.seen.x);
    let w = 1.0 - barycentric.x - barycentric.y;
    let met = w * triangle.corner_a + barycentric.x * triangle.corner_b + barycentric.y * triangle.corner_c;
    let direction = decode_octahedral(unpack2x16snorm(end.ray.x));
    return LinkRay(met - distance * direction, direction, hit_of(distance, end.seen.x, barycentric));
}
