#define_import_path lightwell::radiosity

// Links of surfels to what they see.
//   RAYS     those of a surfel

#import lightwell::patches::NO_PATCH
#import lightwell::ray_scene::{NONE, load_triangle}
#import lightwell::rays::{Hit, hit_of, no_hit}
#import lightwell::sweep::Surfel

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif

// Where the links of a surfel start: a little before it [m], since objects stand on each other and surfaces nearly coincide.
// What lies just below another surface then sees what that one does.
fn link_start(surfel: Surfel, before: f32) -> vec3f {
    return surfel.position + before * surfel.normal;
}

struct Link {
    seen: vec2u,           // the patch, or NO_PATCH, and the reflectance there, which has 15, 15 and 14 bits
    triangle: u32,         // or NONE: the sky, or the back of something
    barycentric: u32,      // of the second and third corner, 16 bits each
}

fn no_link() -> Link {
    return Link(vec2u(NO_PATCH, 0u), NONE, 0u);
}

fn encode_link(patch_index: u32, albedo: vec3f, hit: Hit) -> Link {
    let code = vec3u(round(saturate(albedo) * vec3f(32767.0, 32767.0, 16383.0)));
    let low = code & vec3u(15u);
    let high = code >> vec3u(4u);
    let seen = vec2u(
        (patch_index & NO_PATCH) | (low.x << 20u) | (low.y << 24u) | (low.z << 28u),
        high.x | (high.y << 11u) | (high.z << 22u),
    );
    return Link(seen, hit.triangle, pack2x16unorm(hit.barycentric));
}

fn link_patch(seen: vec2u) -> u32 {
    return seen.x & NO_PATCH;
}

fn link_albedo(seen: vec2u) -> vec3f {
    let low = vec3u(seen.x >> 20u, seen.x >> 24u, seen.x >> 28u) & vec3u(15u);
    let high = vec3u(seen.y & 0x7ffu, (seen.y >> 11u) & 0x7ffu, seen.y >> 22u);
    return vec3f(low | (high << vec3u(4u))) / vec3f(32767.0, 32767.0, 16383.0);
}

// What a link from a point [m] meets, and the unit direction from there.
struct LinkEnd {
    triangle: u32,         // or NONE
    hit: Hit,
    direction: vec3f,
}

fn link_hit(link: Link, position: vec3f) -> LinkEnd {
    if link.triangle == NONE {
        return LinkEnd(NONE, no_hit(0.0), vec3f(0.0));
    }
    let barycentric = unpack2x16unorm(link.barycentric);
    let triangle = load_triangle(link.triangle);
    let w = 1.0 - barycentric.x - barycentric.y;
    let end = w * triangle.corner_a + barycentric.x * triangle.corner_b + barycentric.y * triangle.corner_c;
    let way = end - position;
    let distance = length(way);
    return LinkEnd(link.triangle, hit_of(distance, link.triangle, barycentric), way / max(distance, 1e-30));
}
