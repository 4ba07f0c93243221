#define_import_path lightwell::ray_scene

// The scene as rays see it: group 1 of all passes that cast rays (engine/src/render/rays/).
//
// Boxes, triangles and lights lie in storage textures of integers: four words come with one fetch, which on some
// adapters costs a quarter of the same words from a buffer, and half of a fetch from a sampled texture, which has levels.
// What a scene does not have is left out of the shader, since adapters that run both sides of a branch would pay for it
// at every step:
//   UNTEXTURED  no material has a texture
//   OPAQUE      no material's alpha is tested
//   DARK        no material emits light
//   GLASS       (the other way around) light passes a surface: see lib/glass.wgsl
//   DISPERSION  (the other way around) a solid body of glass parts colours
//   MOVERS      (the other way around) something moves
//   CLASSES     (the other way around) lists hold geometry that is not opaque apart from what is: in front in those of static
//               objects, with SPLIT, and among dynamic objects, with OTHER_MOVERS
//   LAYERED     (the other way around) a surface has more than the metallic-roughness base: see lib/layers.wgsl; and with it
//               COATS, SHEEN, FILMS and ANISOTROPY, as far as there are any
//   PLAIN       one set of texture coordinates as it is, no vertex colours, no textures but those of the base

#import lightwell::lights::Light

const NONE: u32 = 0xffffffffu;

struct Material {
    base_color: vec4f,
    emissive: vec3f,       // radiance [W/(m² sr)]
    metallic: f32,
    specular_color: vec3f,
    roughness: f32,
    specular: f32,
    alpha_cutoff: f32,     // below 0: alpha is ignored; BLENDED: the chance that a ray meets the surface
    normal_scale: f32,
    double_sided: u32,
    absorption: vec3f,     // of the inside [1/m]
    transmission: f32,     // of light that is neither reflected nor a metal's; 0: no glass
    ior: f32,              // of the inside, relative to air
    is_solid: u32,         // it bounds a body; else it is a thin wall
    dispersion: f32,       // 20 over its Abbe number
    pad: u32,
    sheen: vec4f,          // colour, roughness; the layers: lib/layers.wgsl
    iridescence: vec4f,    // share of the surface, index of refraction, least and most thickness [nm]
    clearcoat: vec3f,      // share of the surface, roughness, scale of its normal map
    anisotropy: vec3f,     // strength; cosine and sine of its turn from the tangent
    base_color_texture: vec4u,
    metallic_roughness_texture: vec4u,
    normal_texture: vec4u,
    emissive_texture: vec4u,
    specular_texture: vec4u,
    specular_color_texture: vec4u,
    transmission_texture: vec4u,
    clearcoat_texture: vec4u,
    clearcoat_roughness_texture: vec4u,
    clearcoat_normal_texture: vec4u,
    sheen_color_texture: vec4u,
    sheen_roughness_texture: vec4u,
    anisotropy_texture: vec4u,
    iridescence_texture: vec4u,
    iridescence_thickness_texture: vec4u,
    // Two rows for each texture, as in lib/mesh.wgsl.
    uv_rows: array<vec4f, 30>,
}

struct Emitter {
    cumulative: f32,       // chance that it or one before it is chosen
    density: f32,          // its chance over its area [1/m²]
    triangle: u32,
    pad: u32,
}

struct RayLight {
    light: Light,
    casts_shadow: u32,
    indirect: u32,
}

