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
    triangle: u32,         // or NONE: the sky, or the back of something
    barycentric: u32,      // of the second and third corner, 16 bits each
    direction: u32,        // in which the ray came, octahedral, 16 bits each
    distance: f32,         // that it came [m]
    weight: u32,           // of light that is sent back along the ray, over MOST_MET, 10 bits a channel
}

// The ray that met it: where it began, its unit direction, and what it met.
struct LinkRay {
    start: vec3f,          // [m]
    direction: vec3f,
    hit: Hit,
}

fn no_link_end() -> LinkEnd {
    return LinkEnd(NONE, 0u, 0u, 0.0, 0u);
}

fn encode_link_end(ray: LinkRay, weight: vec3f) -> LinkEnd {
    let code = vec3u(round(saturate(weight / f32(MOST_MET)) * 1023.0));
    return LinkEnd(
        ray.hit.triangle,
        pack2x16unorm(ray.hit.barycentric),
        pack2x16snorm(encode_octahedral(ray.direction)),
        ray.hit.t,
        code.x | (code.y << 10u) | (code.z << 20u),
    );
}

fn link_end_weight(end: LinkEnd) -> vec3f {
    let code = vec3u(end.weight, end.weight >> 10u, end.weight >> 20u) & vec3u(1023u);
    return vec3f(code) * (f32(MOST_MET) / 1023.0);
}

fn link_ray(end: LinkEnd) -> LinkRay {
    let barycentric = unpack2x16unorm(end.barycentric);
    let triangle = load_triangle(end.triangle);
    let w = 1.0 - barycentric.x - barycentric.y;
    let met = w * triangle.corner_a + barycentric.x * triangle.corner_b + barycentric.y * triangle.corner_c;
    let direction = decode_octahedral(unpack2x16snorm(end.direction));
    return LinkRay(met - end.distance * direction, direction, hit_of(end.distance, end.triangle, barycentric));
}
