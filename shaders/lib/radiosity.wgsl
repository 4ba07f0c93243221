#define_import_path lightwell::radiosity

// Links of surfels to the patches that they see, and the light of patches.

#import lightwell::patches::NO_PATCH

// A link: the patch, or NO_PATCH, and the diffuse reflectance of what the ray met there, which has 15, 15 and 14 bits.
fn encode_link(patch_index: u32, albedo: vec3f) -> vec2u {
    let code = vec3u(round(saturate(albedo) * vec3f(32767.0, 32767.0, 16383.0)));
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

fn link_albedo(link: vec2u) -> vec3f {
    let low = vec3u(link.x >> 20u, link.x >> 24u, link.x >> 28u) & vec3u(15u);
    let high = vec3u(link.y & 0x7ffu, (link.y >> 11u) & 0x7ffu, link.y >> 22u);
    return vec3f(low | (high << vec3u(4u))) / vec3f(32767.0, 32767.0, 16383.0);
}
