// Direct light of a light with a surface, added to the radiance of the pixels that it can reach: what it would bring if nothing
// were in its way, by integrals over its outline (Lambert 1760 for diffuse reflection; Heitz, Dupuy, Hill and Neubelt 2016,
// "Real-time polygonal-light shading with linearly transformed cosines", for specular reflection), times the share that
// arrives. That share is a ratio of samples with and without shadows, filtered (Heitz, Hill and McGuire 2018, "Combining
// analytic direct illumination and stochastic shadows"): where nothing casts a shadow there is no noise.
//   SHADOW_RAYS  the share was found by `direct/area_shadows.wgsl`
//   GLASS        glass colours it
//   SHADOW_MAP   it is that of the light's middle, by its shadow map: the scene is not there for rays
// Without both, all of it arrives.

#import lightwell::area_lights::{Cone, arc_of, cone_of, third_axis}
#import lightwell::bilateral::likeness
#import lightwell::brdf::fresnel_schlick
#import lightwell::direct::through_media
#import lightwell::environment::lobe_reflectance
#import lightwell::gbuffer::{Surface, decode_normal, decode_surface, world_position}
#import lightwell::lights::{Incidence, Light, SUN, SPHERE, DISC, RECTANGLE, TUBE, light_incidence, range_window}
#import lightwell::sampling::{TAU, basis}
#ifdef GLASS
#import lightwell::shadow_rays::left_on_way
#endif
#ifdef SHADOW_RAYS
#import lightwell::shadow_tiles::{DARK, MIXED, kinds_of, tile_of}
#endif
#ifdef SHADOW_MAP
#import lightwell::shadow_lookup::{Shadow, shadow_coordinate, shadow_receiver}
#endif
#import lightwell::view::{View, toward_eye}

