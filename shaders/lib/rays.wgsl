#define_import_path lightwell::rays

// The scene as rays see it: group 1 of all passes that cast rays (engine/src/render/rays/).
//
// Boxes, triangles and lights lie in storage textures of integers: four words come with one fetch, which on some
// adapters costs a quarter of the same words from a buffer, and half of a fetch from a sampled texture, which has levels.
// What a scene does not have is left out of the shader, since adapters that run both sides of a branch would pay for it
// at every step:
//   UNTEXTURED  no material has a texture
//   OPAQUE      no material's alpha is tested
//   DARK        no material emits light
//   MOVERS      (the other way around) something moves
//   PLAIN       one set of texture coordinates as it is, no vertex colours, no textures of KHR_materials_specular

#import lightwell::gbuffer::decode_octahedral
#import lightwell::lights::Light
#import lightwell::mesh::{normalize_or_zero, emission_color, BLENDED}
#import lightwell::sampling::hash_pair

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
    base_color_texture: vec4u,
    metallic_roughness_texture: vec4u,
    normal_texture: vec4u,
    emissive_texture: vec4u,
    specular_texture: vec4u,
    specular_color_texture: vec4u,
    // Two rows for each texture, as in lib/mesh.wgsl.
    uv_rows: array<vec4f, 12>,
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
@group(1) @binding(0) var nodes: texture_storage_2d<rgba32uint, read>;
// Three texels a triangle: a corner in world space [m], and a word: material and flags; emitter or NONE; primitive.
@group(1) @binding(1) var triangles: texture_storage_2d<rgba32uint, read>;
// Three texels a triangle, one a corner: normal (octahedral), u, v, tangent (octahedral, sign of the bitangent).
@group(1) @binding(2) var attributes: texture_storage_2d<rgba32uint, read>;
@group(1) @binding(3) var<storage, read> materials: array<Material>;
@group(1) @binding(4) var<storage, read> emitters: array<Emitter>;
// Five texels a light.
@group(1) @binding(5) var lights: texture_storage_2d<rgba32uint, read>;
@group(1) @binding(6) var atlas: texture_2d_array<f32>;
#ifndef PLAIN
// Three texels a triangle, one a corner: second u, v, colour and alpha of 16 bits each. Sampled, since four storage
// textures are what every adapter has for a shader.
@group(1) @binding(7) var extras: texture_2d<u32>;
#endif

const LEAF: u32 = 0x80000000u;
const COUNT_BITS: u32 = 29u;
const FIRST_MASK: u32 = 0x1fffffffu;

const MATERIAL_MASK: u32 = 0x1fffffffu;
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

// ---- Textures ----

