#define_import_path lightwell::seen_along

// What is seen along a ray, in a mirror or through glass: what the surface that it meets emits and reflects, light straight from
// the lights, by a shadow ray, and the light of its patch. Where a surface reflects more by its specular lobe than diffusely, as
// metals do, a ray along that lobe goes on (Whitted 1980), up to MOST_MIRRORS times. Other lobes reflect as if light were even
// around them. Where a ray meets glass, both what passes and what is reflected are followed, as far as there is room.
//
// Patches are steps of light, which a mirror would show. Each look-up is therefore moved by up to half a patch, at random:
// the mean over look-ups is the light interpolated between patches.
//   ONE_BOUNCE  patches have no light
//   HAZE        media take and scatter light on the way of rays
//   ON_SCREEN   what the camera sees too is taken from there; rays are those through glass
//   LAYER       of such rays: the light that is asked for
//   UNLIT, DIFFUSE, EVEN_SKY, GLASS and others: what the scene does (not) have, see lib/ray_scene.wgsl

#ifdef HAZE
#import lightwell::haze_along::haze_along
#endif
#import lightwell::next_event::{LightRange, NO_RAY, blurred, bounded, diffuse_reflectance, even_reflectance, sample_light, specular_of, specular_share}
#ifndef EVEN_SKY
#import lightwell::sky::sky_radiance
#endif
#ifndef ONE_BOUNCE
#import lightwell::patches::{NO_PATCH, patch_at}
#import lightwell::ray_scene::primitive_of
#endif
#import lightwell::ray_scene::NONE
#import lightwell::ray_surfaces::{Surface, surface_at}
#ifdef GLASS
#import lightwell::ray_surfaces::leave_surface
#import lightwell::rays::{Ray, SEEN}
#import lightwell::refraction::{CLEAR, cross_surface, crossing_share, mirror_at_surface, reflecting}
#endif
#import lightwell::rays::{Hit, LIGHT, SHADOW}
#ifdef GLASS
#import lightwell::rays::no_hit
#endif
#import lightwell::walk::{passed, trace}
#import lightwell::sampling::{INVERSE_PI, Sampler, basis, next_pair}
#import lightwell::visible_surface::{SeenRay, VisibleSurface, ray_from}
#ifdef ON_SCREEN
#import lightwell::gbuffer::world_position
#import lightwell::view::{View, eye_distance}
#endif

// What rays are cast in.
struct Around {
    sky: vec3f,            // radiance [W/(m² sr)]
    sky_turn: f32,         // of the sky's map [rad]
    root: u32,             // of the hierarchy
    light_count: u32,
    patch_size: f32,       // [m]
}

var<private> around: Around;
#ifdef GLASS
// What lights make of the glass at which a way begins [W/(m² sr)]: apart, since it has no noise of where the way goes on.
var<private> light_at_glass: vec3f;
// Surfaces that the last way has met, with all that part from it.
var<private> surfaces_met: u32;
#endif

@group(0) @binding(10) var sky: texture_2d<f32>;
#ifndef ONE_BOUNCE
// Irradiance of patches [W/m²].
@group(0) @binding(11) var<storage, read> patch_light: array<vec4f>;
#endif
#ifdef ON_SCREEN
@group(0) @binding(12) var opaque_radiance: texture_2d<f32>;
@group(0) @binding(13) var opaque_depth: texture_depth_2d;

var<private> screen: View;
#endif

// Mirrors that a ray meets one after the other.
const MOST_MIRRORS: u32 = 4u;
// Share of the specular lobe in what a surface reflects from which on light in other directions than its own says little.
const GLOSSY: f32 = 0.5;
// Lights of which none is left out.
const FEW_LIGHTS: u32 = 4u;
// Look-ups of patches around what a ray has met.
const LOOKUPS: u32 = 2u;
// How many times as wide as the lobe of a mirror, in α, highlights of what it shows are at least. One that another surface
// shows in a rough mirror is blurred twice, and is else found by chance alone; in a smooth mirror it stays as it is.
const WIDER: f32 = 4.0;
// How far off the sky is [m].
const FAR: f32 = 1e6;

