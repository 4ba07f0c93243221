#define_import_path lightwell::lights

// Point, spot and directional lights, read radiometrically (KHR_lights_punctual), and lights with a surface as they are from
// far off; lib/area_lights.wgsl has their surfaces.

const DIRECTIONAL: u32 = 0u;
const POINT: u32 = 1u;
const SPOT: u32 = 2u;
const SUN: u32 = 3u;
const SPHERE: u32 = 4u;
const DISC: u32 = 5u;
const RECTANGLE: u32 = 6u;
const TUBE: u32 = 7u;

// Nothing brighter leaves a light: the largest irradiance [W/m²] that later sums can hold without overflow.
const MAX_IRRADIANCE: f32 = 1e30;

struct Light {
    position: vec3f,
    shape: u32,
    direction: vec3f,      // unit, the way that light travels along the axis
    range: f32,            // 0: no bound
    intensity: vec3f,      // E [W/m²] for directional lights and the sun, I [W/sr] for the others
    cone_scale: f32,       // spot: 1 / (cos inner − cos outer)
    axis: vec3f,           // unit, of a rectangle's width or a tube
    cone_offset: f32,      // spot: −cos outer · cone_scale
    size: vec2f,           // sun: sine and cosine of the half angle; radius; half width and height; half length and radius [m]
}

struct Incidence {
    to_light: vec3f,       // unit
    distance: f32,         // [m]; 0 for directional lights
    irradiance: vec3f,     // on a plane perpendicular to the light [W/m²]; of a light with a surface, over the density
    solid_angle: f32,      // one over the density of the direction [sr]; 0: there is no other
}

// Whether all its light comes from one direction, or nearly so.
fn is_distant(light: Light) -> bool {
    return light.shape == DIRECTIONAL || light.shape == SUN;
}

// Radiant intensity [W/sr] (directional: irradiance) in a unit direction seen from the light.
fn light_intensity_towards(light: Light, from_light: vec3f) -> vec3f {
    // glTF's quadratic smoothing between the inner and the outer cone.
    let t = saturate(dot(light.direction, from_light) * light.cone_scale + light.cone_offset);
    var share = select(1.0, t * t, light.shape == SPOT);
    // The area that a flat light or a tube shows to that direction.
    if light.shape == DISC || light.shape == RECTANGLE {
        share = saturate(dot(light.direction, from_light));
    }
    if light.shape == TUBE {
        share = length(cross(light.axis, from_light));
    }
    return light.intensity * share;
}

// KHR_lights_punctual's window: falls to zero at the range, with a smooth end.
fn range_window(light: Light, distance: f32) -> f32 {
    let ratio = distance / max(light.range, 1e-30);
    return select(1.0, saturate(1.0 - ratio * ratio * ratio * ratio), light.range > 0.0);
}

// What arrives at a point, before any shadow. Lights with a surface count as if they were far off.
fn light_incidence(light: Light, position: vec3f) -> Incidence {
    var incidence: Incidence;
    incidence.solid_angle = 0.0;
    if is_distant(light) {
        incidence.to_light = -light.direction;
        incidence.distance = 0.0;
        incidence.irradiance = min(light.intensity, vec3f(MAX_IRRADIANCE));
        return incidence;
    }
    let offset = light.position - position;
    let distance = length(offset);
    // At the light itself there is no direction; any will do, since the bound below applies.
    incidence.to_light = select(vec3f(0.0, 1.0, 0.0), offset / distance, distance > 1e-18);
    incidence.distance = distance;
    let intensity = light_intensity_towards(light, -incidence.to_light) * range_window(light, distance);
    // Divided twice by d, so that the square of a tiny distance cannot vanish.
    let d = max(distance, 1e-18);
    incidence.irradiance = min(min(intensity / d, vec3f(MAX_IRRADIANCE)) / d, vec3f(MAX_IRRADIANCE));
    return incidence;
}
