#define_import_path lightwell::ray_textures

// The textures of a material at a point, as rays see it: of each use its texel, or what changes nothing where the material has
// no texture. A use that no material of the scene has is left out: drivers inline `sample_texture` at each place where it
// is called, and that made half of what they compiled.
//   BASE_COLOR_TEXTURES and so on   a material has a texture of that use

#import lightwell::ray_scene::{atlas, attributes, materials, triangle_texel}
#ifndef PLAIN
#import lightwell::ray_scene::extras
#endif

fn srgb_decode(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

// `t` modulo `n`, never negative. Processors have no vector instruction that divides integers: of a rounded quotient the
// remainder is off by one `n` at most.
fn remainder(t: i32, n: i32) -> i32 {
    let r = t - i32(floor(f32(t) / f32(n))) * n;
    return r + select(0, n, r < 0) - select(0, n, r >= n);
}

// Texels that lie beside each other along an axis, wrapped into the texture.
fn wrapped(texels: vec2i, size: i32, wrap: u32) -> vec2i {
    let is_mirrored = wrap == 1u;
    let period = select(size, 2 * size, is_mirrored);
    let first = remainder(texels.x, period);
    let second = select(0, first + 1, first + 1 < period);
    let repeated = vec2i(first, select(first, second, texels.y != texels.x));
    let mirrored = select(repeated, period - 1 - repeated, repeated >= vec2i(size));
    return select(mirrored, clamp(texels, vec2i(0), vec2i(size - 1)), vec2<bool>(wrap > 1u));
}

fn texel_at(slot: vec4u, at: vec2i) -> vec4f {
    let texel = textureLoad(atlas, at, i32(slot.z & 0xffffu), 0);
    return select(texel, vec4f(srgb_decode(texel.rgb), texel.a), ((slot.z >> 16u) & 1u) != 0u);
}

// The texture at full resolution, with its own filter and wrapping.
fn sample_texture(slot: vec4u, uv: vec2f, neutral: vec4f) -> vec4f {
#ifdef UNTEXTURED
    return neutral;
#else
    if slot.w == 0u {
        return neutral;
    }
    // Beyond 10⁴ repeats a float cannot tell the texels apart.
    let bounded = select(vec2f(0.0), clamp(uv, vec2f(-1e4), vec2f(1e4)), abs(uv) < vec2f(1e30));
    let at = bounded * vec2f(vec2u(slot.y & 0xffffu, slot.y >> 16u));
    let is_nearest = ((slot.z >> 17u) & 1u) != 0u;
    let corner = select(floor(at - 0.5), floor(at), is_nearest);
    let f = select(at - 0.5 - corner, vec2f(0.0), is_nearest);
    // The nearest texel alone is four times the same.
    let low = vec2i(corner);
    let high = select(low + 1, low, is_nearest);
    let size = vec2i(vec2u(slot.y & 0xffffu, slot.y >> 16u));
    let x = wrapped(vec2i(low.x, high.x), size.x, (slot.z >> 18u) & 3u) + i32(slot.x & 0xffffu);
    let y = wrapped(vec2i(low.y, high.y), size.y, (slot.z >> 20u) & 3u) + i32(slot.x >> 16u);
    let top = mix(texel_at(slot, vec2i(x.x, y.x)), texel_at(slot, vec2i(x.y, y.x)), f.x);
    let bottom = mix(texel_at(slot, vec2i(x.x, y.y)), texel_at(slot, vec2i(x.y, y.y)), f.x);
    return mix(top, bottom, f.y);
#endif
}

fn interpolated_uv(triangle: u32, barycentric: vec2f) -> vec2f {
    let at = triangle_texel(triangle);
    let a = bitcast<vec2f>(textureLoad(attributes, at).yz);
    let b = bitcast<vec2f>(textureLoad(attributes, at + vec2u(0u, 1u)).yz);
    let c = bitcast<vec2f>(textureLoad(attributes, at + vec2u(0u, 2u)).yz);
    return (1.0 - barycentric.x - barycentric.y) * a + barycentric.x * b + barycentric.y * c;
}

// Both sets of texture coordinates, and the vertex colour.
struct Coordinates {
    uv: vec2f,
    second_uv: vec2f,
    color: vec4f,
}

fn coordinates(triangle: u32, barycentric: vec2f) -> Coordinates {
    let uv = interpolated_uv(triangle, barycentric);
#ifdef PLAIN
    return Coordinates(uv, uv, vec4f(1.0));
#else
    let at = triangle_texel(triangle);
    let a = textureLoad(extras, at, 0);
    let b = textureLoad(extras, at + vec2u(0u, 1u), 0);
    let c = textureLoad(extras, at + vec2u(0u, 2u), 0);
    let w = 1.0 - barycentric.x - barycentric.y;
    return Coordinates(
        uv,
        w * bitcast<vec2f>(a.xy) + barycentric.x * bitcast<vec2f>(b.xy) + barycentric.y * bitcast<vec2f>(c.xy),
        w * vertex_color(a.zw) + barycentric.x * vertex_color(b.zw) + barycentric.y * vertex_color(c.zw),
    );
#endif
}

fn vertex_color(words: vec2u) -> vec4f {
    return vec4f(unpack2x16unorm(words.x), unpack2x16unorm(words.y));
}

// Where the texture of a use (0: base colour, 1: metallic-roughness, …) is sampled.
fn uv_of_use(material: u32, index: u32, at: Coordinates) -> vec2f {
#ifdef PLAIN
    return at.uv;
#else
    let row_u = materials[material].uv_rows[2u * index];
    let row_v = materials[material].uv_rows[2u * index + 1u];
    let uv = select(at.uv, at.second_uv, row_u.w != 0.0);
    return vec2f(dot(row_u.xy, uv) + row_u.z, dot(row_v.xy, uv) + row_v.z);
#endif
}

// A normal map without slopes.
const FLAT = vec4f(0.5, 0.5, 1.0, 1.0);
// Anisotropy along the tangent, in full.
const UNTURNED = vec4f(1.0, 0.5, 1.0, 1.0);

fn base_color_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef BASE_COLOR_TEXTURES
    return sample_texture(materials[material].base_color_texture, uv_of_use(material, 0u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn metallic_roughness_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef METALLIC_ROUGHNESS_TEXTURES
    return sample_texture(materials[material].metallic_roughness_texture, uv_of_use(material, 1u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn normal_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef NORMAL_TEXTURES
    return sample_texture(materials[material].normal_texture, uv_of_use(material, 2u, place), FLAT);
#else
    return FLAT;
#endif
}

fn emissive_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef EMISSIVE_TEXTURES
    return sample_texture(materials[material].emissive_texture, uv_of_use(material, 3u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn specular_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef SPECULAR_TEXTURES
    return sample_texture(materials[material].specular_texture, uv_of_use(material, 4u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn specular_color_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef SPECULAR_COLOR_TEXTURES
    return sample_texture(materials[material].specular_color_texture, uv_of_use(material, 5u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn transmission_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef TRANSMISSION_TEXTURES
    return sample_texture(materials[material].transmission_texture, uv_of_use(material, 6u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn clearcoat_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef CLEARCOAT_TEXTURES
    return sample_texture(materials[material].clearcoat_texture, uv_of_use(material, 7u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn clearcoat_roughness_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef CLEARCOAT_ROUGHNESS_TEXTURES
    return sample_texture(materials[material].clearcoat_roughness_texture, uv_of_use(material, 8u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn clearcoat_normal_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef CLEARCOAT_NORMAL_TEXTURES
    return sample_texture(materials[material].clearcoat_normal_texture, uv_of_use(material, 9u, place), FLAT);
#else
    return FLAT;
#endif
}

fn sheen_color_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef SHEEN_COLOR_TEXTURES
    return sample_texture(materials[material].sheen_color_texture, uv_of_use(material, 10u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn sheen_roughness_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef SHEEN_ROUGHNESS_TEXTURES
    return sample_texture(materials[material].sheen_roughness_texture, uv_of_use(material, 11u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn anisotropy_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef ANISOTROPY_TEXTURES
    return sample_texture(materials[material].anisotropy_texture, uv_of_use(material, 12u, place), UNTURNED);
#else
    return UNTURNED;
#endif
}

fn iridescence_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef IRIDESCENCE_TEXTURES
    return sample_texture(materials[material].iridescence_texture, uv_of_use(material, 13u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}

fn iridescence_thickness_texel(material: u32, place: Coordinates) -> vec4f {
#ifdef IRIDESCENCE_THICKNESS_TEXTURES
    return sample_texture(materials[material].iridescence_thickness_texture, uv_of_use(material, 14u, place), vec4f(1.0));
#else
    return vec4f(1.0);
#endif
}