struct Reflection {
    radiance: vec3f,       // [W/(m² sr)]
    distance: f32,         // to what the first ray met [m]
}

fn sky_along(direction: vec3f) -> vec3f {
#ifdef EVEN_SKY
    return around.sky;
#else
    return sky_radiance(sky, direction, around.sky_turn);
#endif
}

#ifndef ONE_BOUNCE
// Irradiance of the patches around what was met [W/m²].
fn patch_irradiance(surface: Surface, hit: Hit, random: ptr<function, Sampler>) -> vec3f {
    let primitive = primitive_of(hit.triangle);
    let across = basis(surface.geometric_normal);
    let first = next_pair(random);
    var sum = vec3f(0.0);
    var count = 0.0;
    for (var i = 0u; i < LOOKUPS; i++) {
        // The two lie opposite to each other: light that changes evenly has no noise.
        let offset = select(first - 0.5, 0.5 - first, i == 1u) * around.patch_size;
        let near = surface.position + across[0] * offset.x + across[1] * offset.y;
        let found = patch_at(primitive, near, surface.geometric_normal);
        if found != NO_PATCH {
            sum += patch_light[found].rgb;
            count += 1.0;
        }
    }
    let own = patch_at(primitive, surface.position, surface.geometric_normal);
    if count == 0.0 && own != NO_PATCH {
        return patch_light[own].rgb;
    }
    return sum / max(count, 1.0);
}
#endif

// What a white surface reflects of the light of its patches.
fn patch_radiance(surface: Surface, hit: Hit, random: ptr<function, Sampler>) -> vec3f {
#ifdef ONE_BOUNCE
    return vec3f(0.0);
#else
    return patch_irradiance(surface, hit, random) * INVERSE_PI;
#endif
}

// What a surface reflects of the lights, straight from there: of all if they are few, since the choice of one would be noise,
// or else of one.
fn lit_radiance(surface: Surface, direction: vec3f, random: ptr<function, Sampler>) -> vec3f {
    let are_few = around.light_count <= FEW_LIGHTS;
    var pick = 0.0;
    if !are_few {
        pick = next_pair(random).x;
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < select(1u, around.light_count, are_few); i++) {
        var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
        on_light = next_pair(random);
#endif
        var range = LightRange(0u, around.light_count);
        if are_few {
            range = LightRange(i, i + 1u);
        }
        let sample = sample_light(surface, -direction, NO_RAY, range, false, pick, on_light);
        let hit = trace(around.root, sample.ray, sample.reach, SHADOW);
        if hit.triangle == NONE {
            sum += bounded(sample.light * passed(sample.ray, hit));
        }
    }
    return sum;
}

#ifdef GLASS
// A way that is followed.
struct Branch {
    ray: SeenRay,
    absorption: vec3f,     // of the body in which it is [1/m]
    blur: f32,             // GGX α of what it came from
    is_straight: bool,     // it has met nothing but glass, which it has crossed
}

// Ways that may wait: what passes and what is reflected, twice one after the other.
const ROOM: u32 = 3u;
// Surfaces that all of them together meet at most.
const MOST_SURFACES: u32 = 12u;
// Least share of a way that waits: less is left out.
const WORTHWHILE: f32 = 0.01;

fn strength(way: Branch) -> f32 {
    let t = way.ray.throughput;
    return max(t.r, max(t.g, t.b));
}

// Of several rays from rough glass each goes one way, by chance.
fn one_of(ways: Ways, random: ptr<function, Sampler>) -> Branch {
    let smaller = strength(ways.smaller);
    let share = smaller / max(smaller + strength(ways.larger), 1e-30);
    let takes_smaller = next_pair(random).x < share;
    var chosen = ways.larger;
    if takes_smaller {
        chosen = ways.smaller;
    }
    chosen.ray.throughput /= max(select(1.0 - share, share, takes_smaller), 1e-6);
    return chosen;
}

