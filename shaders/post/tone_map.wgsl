// Display step: exposure, tone map, sRGB encoding. Never touches a measured image.

#import lightwell::color::luminance

struct ToneMap {
    scale: f32,            // 2^exposure
    vignette: f32,         // square of the tangent at the corners
    low: vec3f,            // colour of the table's first entry
    entries: u32,          // along each of its edges
    high: vec3f,           // colour of its last entry
}

const NEUTRAL: u32 = 0u;
const COLOR: u32 = 1u;      // albedo, normal, and light without a tone map: as they are
const DISTANCE: u32 = 2u;   // [m], shown as d/(1 + d): all of it fits
const FILMIC: u32 = 3u;
const AGX: u32 = 4u;
const ACES: u32 = 5u;
const REINHARD: u32 = 6u;

// Known when the shader is compiled, see post/compose.wgsl.
#ifdef MODE
const MODE: u32 = #{MODE}u;
#else
const MODE: u32 = NEUTRAL;
#endif

@group(0) @binding(0) var<uniform> tone_map: ToneMap;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var display: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var<storage, read> automatic: array<f32>;   // factor of the automatic exposure, or 1
#ifdef GRADING
@group(0) @binding(4) var<storage, read> grading: array<vec4f>;   // red fastest
#endif

// Khronos PBR Neutral tone mapper (specification 1.0): base colours below 0.8 keep their hue and saturation,
// brighter light is compressed and desaturated.
fn pbr_neutral(color: vec3f) -> vec3f {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let lowest = min(color.r, min(color.g, color.b));
    let offset = select(0.04, lowest - 6.25 * lowest * lowest, lowest < 0.08);
    let shifted = color - offset;
    let peak = max(shifted.r, max(shifted.g, shifted.b));
    if peak < START {
        return shifted;
    }
    const D: f32 = 1.0 - START;
    let new_peak = 1.0 - D * D / (peak + D - START);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    return mix(shifted * (new_peak / peak), vec3f(new_peak), g);
}

// Narkowicz 2016, "ACES filmic tone mapping curve": a rational fit of the ACES reference transform.
fn filmic(color: vec3f) -> vec3f {
    let x = min(color * 0.6, vec3f(1e4));
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

// AgX (Sobotka 2022): a matrix that mixes the primaries, a logarithm over 16.5 stops, a sigmoid, and the matrix back. The
// numbers and the polynomial for the sigmoid are those of Wrensch 2023, "Minimal AgX implementation".
fn agx(color: vec3f) -> vec3f {
    const INSET = mat3x3f(
        vec3f(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
        vec3f(0.0784335999999992, 0.878468636469772, 0.0784336),
        vec3f(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
    );
    const OUTSET = mat3x3f(
        vec3f(1.19687900512017, -0.0528968517574562, -0.0529716355144438),
        vec3f(-0.0980208811401368, 1.15190312990417, -0.0980434501171241),
        vec3f(-0.0990297440797205, -0.0989611768448433, 1.15107367264116),
    );
    const LOWEST: f32 = -12.47393;   // [stops]
    const HIGHEST: f32 = 4.026069;
    let stops = log2(max(INSET * color, vec3f(1e-10)));
    let x = (clamp(stops, vec3f(LOWEST), vec3f(HIGHEST)) - LOWEST) / (HIGHEST - LOWEST);
    let curve = (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232;
    // What comes out is encoded with a power of 2.2.
    return pow(max(OUTSET * curve, vec3f(0.0)), vec3f(2.2));
}

// Hill 2016: a fit of the ACES reference rendering transform with the output transform for sRGB.
fn aces(color: vec3f) -> vec3f {
    const INPUT = mat3x3f(
        vec3f(0.59719, 0.07600, 0.02840), vec3f(0.35458, 0.90834, 0.13383), vec3f(0.04823, 0.01566, 0.83777),
    );
    const OUTPUT = mat3x3f(
        vec3f(1.60475, -0.10208, -0.00327), vec3f(-0.53108, 1.10813, -0.07276), vec3f(-0.07367, -0.00605, 1.07602),
    );
    let x = INPUT * color;
    let fit = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
    return OUTPUT * fit;
}

// Reinhard et al. 2002, eq. 4, on luminance: what is as bright as `WHITE` becomes 1.
fn reinhard(color: vec3f) -> vec3f {
    const WHITE: f32 = 4.0;
    let l = luminance(color);
    return color * (1.0 + l / (WHITE * WHITE)) / (1.0 + l);
}

// Share of the light that arrives: cos⁴θ, the law of natural vignetting, with cos²θ = 1/(1 + tan²θ).
fn falloff(pixel: vec2u) -> f32 {
#ifdef VIGNETTE
    let size = vec2f(textureDimensions(radiance));
    let from_center = vec2f(pixel) + 0.5 - 0.5 * size;
    let cosine = 1.0 / (1.0 + tone_map.vignette * dot(from_center, from_center) / (0.25 * dot(size, size)));
    return cosine * cosine;
#else
    return 1.0;
#endif
}

fn mapped(color: vec3f) -> vec3f {
    switch MODE {
        case COLOR: { return color; }
        case DISTANCE: { return color / (1.0 + color); }
        case FILMIC: { return filmic(color); }
        case AGX: { return agx(color); }
        case ACES: { return aces(color); }
        case REINHARD: { return reinhard(color); }
        default: { return pbr_neutral(color); }
    }
}

// IEC 61966-2-1.
fn encode_srgb(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

#ifdef GRADING
fn entry(at: vec3u) -> vec3f {
    return grading[at.x + tone_map.entries * (at.y + tone_map.entries * at.z)].rgb;
}

// Between the eight entries around a colour, linearly.
fn graded(color: vec3f) -> vec3f {
    let last = f32(tone_map.entries - 1u);
    let place = clamp((color - tone_map.low) / (tone_map.high - tone_map.low), vec3f(0.0), vec3f(1.0)) * last;
    let a = vec3u(min(floor(place), vec3f(last - 1.0)));
    let b = a + 1u;
    let t = place - vec3f(a);
    let front = mix(
        mix(entry(a), entry(vec3u(b.x, a.yz)), t.x), mix(entry(vec3u(a.x, b.y, a.z)), entry(vec3u(b.xy, a.z)), t.x), t.y,
    );
    let back = mix(
        mix(entry(vec3u(a.xy, b.z)), entry(vec3u(b.x, a.y, b.z)), t.x), mix(entry(vec3u(a.x, b.yz)), entry(b), t.x), t.y,
    );
    return saturate(mix(front, back, t.z));
}
#else
fn graded(color: vec3f) -> vec3f {
    return color;
}
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(radiance)) {
        return;
    }
    // Above 1e6 everything is white; the bound keeps the squares above finite.
    let scale = tone_map.scale * automatic[0];
    let exposed = min(textureLoad(radiance, thread.xy, 0).rgb * scale * falloff(thread.xy), vec3f(1e6));
    textureStore(display, thread.xy, vec4f(graded(encode_srgb(saturate(mapped(exposed)))), 1.0));
}
