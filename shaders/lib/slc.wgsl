#define_import_path lightwell::slc

// Stochastic light culling (Tokuyoshi and Harada 2016, 2017): virtual lights, how brightly they shine, and how far
// they reach. The same functions on the host: engine/src/render/indirect/light_culling/lobe.rs.

#import lightwell::brdf::{PI, distribution_ggx, visibility_smith, fresnel_schlick}
#import lightwell::view::View

// A texel of a reflective shadow map as a point light with the reflection of its surface.
struct VirtualLight {
    position: vec3f,       // world [m]
    spread: f32,           // area of its surface over π [m²]
    to_light: vec3f,       // ω_i, unit, towards the light that it reflects
    alpha: f32,            // GGX α = roughness²
    normal: vec3f,         // unit
    grazing_reflectance: f32, // F90
    flux: vec3f,           // received, Φ [W]; zero: there is no light
    area: f32,             // of its surface [m²]
    albedo: vec3f,         // diffuse reflectance ρ
    pad_albedo: f32,
    normal_reflectance: vec3f, // F0
    pad_reflectance: f32,
}

// What holds all points that may accept a light. A radius below 0: there are none.
struct LightRange {
    diffuse_center: vec3f, // world [m]
    diffuse_radius: f32,   // [m]
    specular_center: vec3f,
    specular_radius: f32,  // across the axis [m]
    axis: vec3f,           // unit
    squeeze: f32,          // semi-axis across over the one along the axis, at most 1
    xi: f32,               // ξ in (0, 1)
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

// What shading reads of a light: texels of an image with a layer each, since that is several times as fast as buffers on
// software drivers and no slower elsewhere. Light i is at (i mod LIGHTS_A_ROW, i / LIGHTS_A_ROW).
const LIGHTS_A_ROW: u32 = 4096u;
const PLACE: u32 = 0u;     // position [m]; spread [m²], negative if the reflection depends on the angle
const SHAPE: u32 = 1u;     // normal; reach of the diffuse lobe along it, squared: I/(δ·ξ) [m²]
const COLOR: u32 = 2u;     // diffuse intensity along the normal [W/sr]; brightest channel of F0
const INCIDENCE: u32 = 3u; // ω_i, octahedral; F90; α
const NORMAL_FLUX: u32 = 4u;  // Φ·F0 [W]; ξ
const GRAZING_FLUX: u32 = 5u; // Φ·F90 [W]
const SPHEROID: u32 = 6u;  // centre [m] and radius across [m] of the specular range
const AXIS: u32 = 7u;      // its axis; squeeze

// All settings of the passes, in one block. Where there are several, or where branches hang on more than three values of
// uniforms, Mesa's software driver (22.3) makes a shader anew in every frame, and keeps all.
struct Culling {
    view: View,
    lights: u32,           // of a subset
    interleave: u32,       // subsets along an edge
    words: u32,            // of a mask: 32 lights each
    tiles: vec2u,          // of 16 × 16 pixels in the image of a subset
    seed: u32,
    root: u32,             // of the ray hierarchy
    filter_radius: u32,    // [pixels]
    show: u32,
    first_subset: u32,     // of this dispatch
    sky: vec3f,            // radiance, of a map the mean [W/(m² sr)]
    sky_rays: u32,         // of a pixel
    sky_turn: f32,         // of the sky's map [rad]
}

// Slices of depth in a tile, as engine/src/render/indirect/light_culling/mod.rs has them.
#ifdef SLICES
const SLICES: u32 = #{SLICES}u;
#else
const SLICES: u32 = 2u;
#endif

// Words of a mask with its summaries: for every 32 words another, whose bits tell which of them are not zero.
fn mask_stride(words: u32) -> u32 {
    return words + (words + 31u) / 32u;
}

const ELLIPSOID: u32 = 0u;
const CENTRED_SPHERE: u32 = 1u;
const ENCLOSING_SPHERE: u32 = 2u;

const DIFFUSE_LOBE: u32 = 0u;
const SPECULAR_LOBE: u32 = 1u;

// Rounding must not cull: ranges are larger by this share, and by that of the coordinates.
const RANGE_MARGIN: f32 = 1.001;
const COORDINATE_MARGIN: f32 = 1e-6;

fn brightest(c: vec3f) -> f32 {
    return max(c.r, max(c.g, c.b));
}

// Schlick's weight (1 − ω_i·h)⁵ of F90 against F0, where ω_i·h = ½|ω_i + ω|.
fn grazing_weight(to_light: vec3f, direction: vec3f) -> f32 {
    let half_sum = to_light + direction;
    let m = saturate(1.0 - 0.5 * sqrt(dot(half_sum, half_sum)));
    let m_squared = m * m;
    return m_squared * m_squared * m;
}

// Share of the light that the specular reflection leaves to the diffuse one, 1 − max F; F0 by its brightest channel.
fn diffuse_share(normal_reflectance: f32, grazing_reflectance: f32, weight: f32) -> f32 {
    return 1.0 - mix(normal_reflectance, grazing_reflectance, weight);
}

// D·V·cosθ of the specular lobe in a unit direction.
fn specular_factor(normal: vec3f, to_light: vec3f, alpha: f32, direction: vec3f, cosine: f32) -> f32 {
    let half_sum = to_light + direction;
    let h = half_sum * inverseSqrt(max(dot(half_sum, half_sum), 1e-12));
    return distribution_ggx(normal, h, alpha) * visibility_smith(dot(normal, to_light), cosine, alpha) * cosine;
}

// Radiant intensity [W/sr] of a lobe in a unit direction: Φ·f(ω_i, ω)·max(0, n·ω).
fn lobe_intensity(light: VirtualLight, lobe: u32, direction: vec3f) -> vec3f {
    let cosine = dot(light.normal, direction);
    let incident = dot(light.normal, light.to_light);
    if cosine <= 0.0 || incident <= 0.0 {
        return vec3f(0.0);
    }
    let weight = grazing_weight(light.to_light, direction);
    if lobe == DIFFUSE_LOBE {
        let share = diffuse_share(brightest(light.normal_reflectance), light.grazing_reflectance, weight);
        return light.flux * light.albedo * (share * cosine / PI);
    }
    let f = mix(light.normal_reflectance, vec3f(light.grazing_reflectance), weight);
    return light.flux * f * specular_factor(light.normal, light.to_light, light.alpha, direction, cosine);
}

// Chance that a light is accepted: p = min(I/(δ·l²), 1). l² counts the light as a small disc rather than a point,
// l² + A/π (form factor of a disc), so that no light is brighter than the surface that it stands for.
fn acceptance(intensity: vec3f, delta: f32, distance_squared: f32) -> f32 {
    return min(brightest(intensity) / delta / distance_squared, 1.0);
}

// Radius of the sphere l² = I/(δ·ξ) [m].
fn reach(intensity: f32, delta: f32, xi: f32) -> f32 {
    return sqrt(clamp(intensity / delta / xi, 0.0, 1e30));
}

fn with_margin(radius: f32, center: vec3f) -> f32 {
    let c = abs(center);
    return radius * RANGE_MARGIN + COORDINATE_MARGIN * max(c.x, max(c.y, c.z));
}

// Sphere around all points with p > ξ of the diffuse lobe: l = R·√cosθ lies in the sphere of radius (4/27)^¼·R around
// q + (1/3)^¾·R·n.
fn diffuse_range(light: VirtualLight, delta: f32, xi: f32, bounds: u32) -> vec4f {
    let least = min(brightest(light.normal_reflectance), light.grazing_reflectance);
    let intensity = brightest(light.flux * light.albedo) * (1.0 - least) / PI;
    if !(intensity > 0.0) {
        return vec4f(light.position, -1.0);
    }
    let r = reach(intensity, delta, xi);
    if bounds == CENTRED_SPHERE {
        return vec4f(light.position, with_margin(r, light.position));
    }
    let center = light.position + light.normal * (0.438691338 * r);
    return vec4f(center, with_margin(0.620403240 * r, light.position));
}

// Semi-axis r of the spheroid of the specular lobe: √(Φ·F_max·G₁/(4π·δ·ξ·|ω_i·n|)), with |ω_i·n| cancelled:
// G₁/c = 2/(c + √((1 − α²)c² + α²)). F_max is Schlick's term where ω lies on the horizon opposite of ω_i.
fn specular_semi_axis(light: VirtualLight, delta: f32, xi: f32) -> f32 {
    let c = clamp(dot(light.normal, light.to_light), 0.0, 1.0);
    let a_squared = light.alpha * light.alpha;
    let masking = 2.0 / (c + sqrt((1.0 - a_squared) * c * c + a_squared));
    let sine = sqrt(max(0.0, 1.0 - c * c));
    let f = fresnel_schlick(light.normal_reflectance, light.grazing_reflectance, sqrt(max(0.0, 0.5 * (1.0 - sine))));
    return reach(brightest(light.flux * f) * masking / (4.0 * PI), delta, xi);
}

// The spheroid with semi-axes r·((1 + α²)/(2α), 1, 1) whose focus is the light, along the mirror direction.
fn light_range(light: VirtualLight, delta: f32, xi: f32, bounds: u32) -> LightRange {
    var range: LightRange;
    range.xi = xi;
    range.axis = vec3f(0.0, 1.0, 0.0);
    range.squeeze = 1.0;
    range.diffuse_radius = -1.0;
    range.specular_radius = -1.0;
    if all(light.flux <= vec3f(0.0)) || dot(light.normal, light.to_light) <= 0.0 {
        return range;
    }
    let diffuse = diffuse_range(light, delta, xi, bounds);
    range.diffuse_center = diffuse.xyz;
    range.diffuse_radius = diffuse.w;
    let r = specular_semi_axis(light, delta, xi);
    if !(r > 0.0) {
        return range;
    }
    let mirror = normalize(reflect(-light.to_light, light.normal));
    let a_squared = light.alpha * light.alpha;
    let long = r * (1.0 + a_squared) / (2.0 * light.alpha);
    let center = light.position + mirror * (r * (1.0 - a_squared) / (2.0 * light.alpha));
    if bounds == CENTRED_SPHERE {
        range.specular_center = light.position;
        range.specular_radius = with_margin(r / light.alpha, light.position);
    } else if bounds == ENCLOSING_SPHERE {
        range.specular_center = center;
        range.specular_radius = with_margin(long, center);
    } else {
        range.specular_center = center;
        range.specular_radius = with_margin(r, center);
        range.axis = mirror;
        range.squeeze = r / long;
    }
    return range;
}

// The matrix that turns the spheroid into a sphere of its radius across: squeezes along the axis.
fn squeezed(v: vec3f, axis: vec3f, squeeze: f32) -> vec3f {
    return v + axis * ((squeeze - 1.0) * dot(axis, v));
}

// The space in which a tile is tested against a bound: rows of B·S (eqs. 16 and 17 of 2017), where S squeezes the spheroid
// along its axis into a sphere of its radius across, and B turns. Products of them with an offset from the bound's centre
// are its coordinates there. The paper makes the sphere one of radius 1; metres keep margins simple.
struct TestFrame {
    right: vec3f,
    up: vec3f,
    forward: vec3f,
}

// B·S from the axes of B, unit and in the squeezed space. S is symmetric: S·v on an axis is v on S times that axis.
fn test_frame(right: vec3f, up: vec3f, forward: vec3f, axis: vec3f, squeeze: f32) -> TestFrame {
    return TestFrame(squeezed(right, axis, squeeze), squeezed(up, axis, squeeze), squeezed(forward, axis, squeeze));
}

// The view's own axes: two in the planes of equal depth, and the one across them.
fn view_frame(view: View) -> TestFrame {
    let c = view.clip_from_world;
    let forward = normalize(view.axis.xyz);
    // Lenses that are off the middle, and shifted grids of pixels, shear the row.
    let row = vec3f(c[0].x, c[1].x, c[2].x);
    let right = normalize(row - forward * dot(row, forward));
    return TestFrame(right, cross(right, forward), forward);
}

// B·S of eq. 17: B turns the space so that the planes of equal depth, which S tilts, are perpendicular to an axis again.
fn depth_frame(view: TestFrame, axis: vec3f, squeeze: f32) -> TestFrame {
    let x = squeezed(view.right, axis, squeeze);
    let y = squeezed(view.up, axis, squeeze);
    let z = cross(x, y);
    let forward = normalize(z);
    if dot(x, x) > dot(y, y) {
        let right = normalize(x);
        return test_frame(right, cross(forward, right), forward, axis, squeeze);
    }
    let up = normalize(y);
    return test_frame(cross(up, forward), up, forward, axis, squeeze);
}