// The ways on from a surface of glass: that on which more goes on, and the other.
struct Ways {
    larger: Branch,
    smaller: Branch,
}

fn ways_from(surface: Surface, branch: Branch, random: ptr<function, Sampler>) -> Ways {
    let to_eye = -branch.ray.ray.direction;
    let share = crossing_share(surface, to_eye);
    let normal = next_pair(random);
    let crossing = cross_surface(surface, to_eye, normal);
    var passing = branch;
    let origin = leave_surface(surface, crossing.direction);
    passing.ray = SeenRay(Ray(origin, crossing.direction), 0.0, branch.ray.throughput * crossing.weight);
    if surface.is_solid {
        passing.absorption = select(surface.absorption, vec3f(0.0), surface.is_inside);
    }
    passing.blur = max(branch.blur, surface.alpha);
    var mirroring = branch;
    let mirror = mirror_at_surface(surface, to_eye, normal);
    let mirror_ray = Ray(leave_surface(surface, mirror.direction), mirror.direction);
    mirroring.ray = SeenRay(mirror_ray, 0.0, branch.ray.throughput * mirror.weight);
    mirroring.blur = max(branch.blur, surface.alpha);
    mirroring.is_straight = false;
    if share >= 0.5 {
        return Ways(passing, mirroring);
    }
    return Ways(mirroring, passing);
}

// What lights make of a surface: seen from the front; of glass, what it reflects of them and their glow through it. In clear glass
// neither is more than a point.
const FRONT: u32 = 0u;
const REFLECTING: u32 = 1u;
const CROSSED: u32 = 2u;

fn lit_sides(surface: Surface, first: u32, last: u32, direction: vec3f, random: ptr<function, Sampler>) -> vec3f {
    var sum = vec3f(0.0);
    for (var side = first; side <= last; side++) {
        var lit = surface;
        if side == REFLECTING {
            lit = reflecting(surface, -direction);
        }
        lit.is_crossed = side == CROSSED;
        sum += lit_radiance(lit, direction, random);
    }
    return sum;
}
#endif

#ifdef ON_SCREEN
const TOTAL: u32 = 0u;
const DIRECT: u32 = 1u;
const INDIRECT: u32 = 2u;
#ifdef LAYER
const LAYER: u32 = #{LAYER}u;
#else
const LAYER: u32 = TOTAL;
#endif
// How far from where the camera sees a surface, as a part of its distance, it still is the same one.
const SAME_PLACE: f32 = 0.01;

// Light straight from lights and emission, and all else, as far as they are asked for. Seen by a reflection all of it is indirect.
fn of_layer(straight: vec3f, indirect: vec3f, is_straight: bool) -> vec3f {
    switch LAYER {
        case DIRECT: { return select(vec3f(0.0), straight, is_straight); }
        case INDIRECT: { return select(straight + indirect, indirect, is_straight); }
        default: { return straight + indirect; }
    }
}

// What the camera sees at a place, and in alpha whether it sees it.
fn on_screen(position: vec3f) -> vec4f {
    let clip = screen.clip_from_world * vec4f(position, 1.0);
    let at = vec2f(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w) * vec2f(screen.size) - 0.5;
    if clip.w <= 0.0 || !all(at >= vec2f(-0.5)) || !all(at <= vec2f(screen.size) - 0.5) {
        return vec4f(0.0);
    }
    let low = floor(at);
    let part = at - low;
    let reach = SAME_PLACE * eye_distance(screen, position);
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let pixel = vec2u(clamp(vec2i(low) + corner, vec2i(0), vec2i(screen.size) - 1));
        let z = textureLoad(opaque_depth, pixel, 0);
        let share = select(1.0 - part, part, corner == vec2i(1));
        if z > 0.0 && distance(world_position(pixel, screen.size, z, screen.world_from_clip), position) < reach {
            sum += share.x * share.y * vec4f(textureLoad(opaque_radiance, pixel, 0).rgb, 1.0);
        }
    }
    return select(vec4f(0.0), vec4f(sum.rgb / sum.a, 1.0), sum.a > 0.25);
}
#else
fn of_layer(straight: vec3f, indirect: vec3f, is_straight: bool) -> vec3f {
    return straight + indirect;
}
#endif

