#define_import_path lightwell::visible_surface

// A visible surface that rays start from, and their contributions, apart by what reflects them: diffuse light as if the surface
// were white, so that it can be filtered without its texture, and the light of the specular lobe.
//   MIRRORS   roughness [%] up to which a pass of its own traces the specular lobe, see
//             indirect/light_volumes/sweep/mirror.wgsl; of what reflects by that lobe more than diffusely, up to 45 at least
//             where nothing emits light

#import lightwell::brdf::fresnel_schlick
#import lightwell::gbuffer::{Surface as Drawn}
#import lightwell::next_event::{bounded, direction_density, reflected, sample_direction, specular_share}
#import lightwell::ray_surfaces::{Surface, leave_surface}
#import lightwell::rays::Ray
#import lightwell::sampling::{INVERSE_PI, Sampler, next_pair}
#import lightwell::view::{View, position_error, toward_eye}

#ifdef MIRRORS
#ifdef UNLIT
// `MIRROR_ROUGHNESS` of rays/materials.rs [%].
const GLOSSY_MIRRORS: f32 = 45.0;
#else
// The gather samples what emits light; rays of rough mirrors would meet it by chance alone.
const GLOSSY_MIRRORS: f32 = 0.0;
#endif
// Share of the specular lobe in what a surface reflects above which it is a mirror before all.
const GLOSSY: f32 = 0.5;
#endif

struct VisibleSurface {
    surface: Surface,      // white, as far as it is diffuse
    to_eye: vec3f,
    to_specular: f32,      // chance of a ray to follow the specular lobe
    is_mirror: bool,       // that lobe is traced by a pass of its own; if there is nothing else, the surface is black
}

struct Contribution {
    diffuse: vec3f,
    specular: vec3f,
}

// A ray from the visible surface; without throughput it need not be traced.
struct SeenRay {
    ray: Ray,
    density: f32,          // with which its direction is chosen [1/sr]
    throughput: vec3f,     // reflected light over the light that arrives, over the density
}

fn seen_surface(view: View, drawn: Drawn) -> VisibleSurface {
    var seen: VisibleSurface;
    seen.to_eye = normalize(toward_eye(view, drawn.position));
    seen.surface.position = drawn.position;
    seen.surface.normal = drawn.normal;
    seen.surface.geometric_normal = drawn.normal;
    seen.surface.albedo = drawn.albedo;
    seen.surface.normal_reflectance = drawn.normal_reflectance;
    seen.surface.grazing_reflectance = drawn.grazing_reflectance;
    seen.surface.alpha = max(drawn.roughness * drawn.roughness, 1e-3);
#ifdef STRETCHED
#ifdef LAYERED
    if drawn.alpha_along > 0.0 {
        seen.surface.along = drawn.along;
        seen.surface.alpha_along = drawn.alpha_along;
        seen.surface.alpha = seen.surface.alpha * seen.surface.alpha / drawn.alpha_along;
    }
#endif
#endif
    seen.surface.error = position_error(view, drawn.position);
    seen.to_specular = specular_share(seen.surface, seen.to_eye);
    seen.surface.albedo = vec3f(1.0);
#ifdef MIRRORS
    let percent = max(f32(#{MIRRORS}u), select(0.0, GLOSSY_MIRRORS, seen.to_specular > GLOSSY));
    seen.is_mirror = drawn.roughness <= percent / 100.0 && seen.to_specular > 0.0;
    seen.to_specular = select(seen.to_specular, 0.0, seen.is_mirror);
    seen.surface.albedo = select(vec3f(1.0), vec3f(0.0), seen.is_mirror && all(drawn.albedo <= vec3f(0.0)));
#endif
    return seen;
}

// The specular lobe of a mirror alone.
fn mirror_surface(view: View, drawn: Drawn) -> VisibleSurface {
    var seen = seen_surface(view, drawn);
    seen.surface.albedo = vec3f(0.0);
    seen.to_specular = 1.0;
    return seen;
}

fn ray_from(seen: VisibleSurface, random: ptr<function, Sampler>) -> SeenRay {
    // Without a specular lobe there is no choice, and the first pair gives the direction.
    var choice = 1.0;
    if seen.to_specular > 0.0 {
        choice = next_pair(random).x;
    }
    let direction = sample_direction(seen.surface, seen.to_eye, seen.to_specular, choice, next_pair(random));
    let density = direction_density(seen.surface, seen.to_eye, direction, seen.to_specular);
    var throughput = vec3f(0.0);
    if density > 0.0 {
        throughput = reflected(seen.surface, seen.to_eye, direction) / density;
    }
    return SeenRay(Ray(leave_surface(seen.surface, direction), direction), density, throughput);
}

// Light that the white surface reflects, from a direction, by what reflects it.
fn by_lobe(seen: VisibleSurface, direction: vec3f, light: vec3f) -> Contribution {
    let value = bounded(light);
#ifdef DIFFUSE
    return Contribution(value, vec3f(0.0));
#else
    let h = normalize(direction + seen.to_eye);
    let f = fresnel_schlick(seen.surface.normal_reflectance, seen.surface.grazing_reflectance, dot(seen.to_eye, h));
    let of_diffuse = (1.0 - max(f.r, max(f.g, f.b))) * max(0.0, dot(seen.surface.normal, direction)) * INVERSE_PI;
    let share = saturate(vec3f(of_diffuse) / max(reflected(seen.surface, seen.to_eye, direction), vec3f(1e-20)));
    return Contribution(value * share, select(value * (1.0 - share), vec3f(0.0), seen.is_mirror));
#endif
}

// Number of a pixel along Morton's curve: neighbouring pixels have neighbouring numbers of one sequence, so that any square
// block of 2ⁿ×2ⁿ pixels has a well distributed set of them (Ahmed and Wonka 2020, "Screen-space blue-noise diffusion of
// Monte Carlo sampling error via hierarchical ordering of pixels").
fn number_of(pixel: vec2u) -> u32 {
    return spread(pixel.x) | (spread(pixel.y) << 1u);
}

// Bits of a coordinate, with a zero before each.
fn spread(value: u32) -> u32 {
    var x = value & 0xffffu;
    x = (x | (x << 8u)) & 0x00ff00ffu;
    x = (x | (x << 4u)) & 0x0f0f0f0fu;
    x = (x | (x << 2u)) & 0x33333333u;
    return (x | (x << 1u)) & 0x55555555u;
}
