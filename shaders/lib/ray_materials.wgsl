#define_import_path lightwell::ray_materials

// Alpha and emission at a point of a triangle.

#ifdef LAYERED
#import lightwell::layers::coat_reflectance
#endif
#import lightwell::mesh::{BLENDED, emission_color}
#import lightwell::ray_scene::materials
#ifdef LAYERED
#import lightwell::ray_textures::clearcoat_texel
#endif
#import lightwell::ray_textures::{Coordinates, base_color_texel, coordinates, emissive_texel}

// Base colour and alpha of a point.
fn base_color_at(material: u32, place: Coordinates) -> vec4f {
    return materials[material].base_color * place.color * base_color_texel(material, place);
}

// Share of the rays that meet a point of a surface: alpha where it is blended.
fn coverage(triangle: u32, material: u32, barycentric: vec2f) -> f32 {
#ifdef OPAQUE
    return 1.0;
#else
    if materials[material].alpha_cutoff < BLENDED {
        return 1.0;
    }
    return saturate(base_color_at(material, coordinates(triangle, barycentric)).a);
#endif
}

#ifdef LAYERED
// What a clear coat leaves of the emission of a point, seen at a cosine.
fn emission_below_coat(triangle: u32, material: u32, barycentric: vec2f, cosine: f32) -> f32 {
    let coat = materials[material].clearcoat.x;
    if coat <= 0.0 {
        return 1.0;
    }
    let at = coordinates(triangle, barycentric);
    let texel = clearcoat_texel(material, at).r;
    return 1.0 - coat_reflectance(coat * texel, cosine);
}
#endif

// Emitted radiance of a point of a triangle [W/(m² sr)].
fn emitted_at(triangle: u32, material: u32, barycentric: vec2f) -> vec3f {
    let at = coordinates(triangle, barycentric);
    let texel = emissive_texel(material, at).rgb;
    return materials[material].emissive * emission_color(materials[material].uv_rows[7], at.color) * texel;
}