fn srgb_decode(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn wrapped(texel: i32, size: i32, wrap: u32) -> i32 {
    switch wrap {
        case 0u: { return ((texel % size) + size) % size; }
        case 1u: {
            let period = 2 * size;
            let t = ((texel % period) + period) % period;
            return select(period - 1 - t, t, t < size);
        }
        default: { return clamp(texel, 0, size - 1); }
    }
}

fn texel_at(slot: vec4u, at: vec2i) -> vec4f {
    let size = vec2i(vec2u(slot.y & 0xffffu, slot.y >> 16u));
    let flags = slot.z >> 16u;
    let x = wrapped(at.x, size.x, (flags >> 2u) & 3u) + i32(slot.x & 0xffffu);
    let y = wrapped(at.y, size.y, (flags >> 4u) & 3u) + i32(slot.x >> 16u);
    let texel = textureLoad(atlas, vec2i(x, y), i32(slot.z & 0xffffu), 0);
    return select(texel, vec4f(srgb_decode(texel.rgb), texel.a), (flags & 1u) != 0u);
}

// The texture at full resolution, with its own filter and wrapping.
fn sample_texture(slot: vec4u, uv: vec2f, neutral: vec4f) -> vec4f {
#ifdef UNTEXTURED
    return neutral;
#else
    if slot.w == 0u {
        return neutral;
    }
    // Beyond 10⁴ repeats a float cannot tell the texels apart.
    let bounded = select(vec2f(0.0), clamp(uv, vec2f(-1e4), vec2f(1e4)), abs(uv) < vec2f(1e30));
    let at = bounded * vec2f(vec2u(slot.y & 0xffffu, slot.y >> 16u));
    if ((slot.z >> 17u) & 1u) != 0u {
        return texel_at(slot, vec2i(floor(at)));
    }
    let corner = floor(at - 0.5);
    let f = at - 0.5 - corner;
    let low = vec2i(corner);
    let top = mix(texel_at(slot, low), texel_at(slot, low + vec2i(1, 0)), f.x);
    let bottom = mix(texel_at(slot, low + vec2i(0, 1)), texel_at(slot, low + vec2i(1, 1)), f.x);
    return mix(top, bottom, f.y);
#endif
}

// ---- Traversal ----

// What a ray is for.
const CAMERA: u32 = 0u;    // nearest surface, backs of single-sided ones left out
const LIGHT: u32 = 1u;     // nearest surface that casts shadows, from both sides
const SHADOW: u32 = 2u;    // any surface that casts shadows; which one is not said

struct Ray {
    origin: vec3f,
    direction: vec3f,      // of any length; distances are in its units
}

struct Hit {
    t: f32,
    triangle: u32,         // NONE: nothing was met
    barycentric: vec2f,    // of the second and third corner
}

fn inverse_direction(d: vec3f) -> vec3f {
    // No component is zero, so that no 0·∞ arises.
    return select(select(vec3f(1e20), vec3f(-1e20), d < vec3f(0.0)), 1.0 / d, abs(d) > vec3f(1e-20));
}

// Where the boxes lie.
struct Frame {
    origin: vec3f,
    unit: vec3f,
    boxes: u32,            // of a list
    movers: u32,           // where those of dynamic objects begin; 0: nothing does
}

// `boxes` is the number of boxes of a list of static objects, which the host knows.
fn load_frame(boxes: u32) -> Frame {
    let second = textureLoad(nodes, vec2u(1u, 0u));
#ifdef EXACT_BOXES
    return Frame(vec3f(0.0), vec3f(1.0), boxes, second.w);
#else
    let origin = bitcast<vec3f>(textureLoad(nodes, vec2u(0u, 0u)).xyz);
    return Frame(origin, bitcast<vec3f>(second.xyz), boxes, second.w);
#endif
}

// A ray on its way along its list of boxes, which lie at box·scale + offset along it.
struct Walk {
    ray: Ray,
    scale: vec3f,
    offset: vec3f,
    next: u32,             // box to be looked at
    end: u32,              // of the list
#ifdef MOVERS
    movers: u32,           // where those of dynamic objects begin, if they are still to be looked at; else 0
#endif
    kind: u32,
    hit: Hit,              // so far
}

struct Box {
    low: vec3f,
    high: vec3f,
    link: u32,
}

fn box_texel(index: u32) -> vec2u {
    return vec2u(index & 4095u, index >> 12u);
}

// A ray at its start; one without reach is over already.
fn begin_walk(frame: Frame, ray: Ray, reach: f32, kind: u32) -> Walk {
    let inverse = inverse_direction(ray.direction);
    let first = HEADER + octant(ray.direction) * frame.boxes;
    let end = first + frame.boxes;
    let next = select(end, first, reach > 0.0);
    let hit = Hit(reach, NONE, vec2f(0.0));
#ifdef EXACT_BOXES
    let scale = inverse;
    let offset = ray.origin;
#else
    let scale = frame.unit * inverse;
    let offset = (frame.origin - ray.origin) * inverse;
#endif
#ifdef MOVERS
    return Walk(ray, scale, offset, next, end, frame.movers, kind, hit);
#else
    return Walk(ray, scale, offset, next, end, kind, hit);
#endif
}

// Which of the eight lists is that of a direction.
fn octant(direction: vec3f) -> u32 {
    let negative = vec3u(direction < vec3f(0.0));
    return negative.x + 2u * negative.y + 4u * negative.z;
}

#ifdef MOVERS
// The list of dynamic objects, after that of static objects.
fn go_on_with_movers(walk: ptr<function, Walk>) {
    let place = (*walk).movers;
#ifdef EXACT_BOXES
    let boxes = textureLoad(nodes, box_texel(2u * place)).w;
#else
    let header = textureLoad(nodes, box_texel(place));
    let boxes = header.w;
    let unit = bitcast<vec3f>(textureLoad(nodes, box_texel(place + 1u)).xyz);
    let inverse = inverse_direction((*walk).ray.direction);
    (*walk).scale = unit * inverse;
    (*walk).offset = (bitcast<vec3f>(header.xyz) - (*walk).ray.origin) * inverse;
#endif
    (*walk).next = place + HEADER + octant((*walk).ray.direction) * boxes;
    (*walk).end = (*walk).next + boxes;
    (*walk).movers = 0u;
}
#endif

// Boxes that the two texels before the lists take.
#ifdef EXACT_BOXES
const HEADER: u32 = 1u;
#else
const HEADER: u32 = 2u;
#endif

fn load_box(index: u32) -> Box {
#ifdef EXACT_BOXES
    let low = textureLoad(nodes, box_texel(2u * index));
    let high = textureLoad(nodes, box_texel(2u * index + 1u));
    return Box(bitcast<vec3f>(low.xyz), bitcast<vec3f>(high.xyz), low.w);
#else
    let words = textureLoad(nodes, box_texel(index));
    // Signed, since that is one instruction on adapters that convert unsigned numbers in six.
    let low = vec3i(vec3u(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu));
    let high = vec3i(vec3u(words.y >> 16u, words.z & 0xffffu, words.z >> 16u));
    return Box(vec3f(low), vec3f(high), words.w);
#endif
}

// Whether the ray meets the box before t_max.
//
// Floats that are not negative are ordered as their bits are, and what is negative stays so: whole numbers will do,
// whose minimum is one instruction where that of floats has to look out for NaN.
fn meets_box(box: Box, walk: Walk) -> bool {
#ifdef EXACT_BOXES
    let a = bitcast<vec3i>((box.low - walk.offset) * walk.scale);
    let b = bitcast<vec3i>((box.high - walk.offset) * walk.scale);
#else
    let a = bitcast<vec3i>(box.low * walk.scale + walk.offset);
    let b = bitcast<vec3i>(box.high * walk.scale + walk.offset);
#endif
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0));
    let leave = min(min(far.x, far.y), min(far.z, bitcast<i32>(walk.hit.t)));
    // Four roundings further, so that no box is missed that holds a hit (Ize 2013).
    return enter <= leave + 4;
}