struct Area {
    origin: vec2u,         // first pixel
    size: vec2u,           // [pixels]
    radius: u32,           // of the filter [pixels]
    root: u32,             // of the hierarchy for rays
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> area: Area;
@group(0) @binding(3) var base_color: texture_2d<u32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var object: texture_2d<u32>;
@group(0) @binding(6) var depth: texture_depth_2d;
// By `engine/examples/fit_lobes.rs`: for ALPHAS values of log₂ α from −10 to 0, and ANGLES angles to the eye, the matrix
// [a 0 b; 0 1 0; c 0 d] from the lobe to a cosine, as a, b, c/α, d/α.
@group(0) @binding(7) var<storage, read> lobes: array<vec4f>;
@group(0) @binding(8) var radiance: texture_storage_2d_array<r32float, read_write>;
#ifdef SHADOW_RAYS
@group(0) @binding(9) var arrived: texture_2d<f32>;
@group(0) @binding(13) var<storage, read> tiles: array<u32>;
#endif
#ifdef SHADOW_MAP
@group(0) @binding(10) var<uniform> shadow: Shadow;
@group(0) @binding(11) var shadow_map: texture_depth_2d_array;
@group(0) @binding(12) var shadow_sampler: sampler_comparison;
#endif

const PI: f32 = 3.14159265358979;
const MAX_RADIANCE: f32 = 1e30;

// ---- The outline of a light ----

// Corners of a circle's outline, and of each end of a tube.
const ROUND: u32 = 16u;
const END: u32 = 5u;
// Lights count as no smaller than this share of their distance, and are less bright instead: of the outline of a smaller one
// rounding would leave nothing.
const LEAST: f32 = 5e-4;

// The light as it is seen from a point: no smaller than LEAST, and with its radiance.
struct Seen {
    light: Light,
    radiance: vec3f,       // [W/(m² sr)]
    corners: u32,
}

fn seen_from(position: vec3f) -> Seen {
    var seen = Seen(light, vec3f(0.0), ROUND);
    if light.shape == SUN {
        seen.light.size.x = max(light.size.x, LEAST);
        seen.radiance = light.intensity / (PI * seen.light.size.x * seen.light.size.x);
        return seen;
    }
    let distance = length(light.position - position);
    seen.light.size = max(light.size, vec2f(LEAST * distance));
    let size = seen.light.size;
    var profile = PI * size.x * size.x;
    if light.shape == RECTANGLE {
        profile = 4.0 * size.x * size.y;
        seen.corners = 4u;
    }
    if light.shape == TUBE {
        profile = 4.0 * size.x * size.y;
        seen.corners = 2u * END;
    }
    seen.radiance = min(light.intensity * (range_window(light, distance) / max(profile, 1e-37)), vec3f(MAX_RADIANCE));
    return seen;
}

// Whether a point lies where the light shines to.
fn is_before(seen: Seen, position: vec3f) -> bool {
    let is_flat = light.shape == DISC || light.shape == RECTANGLE;
    let offset = position - light.position;
    if is_flat {
        return dot(light.direction, offset) > 0.0;
    }
    if light.shape == SPHERE {
        return dot(offset, offset) > seen.light.size.x * seen.light.size.x;
    }
    return light.shape != TUBE || arc_of(seen.light, position).half_angle > 0.0;
}

// Radius of the circle around a polygon of ROUND corners that is as large as a circle of radius 1: √(2π/(n·sin(2π/n))).
const ROUND_RADIUS: f32 = 1.0130016;

// A corner of the outline, from the point.
fn corner(seen: Seen, position: vec3f, index: u32) -> vec3f {
    let l = seen.light;
    let to_middle = l.position - position;
    switch l.shape {
        case RECTANGLE: {
            let x = select(1.0, -1.0, index == 1u || index == 2u);
            let y = select(1.0, -1.0, index >= 2u);
            return to_middle + l.axis * (x * l.size.x) + third_axis(l) * (y * l.size.y);
        }
        case TUBE: {
            let arc = arc_of(l, position);
            let is_far_end = index >= END;
            let step = f32(select(index, 2u * END - 1u - index, is_far_end)) / f32(END - 1u);
            let angle = (2.0 * step - 1.0) * arc.half_angle;
            let n = cos(angle) * arc.toward + sin(angle) * arc.across;
            return to_middle + l.axis * select(l.size.x, -l.size.x, is_far_end) + n * l.size.y;
        }
        default: {
            let angle = TAU * f32(index) / f32(ROUND);
            let circle = ROUND_RADIUS * vec2f(cos(angle), sin(angle));
            if l.shape == DISC {
                return to_middle + l.size.x * (circle.x * l.axis + circle.y * third_axis(l));
            }
            // A sphere looks like a disc across the line of sight, of which only the directions count.
            let cone = cone_of(l, position);
            let axes = basis(cone.axis);
            let tangent = cone.sine / max(cone.cosine, 1e-3);
            return cone.axis + tangent * (circle.x * axes[0] + circle.y * axes[1]);
        }
    }
}

// ---- Integrals over the outline ----

// θ/sin θ of an angle up to a right one by 1 − cos θ; off by at most 4e−6 (Chebyshev interpolation).
fn angle_over_sine(fall: f32) -> f32 {
    let high = 0.03436362 + fall * (0.08386244 + fall * (-0.0606734 + fall * 0.04275052));
    return 1.00000288 + fall * (0.33306327 + fall * (0.13742301 + fall * high));
}

// Angle between two unit vectors along the normal of their plane: an edge's part of Lambert's sum. Of near corners the
// difference is more exact than their product would be.
fn edge(a: vec3f, b: vec3f) -> vec3f {
    let normal = cross(a, b - a);
    let cosine = dot(a, b);
    let acute = angle_over_sine(max(1.0 - abs(cosine), 0.0));
    if cosine >= 0.0 {
        return normal * acute;
    }
    // Of an obtuse angle it is that of the rest of π.
    return normal * (PI * inverseSqrt(max(dot(normal, normal), 1e-30)) - acute);
}

// A direction; none of what vanishes.
fn unit(v: vec3f) -> vec3f {
    return v * inverseSqrt(max(dot(v, v), 1e-37));
}

// Where an edge meets the horizon.
fn at_horizon(a: vec3f, b: vec3f) -> vec3f {
    let t = a.z / (a.z - b.z);
    return unit(vec3f(mix(a.xy, b.xy, t), 0.0));
}

// Share of a cosine lobe around z that a light fills, in coordinates of the lobe: 1/(2π)·Σ θᵢ·nᵢ·z over the edges, clipped at
// the horizon. What lies above it of a convex outline is closed by one edge along it. Direction: Σ θᵢ·nᵢ, of unclipped edges.
struct Filled {
    share: f32,
    direction: vec3f,
}

fn filled(seen: Seen, position: vec3f, to_lobe: mat3x3f) -> Filled {
    var sum = 0.0;
    var whole = vec3f(0.0);
    var leaving = vec3f(0.0);
    var entering = vec3f(0.0);
    var previous = unit(to_lobe * corner(seen, position, seen.corners - 1u));
    for (var i = 0u; i < seen.corners; i++) {
        let next = unit(to_lobe * corner(seen, position, i));
        var a = previous;
        var b = next;
        whole += edge(a, b);
        if a.z > 0.0 || b.z > 0.0 {
            if b.z <= 0.0 {
                b = at_horizon(a, b);
                leaving = b;
            } else if a.z <= 0.0 {
                a = at_horizon(a, b);
                entering = a;
            }
            sum += edge(a, b).z;
        }
        previous = next;
    }
    sum += edge(leaving, entering).z;
    return Filled(min(abs(sum) / TAU, 1.0), whole * select(-1.0, 1.0, sum > 0.0));
}

// The same of a cosine around a normal for what is seen as a cone: exact, above, below and across the horizon (Snyder 1996,
// "Area light sources for real-time graphics"; as Lagarde and de Rousiers 2014 write it).
fn filled_by_cone(cone: Cone, n: vec3f) -> Filled {
    let cosine = dot(cone.axis, n);
    let sine_squared = cone.sine * cone.sine;
    var share = cosine * sine_squared;
    if abs(cosine) < cone.sine {
        let sine = sqrt(max(1.0 - cosine * cosine, 1e-12));
        let x = cone.cosine / cone.sine;
        let y = clamp(-x * cosine / sine, -1.0, 1.0);
        let across = sine * sqrt(1.0 - y * y);
        share = ((cosine * acos(y) - x * across) * sine_squared + atan2(across, x)) / PI;
    }
    return Filled(clamp(share, 0.0, 1.0), cone.axis);
}

// ---- The specular lobe ----

const ALPHAS: u32 = 41u;
const ANGLES: u32 = 32u;
const LAST_ANGLE: f32 = 1.5629424;

fn lobe_at(alpha_node: u32, angle_node: u32) -> vec4f {
    return lobes[min(alpha_node, ALPHAS - 1u) * ANGLES + min(angle_node, ANGLES - 1u)];
}

// The matrix from the lobe to a cosine, interpolated.
fn to_cosine(alpha: f32, n_dot_v: f32) -> mat3x3f {
    let row = clamp((log2(alpha) + 10.0) * 0.1, 0.0, 1.0) * f32(ALPHAS - 1u);
    let column = clamp(acos(clamp(n_dot_v, 0.0, 1.0)) / LAST_ANGLE, 0.0, 1.0) * f32(ANGLES - 1u);
    let at = vec2u(u32(row), u32(column));
    let part = vec2f(row, column) - vec2f(at);
    let low = mix(lobe_at(at.x, at.y), lobe_at(at.x, at.y + 1u), part.y);
    let high = mix(lobe_at(at.x + 1u, at.y), lobe_at(at.x + 1u, at.y + 1u), part.y);
    let m = mix(low, high, part.x);
    return mat3x3f(vec3f(m.x, 0.0, m.z * alpha), vec3f(0.0, 1.0, 0.0), vec3f(m.y, 0.0, m.w * alpha));
}

// Unit vectors as columns: the direction to the eye lies in the plane of the first and the third, which is the normal.
fn frame_of(n: vec3f, to_eye: vec3f) -> mat3x3f {
    let across = to_eye - n * dot(n, to_eye);
    let length_squared = dot(across, across);
    let x = select(basis(n)[0], across * inverseSqrt(max(length_squared, 1e-30)), length_squared > 1e-12);
    return mat3x3f(x, cross(n, x), n);
}

// Radiance that a surface reflects of the light without shadows, diffuse and specular [W/(m² sr)].
struct Unshadowed {
    diffuse: vec3f,
    specular: vec3f,
}

fn unshadowed(surface: Surface, to_eye: vec3f) -> Unshadowed {
    let position = surface.position;
    let seen = seen_from(position);
    if !is_before(seen, position) {
        return Unshadowed(vec3f(0.0), vec3f(0.0));
    }
    let to_local = transpose(frame_of(surface.normal, to_eye));
    var whole: Filled;
    if light.shape == SUN || light.shape == SPHERE {
        whole = filled_by_cone(cone_of(seen.light, position), surface.normal);
    } else {
        whole = filled(seen, position, to_local);
        whole.direction = transpose(to_local) * whole.direction;
    }
    if whole.share <= 0.0 {
        return Unshadowed(vec3f(0.0), vec3f(0.0));
    }
    let middle = whole.direction;
    // Neither vector is normalized where it may vanish.
    let half_sum = middle * inverseSqrt(max(dot(middle, middle), 1e-30)) + to_eye;
    let cosine = saturate(dot(half_sum, to_eye) * inverseSqrt(max(dot(half_sum, half_sum), 1e-12)));
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, cosine);
    let diffuse = (1.0 - max(f.r, max(f.g, f.b))) * surface.albedo * whole.share;
    let alpha = max(surface.roughness * surface.roughness, 1e-3);
    let n_dot_v = max(dot(surface.normal, to_eye), 1e-4);
    let of_even = lobe_reflectance(surface.normal_reflectance, surface.grazing_reflectance, sqrt(alpha), n_dot_v);
    var specular = vec3f(0.0);
    if any(of_even > vec3f(0.0)) {
        specular = of_even * filled(seen, position, to_cosine(alpha, n_dot_v) * to_local).share;
    }
    return Unshadowed(min(diffuse * seen.radiance, vec3f(MAX_RADIANCE)), min(specular * seen.radiance, vec3f(MAX_RADIANCE)));
}

