// Mirror reflections: what surfaces too smooth for the gather's filter reflect by their specular lobes, by rays of their own
// for every pixel. What a ray brings: see lib/seen_along.wgsl.
//   RAYS        rays of a pixel of what reflects by its specular lobe alone; of others as much less as they reflect by it
//   MOST_RAYS   the same where hardly any pixel beside sees the same, on what is round: no filter helps there
//   MIRRORS     roughness up to which surfaces mirror [%]
//   ONE_BOUNCE  patches have no light
//   HAZE        media take and scatter light on the way of rays
//   STRETCHED   the surfaces are second lobes, whose reflections are told over their tint
//   UNLIT, DIFFUSE, EVEN_SKY and others: what the scene does not have, see lib/ray_scene.wgsl

#import lightwell::gbuffer::{Surface as Drawn, decode_normal, decode_surface, world_position}
#ifdef STRETCHED
#import lightwell::layers::tint_of_lobe
#endif
#import lightwell::lobe_filter::{Lobe, across_of, offset_in, pixels_in_lobe}
#import lightwell::next_event::specular_share
#import lightwell::sampling::{Sampler, hash_pair}
#import lightwell::seen_along::{Around, FAR, Reflection, around, seen_along}
#import lightwell::view::{View, toward_eye}
#import lightwell::visible_surface::{VisibleSurface, mirror_surface, number_of, ray_from}

struct Mirror {
    view: View,
    sky: vec3f,            // radiance [W/(m² sr)]
    sky_turn: f32,         // of the sky's map [rad]
    root: u32,             // of the hierarchy
    light_count: u32,
    seed: u32,
    first_row: u32,        // of this dispatch [pixels]
    patch_size: f32,       // [m]
}

@group(0) @binding(0) var<uniform> mirror: Mirror;
@group(0) @binding(4) var base_color: texture_2d<u32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var object: texture_2d<u32>;
@group(0) @binding(7) var depth: texture_depth_2d;
// Radiance [W/(m² sr)], and how far off is what the first ray met [m]; 0: the pixel mirrors nothing.
@group(0) @binding(8) var mirrored: texture_storage_2d<rgba32float, write>;

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif
#ifdef MOST_RAYS
const MOST_RAYS: u32 = #{MOST_RAYS}u;
#else
const MOST_RAYS: u32 = RAYS;
#endif

// Pixels that share a lobe from which on RAYS are enough.
const MANY_PIXELS: f32 = 24.0;

fn share_of_lobe(drawn: Drawn, seen: VisibleSurface) -> f32 {
#ifdef STRETCHED
    let tint = tint_of_lobe(drawn.normal_reflectance, drawn.grazing_reflectance, dot(drawn.normal, seen.to_eye));
    return max(tint.r, max(tint.g, tint.b));
#else
    var surface = seen.surface;
    surface.albedo = drawn.albedo;
    return specular_share(surface, seen.to_eye);
#endif
}

// Offset of what a pixel beside sees of things far off [widths of the lobe].
fn offset_beside(lobe: Lobe, pixel: vec2u, id: u32) -> vec2f {
    let at = min(pixel, mirror.view.size - 1u);
    if textureLoad(object, at, 0).x != id {
        return vec2f(0.0);
    }
    let position = world_position(at, mirror.view.size, textureLoad(depth, at, 0), mirror.view.world_from_clip);
    let n = decode_normal(textureLoad(normal, at, 0));
    return offset_in(lobe, position, reflect(-normalize(toward_eye(mirror.view, position)), n));
}

// How many times as many rays a pixel needs as one whose lobe many others share.
fn need_of(pixel: vec2u, seen: VisibleSurface) -> f32 {
    let n = seen.surface.normal;
    let narrowing = clamp(dot(n, seen.to_eye), 0.1, 1.0);
    let mirrored = reflect(-seen.to_eye, n);
    let lobe = Lobe(seen.surface.position, mirrored, across_of(n, seen.to_eye), narrowing, seen.surface.alpha, FAR);
    let id = textureLoad(object, pixel, 0).x;
    let sharing = pixels_in_lobe(offset_beside(lobe, pixel + vec2u(1u, 0u), id), offset_beside(lobe, pixel + vec2u(0u, 1u), id));
    return clamp(MANY_PIXELS / sharing, 1.0, f32(MOST_RAYS) / f32(RAYS));
}

// `share` is that of the specular lobe in what the surface reflects; of a second lobe what it reflects, of all.
fn reflection(pixel: vec2u, seen: VisibleSurface, share: f32) -> Reflection {
    var need = 1.0;
    if MOST_RAYS > RAYS {
        need = need_of(pixel, seen);
    }
    let rays = clamp(u32(round(share * need * f32(RAYS))), 1u, MOST_RAYS);
    var sum = Reflection(vec3f(0.0), 0.0);
    for (var i = 0u; i < rays; i++) {
        var random = Sampler(hash_pair(mirror.seed, 0x68e31da4u), number_of(pixel) * MOST_RAYS + i, 0u);
        let found = seen_along(ray_from(seen, &random), seen.surface.alpha, &random);
        sum.radiance += found.radiance;
        // What is near parts most from what a pixel beside it shows.
        sum.distance += 1.0 / found.distance;
    }
    return Reflection(sum.radiance / f32(rays), f32(rays) / sum.distance);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = vec2u(thread.x, thread.y + mirror.first_row);
    if any(pixel >= mirror.view.size) {
        return;
    }
    around = Around(mirror.sky, mirror.sky_turn, mirror.root, mirror.light_count, mirror.patch_size);
    let z = textureLoad(depth, pixel, 0);
    var found = Reflection(vec3f(0.0), 0.0);
    if z > 0.0 {
        let position = world_position(pixel, mirror.view.size, z, mirror.view.world_from_clip);
        let drawn = decode_surface(
            textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
        );
        let seen = mirror_surface(mirror.view, drawn);
        if seen.is_mirror {
            found = reflection(pixel, seen, share_of_lobe(drawn, seen));
#ifdef STRETCHED
            found.radiance /=
                tint_of_lobe(drawn.normal_reflectance, drawn.grazing_reflectance, dot(drawn.normal, seen.to_eye));
#endif
        }
    }
    textureStore(mirrored, pixel, vec4f(found.radiance, found.distance));
}
