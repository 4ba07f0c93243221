#define_import_path lightwell::rough_glass

// The rough glass of a pixel, as a filter over what is seen through it needs it: normal, roughness, number of the object, and how
// far behind it is what is seen. Clear glass has none.

#import lightwell::gbuffer::{decode_octahedral, encode_octahedral}

struct RoughGlass {
    normal: vec3f,         // on the side of the eye
    alpha: f32,            // GGX α
    is_solid: bool,        // it bounds a body
}

// Index of refraction of bodies, as far as widths of lobes depend on it.
const USUAL_IOR: f32 = 1.5;
// Width of what passes both surfaces of a body over that of a reflection: microfacets turn what is refracted by n − 1 of the angle
// that they are turned by, and what is reflected by twice that angle. That of both surfaces is mostly about one.
const WIDTH_OF_BODIES: f32 = 0.25;

// From 1 on, so that no glass is 0.
fn encode_rough_glass(glass: RoughGlass, primitive: u32, distance: f32) -> vec4u {
    let packed = pack2x16snorm(encode_octahedral(glass.normal));
    return vec4u(packed, bitcast<u32>(select(glass.alpha, -glass.alpha, glass.is_solid)), primitive + 1u, bitcast<u32>(distance));
}

fn decode_rough_glass(texel: vec4u) -> RoughGlass {
    let alpha = bitcast<f32>(texel.y);
    return RoughGlass(decode_octahedral(unpack2x16snorm(texel.x)), abs(alpha), alpha < 0.0);
}

fn passing_direction(glass: RoughGlass, to_eye: vec3f) -> vec3f {
    if !glass.is_solid {
        return -to_eye;
    }
    return refract(-to_eye, glass.normal, 1.0 / USUAL_IOR);
}

fn passing_width(glass: RoughGlass) -> f32 {
    return glass.alpha * select(1.0, WIDTH_OF_BODIES, glass.is_solid);
}
