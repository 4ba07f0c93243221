#define_import_path lightwell::gbuffer

// The G-buffer's encoding: 32 colour bytes a texel, the portable limit. Integer targets, since their precision is
// the same everywhere; base colours of eight bits would be wrong by up to 1 % of the light.
//   base_color  rgba16uint    linear base colour; metallic
//   normal      rgba16uint    octahedral world normal x, y; roughness; F90
//   emissive    rg32uint      emitted radiance, shared exponent
//   object      rg32uint      object id, 0 where there is nothing; √F0, ten bits a channel
//   depth       depth32float  reversed: 1 near, 0 far and where there is nothing
// With STRETCHED it is that of second lobes, whose base colour is what `encode_stretch` makes.

struct Surface {
    position: vec3f,       // world [m]
    normal: vec3f,         // world, unit
    albedo: vec3f,         // diffuse reflectance ρ = base·(1 − metallic)
    normal_reflectance: vec3f, // F0. Names must not end in digits: the composer renames those.
    grazing_reflectance: f32,  // F90
    roughness: f32,        // perceptual; GGX α is its square
    hit: bool,             // false where there is nothing
#ifdef STRETCHED
    along: vec3f,          // direction in which the lobe is stretched, unit
    alpha_along: f32,      // GGX α along it; 0: the lobe is round
#endif
}

fn sign_not_zero(v: vec2f) -> vec2f {
    return select(vec2f(-1.0), vec2f(1.0), v >= vec2f(0.0));
}

// Octahedral map of the unit sphere to [−1, 1]² (Cigolle et al. 2014).
fn encode_octahedral(n: vec3f) -> vec2f {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return select((1.0 - abs(p.yx)) * sign_not_zero(p), p, n.z >= 0.0);
}

fn decode_octahedral(e: vec2f) -> vec3f {
    let z = 1.0 - abs(e.x) - abs(e.y);
    let xy = select((1.0 - abs(e.yx)) * sign_not_zero(e), e, z >= 0.0);
    return normalize(vec3f(xy, z));
}

// 32767 is zero, so that axes are stored exactly.
fn encode_normal(n: vec3f, roughness: f32, f90: f32) -> vec4u {
    let e = round(encode_octahedral(n) * 32767.0) + 32767.0;
    return vec4u(vec2u(e), vec2u(round(saturate(vec2f(roughness, f90)) * 65535.0)));
}

fn decode_normal(texel: vec4u) -> vec3f {
    return decode_octahedral((vec2f(texel.xy) - 32767.0) / 32767.0);
}

// Three 18-bit mantissas and a 10-bit exponent in 64 bits: 4e-6 of the largest channel, at any magnitude.
fn encode_radiance(color: vec3f) -> vec2u {
    let c = clamp(color, vec3f(0.0), vec3f(1e30));
    let largest = max(c.r, max(c.g, c.b));
    if largest < 1e-30 {
        return vec2u(0u);
    }
    let exponent = frexp(largest).exp;
    let m = min(vec3u(round(ldexp(ldexp(c, vec3i(-exponent)), vec3i(18)))), vec3u(0x3ffffu));
    let e = u32(exponent + 512);
    return vec2u(m.r | (m.g << 18u), (m.g >> 14u) | (m.b << 4u) | (e << 22u));
}

fn decode_radiance(texel: vec2u) -> vec3f {
    if texel.x == 0u && texel.y == 0u {
        return vec3f(0.0);
    }
    let m = vec3u(texel.x & 0x3ffffu, (texel.x >> 18u) | ((texel.y & 0xfu) << 14u), (texel.y >> 4u) & 0x3ffffu);
    let exponent = i32(texel.y >> 22u) - 512;
    return ldexp(ldexp(vec3f(m), vec3i(-18)), vec3i(exponent));
}

// World position of a pixel's centre at a stored depth.
fn world_position(pixel: vec2u, size: vec2u, depth: f32, world_from_clip: mat4x4f) -> vec3f {
    let uv = (vec2f(pixel) + 0.5) / vec2f(size);
    let ndc = vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, depth, 1.0);
    let world = world_from_clip * ndc;
    return world.xyz / world.w;
}

fn encode_base_color(color: vec3f, metallic: f32) -> vec4u {
    return vec4u(round(saturate(vec4f(color, metallic)) * 65535.0));
}

fn decode_base_color(texel: vec4u) -> vec3f {
    return vec3f(texel.rgb) / 65535.0;
}

// Diffuse reflectance ρ: metals have none.
fn decode_albedo(texel: vec4u) -> vec3f {
    return decode_base_color(texel) * (f32(65535u - texel.a) / 65535.0);
}

// In place of a base colour: the direction of a stretched lobe, octahedral, and the GGX α along it. Of a metal, which is black as
// far as it is diffuse; α is never 0.
fn encode_stretch(along: vec3f, alpha_along: f32) -> vec4u {
    let e = round(encode_octahedral(along) * 32767.0) + 32767.0;
    return vec4u(vec2u(e), max(u32(round(saturate(alpha_along) * 65535.0)), 1u), 65535u);
}

fn encode_object(id: u32, normal_reflectance: vec3f) -> vec2u {
    let root = vec3u(round(sqrt(saturate(normal_reflectance)) * 1023.0));
    return vec2u(id, root.r | (root.g << 10u) | (root.b << 20u));
}

fn decode_normal_reflectance(object: vec2u) -> vec3f {
    let root = vec3f(vec3u(object.y, object.y >> 10u, object.y >> 20u) & vec3u(1023u)) / 1023.0;
    return root * root;
}

fn decode_surface(base_color: vec4u, normal: vec4u, object: vec2u, depth: f32, position: vec3f) -> Surface {
    var surface: Surface;
    surface.hit = depth > 0.0;
    surface.position = position;
    surface.normal = decode_normal(normal);
    surface.albedo = decode_albedo(base_color);
    surface.normal_reflectance = decode_normal_reflectance(object);
    surface.grazing_reflectance = f32(normal.w) / 65535.0;
    surface.roughness = f32(normal.z) / 65535.0;
#ifdef STRETCHED
    surface.along = decode_octahedral((vec2f(base_color.xy) - 32767.0) / 32767.0);
    surface.alpha_along = f32(base_color.z) / 65535.0;
#endif
    return surface;
}