#ifndef GLASS
fn seen_along(first: SeenRay, alpha: f32, random: ptr<function, Sampler>) -> Reflection {
    var found = Reflection(vec3f(0.0), FAR);
    var ray = first;
    var blur = alpha;
    for (var depth = 0u; depth <= MOST_MIRRORS; depth++) {
        if !any(ray.throughput > vec3f(0.0)) {
            break;
        }
        let direction = ray.ray.direction;
        let hit = trace(around.root, ray.ray, 3e38, LIGHT);
#ifdef HAZE
        let between = haze_along(ray.ray.origin, direction, hit.t, next_pair(random).x);
        found.radiance += bounded(ray.throughput * between.added);
        ray.throughput *= between.passing;
#endif
        if hit.triangle == NONE {
            found.radiance += bounded(ray.throughput * sky_along(direction));
            break;
        }
        found.distance = select(found.distance, clamp(hit.t, 1e-6, FAR), depth == 0u);
        var surface = blurred(surface_at(hit, direction), blur);
        if !surface.visible {
            break;
        }
        var light = bounded(surface.emissive) + lit_radiance(blurred(surface, WIDER * blur), direction, random);
        blur = surface.alpha;
        var next = SeenRay(ray.ray, 0.0, vec3f(0.0));
        if specular_share(surface, -direction) > GLOSSY && depth < MOST_MIRRORS {
            light += diffuse_reflectance(surface) * patch_radiance(surface, hit, random);
            surface = specular_of(surface);
            next = ray_from(VisibleSurface(surface, -direction, 1.0, false), random);
        } else {
            light += even_reflectance(surface, -direction) * patch_radiance(surface, hit, random);
        }
        found.radiance += bounded(ray.throughput * light);
        ray = SeenRay(next.ray, next.density, ray.throughput * next.throughput);
    }
    return found;
}
#else
// Which lights count for a surface that a branch has met: as `lit_sides` takes them, none if the last comes before the first.
fn sides_of(surface: Surface, is_glass: bool, is_first: bool) -> vec2u {
    if !is_glass {
        return select(vec2u(1u, 0u), vec2u(FRONT), surface.visible);
    }
    // What the first surface reflects of lights is drawn with it.
    return select(vec2u(select(REFLECTING, CROSSED, is_first), CROSSED), vec2u(1u, 0u), surface.alpha <= CLEAR);
}

// What a surface that is not of glass shows along a branch, beside the light that comes straight from lights. The branch goes on
// where it mirrors, or ends.
fn shown(surface: Surface, hit: Hit, of_lights: vec3f, branch: ptr<function, Branch>, random: ptr<function, Sampler>) -> vec3f {
    let direction = (*branch).ray.ray.direction;
    var light = vec3f(0.0);
    var next = SeenRay((*branch).ray.ray, 0.0, vec3f(0.0));
    if surface.visible {
        (*branch).blur = surface.alpha;
        let is_glossy = specular_share(surface, -direction) > GLOSSY;
        var reflectance = even_reflectance(surface, -direction);
        if is_glossy {
            reflectance = diffuse_reflectance(surface);
        }
        let indirect = reflectance * patch_radiance(surface, hit, random);
        if is_glossy {
            next = ray_from(VisibleSurface(specular_of(surface), -direction, 1.0, false), random);
        }
        light = of_layer(bounded(surface.emissive) + of_lights, indirect, (*branch).is_straight);
    }
    (*branch).ray = SeenRay(next.ray, next.density, (*branch).ray.throughput * next.throughput);
    (*branch).absorption = vec3f(0.0);
    (*branch).is_straight = false;
    return light;
}

