#define_import_path lightwell::ray_surfaces

// What a ray meets: the surface at a hit.

#import lightwell::gbuffer::decode_octahedral
#ifdef LAYERED
#import lightwell::layers::{stretched_alpha, coat_reflectance, film_reflectance, left_by_sheen, reflectance_of_film, albedo_of_sheen, stretch_direction}
#endif
#import lightwell::mesh::{emission_color, normalize_or_zero}
#import lightwell::ray_scene::{DOUBLE_SIDED, NONE, attributes, load_triangle, materials, triangle_texel}
#import lightwell::ray_textures::{Coordinates, coordinates, base_color_texel, metallic_roughness_texel, normal_texel, emissive_texel}
#import lightwell::ray_textures::{specular_texel, specular_color_texel, transmission_texel, clearcoat_texel, clearcoat_roughness_texel}
#import lightwell::ray_textures::{clearcoat_normal_texel, sheen_color_texel, sheen_roughness_texel, anisotropy_texel}
#import lightwell::ray_textures::{iridescence_texel, iridescence_thickness_texel}
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
#ifdef LAYERED
    // What is below a layer has that layer's share taken out already, as the ray sees it.
    coat: f32,             // what the clear coat reflects of what its lobe gathers; 0: there is none
    coat_alpha: f32,
    coat_normal: vec3f,
    sheen: vec3f,
    sheen_roughness: f32,
    sheen_albedo: vec3f,   // share of even light that it reflects
    along: vec3f,          // direction of anisotropy, unit
    alpha_along: f32,      // GGX α along it; 0: as across
    film: f32,             // share of the surface that a film covers
    film_ior: f32,
    film_thickness: f32,   // [nm]
    film_base: vec3f,      // F0 below the film
    film_left: f32,        // what the layers above leave of it
#endif
#ifdef GLASS
    passing: vec3f,        // what of unreflected light passes the surface; 0: it is not of glass
    eta: f32,              // index of refraction on this side over that on the other; 1 for a thin wall
    absorption: vec3f,     // of the body that it bounds [1/m]
    is_solid: bool,        // it bounds a body
    is_inside: bool,       // in which the ray came
    is_crossed: bool,      // the light that counts here is that which passes
#ifdef DISPERSION
    dispersion: f32,       // how much more blue light is refracted than green: a difference of the indices
#endif
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

#ifdef DISPERSION
// Half of the difference of indices between blue and red light, over n − 1 and the material's dispersion: that is 20/V of Abbe's
// number V = (n − 1)/(n_F − n_C) (KHR_materials_dispersion).
const DISPERSION_SCALE: f32 = 0.025;

// The light that is followed: −1 red, 0 green or all, 1 blue.
var<private> followed_color: f32;

// The surface as that light meets it.
fn dispersed(surface: Surface) -> Surface {
    var result = surface;
    if surface.dispersion > 0.0 && followed_color != 0.0 {
        let ior = max(select(1.0 / surface.eta, surface.eta, surface.is_inside) + followed_color * surface.dispersion, 1.0);
        result.eta = select(1.0 / ior, ior, surface.is_inside);
    }
    return result;
}
#endif

