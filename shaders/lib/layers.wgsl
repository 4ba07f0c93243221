#define_import_path lightwell::layers

// Layers of a surface beyond the metallic-roughness base, as glTF's extensions define them: KHR_materials_clearcoat, _sheen,
// _anisotropy and _iridescence. From outside: a clear coat, sheen, the base with its film and stretched highlights. Each layer
// takes from those below what it reflects itself towards the eye, by the angle of the view alone.

#import lightwell::brdf::fresnel_schlick
#import lightwell::gbuffer::{decode_normal, decode_normal_reflectance}
#import lightwell::sampling::{TAU, basis}

// ---- Clear coat: a smooth or rough dielectric of the index 1.5 ----

// What a coat reflects towards the eye of what its lobe gathers, and takes from all below: Schlick's term of F0 = 4 %.
fn coat_reflectance(factor: f32, cosine: f32) -> f32 {
    let m = saturate(1.0 - cosine);
    let m2 = m * m;
    return factor * (0.04 + 0.96 * (m2 * m2 * m));
}

// ---- Tints of lobes ----

// What the reflections of a lobe are divided by before they are filtered, since by layers it changes more from pixel to pixel than
// what they show.
fn tint_of_lobe(normal_reflectance: vec3f, grazing_reflectance: f32, n_dot_v: f32) -> vec3f {
    return max(fresnel_schlick(normal_reflectance, grazing_reflectance, max(n_dot_v, 0.0)), vec3f(1e-4));
}

// The same of texels of a geometry buffer.
fn tint_seen(normal: vec4u, object: vec4u, to_eye: vec3f) -> vec3f {
    let n_dot_v = dot(decode_normal(normal), normalize(to_eye));
    return tint_of_lobe(decode_normal_reflectance(object.xy), f32(normal.w) / 65535.0, n_dot_v);
}

// ---- Sheen: fibres that stand off the surface (Estevez and Kulla 2017, "Production friendly microfacet sheen BRDF") ----

// `Sheen::LEAST_ROUGHNESS` of assets/layers.rs.
const LEAST_SHEEN_ROUGHNESS: f32 = 0.3;

// ln Λ of the fit of their shadowing, up to a cosine of ½.
fn log_shadowing(x: f32, parameters: array<f32, 5>) -> f32 {
    return parameters[0] / (1.0 + parameters[1] * pow(x, parameters[2])) + parameters[3] * x + parameters[4];
}

fn sheen_shadowing(cosine: f32, parameters: array<f32, 5>) -> f32 {
    if cosine < 0.5 {
        return exp(log_shadowing(cosine, parameters));
    }
    return exp(2.0 * log_shadowing(0.5, parameters) - log_shadowing(1.0 - cosine, parameters));
}

// The lobe of white sheen, without the cosine [1/sr]: D·V with D = (2 + 1/α)·sin^(1/α) θ/2π and α = roughness².
fn sheen_lobe(roughness: f32, n_dot_h: f32, n_dot_l: f32, n_dot_v: f32) -> f32 {
    let r = max(roughness, LEAST_SHEEN_ROUGHNESS);
    let inverse = 1.0 / (r * r);
    let sine_squared = max(1.0 - n_dot_h * n_dot_h, 1e-7);
    let distribution = (2.0 + inverse) * pow(sine_squared, 0.5 * inverse) / TAU;
    let smooth_part = (1.0 - r * r) * (1.0 - r * r);
    let parameters = array<f32, 5>(
        mix(21.5473, 25.3245, smooth_part), mix(3.82987, 3.32435, smooth_part), mix(0.19823, 0.16801, smooth_part),
        mix(-1.97760, -1.27393, smooth_part), mix(-4.32054, -4.85967, smooth_part),
    );
    let shadowing = 1.0 + sheen_shadowing(n_dot_l, parameters) + sheen_shadowing(n_dot_v, parameters);
    return distribution / (shadowing * 4.0 * max(n_dot_l * n_dot_v, 1e-6));
}

// Share of even light that white sheen reflects: ∫ f·cosine over the hemisphere, a fit to its numbers within 0.008.
fn albedo_of_sheen(roughness: f32, n_dot_v: f32) -> f32 {
    let r = clamp(roughness, LEAST_SHEEN_ROUGHNESS, 1.0);
    let powers = vec4f(1.0, r, r * r, r * r * r);
    let s = sqrt(saturate(n_dot_v));
    let a = dot(vec4f(0.8119, -5.2521, 8.1984, -3.8364), powers);
    let b = dot(vec4f(3.0739, -6.616, 6.7603, -2.4822), powers);
    let c = dot(vec4f(-34.2652, 84.7585, -92.906, 35.1248), powers);
    let d = dot(vec4f(54.3032, -140.0543, 152.2341, -56.9721), powers);
    let e = dot(vec4f(-36.5864, 97.523, -103.9566, 38.2905), powers);
    return min(exp(a + s * (b + s * (c + s * (d + s * e)))), 1.0);
}

// What sheen leaves to the layers below.
fn left_by_sheen(color: vec3f, albedo: f32) -> f32 {
    return 1.0 - max(color.r, max(color.g, color.b)) * albedo;
}

// ---- A film as thin as the waves of light (Belcour and Barla 2017, "A practical extension to microfacet theory for the
// modeling of varying iridescence") ----

const REC709_FROM_XYZ = mat3x3f(
    3.2404542, -0.9692660, 0.0556434,
    -1.5371385, 1.8760108, -0.2040259,
    -0.4985314, 0.0415560, 1.0572252,
);

