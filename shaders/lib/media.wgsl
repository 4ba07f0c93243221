#define_import_path lightwell::media

// Participating media: how much light passes, and where it is scattered (Chandrasekhar 1960; Pharr, Jakob and Humphreys 2023,
// "Physically Based Rendering", chapter 11).
//   T(a, b) = exp(−∫ σₜ),  σₜ(x) = Σ over media that hold x of σ·min(1, exp(−falloff·height))
// Integrals along a ray are exact: a medium is a box, a ball or all of space, and its density is even or exponential.
//   MEDIA       how many there are; without it nothing of this is used
//   RAY_MEDIA   the binding is one of the scene as rays see it
//   FORWARD     it is one of a raster pass, whose first groups are taken

#import lightwell::sampling::{TAU, basis}

#ifdef MEDIA
const MEDIA: u32 = #{MEDIA}u;
#else
const MEDIA: u32 = 0u;
#endif

struct Medium {
    local_rows: array<vec4f, 3>, // rows of the matrix from world to its own coordinates
    up: vec3f,             // unit, along which heights are measured
    base: f32,             // of the height 0 along that [m]
    albedo: vec3f,
    extinction: f32,       // at and below the height 0 [1/m]
    falloff: f32,          // [1/m]
    anisotropy: f32,
    shape: u32,
    padding: u32,
}

const EVERYWHERE: u32 = 0u;
const BOX: u32 = 1u;
const SPHERE: u32 = 2u;

#ifdef RAY_MEDIA
@group(1) @binding(8) var<uniform> media: array<Medium, 16>;
#else
#ifdef FORWARD
@group(3) @binding(16) var<uniform> media: array<Medium, 16>;
#else
@group(0) @binding(32) var<uniform> media: array<Medium, 16>;
#endif
#endif

// What lies farther counts as this far off [m]: the square of it, and its product with an extinction, stay finite.
const FARTHEST: f32 = 1e12;

// Part of a ray [m]; empty where it does not begin before it ends.
struct Span {
    begin: f32,
    end: f32,
}

// The part of a ray in a unit direction, up to a distance, that lies in a medium.
fn span_in(medium: Medium, origin: vec3f, direction: vec3f, distance: f32) -> Span {
    let reach = min(distance, FARTHEST);
    let p = vec4f(origin, 1.0);
    let o = vec3f(dot(medium.local_rows[0], p), dot(medium.local_rows[1], p), dot(medium.local_rows[2], p));
    let d = vec3f(
        dot(medium.local_rows[0].xyz, direction), dot(medium.local_rows[1].xyz, direction),
        dot(medium.local_rows[2].xyz, direction),
    );
    // All shapes are computed: Mesa's software driver (22.3) makes shaders anew whose branches hang on uniforms alone.
    let along = select(d, vec3f(1e-30), abs(d) < vec3f(1e-30));
    let near = (-sign(along) - o) / along;
    let far = (sign(along) - o) / along;
    var begin = max(near.x, max(near.y, near.z));
    var end = min(far.x, min(far.y, far.z));
    // The ball: where |o + t·d| = 1, from the point of the ray that is nearest to its middle.
    let dd = max(dot(d, d), 1e-37);
    let middle = -dot(o, d) / dd;
    let nearest = o + middle * d;
    let squared = 1.0 - dot(nearest, nearest);
    let half = sqrt(max(squared, 0.0) / dd);
    begin = select(begin, middle - half, medium.shape == SPHERE);
    end = select(end, select(-1.0, middle + half, squared > 0.0), medium.shape == SPHERE);
    begin = select(begin, 0.0, medium.shape == EVERYWHERE);
    end = select(end, reach, medium.shape == EVERYWHERE);
    return Span(max(begin, 0.0), min(end, reach));
}

fn height_in(medium: Medium, position: vec3f) -> f32 {
    return dot(medium.up, position) - medium.base;
}

// Density over that at the height 0.
fn density_at(medium: Medium, height: f32) -> f32 {
    return exp(-min(medium.falloff * max(height, 0.0), 80.0));
}

// (1 − exp(−x))/x.
fn mean_of_decay(x: f32) -> f32 {
    return select((1.0 - exp(-min(x, 80.0))) / max(x, 1e-30), 1.0 - 0.5 * x, x < 1e-3);
}

// Optical depth of a medium along a part of a ray: its lower part lies below the height 0, where the density is even, and
// above it is exponential.
fn depth_of(medium: Medium, origin: vec3f, direction: vec3f, span: Span) -> f32 {
    let length = max(span.end - span.begin, 0.0);
    let slope = dot(medium.up, direction);
    let rise = abs(slope);
    let lowest = height_in(medium, origin + direction * select(span.end, span.begin, slope >= 0.0));
    let below = clamp(-lowest / max(rise, 1e-20), 0.0, length);
    let above = length - below;
    let thinned = density_at(medium, lowest) * mean_of_decay(medium.falloff * rise * above);
    return medium.extinction * (below + above * thinned);
}

// Optical depth of all.
fn optical_depth(origin: vec3f, direction: vec3f, distance: f32) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < MEDIA; i++) {
        sum += depth_of(media[i], origin, direction, span_in(media[i], origin, direction, distance));
    }
    return sum;
}

// Share of light that passes.
fn transmittance(origin: vec3f, direction: vec3f, distance: f32) -> f32 {
    return exp(-optical_depth(origin, direction, distance));
}