fn surface_at(hit: Hit, direction: vec3f) -> Surface {
    let triangle = load_triangle(hit.triangle);
    let w = 1.0 - hit.barycentric.x - hit.barycentric.y;
    var surface: Surface;
    surface.position = w * triangle.corner_a + hit.barycentric.x * triangle.corner_b + hit.barycentric.y * triangle.corner_c;
    let largest = max(abs(triangle.corner_a), max(abs(triangle.corner_b), abs(triangle.corner_c)));
    let outward = normalize_or_zero(cross(triangle.corner_b - triangle.corner_a, triangle.corner_c - triangle.corner_a));
    let back = dot(outward, direction) > 0.0;
    let turn = select(1.0, -1.0, back);
    surface.geometric_normal = turn * outward;
    // What rounding of its corners moves the point off its plane by (Pharr et al. 2023, "Physically Based Rendering", section
    // 6.8), which is nothing on a floor that follows the axes, however large; and that of the point itself.
    let p = abs(surface.position);
    surface.error = max(dot(abs(outward), largest), max(p.x, max(p.y, p.z))) * 0x1p-20f;
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
    let base = materials[material].base_color * place.color * base_color_texel(material, place);
    surface.visible = !back || (triangle.flags & DOUBLE_SIDED) != 0u;
    surface.albedo = base.rgb;
#ifndef DIFFUSE
    let metallic_roughness = metallic_roughness_texel(material, place);
    let metallic = saturate(materials[material].metallic * metallic_roughness.b);
    let specular = materials[material].specular * specular_texel(material, place).a;
    let specular_color = materials[material].specular_color * specular_color_texel(material, place).rgb;
    let dielectric = min(0.04 * specular_color, vec3f(1.0)) * specular;
    surface.albedo = base.rgb * (1.0 - metallic);
    surface.normal_reflectance = mix(dielectric, base.rgb, metallic);
    surface.grazing_reflectance = mix(specular, 1.0, metallic);
    let roughness = saturate(materials[material].roughness * metallic_roughness.g);
    surface.alpha = max(roughness * roughness, 1e-3);
#endif
#ifdef GLASS
    let transmission = materials[material].transmission * transmission_texel(material, place).r;
    surface.passing = surface.albedo * transmission;
    surface.albedo *= 1.0 - transmission;
    surface.is_solid = materials[material].is_solid != 0u;
    let ior = materials[material].ior;
    surface.eta = select(1.0, select(1.0 / ior, ior, back), surface.is_solid);
#ifdef DISPERSION
    surface.dispersion = select(0.0, (ior - 1.0) * DISPERSION_SCALE * materials[material].dispersion, surface.is_solid);
#endif
    surface.absorption = materials[material].absorption;
    surface.is_inside = back && surface.is_solid;
#ifdef DISPERSION
    surface.eta = dispersed(surface).eta;
#endif
    surface.visible = surface.visible || materials[material].transmission > 0.0;
#endif
#ifdef DARK
    surface.emissive = vec3f(0.0);
#else
    surface.emissive = materials[material].emissive * emission_color(materials[material].uv_rows[7], place.color);
#ifdef EMISSIVE_TEXTURES
    if any(surface.emissive > vec3f(0.0)) {
        surface.emissive *= emissive_texel(material, place).rgb;
    }
#endif
#endif

    let interpolated = w * decode_direction(a.x) + hit.barycentric.x * decode_direction(b.x)
        + hit.barycentric.y * decode_direction(c.x);
    var n = turn * normalize_or_zero(interpolated);
    if all(n == vec3f(0.0)) {
        n = surface.geometric_normal;
    }
#ifdef LAYERED
    surface.coat_normal = n;
#endif
#ifdef NORMAL_TEXTURES
    if materials[material].normal_texture.w != 0u && materials[material].normal_scale != 0.0 {
        let tangent = w * decode_direction(a.w & ~1u) + hit.barycentric.x * decode_direction(b.w & ~1u)
            + hit.barycentric.y * decode_direction(c.w & ~1u);
        let handedness = select(1.0, -1.0, (a.w & 1u) != 0u);
        let sampled = normal_texel(material, place).xyz;
        n = bent_normal(n, tangent, handedness, sampled, materials[material].normal_scale);
    }
#endif
    surface.normal = n;
#ifdef LAYERED
    let tangent_here = w * decode_direction(a.w & ~1u) + hit.barycentric.x * decode_direction(b.w & ~1u)
        + hit.barycentric.y * decode_direction(c.w & ~1u);
    add_layers(&surface, material, place, vec4f(tangent_here, select(1.0, -1.0, (a.w & 1u) != 0u)), -normalize(direction));
#endif
    return surface;
}