fn seen_along(first: SeenRay, alpha: f32, random: ptr<function, Sampler>) -> Reflection {
    return follow(Branch(first, vec3f(0.0), alpha, false), no_hit(0.0), random);
}

// What is seen along a way and all that part from it. Where it begins at glass that the camera sees, what the way met there is
// given. What is reflected or passes where there is no room for it to wait is lost.
fn follow(start: Branch, glass_hit: Hit, random: ptr<function, Sampler>) -> Reflection {
    var waiting: array<Branch, ROOM>;
    var found = Reflection(vec3f(0.0), FAR);
    var left = 0u;
    var branch = start;
    let begins_at_glass = glass_hit.triangle != NONE;
    for (var step = 0u; step < MOST_SURFACES + u32(begins_at_glass); step++) {
        surfaces_met = step + 1u;
        let is_first = begins_at_glass && step == 0u;
        let ray = branch.ray.ray;
        var hit = trace(around.root, ray, select(3e38, 0.0, is_first), SEEN);
        if is_first {
            hit = glass_hit;
        }
        branch.ray.throughput *= exp(-branch.absorption * min(hit.t, 1e9));
#ifdef HAZE
        if !is_first {
            let between = haze_along(ray.origin, ray.direction, hit.t, next_pair(random).x);
            found.radiance += bounded(branch.ray.throughput * of_layer(vec3f(0.0), between.added, branch.is_straight));
            branch.ray.throughput *= between.passing;
        }
#endif
        // Of glass that the camera sees, that of what lies behind.
        found.distance = select(found.distance, clamp(hit.t, 1e-6, FAR), step == u32(begins_at_glass));
        let throughput = branch.ray.throughput;
        var light = vec3f(0.0);
        if hit.triangle == NONE {
            light = of_layer(sky_along(ray.direction), vec3f(0.0), branch.is_straight);
            branch.ray.throughput = vec3f(0.0);
        } else {
            let surface = surface_at(hit, ray.direction);
            let is_glass = any(surface.passing > vec3f(0.0));
#ifdef ON_SCREEN
            let is_glossy = specular_share(blurred(surface, branch.blur), -ray.direction) > GLOSSY;
            let there = on_screen(surface.position);
            let is_on_screen = surface.visible && branch.is_straight && !is_glass && !is_glossy && there.a > 0.0;
#else
            let there = vec4f(0.0);
            let is_on_screen = false;
#endif
            let sides = select(sides_of(surface, is_glass, is_first), vec2u(1u, 0u), is_on_screen);
            let of_lights = lit_sides(blurred(surface, WIDER * branch.blur), sides.x, sides.y, ray.direction, random);
            if is_on_screen {
                light = there.rgb;
                branch.ray.throughput = vec3f(0.0);
            } else if is_glass {
                light = of_layer(of_lights, vec3f(0.0), branch.is_straight);
                let on = ways_from(surface, branch, random);
                branch = on.larger;
                if is_first && surface.alpha > CLEAR {
                    branch = one_of(on, random);
                } else if left < ROOM && (is_first || strength(on.smaller) > WORTHWHILE) {
                    waiting[left] = on.smaller;
                    left += 1u;
                }
            } else {
                light = shown(blurred(surface, branch.blur), hit, of_lights, &branch, random);
            }
        }
        if is_first {
            light_at_glass = bounded(throughput * light);
        } else {
            found.radiance += bounded(throughput * light);
        }
        if !any(branch.ray.throughput > vec3f(0.0)) {
            if left == 0u {
                break;
            }
            left -= 1u;
            branch = waiting[left];
        }
    }
    return found;
}
#endif