// What the eye makes of interference at a difference of paths [nm]: Fourier transforms of the colour matching functions, as sums
// of Gaussians (their supplement).
fn sensitivity(path: f32, shift: vec3f) -> vec3f {
    let phase = TAU * path * 1e-9;
    let variance = vec3f(4.3278e9, 9.3046e9, 6.6121e9);
    var xyz = vec3f(5.4856e-13, 4.4201e-13, 5.2481e-13) * sqrt(TAU * variance)
        * cos(vec3f(1.6810e6, 1.7953e6, 2.2084e6) * phase + shift) * exp(-variance * (phase * phase));
    xyz.x += 9.7470e-14 * sqrt(TAU * 4.5282e9) * cos(2.2399e6 * phase + shift.x) * exp(-4.5282e9 * phase * phase);
    return REC709_FROM_XYZ * (xyz / 1.0685e-7);
}

fn squared_ratio(a: vec3f, b: vec3f) -> vec3f {
    let ratio = (a - b) / (a + b);
    return ratio * ratio;
}

// From this thickness on a film counts in full [nm]: a 25th of a wave of blue light in glass.
const THINNEST: f32 = 10.0;

// Reflectance of a base of that F0 with a film of that index and thickness [nm] on it, where light comes with that cosine.
fn film_reflectance(base: vec3f, ior: f32, thickness: f32, cosine: f32) -> vec3f {
    let c = saturate(cosine);
    let cosine_within = sqrt(max(0.0, 1.0 - (1.0 - c * c) / (ior * ior)));
    let m = pow(1.0 - c, 5.0);
    let upper = mix(((ior - 1.0) / (ior + 1.0)) * ((ior - 1.0) / (ior + 1.0)), 1.0, m);
    // The base's index from its reflectance in air, and what it reflects in the film.
    let root = sqrt(clamp(base, vec3f(0.0), vec3f(0.9999)));
    let base_ior = (1.0 + root) / (1.0 - root);
    let lower = mix(squared_ratio(base_ior, vec3f(ior)), vec3f(1.0), pow(1.0 - cosine_within, 5.0));
    let shift = vec3f(0.5 * TAU) + select(vec3f(0.0), vec3f(0.5 * TAU), base_ior < vec3f(ior));
    let path = 2.0 * ior * thickness * cosine_within;
    // Reflections within the film, one after the other (their eq. 5 to 10).
    let round = clamp(upper * lower, vec3f(1e-5), vec3f(0.9999));
    let passed = 1.0 - upper;
    let mean = passed * passed * lower / (1.0 - round);
    var sum = upper + mean;
    var order = mean - passed;
    for (var i = 1; i <= 2; i++) {
        order *= sqrt(round);
        sum += order * 2.0 * sensitivity(f32(i) * path, f32(i) * shift);
    }
    // A film that is much thinner than a wave changes nothing, of which Schlick's terms at both of its sides know nothing.
    let bare = mix(base, vec3f(1.0), m);
    return clamp(mix(bare, sum, smoothstep(0.0, THINNEST, thickness)), vec3f(0.0), vec3f(1.0));
}

// F0 of Schlick's term that is as bright at this angle as the film is (as KHR_materials_iridescence proposes).
fn reflectance_of_film(seen: vec3f, f90: f32, cosine: f32) -> vec3f {
    let m = pow(saturate(1.0 - cosine), 5.0);
    return clamp((seen - f90 * m) / max(1.0 - m, 1e-2), vec3f(0.0), vec3f(1.0));
}

// ---- Anisotropy: GGX with other α along a tangent than across (Heitz 2014 and 2018) ----

// GGX α along the direction of anisotropy.
fn stretched_alpha(alpha: f32, strength: f32) -> f32 {
    return mix(alpha, 1.0, strength * strength);
}

// A direction on the surface as a texture or a turn gives it; any where the surface has no tangent.
fn stretch_direction(n: vec3f, tangent: vec3f, handedness: f32, turn: vec2f) -> vec3f {
    var t = tangent - n * dot(n, tangent);
    if dot(t, t) < 1e-12 {
        t = basis(n)[0];
    }
    t = normalize(t);
    let b = cross(n, t) * handedness;
    let along = t * turn.x + b * turn.y;
    return select(t, normalize(along), dot(along, along) > 1e-12);
}

// D of a half vector.
fn stretched_distribution(n: vec3f, along: vec3f, h: vec3f, alphas: vec2f) -> f32 {
    let x = dot(along, h) / alphas.x;
    let y = dot(cross(n, along), h) / alphas.y;
    let z = dot(n, h);
    let k = x * x + y * y + z * z;
    return 2.0 / (TAU * alphas.x * alphas.y * max(k * k, 1e-20));
}

// √((α_t·t·v)² + (α_b·b·v)² + (n·v)²): n·v times Λ's root.
fn stretched_length(n: vec3f, along: vec3f, v: vec3f, alphas: vec2f) -> f32 {
    return length(vec3f(alphas.x * dot(along, v), alphas.y * dot(cross(n, along), v), dot(n, v)));
}

// D·V, height-correlated.
fn stretched_lobe(n: vec3f, along: vec3f, v: vec3f, l: vec3f, h: vec3f, alphas: vec2f) -> f32 {
    let n_dot_v = max(dot(n, v), 1e-4);
    let masking = dot(n, l) * stretched_length(n, along, v, alphas) + n_dot_v * stretched_length(n, along, l, alphas);
    return stretched_distribution(n, along, h, alphas) * 0.5 / max(masking, 1e-20);
}

// As `visible_normal_density` of lib/brdf.wgsl.
fn stretched_density(n: vec3f, along: vec3f, v: vec3f, h: vec3f, alphas: vec2f) -> f32 {
    return stretched_distribution(n, along, h, alphas) / (2.0 * (dot(n, v) + stretched_length(n, along, v, alphas)));
}