fn interpolated_uv(triangle: u32, barycentric: vec2f) -> vec2f {
    let at = triangle_texel(triangle);
    let a = bitcast<vec2f>(textureLoad(attributes, at).yz);
    let b = bitcast<vec2f>(textureLoad(attributes, at + vec2u(0u, 1u)).yz);
    let c = bitcast<vec2f>(textureLoad(attributes, at + vec2u(0u, 2u)).yz);
    return (1.0 - barycentric.x - barycentric.y) * a + barycentric.x * b + barycentric.y * c;
}

// Both sets of texture coordinates, and the vertex colour.
struct Coordinates {
    uv: vec2f,
    second_uv: vec2f,
    color: vec4f,
}

fn coordinates(triangle: u32, barycentric: vec2f) -> Coordinates {
    let uv = interpolated_uv(triangle, barycentric);
#ifdef PLAIN
    return Coordinates(uv, uv, vec4f(1.0));
#else
    let at = triangle_texel(triangle);
    let a = textureLoad(extras, at, 0);
    let b = textureLoad(extras, at + vec2u(0u, 1u), 0);
    let c = textureLoad(extras, at + vec2u(0u, 2u), 0);
    let w = 1.0 - barycentric.x - barycentric.y;
    return Coordinates(
        uv,
        w * bitcast<vec2f>(a.xy) + barycentric.x * bitcast<vec2f>(b.xy) + barycentric.y * bitcast<vec2f>(c.xy),
        w * vertex_color(a.zw) + barycentric.x * vertex_color(b.zw) + barycentric.y * vertex_color(c.zw),
    );
#endif
}

fn vertex_color(words: vec2u) -> vec4f {
    return vec4f(unpack2x16unorm(words.x), unpack2x16unorm(words.y));
}

// Where the texture of a use (0: base colour, 1: metallic-roughness, …) is sampled.
fn uv_of_use(material: u32, index: u32, at: Coordinates) -> vec2f {
#ifdef PLAIN
    return at.uv;
#else
    let row_u = materials[material].uv_rows[2u * index];
    let row_v = materials[material].uv_rows[2u * index + 1u];
    let uv = select(at.uv, at.second_uv, row_u.w != 0.0);
    return vec2f(dot(row_u.xy, uv) + row_u.z, dot(row_v.xy, uv) + row_v.z);
#endif
}

