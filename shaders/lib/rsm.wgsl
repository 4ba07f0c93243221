#define_import_path lightwell::rsm

#import lightwell::gbuffer::world_position
#import lightwell::lights::{Light, is_distant, light_intensity_towards, range_window}

// One view of a reflective shadow map.
struct RsmLayer {
    world_from_clip: mat4x4f,
    half_extent: f32,      // tangent of the half angle, or metres for directional lights
    size: u32,             // edge of the map [texels]
    layer: i32,
    scale: f32,            // power of two that turns flux into fixed point
}

struct Received {
    flux: vec3f,           // Φ_in [W]
    to_light: vec3f,       // unit
    area: f32,             // of the texel across the light A_⊥ [m²]
}

// Where a texel's surface is [m], before it by as much as the rasterizer may have put it behind, see `position_error` of
// lib/view.wgsl: rays end there.
fn texel_position(rsm: RsmLayer, texel: vec2u, z: f32, n: vec3f) -> vec3f {
    let size = vec2u(rsm.size);
    let position = world_position(texel, size, z, rsm.world_from_clip);
    let beside = world_position(texel + vec2u(1u, 0u), size, z, rsm.world_from_clip);
    return position + n * (distance(position, beside) * 0x1p-8f);
}

// Solid angle from the axis to a corner of the image plane at distance one: ∫∫ (1+x²+y²)^(−3/2).
fn corner_solid_angle(corner: vec2f) -> f32 {
    return atan2(corner.x * corner.y, sqrt(1.0 + dot(corner, corner)));
}

// Solid angle of a rectangle on the image plane [sr], exact.
fn texel_solid_angle(low: vec2f, high: vec2f) -> f32 {
    return max(0.0, corner_solid_angle(high) - corner_solid_angle(vec2f(low.x, high.y))
        - corner_solid_angle(vec2f(high.x, low.y)) + corner_solid_angle(low));
}

// What the surface in a texel receives from the light: Φ_in = I·Δω or E·A_⊥. No cosine: the texel is what the
// light sees of the surface.
fn texel_received(rsm: RsmLayer, light: Light, texel: vec2u, position: vec3f) -> Received {
    let step = 2.0 * rsm.half_extent / f32(rsm.size);
    let offset = light.position - position;
    let d = length(offset);
    let to_light = select(vec3f(0.0, 1.0, 0.0), offset / d, d > 1e-18);
    let low = vec2f(texel) * step - rsm.half_extent;
    let solid_angle = texel_solid_angle(low, low + step);
    let flux = light_intensity_towards(light, -to_light) * range_window(light, d) * solid_angle;
    // Both are computed: Mesa's software driver (22.3) makes shaders anew in every frame whose branches hang on values of
    // uniforms alone that stand beside others that change.
    let is_directional = is_distant(light);
    return Received(
        select(flux, light.intensity * (step * step), is_directional),
        select(to_light, -light.direction, is_directional),
        select(solid_angle * d * d, step * step, is_directional),
    );
}