// The same where light that is scattered counts as if it went on, so that only what is absorbed is lost: for light between
// surfaces, of which as much is scattered to a place as away from it.
fn share_not_absorbed(origin: vec3f, direction: vec3f, distance: f32) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < MEDIA; i++) {
        let depth = depth_of(media[i], origin, direction, span_in(media[i], origin, direction, distance));
        sum += depth * (1.0 - media[i].albedo);
    }
    return exp(-sum);
}

// Extinction coefficient of a medium at a point [1/m].
fn extinction_at(medium: Medium, position: vec3f) -> f32 {
    let p = vec4f(position, 1.0);
    let o = vec3f(dot(medium.local_rows[0], p), dot(medium.local_rows[1], p), dot(medium.local_rows[2], p));
    let in_box = all(abs(o) <= vec3f(1.0));
    let in_ball = dot(o, o) <= 1.0;
    let is_in = medium.shape == EVERYWHERE || (medium.shape == BOX && in_box) || (medium.shape == SPHERE && in_ball);
    return select(0.0, medium.extinction * density_at(medium, height_in(medium, position)), is_in);
}

// Density with which light that travels in one direction is scattered into another, by the cosine between the two [1/sr]
// (Henyey and Greenstein 1941).
fn phase(anisotropy: f32, cosine: f32) -> f32 {
    let g = anisotropy;
    let d = max(1.0 + g * g - 2.0 * g * cosine, 1e-6);
    return (1.0 - g * g) / (2.0 * TAU * d * sqrt(d));
}

// A direction with that density around the one that light travels in (the cosine by inversion: Witt 1977).
fn scattered_direction(anisotropy: f32, direction: vec3f, random: vec2f) -> vec3f {
    let g = anisotropy;
    let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * random.x);
    let inverted = (1.0 + g * g - s * s) / (2.0 * select(1.0, g, abs(g) > 1e-3));
    let cosine = clamp(select(1.0 - 2.0 * random.x, inverted, abs(g) > 1e-3), -1.0, 1.0);
    // With inversion the cosine grows with the random number, without it falls; either way it has its density.
    let sine = sqrt(1.0 - cosine * cosine);
    let angle = TAU * random.y;
    return normalize(basis(direction) * vec3f(sine * cos(angle), sine * sin(angle), cosine));
}

// Distance from the beginning of a medium's span at which its optical depth reaches a value; beyond the span if it does not.
fn distance_of_depth(medium: Medium, origin: vec3f, direction: vec3f, span: Span, depth: f32) -> f32 {
    let wanted = depth / medium.extinction;
    let slope = dot(medium.up, direction);
    let thinning = medium.falloff * abs(slope);
    let height = height_in(medium, origin + direction * span.begin);
    let thin = medium.falloff * max(height, 0.0);
    // Upwards: even up to the height 0, then ever thinner; the exponential's inverse.
    let below = select(0.0, max(-height, 0.0) / max(slope, 1e-20), slope > 0.0);
    let rest = max(wanted - below, 0.0);
    let left = 1.0 - rest * thinning * exp(min(thin, 80.0));
    let upward = select(select(below - log(max(left, 1e-30)) / max(thinning, 1e-30), 3e38, left <= 0.0), wanted, wanted <= below);
    // Downwards: ever denser down to the height 0, then even.
    let to_ground = max(height, 0.0) / max(-slope, 1e-20);
    let falling = (thin + log(exp(-min(thin, 80.0)) + wanted * thinning)) / max(thinning, 1e-30);
    let above = (1.0 - exp(-min(thin, 80.0))) / max(thinning, 1e-30);
    let downward = select(to_ground + wanted - above, falling, falling <= to_ground);
    let even = wanted / max(density_at(medium, height), 1e-35);
    return select(select(downward, upward, slope > 0.0), even, thinning < 1e-7);
}

// ---- Points on a ray that are lit by a light ----

// The part of a ray that lies in any medium.
fn span_of_all(origin: vec3f, direction: vec3f, distance: f32) -> Span {
    var all = Span(FARTHEST, 0.0);
    for (var i = 0u; i < MEDIA; i++) {
        let span = span_in(media[i], origin, direction, distance);
        if span.end > span.begin {
            all = Span(min(all.begin, span.begin), max(all.end, span.end));
        }
    }
    return all;
}

// Equiangular sampling (Kulla and Fajardo 2012): distances along a part of a ray with a density that follows 1/r² of a light.
struct Equiangular {
    foot: f32,             // distance along the ray of the light's perpendicular [m]
    across: f32,           // length of that [m]
    low: f32,              // angles of the part's ends [rad]
    high: f32,
}

fn equiangular(origin: vec3f, direction: vec3f, span: Span, light: vec3f) -> Equiangular {
    let foot = dot(light - origin, direction);
    let across = max(length(light - origin - direction * foot), 1e-5);
    return Equiangular(foot, across, atan((span.begin - foot) / across), atan((span.end - foot) / across));
}

fn equiangular_distance(e: Equiangular, random: f32) -> f32 {
    return e.foot + e.across * tan(mix(e.low, e.high, random));
}

// Its density [1/m].
fn equiangular_density(e: Equiangular, distance: f32) -> f32 {
    let along = distance - e.foot;
    return e.across / (max(e.high - e.low, 1e-9) * (e.across * e.across + along * along));
}

// Extinction coefficient of all media at a point [1/m].
fn extinction_of_all(position: vec3f) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < MEDIA; i++) {
        sum += extinction_at(media[i], position);
    }
    return sum;
}

// What all media at a point scatter of light from one direction into another, over it [1/(m sr)].
fn scattering_at(position: vec3f, cosine: f32) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < MEDIA; i++) {
        sum += extinction_at(media[i], position) * media[i].albedo * phase(media[i].anisotropy, cosine);
    }
    return sum;
}