// Alpha of a point.
fn alpha_at(triangle: u32, material: u32, barycentric: vec2f) -> f32 {
    let at = coordinates(triangle, barycentric);
    let texel = sample_texture(materials[material].base_color_texture, uv_of_use(material, 0u, at), vec4f(1.0));
    return materials[material].base_color.a * at.color.a * texel.a;
}

// Share of the rays that meet a point of a surface: alpha where it is blended.
fn coverage(triangle: u32, material: u32, barycentric: vec2f) -> f32 {
#ifdef OPAQUE
    return 1.0;
#else
    if materials[material].alpha_cutoff < BLENDED {
        return 1.0;
    }
    return saturate(alpha_at(triangle, material, barycentric));
#endif
}

// A number in [0, 1) for a ray and a point of a triangle: of all rays through a blended surface the share 1 − alpha
// passes (stochastic transparency, Enderton et al. 2010), which is the mean that blending computes. Triangles are told
// apart by the point: their numbers follow the hierarchy, which depends on the frames before.
fn pass_chance(ray: Ray, barycentric: vec2f) -> f32 {
    let o = bitcast<vec3u>(ray.origin);
    let d = bitcast<vec3u>(ray.direction);
    let a = hash_pair(o.x ^ (o.y * 0x9e3779b9u), o.z ^ (d.x * 0x85ebca6bu));
    let at = bitcast<vec2u>(barycentric);
    let b = hash_pair(d.y ^ (d.z * 0xc2b2ae35u), hash_pair(at.x, at.y));
    return f32((hash_pair(a, b)) >> 8u) * 0x1p-24f;
}

fn is_transparent(triangle: u32, material: u32, barycentric: vec2f, ray: Ray) -> bool {
    let alpha = alpha_at(triangle, material, barycentric);
    let cutoff = materials[material].alpha_cutoff;
    if cutoff >= BLENDED {
        return alpha <= pass_chance(ray, barycentric);
    }
    return alpha < cutoff;
}

// Emitted radiance of a point of a triangle [W/(m² sr)].
fn emitted_at(triangle: u32, material: u32, barycentric: vec2f) -> vec3f {
    let at = coordinates(triangle, barycentric);
    let texel = sample_texture(materials[material].emissive_texture, uv_of_use(material, 3u, at), vec4f(1.0)).rgb;
    return materials[material].emissive * emission_color(materials[material].uv_rows[7], at.color) * texel;
}

// Möller and Trumbore 1997, without any tolerance: the hit so far, or a nearer one with this triangle.
fn meet_triangle(index: u32, ray: Ray, hit: Hit, is_camera: bool) -> Hit {
    let triangle = load_triangle(index);
    let edge_b = triangle.corner_b - triangle.corner_a;
    let edge_c = triangle.corner_c - triangle.corner_a;
    let p = cross(ray.direction, edge_c);
    let determinant = dot(edge_b, p);
    let r = 1.0 / determinant;
    let s = ray.origin - triangle.corner_a;
    let u = dot(s, p) * r;
    let q = cross(s, edge_b);
    let v = dot(ray.direction, q) * r;
    let t = dot(edge_c, q) * r;
    // Seen from the front the determinant is positive.
    let counts = select(
        (triangle.flags & CASTS_SHADOW) != 0u,
        determinant > 0.0 || (triangle.flags & DOUBLE_SIDED) != 0u,
        is_camera,
    );
    // Where two triangles are met at the same distance, the point on them says which counts: their order depends on the
    // frames before, and on which of them moves.
    let is_tie_won = t == hit.t && hit.triangle != NONE
        && (u < hit.barycentric.x || (u == hit.barycentric.x && v < hit.barycentric.y));
    var met = counts && determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
        && (t < hit.t || is_tie_won);
#ifndef OPAQUE
    if met && (triangle.flags & ALPHA_TESTED) != 0u {
        met = !is_transparent(index, triangle.material, vec2f(u, v), ray);
    }
#endif
    if met {
        return Hit(t, index, vec2f(u, v));
    }
    return hit;
}

fn is_over(walk: Walk) -> bool {
    return walk.next >= walk.end;
}