// ---- Shadows ----

#ifdef SHADOW_RAYS
// Share of a pixel's own samples that arrive; below 0: it has none.
fn lit_share(s: vec4f) -> f32 {
    return select(-1.0, s.x / max(s.y, 1e-37), s.y > 0.0);
}

// Kinds of samples in the tiles of a window, which is smaller than a tile.
fn kinds_around(low: vec2i, high: vec2i) -> u32 {
    let a = vec2u(low);
    let b = vec2u(high);
    return tiles[tile_of(a, view.size)] | tiles[tile_of(vec2u(b.x, a.y), view.size)]
        | tiles[tile_of(vec2u(a.x, b.y), view.size)] | tiles[tile_of(b, view.size)];
}

// Share of diffuse and of specular light that arrives: the ratio of sums over the neighbourhood. Its border counts half, so that
// the window holds as many pixels of each kind as the samples of a square of pixels have. Stratified samples of a soft shadow
// are rarely all lit in one pixel and all dark in the next: where they are, there is the border of a hard one.
fn arriving(pixel: vec2u, surface: Surface) -> vec2f {
    let r = i32(area.radius);
    let low = vec2i(area.origin);
    let high = vec2i(area.origin + area.size) - 1;
    var kinds = kinds_around(clamp(vec2i(pixel) - r, low, high), clamp(vec2i(pixel) + r, low, high));
    if kinds == MIXED {
        kinds = 0u;
        for (var y = -r; y <= r; y++) {
            for (var x = -r; x <= r; x++) {
                kinds |= kinds_of(textureLoad(arrived, clamp(vec2i(pixel) + vec2i(x, y), low, high), 0));
            }
        }
    }
    if kinds != MIXED {
        return vec2f(select(1.0, 0.0, kinds == DARK));
    }
    var sums = textureLoad(arrived, pixel, 0);
    let own = lit_share(sums);
    for (var y = -r; y <= r; y++) {
        for (var x = -r; x <= r; x++) {
            let other = vec2i(pixel) + vec2i(x, y);
            let is_own = x == 0 && y == 0;
            let s = textureLoad(arrived, clamp(other, low, high), 0);
            if is_own || any(other < low) || any(other > high) || s.y + s.w <= 0.0 {
                continue;
            }
            let z = textureLoad(depth, other, 0);
            let at = world_position(vec2u(other), view.size, z, view.world_from_clip);
            let n = decode_normal(textureLoad(normal, other, 0));
            let border = select(1.0, 0.5, abs(x) == r) * select(1.0, 0.5, abs(y) == r);
            let apart = own - lit_share(s);
            let alike = select(1.0 - apart * apart, 1.0, own < 0.0 || lit_share(s) < 0.0);
            sums += s * (border * alike * likeness(surface.position, surface.normal, at, n));
        }
    }
    let diffuse = select(0.0, sums.x / max(sums.y, 1e-37), sums.y > 0.0);
    return vec2f(diffuse, select(diffuse, sums.z / max(sums.w, 1e-37), sums.w > 1e-30));
}
#endif

