#define_import_path lightwell::ray_surfaces

// What a ray meets: the surface at a hit.

#import lightwell::gbuffer::decode_octahedral
#import lightwell::mesh::{emission_color, normalize_or_zero}
#import lightwell::ray_materials::{Coordinates, coordinates, sample_texture, uv_of_use}
#import lightwell::ray_scene::{DOUBLE_SIDED, NONE, attributes, load_triangle, materials, triangle_texel}
#import lightwell::rays::Hit

struct Surface {
    position: vec3f,       // world [m]
    geometric_normal: vec3f, // unit, on the side that the ray came from
    normal: vec3f,         // for shading: interpolated and bent by the normal map, unit
    albedo: vec3f,         // diffuse reflectance
    normal_reflectance: vec3f, // F0
    grazing_reflectance: f32,  // F90
    alpha: f32,            // GGX α = roughness²
    emissive: vec3f,       // radiance towards the ray [W/(m² sr)]
    error: f32,            // how far rounding may have moved the position [m]
    emitter: u32,          // or NONE
    visible: bool,         // false: the back of a single-sided surface
#ifdef GLASS
    passing: vec3f,        // what of unreflected light passes the surface; 0: it is not of glass
    eta: f32,              // index of refraction on this side over that on the other; 1 for a thin wall
    absorption: vec3f,     // of the body that it bounds [1/m]
    is_solid: bool,        // it bounds a body
    is_inside: bool,       // in which the ray came
    is_crossed: bool,      // the light that counts here is that which passes
#endif
#ifdef MEDIA
    is_medium: bool,       // it is a point of a medium, whose albedo this one's is
    anisotropy: f32,       // of that medium
#endif
}

// As `encode_direction` of rays/geometry.rs; zero for no direction.
fn decode_direction(code: u32) -> vec3f {
    if code == 0u {
        return vec3f(0.0);
    }
    return decode_octahedral((vec2f(vec2u(code & 0xffffu, code >> 16u)) - 32768.0) / 32767.0);
}