// Looks at boxes until there are two leaves or more, or nothing is left, and then into the leaves: adapters that run
// lanes in lockstep let no lane look into one while others search (Aila and Laine 2009, "Understanding the efficiency
// of ray traversal on GPUs"). The walk must not be over.
fn go_on(walk: ptr<function, Walk>) {
    // Leaves whose boxes are met: one of earlier boxes, and those of the last two boxes.
    var leaf = 0u;
    var box_leaf = 0u;
    var after_leaf = 0u;
    loop {
        // The box behind is the next one of most rays, and both at once take not much longer than one: most of the
        // time goes into waiting, for memory and for one result after another. What lies behind the list's end leads
        // nowhere or is met in vain.
        let box = load_box((*walk).next);
        let after = load_box((*walk).next + 1u);
        let is_leaf = box.link >= LEAF;
        let is_after_leaf = after.link >= LEAF;
        let is_met = meets_box(box, *walk);
        let is_after_met = meets_box(after, *walk);
        let reaches_after = is_met || is_leaf;
        leaf |= box_leaf | after_leaf;
        box_leaf = select(0u, box.link, is_met && is_leaf);
        after_leaf = select(0u, after.link, reaches_after && is_after_met && is_after_leaf);
        let after_next = select(after.link, (*walk).next + 2u, is_after_met || is_after_leaf);
        (*walk).next = select(box.link, after_next, reaches_after);
        continuing {
            let leaves = u32(leaf != 0u) + u32(box_leaf != 0u) + u32(after_leaf != 0u);
            break if leaves >= 2u || (*walk).next >= (*walk).end;
        }
    }
    while (leaf | box_leaf | after_leaf) != 0u {
        if leaf == 0u {
            leaf = select(after_leaf, box_leaf, box_leaf != 0u);
            after_leaf = select(0u, after_leaf, box_leaf != 0u);
            box_leaf = 0u;
        }
        (*walk).hit = meet_triangle(leaf & FIRST_MASK, (*walk).ray, (*walk).hit, (*walk).kind == CAMERA);
        // The leaf without this triangle.
        leaf = select(leaf + 1u - (1u << COUNT_BITS), 0u, ((leaf >> COUNT_BITS) & 3u) == 0u);
    }
    if (*walk).kind == SHADOW && (*walk).hit.triangle != NONE {
        (*walk).next = (*walk).end;
    }
#ifdef MOVERS
    else if (*walk).next >= (*walk).end && (*walk).movers != 0u {
        go_on_with_movers(walk);
    }
#endif
}

fn trace(boxes: u32, ray: Ray, t_max: f32, kind: u32) -> Hit {
    var walk = begin_walk(load_frame(boxes), ray, t_max, kind);
    while !is_over(walk) {
        go_on(&walk);
    }
    return walk.hit;
}

// ---- Surfaces ----

struct Surface {
    position: vec3f,       // world [m]
    geometric_normal: vec3f, // unit, on the side that the ray came from
    normal: vec3f,         // for shading: interpolated and bent by the normal map, unit
    albedo: vec3f,         // diffuse reflectance
    normal_reflectance: vec3f, // F0
    grazing_reflectance: f32,  // F90
    alpha: f32,            // GGX α = roughness²
    emissive: vec3f,       // radiance towards the ray [W/(m² sr)]
    error: f32,            // how far rounding may have moved the position [m]
    emitter: u32,          // or NONE
    visible: bool,         // false: the back of a single-sided surface
}

// As `encode_direction` of rays/geometry.rs; zero for no direction.
fn decode_direction(code: u32) -> vec3f {
    if code == 0u {
        return vec3f(0.0);
    }
    return decode_octahedral((vec2f(vec2u(code & 0xffffu, code >> 16u)) - 32768.0) / 32767.0);
}

