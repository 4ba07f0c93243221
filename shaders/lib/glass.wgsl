#define_import_path lightwell::glass

// Glass: surfaces that light passes (KHR_materials_transmission and KHR_materials_volume).
//
// A thin wall lets light pass straight; where it is rough, the lobe of its reflection is that of its transmission on the other
// side. The surface of a solid body refracts it by Snell's law at microfacets (Walter et al. 2007, "Microfacet models for refraction
// through rough surfaces"), and the body absorbs it (Beer and Lambert). Radiance stands for L/n² (Nicodemus 1963), which
// refraction keeps: what is inside a body is as bright as through air.
//
// Rays that carry light to what is not seen through glass pass it straight: light is not focused, and a shadow of glass is even.
// What it takes on such a way is counted in whole numbers, whose sums are the same in any order.

#import lightwell::brdf::fresnel_schlick
#import lightwell::ray_scene::materials
#import lightwell::ray_textures::{Coordinates, metallic_roughness_texel, specular_texel, specular_color_texel}
#import lightwell::ray_textures::transmission_texel

// A point of glass.
struct Glass {
    color: vec3f,          // what is left of light that is not reflected
    normal_reflectance: vec3f, // F0
    grazing_reflectance: f32,  // F90
    absorption: vec3f,     // of the body [1/m]; 0 for thin walls
}

// What glass takes on the way of a ray.
struct Taken {
    depth: vec3i,          // optical depth, in units of 1/SCALE
    leaving: vec3i,        // absorption of the bodies that the ray leaves, less of those that it enters [1/m / SCALE]
}

const NOTHING_TAKEN = Taken(vec3i(0), vec3i(0));
const SCALE: f32 = 16384.0;
// Most of one surface: sums stay in range.
const MOST: f32 = 3e4;
// Least share that passes: e^−14.
const LEAST: f32 = 1e-6;

// Where its base colour is known.
fn glass_at(material: u32, place: Coordinates, base: vec3f) -> Glass {
    let metallic = saturate(materials[material].metallic * metallic_roughness_texel(material, place).b);
    let specular = materials[material].specular * specular_texel(material, place).a;
    let specular_color = materials[material].specular_color * specular_color_texel(material, place).rgb;
    let transmission = materials[material].transmission * transmission_texel(material, place).r;
    let dielectric = min(0.04 * specular_color, vec3f(1.0)) * specular;
    return Glass(
        base * (transmission * (1.0 - metallic)),
        mix(dielectric, base, metallic),
        mix(specular, 1.0, metallic),
        select(vec3f(0.0), materials[material].absorption, materials[material].is_solid != 0u),
    );
}

// What is left of light that passes straight.
fn straight_transmittance(glass: Glass, cosine: f32) -> vec3f {
    let f = fresnel_schlick(glass.normal_reflectance, glass.grazing_reflectance, cosine);
    return glass.color * (1.0 - max(f.r, max(f.g, f.b)));
}

// Share of the rays that pass, where they pass by chance.
fn pass_share(glass: Glass, cosine: f32) -> f32 {
    let left = straight_transmittance(glass, cosine);
    return max(left.r, max(left.g, left.b));
}

fn whole(value: vec3f) -> vec3i {
    return vec3i(round(clamp(value, vec3f(-MOST), vec3f(MOST)) * SCALE));
}

// The same after one surface more, so many metres from the ray's start. Bodies need not be gone through in order: of each the
// way to its end counts, less that to its beginning.
fn taken_at(before: Taken, glass: Glass, cosine: f32, distance: f32, enters: bool, by_chance: bool) -> Taken {
    var left = straight_transmittance(glass, cosine);
#ifdef GLASS_REFLECTS
    // The chance to pass has taken its share already.
    left /= select(1.0, max(max(left.r, max(left.g, left.b)), LEAST), by_chance);
#endif
    let side = select(1.0, -1.0, enters);
    let depth = before.depth + whole(-log(max(left, vec3f(LEAST)))) + whole(side * glass.absorption * min(distance, 1e9));
    return Taken(depth, before.leaving + whole(side * glass.absorption));
}

// What is left at the end of a ray, so many metres from its start; it may lie in a body.
fn left_of(taken: Taken, distance: f32) -> vec3f {
    let in_bodies = vec3f(max(-taken.leaving, vec3i(0))) * distance;
    return exp(-max((vec3f(taken.depth) + in_bodies) / SCALE, vec3f(0.0)));
}