fn surface_at(hit: Hit, direction: vec3f) -> Surface {
    let triangle = load_triangle(hit.triangle);
    let w = 1.0 - hit.barycentric.x - hit.barycentric.y;
    var surface: Surface;
    surface.position = w * triangle.corner_a + hit.barycentric.x * triangle.corner_b + hit.barycentric.y * triangle.corner_c;
    let largest = max(abs(triangle.corner_a), max(abs(triangle.corner_b), abs(triangle.corner_c)));
    surface.error = max(largest.x, max(largest.y, largest.z)) * 0x1p-20f;
    let outward = normalize_or_zero(cross(triangle.corner_b - triangle.corner_a, triangle.corner_c - triangle.corner_a));
    let back = dot(outward, direction) > 0.0;
    let turn = select(1.0, -1.0, back);
    surface.geometric_normal = turn * outward;
    surface.emitter = triangle.emitter;

    let at = triangle_texel(hit.triangle);
    let a = textureLoad(attributes, at);
    let b = textureLoad(attributes, at + vec2u(0u, 1u));
    let c = textureLoad(attributes, at + vec2u(0u, 2u));
    let material = triangle.material;
#ifdef PLAIN
#ifndef UNTEXTURED
    let uv = w * bitcast<vec2f>(a.yz) + hit.barycentric.x * bitcast<vec2f>(b.yz) + hit.barycentric.y * bitcast<vec2f>(c.yz);
#else
    let uv = vec2f(0.0);
#endif
    let place = Coordinates(uv, uv, vec4f(1.0));
#else
    let place = coordinates(hit.triangle, hit.barycentric);
#endif
    let base = materials[material].base_color * place.color
        * sample_texture(materials[material].base_color_texture, uv_of_use(material, 0u, place), vec4f(1.0));
    surface.visible = !back || (triangle.flags & DOUBLE_SIDED) != 0u;
    surface.albedo = base.rgb;
#ifndef DIFFUSE
    let metallic_roughness =
        sample_texture(materials[material].metallic_roughness_texture, uv_of_use(material, 1u, place), vec4f(1.0));
    let metallic = saturate(materials[material].metallic * metallic_roughness.b);
    var specular = materials[material].specular;
    var specular_color = materials[material].specular_color;
#ifndef PLAIN
    specular *= sample_texture(materials[material].specular_texture, uv_of_use(material, 4u, place), vec4f(1.0)).a;
    specular_color *=
        sample_texture(materials[material].specular_color_texture, uv_of_use(material, 5u, place), vec4f(1.0)).rgb;
#endif
    let dielectric = min(0.04 * specular_color, vec3f(1.0)) * specular;
    surface.albedo = base.rgb * (1.0 - metallic);
    surface.normal_reflectance = mix(dielectric, base.rgb, metallic);
    surface.grazing_reflectance = mix(specular, 1.0, metallic);
    let roughness = saturate(materials[material].roughness * metallic_roughness.g);
    surface.alpha = max(roughness * roughness, 1e-3);
#endif
#ifdef GLASS
    var transmission = materials[material].transmission;
#ifndef PLAIN
    transmission *= sample_texture(materials[material].transmission_texture, uv_of_use(material, 6u, place), vec4f(1.0)).r;
#endif
    surface.passing = surface.albedo * transmission;
    surface.albedo *= 1.0 - transmission;
    surface.is_solid = materials[material].is_solid != 0u;
    surface.eta = select(1.0, select(1.0 / materials[material].ior, materials[material].ior, back), surface.is_solid);
    surface.absorption = materials[material].absorption;
    surface.is_inside = back && surface.is_solid;
    surface.visible = surface.visible || materials[material].transmission > 0.0;
#endif
#ifdef DARK
    surface.emissive = vec3f(0.0);
#else
    surface.emissive = materials[material].emissive * emission_color(materials[material].uv_rows[7], place.color);
#ifndef UNTEXTURED
    if any(surface.emissive > vec3f(0.0)) {
        surface.emissive *= sample_texture(materials[material].emissive_texture, uv_of_use(material, 3u, place), vec4f(1.0)).rgb;
    }
#endif
#endif

    let interpolated = w * decode_direction(a.x) + hit.barycentric.x * decode_direction(b.x)
        + hit.barycentric.y * decode_direction(c.x);
    var n = turn * normalize_or_zero(interpolated);
    if all(n == vec3f(0.0)) {
        n = surface.geometric_normal;
    }
#ifndef UNTEXTURED
    if materials[material].normal_texture.w != 0u && materials[material].normal_scale != 0.0 {
        let tangent = w * decode_direction(a.w & ~1u) + hit.barycentric.x * decode_direction(b.w & ~1u)
            + hit.barycentric.y * decode_direction(c.w & ~1u);
        let handedness = select(1.0, -1.0, (a.w & 1u) != 0u);
        let at_normal = uv_of_use(material, 2u, place);
        let sampled = sample_texture(materials[material].normal_texture, at_normal, vec4f(0.5, 0.5, 1.0, 1.0)).xyz;
        n = bent_normal(n, tangent, handedness, sampled, materials[material].normal_scale);
    }
#endif
    surface.normal = n;
    return surface;
}

#ifdef MEDIA
// A point of a medium, where light is scattered: no surface, but a vertex of a path like one.
fn point_of_medium(position: vec3f, albedo: vec3f, anisotropy: f32) -> Surface {
    var point: Surface;
    point.position = position;
    point.geometric_normal = vec3f(0.0, 1.0, 0.0);
    point.normal = point.geometric_normal;
    point.albedo = albedo;
    point.alpha = 1.0;
    point.emitter = NONE;
    point.visible = true;
    point.is_medium = true;
    point.anisotropy = anisotropy;
    return point;
}
#endif

// As `shading_normal` of lib/mesh.wgsl.
fn bent_normal(n: vec3f, tangent: vec3f, handedness: f32, sampled: vec3f, scale: f32) -> vec3f {
    let t = normalize_or_zero(tangent - n * dot(n, tangent));
    if all(t == vec3f(0.0)) {
        return n;
    }
    let bend = vec3f((sampled.xy * 2.0 - 1.0) * scale, sampled.z * 2.0 - 1.0);
    let bent = normalize_or_zero(t * bend.x + cross(n, t) * (handedness * bend.y) + n * bend.z);
    return select(bent, n, all(bent == vec3f(0.0)));
}

// Where a ray starts that leaves the surface: off it by more than what rounding may have moved the point.
fn leave_surface(surface: Surface, direction: vec3f) -> vec3f {
    let side = select(-1.0, 1.0, dot(direction, surface.geometric_normal) >= 0.0);
    return surface.position + surface.geometric_normal * (side * 4.0 * surface.error);
}