fn surface_at(hit: Hit, direction: vec3f) -> Surface {
    let triangle = load_triangle(hit.triangle);
    let w = 1.0 - hit.barycentric.x - hit.barycentric.y;
    var surface: Surface;
    surface.position = w * triangle.corner_a + hit.barycentric.x * triangle.corner_b + hit.barycentric.y * triangle.corner_c;
    let largest = max(abs(triangle.corner_a), max(abs(triangle.corner_b), abs(triangle.corner_c)));
    surface.error = max(largest.x, max(largest.y, largest.z)) * 0x1p-20f;
    let outward = normalize_or_zero(cross(triangle.corner_b - triangle.corner_a, triangle.corner_c - triangle.corner_a));
    let back = dot(outward, direction) > 0.0;
    let turn = select(1.0, -1.0, back);
    surface.geometric_normal = turn * outward;
    surface.emitter = triangle.emitter;

    let at = triangle_texel(hit.triangle);
    let a = textureLoad(attributes, at);
    let b = textureLoad(attributes, at + vec2u(0u, 1u));
    let c = textureLoad(attributes, at + vec2u(0u, 2u));
    let material = triangle.material;
#ifdef PLAIN
#ifndef UNTEXTURED
    let uv = w * bitcast<vec2f>(a.yz) + hit.barycentric.x * bitcast<vec2f>(b.yz) + hit.barycentric.y * bitcast<vec2f>(c.yz);
#else
    let uv = vec2f(0.0);
#endif
    let place = Coordinates(uv, uv, vec4f(1.0));
#else
    let place = coordinates(hit.triangle, hit.barycentric);
#endif
    let base = materials[material].base_color * place.color
        * sample_texture(materials[material].base_color_texture, uv_of_use(material, 0u, place), vec4f(1.0));
    surface.visible = !back || (triangle.flags & DOUBLE_SIDED) != 0u;
    surface.albedo = base.rgb;
#ifndef DIFFUSE
    let metallic_roughness =
        sample_texture(materials[material].metallic_roughness_texture, uv_of_use(material, 1u, place), vec4f(1.0));
    let metallic = saturate(materials[material].metallic * metallic_roughness.b);
    var specular = materials[material].specular;
    var specular_color = materials[material].specular_color;
#ifndef PLAIN
    specular *= sample_texture(materials[material].specular_texture, uv_of_use(material, 4u, place), vec4f(1.0)).a;
    specular_color *=
        sample_texture(materials[material].specular_color_texture, uv_of_use(material, 5u, place), vec4f(1.0)).rgb;
#endif
    let dielectric = min(0.04 * specular_color, vec3f(1.0)) * specular;
    surface.albedo = base.rgb * (1.0 - metallic);
    surface.normal_reflectance = mix(dielectric, base.rgb, metallic);
    surface.grazing_reflectance = mix(specular, 1.0, metallic);
    let roughness = saturate(materials[material].roughness * metallic_roughness.g);
    surface.alpha = max(roughness * roughness, 1e-3);
#endif
#ifdef DARK
    surface.emissive = vec3f(0.0);
#else
    surface.emissive = materials[material].emissive * emission_color(materials[material].uv_rows[7], place.color);
#ifndef UNTEXTURED
    if any(surface.emissive > vec3f(0.0)) {
        surface.emissive *= sample_texture(materials[material].emissive_texture, uv_of_use(material, 3u, place), vec4f(1.0)).rgb;
    }
#endif
#endif

    let interpolated = w * decode_direction(a.x) + hit.barycentric.x * decode_direction(b.x)
        + hit.barycentric.y * decode_direction(c.x);
    var n = turn * normalize_or_zero(interpolated);
    if all(n == vec3f(0.0)) {
        n = surface.geometric_normal;
    }
#ifndef UNTEXTURED
    if materials[material].normal_texture.w != 0u && materials[material].normal_scale != 0.0 {
        let tangent = w * decode_direction(a.w & ~1u) + hit.barycentric.x * decode_direction(b.w & ~1u)
            + hit.barycentric.y * decode_direction(c.w & ~1u);
        let handedness = select(1.0, -1.0, (a.w & 1u) != 0u);
        let at_normal = uv_of_use(material, 2u, place);
        let sampled = sample_texture(materials[material].normal_texture, at_normal, vec4f(0.5, 0.5, 1.0, 1.0)).xyz;
        n = bent_normal(n, tangent, handedness, sampled, materials[material].normal_scale);
    }
#endif
    surface.normal = n;
    return surface;
}

// As `shading_normal` of lib/mesh.wgsl.
fn bent_normal(n: vec3f, tangent: vec3f, handedness: f32, sampled: vec3f, scale: f32) -> vec3f {
    let t = normalize_or_zero(tangent - n * dot(n, tangent));
    if all(t == vec3f(0.0)) {
        return n;
    }
    let bend = vec3f((sampled.xy * 2.0 - 1.0) * scale, sampled.z * 2.0 - 1.0);
    let bent = normalize_or_zero(t * bend.x + cross(n, t) * (handedness * bend.y) + n * bend.z);
    return select(bent, n, all(bent == vec3f(0.0)));
}

// Where a ray starts that leaves the surface: off it by more than what rounding may have moved the point.
fn leave_surface(surface: Surface, direction: vec3f) -> vec3f {
    let side = select(-1.0, 1.0, dot(direction, surface.geometric_normal) >= 0.0);
    return surface.position + surface.geometric_normal * (side * 4.0 * surface.error);
}