#ifdef SHADOW_MAP
fn lit_by_map(position: vec3f, n: vec3f) -> f32 {
    let receiver = shadow_receiver(shadow.view, position, n, light_incidence(light, position).to_light);
    let at = shadow_coordinate(shadow.view, shadow.faces[receiver.face].clip_from_world, receiver);
    return select(1.0, textureSampleCompareLevel(shadow_map, shadow_sampler, at.uv, at.face, at.depth), at.inside);
}
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= area.size) {
        return;
    }
    let pixel = area.origin + thread.xy;
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        return;
    }
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    var share = vec2f(1.0);
#ifdef SHADOW_RAYS
    share = arriving(pixel, surface);
#endif
#ifdef SHADOW_MAP
    share = vec2f(lit_by_map(position, surface.normal));
#endif
    if all(share <= vec2f(0.0)) {
        return;
    }
    let shown = unshadowed(surface, normalize(toward_eye(view, position)));
    // As from its middle.
    let toward = light_incidence(light, position);
    let passing = through_media(Incidence(toward.to_light, toward.distance, vec3f(1.0), 0.0), position).irradiance;
    var reflected = (shown.diffuse * share.x + shown.specular * share.y) * passing;
#ifdef GLASS
    // How much glass takes was found by rays, its colour is that of light from the middle.
    let left = left_on_way(view, area.root, position, surface.normal, toward);
    let mean = dot(vec3f(1.0 / 3.0), left);
    reflected *= select(vec3f(1.0), left / max(mean, 1e-6), mean > 1e-6);
#endif
    for (var channel = 0u; channel < 3u; channel++) {
        let before = textureLoad(radiance, pixel, channel).r;
        textureStore(radiance, pixel, channel, vec4f(before + reflected[channel], 0.0, 0.0, 0.0));
    }
}