// Boxes in the order in which a ray meets them, one texel a box, so that a ray needs no stack (Smits 1998, "Efficiency
// issues for ray tracing"): after a box that it meets comes the next one, after one that it misses the one that the
// link names. There is a list for each of the eight signs of a direction, near children before far ones. Words:
// corners in 16 bits each, in units of the frame (x, y, z of the lower, then of the upper corner), and the link: the texel of
// the next box that does not lie in this one; or for a leaf its first triangle, below LEAF and their number less one.
// One box more lies behind all lists, so that there is always one behind the box that a ray is at.
// Two texels come first: the frame's origin and the boxes of a list; the frame's unit and the place of a second part.
// What moves is such a part, with a frame, lists and triangles of its own: a ray that is through with what is static goes
// on with what moves, as far as it still reaches.
//   EXACT_BOXES  instead: lower corner and link, upper corner and an unused word; places count boxes
//   WIDE         instead: nodes of eight children, see lib/wide_nodes.wgsl
#ifdef WIDE
@group(1) @binding(0) var<storage, read> nodes: array<vec4u>;
#else
@group(1) @binding(0) var nodes: texture_storage_2d<rgba32uint, read>;
#endif
// Three texels a triangle: a corner in world space [m], and a word: material and flags; emitter or NONE; primitive.
@group(1) @binding(1) var triangles: texture_storage_2d<rgba32uint, read>;
// Three texels a triangle, one a corner: normal (octahedral), u, v, tangent (octahedral, sign of the bitangent).
@group(1) @binding(2) var attributes: texture_storage_2d<rgba32uint, read>;
@group(1) @binding(3) var<storage, read> materials: array<Material>;
@group(1) @binding(4) var<storage, read> emitters: array<Emitter>;
// Five texels a light.
@group(1) @binding(5) var lights: texture_storage_2d<rgba32uint, read>;
@group(1) @binding(6) var atlas: texture_2d_array<f32>;
#ifdef GLASS
struct GlassBox {
    low: vec3f,            // [m]
    high: vec3f,
}
// Around all that is of glass.
@group(1) @binding(9) var<uniform> glass_box: GlassBox;
#endif
#ifndef PLAIN
// Three texels a triangle, one a corner: second u, v, colour and alpha of 16 bits each. Sampled, since four storage
// textures are what every adapter has for a shader.
@group(1) @binding(7) var extras: texture_2d<u32>;
#endif

const LEAF: u32 = 0x80000000u;
const COUNT_BITS: u32 = 29u;
const FIRST_MASK: u32 = 0x1fffffffu;

const MATERIAL_MASK: u32 = 0x0fffffffu;
const OF_GLASS: u32 = 0x10000000u;
const CASTS_SHADOW: u32 = 0x20000000u;
const DOUBLE_SIDED: u32 = 0x40000000u;
const ALPHA_TESTED: u32 = 0x80000000u;

struct Triangle {
    corner_a: vec3f,       // world space [m], counter-clockwise seen from outside
    corner_b: vec3f,
    corner_c: vec3f,
    material: u32,
    flags: u32,
    emitter: u32,          // or NONE
}

// Three rows hold the first, second and third texels of 4096 triangles.
fn triangle_texel(index: u32) -> vec2u {
    return vec2u(index & 4095u, 3u * (index >> 12u));
}

fn load_triangle(index: u32) -> Triangle {
    let at = triangle_texel(index);
    let a = textureLoad(triangles, at);
    let b = textureLoad(triangles, at + vec2u(0u, 1u));
    let c = textureLoad(triangles, at + vec2u(0u, 2u));
    return Triangle(bitcast<vec3f>(a.xyz), bitcast<vec3f>(b.xyz), bitcast<vec3f>(c.xyz), a.w & MATERIAL_MASK, a.w, b.w);
}

// The primitive of the scene that a triangle is of.
fn primitive_of(index: u32) -> u32 {
    return textureLoad(triangles, triangle_texel(index) + vec2u(0u, 2u)).w;
}

// Where a box lies, or a texel of a light.
fn box_texel(index: u32) -> vec2u {
    return vec2u(index & 4095u, index >> 12u);
}

// Four words of the hierarchies.
fn load_node(texel: u32) -> vec4u {
#ifdef WIDE
    return nodes[texel];
#else
    return textureLoad(nodes, box_texel(texel));
#endif
}

// As rays/lights.rs writes it.
fn load_light(index: u32) -> RayLight {
    let a = textureLoad(lights, box_texel(5u * index));
    let b = textureLoad(lights, box_texel(5u * index + 1u));
    let c = textureLoad(lights, box_texel(5u * index + 2u));
    let d = textureLoad(lights, box_texel(5u * index + 3u));
    let e = textureLoad(lights, box_texel(5u * index + 4u));
    var light: Light;
    light.position = bitcast<vec3f>(a.xyz);
    light.shape = a.w;
    light.direction = bitcast<vec3f>(b.xyz);
    light.range = bitcast<f32>(b.w);
    light.intensity = bitcast<vec3f>(c.xyz);
    light.cone_scale = bitcast<f32>(c.w);
    light.axis = bitcast<vec3f>(d.xyz);
    light.cone_offset = bitcast<f32>(d.w);
    light.size = bitcast<vec2f>(e.xy);
    return RayLight(light, e.z, e.w);
}