#ifdef LAYERED
// The layers of a surface whose base is known, seen from a unit direction.
fn add_layers(surface: ptr<function, Surface>, material: u32, place: Coordinates, tangent: vec4f, to_eye: vec3f) {
    let n_dot_v = abs(dot((*surface).normal, to_eye));
#ifdef FILMS
    add_film(surface, material, place, n_dot_v);
#endif
#ifdef ANISOTROPY
    add_stretch(surface, material, place, tangent);
#endif
    var left = 1.0;
#ifdef SHEEN
    let sheen = materials[material].sheen;
    if any(sheen.rgb > vec3f(0.0)) {
        (*surface).sheen = sheen.rgb * sheen_color_texel(material, place).rgb;
        (*surface).sheen_roughness = sheen.a * sheen_roughness_texel(material, place).a;
        let albedo = albedo_of_sheen((*surface).sheen_roughness, n_dot_v);
        (*surface).sheen_albedo = (*surface).sheen * albedo;
        left = left_by_sheen((*surface).sheen, albedo);
    }
#endif
    var above = 1.0;
#ifdef COATS
    above = left_by_coat(surface, material, place, tangent, to_eye);
#endif
    left *= above;
    (*surface).albedo *= left;
    (*surface).normal_reflectance *= left;
    (*surface).grazing_reflectance *= left;
    (*surface).film_left = left;
    (*surface).sheen *= above;
    (*surface).sheen_albedo *= above;
}

fn add_film(surface: ptr<function, Surface>, material: u32, place: Coordinates, n_dot_v: f32) {
    let film = materials[material].iridescence;
    if film.x <= 0.0 {
        return;
    }
    (*surface).film = film.x * iridescence_texel(material, place).r;
    let part = iridescence_thickness_texel(material, place).g;
    (*surface).film_ior = film.y;
    (*surface).film_thickness = mix(film.z, film.w, part);
    (*surface).film_base = (*surface).normal_reflectance;
    let seen = film_reflectance((*surface).film_base, film.y, (*surface).film_thickness, n_dot_v);
    let of_film = reflectance_of_film(seen, (*surface).grazing_reflectance, n_dot_v);
    (*surface).normal_reflectance = mix((*surface).normal_reflectance, of_film, (*surface).film);
}

fn add_stretch(surface: ptr<function, Surface>, material: u32, place: Coordinates, tangent: vec4f) {
    let stretch = materials[material].anisotropy;
    if stretch.x <= 0.0 {
        return;
    }
    let texel = anisotropy_texel(material, place).rgb;
    let d = texel.rg * 2.0 - 1.0;
    let turn = vec2f(d.x * stretch.y - d.y * stretch.z, d.x * stretch.z + d.y * stretch.y);
    (*surface).along = stretch_direction((*surface).normal, tangent.xyz, tangent.w, turn);
    (*surface).alpha_along = stretched_alpha((*surface).alpha, saturate(stretch.x * texel.b));
}

// Adds the clear coat, and tells what it leaves to all below.
fn left_by_coat(surface: ptr<function, Surface>, material: u32, place: Coordinates, tangent: vec4f, to_eye: vec3f) -> f32 {
    let coat = materials[material].clearcoat;
    if coat.x <= 0.0 {
        return 1.0;
    }
    let factor = coat.x * clearcoat_texel(material, place).r;
    let roughness = saturate(coat.y * clearcoat_roughness_texel(material, place).g);
    (*surface).coat_alpha = max(roughness * roughness, 1e-3);
    if coat.z != 0.0 {
        let sampled = clearcoat_normal_texel(material, place).xyz;
        (*surface).coat_normal = bent_normal((*surface).coat_normal, tangent.xyz, tangent.w, sampled, coat.z);
    }
    (*surface).coat = coat_reflectance(factor, abs(dot((*surface).coat_normal, to_eye)));
    // As `emission_below_coat` of lib/ray_materials.wgsl, which knows the triangle alone.
    (*surface).emissive *= 1.0 - coat_reflectance(factor, abs(dot((*surface).geometric_normal, to_eye)));
    return 1.0 - (*surface).coat;
}
#endif

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
