// Display step: exposure, tone map, sRGB encoding. Never touches a measured image.

struct ToneMap {
    scale: f32,            // 2^exposure
    mode: u32,             // LIGHT, FILMIC, or a layer that is shown without tone map
    is_auto: u32,          // whether `automatic` counts
}

const LIGHT: u32 = 0u;
const COLOR: u32 = 1u;      // albedo, normal: as they are
const DISTANCE: u32 = 2u;   // [m], shown as d/(1 + d): all of it fits
const FILMIC: u32 = 3u;

@group(0) @binding(0) var<uniform> tone_map: ToneMap;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var display: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var<storage, read> automatic: array<f32>;   // factor of the automatic exposure

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

// IEC 61966-2-1.
fn encode_srgb(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(radiance)) {
        return;
    }
    // Above 1e6 everything is white; the bound keeps the squares below finite.
    let scale = tone_map.scale * select(1.0, automatic[0], tone_map.is_auto == 1u);
    let exposed = min(textureLoad(radiance, thread.xy, 0).rgb * scale, vec3f(1e6));
    var mapped = exposed;
    if tone_map.mode == LIGHT {
        mapped = pbr_neutral(exposed);
    } else if tone_map.mode == FILMIC {
        mapped = filmic(exposed);
    } else if tone_map.mode == DISTANCE {
        mapped = exposed / (1.0 + exposed);
    }
    textureStore(display, thread.xy, vec4f(encode_srgb(saturate(mapped)), 1.0));
}
