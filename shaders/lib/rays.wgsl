#define_import_path lightwell::rays

// The scene as rays see it: group 1 of all passes that cast rays (engine/src/render/ray_scene/).

#import lightwell::lights::Light
#import lightwell::mesh::normalize_or_zero

struct Node {
    low: vec3f,
    first: u32,            // inner: first of two children; leaf: first triangle, or (top level) the instance
    high: vec3f,
    count: u32,            // of a leaf; 0: inner node
}

struct Triangle {
    corner_a: vec3f,       // object space [m]
    vertex_a: u32,
    corner_b: vec3f,
    vertex_b: u32,
    corner_c: vec3f,
    vertex_c: u32,
}

struct Vertex {
    normal: vec3f,         // object space
    u: f32,
    tangent: vec4f,
    v: f32,
}

struct Instance {
    object_from_world: array<vec4f, 3>, // row by row
    world_from_object: array<vec4f, 3>,
    root: u32,
    material: u32,
    flags: u32,
    first_emitter: u32,
    first_triangle: u32,
}

const CASTS_SHADOW: u32 = 1u;
const DOUBLE_SIDED: u32 = 2u;
const MASKED: u32 = 4u;
const NONE: u32 = 0xffffffffu;

struct Material {
    base_color: vec4f,
    emissive: vec3f,       // radiance [W/(m² sr)]
    metallic: f32,
    specular_color: vec3f,
    roughness: f32,
    specular: f32,
    alpha_cutoff: f32,     // below 0: alpha is ignored
    normal_scale: f32,
    double_sided: u32,
    base_color_texture: vec4u,
    metallic_roughness_texture: vec4u,
    normal_texture: vec4u,
    emissive_texture: vec4u,
}

struct Emitter {
    cumulative: f32,       // chance that it or one before it is chosen
    density: f32,          // its chance over its area [1/m²]
    instance: u32,
    triangle: u32,         // in the order of its mesh's leaves
}

struct RayLight {
    light: Light,
    casts_shadow: u32,
    indirect: u32,
}

@group(1) @binding(0) var<storage, read> nodes: array<Node>;
@group(1) @binding(1) var<storage, read> triangles: array<Triangle>;
@group(1) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(1) @binding(3) var<storage, read> instances: array<Instance>;
@group(1) @binding(4) var<storage, read> materials: array<Material>;
@group(1) @binding(5) var<storage, read> emitters: array<Emitter>;
@group(1) @binding(6) var<storage, read> lights: array<RayLight>;
@group(1) @binding(7) var atlas: texture_2d_array<f32>;

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
}

// ---- Traversal ----

// What a ray is for.
const CAMERA: u32 = 0u;    // nearest surface, backs of single-sided ones left out
const LIGHT: u32 = 1u;     // nearest surface that casts shadows, from both sides
const SHADOW: u32 = 2u;    // any surface that casts shadows

struct Ray {
    origin: vec3f,
    direction: vec3f,      // of any length; distances are in its units
}

struct Hit {
    t: f32,
    instance: u32,         // NONE: nothing was met
    triangle: u32,
    barycentric: vec2f,    // of the second and third corner
}

fn inverse_direction(d: vec3f) -> vec3f {
    // No component is zero, so that no 0·∞ arises.
    return select(select(vec3f(1e30), vec3f(-1e30), d < vec3f(0.0)), 1.0 / d, abs(d) > vec3f(1e-30));
}

const FAR: f32 = 3e38;

// Where the ray enters the box, or FAR.
fn enter_box(low: vec3f, high: vec3f, origin: vec3f, inverse: vec3f, t_max: f32) -> f32 {
    let a = (low - origin) * inverse;
    let b = (high - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    // Two roundings further, so that no box is missed that holds a hit (Ize 2013).
    let leave = min(far.x, min(far.y, far.z)) * 1.0000005;
    return select(FAR, enter, enter <= min(leave, t_max));
}

fn to_object_point(i: u32, p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(
        dot(instances[i].object_from_world[0], q), dot(instances[i].object_from_world[1], q), dot(instances[i].object_from_world[2], q),
    );
}

fn to_object_vector(i: u32, v: vec3f) -> vec3f {
    return vec3f(
        dot(instances[i].object_from_world[0].xyz, v),
        dot(instances[i].object_from_world[1].xyz, v),
        dot(instances[i].object_from_world[2].xyz, v),
    );
}

fn hit_uv(triangle: u32, barycentric: vec2f) -> vec2f {
    let a = triangles[triangle].vertex_a;
    let b = triangles[triangle].vertex_b;
    let c = triangles[triangle].vertex_c;
    let w = 1.0 - barycentric.x - barycentric.y;
    return w * vec2f(vertices[a].u, vertices[a].v) + barycentric.x * vec2f(vertices[b].u, vertices[b].v)
        + barycentric.y * vec2f(vertices[c].u, vertices[c].v);
}

fn is_transparent(instance: u32, triangle: u32, barycentric: vec2f) -> bool {
    let material = instances[instance].material;
    let texel = sample_texture(materials[material].base_color_texture, hit_uv(triangle, barycentric), vec4f(1.0));
    return materials[material].base_color.a * texel.a < materials[material].alpha_cutoff;
}

// Entries that the deepest way through both levels needs; the host knows.
#ifdef STACK
const STACK_SIZE: u32 = #{STACK}u;
#else
const STACK_SIZE: u32 = 128u;
#endif

// One stack serves both levels: entries above `base` belong to the instance that the ray is in.
fn trace(root: u32, ray: Ray, t_max: f32, kind: u32) -> Hit {
    var hit = Hit(t_max, NONE, 0u, vec2f(0.0));
    if root == NONE {
        return hit;
    }
    var stack: array<u32, STACK_SIZE>;
    var top = 0u;
    var base = 0u;
    var origin = ray.origin;
    var direction = ray.direction;
    var inverse = inverse_direction(direction);
    var instance = NONE;
    var current = root;
    loop {
        let node = nodes[current];
        if node.count == 0u {
            let left = nodes[node.first];
            let right = nodes[node.first + 1u];
            let a = enter_box(left.low, left.high, origin, inverse, hit.t);
            let b = enter_box(right.low, right.high, origin, inverse, hit.t);
            if min(a, b) < FAR {
                let right_first = b < a;
                if max(a, b) < FAR && top < STACK_SIZE {
                    stack[top] = select(node.first + 1u, node.first, right_first);
                    top += 1u;
                }
                current = select(node.first, node.first + 1u, right_first);
                continue;
            }
        } else if instance == NONE {
            let flags = instances[node.first].flags;
            if kind == CAMERA || (flags & CASTS_SHADOW) != 0u {
                instance = node.first;
                base = top;
                origin = to_object_point(instance, ray.origin);
                direction = to_object_vector(instance, ray.direction);
                inverse = inverse_direction(direction);
                current = instances[instance].root;
                continue;
            }
        } else {
            for (var i = node.first; i < node.first + node.count; i++) {
                // Möller and Trumbore 1997, without any tolerance.
                let edge_b = triangles[i].corner_b - triangles[i].corner_a;
                let edge_c = triangles[i].corner_c - triangles[i].corner_a;
                let p = cross(direction, edge_c);
                let determinant = dot(edge_b, p);
                let r = 1.0 / determinant;
                let s = origin - triangles[i].corner_a;
                let u = dot(s, p) * r;
                let q = cross(s, edge_b);
                let v = dot(direction, q) * r;
                let t = dot(edge_c, q) * r;
                if determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < hit.t {
                    let flags = instances[instance].flags;
                    // Seen from the front the determinant is positive.
                    if kind == CAMERA && determinant < 0.0 && (flags & DOUBLE_SIDED) == 0u {
                        continue;
                    }
                    if (flags & MASKED) != 0u && is_transparent(instance, i, vec2f(u, v)) {
                        continue;
                    }
                    hit = Hit(t, instance, i, vec2f(u, v));
                    if kind == SHADOW {
                        return hit;
                    }
                }
            }
        }
        if top == base && instance != NONE {
            instance = NONE;
            base = 0u;
            origin = ray.origin;
            direction = ray.direction;
            inverse = inverse_direction(direction);
        }
        if top == 0u {
            break;
        }
        top -= 1u;
        current = stack[top];
    }
    return hit;
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
    visible: bool,         // false: the back of a single-sided surface
}

fn to_world_point(i: u32, p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(
        dot(instances[i].world_from_object[0], q), dot(instances[i].world_from_object[1], q), dot(instances[i].world_from_object[2], q),
    );
}

fn to_world_vector(i: u32, v: vec3f) -> vec3f {
    return vec3f(
        dot(instances[i].world_from_object[0].xyz, v),
        dot(instances[i].world_from_object[1].xyz, v),
        dot(instances[i].world_from_object[2].xyz, v),
    );
}

// By the cofactor matrix, with the sign of the determinant taken out: mirrored objects keep their outside.
fn to_world_normal(i: u32, n: vec3f) -> vec3f {
    let a = instances[i].world_from_object[0].xyz;
    let b = instances[i].world_from_object[1].xyz;
    let c = instances[i].world_from_object[2].xyz;
    let bc = cross(b, c);
    let mirrored = select(1.0, -1.0, dot(a, bc) < 0.0);
    return normalize_or_zero(mirrored * vec3f(dot(bc, n), dot(cross(c, a), n), dot(cross(a, b), n)));
}

// Upper bound of the rounding of a world position, relative to all terms that went into it.
fn position_error(i: u32, object: vec3f) -> f32 {
    let q = vec4f(abs(object), 1.0);
    let x = dot(abs(instances[i].world_from_object[0]), q);
    let y = dot(abs(instances[i].world_from_object[1]), q);
    let z = dot(abs(instances[i].world_from_object[2]), q);
    return max(x, max(y, z)) * 0x1p-20f;
}

fn surface_at(hit: Hit, direction: vec3f) -> Surface {
    let triangle = triangles[hit.triangle];
    let i = hit.instance;
    let w = 1.0 - hit.barycentric.x - hit.barycentric.y;
    let object = w * triangle.corner_a + hit.barycentric.x * triangle.corner_b + hit.barycentric.y * triangle.corner_c;
    var surface: Surface;
    surface.position = to_world_point(i, object);
    surface.error = position_error(i, object);
    let outward = to_world_normal(i, cross(triangle.corner_b - triangle.corner_a, triangle.corner_c - triangle.corner_a));
    let back = dot(outward, direction) > 0.0;
    let turn = select(1.0, -1.0, back);
    surface.geometric_normal = turn * outward;

    let material = materials[instances[i].material];
    surface.visible = !back || material.double_sided != 0u;
    let a = vertices[triangle.vertex_a];
    let b = vertices[triangle.vertex_b];
    let c = vertices[triangle.vertex_c];
    let uv = w * vec2f(a.u, a.v) + hit.barycentric.x * vec2f(b.u, b.v) + hit.barycentric.y * vec2f(c.u, c.v);
    let base = material.base_color * sample_texture(material.base_color_texture, uv, vec4f(1.0));
    let metallic_roughness = sample_texture(material.metallic_roughness_texture, uv, vec4f(1.0));
    let metallic = saturate(material.metallic * metallic_roughness.b);
    let dielectric = min(0.04 * material.specular_color, vec3f(1.0)) * material.specular;
    surface.albedo = base.rgb * (1.0 - metallic);
    surface.normal_reflectance = mix(dielectric, base.rgb, metallic);
    surface.grazing_reflectance = mix(material.specular, 1.0, metallic);
    let roughness = saturate(material.roughness * metallic_roughness.g);
    surface.alpha = max(roughness * roughness, 1e-3);
    surface.emissive = material.emissive;
    if any(material.emissive > vec3f(0.0)) {
        surface.emissive *= sample_texture(material.emissive_texture, uv, vec4f(1.0)).rgb;
    }

    let interpolated = w * a.normal + hit.barycentric.x * b.normal + hit.barycentric.y * c.normal;
    var n = turn * to_world_normal(i, interpolated);
    if all(n == vec3f(0.0)) {
        n = surface.geometric_normal;
    } else if material.normal_texture.w != 0u && material.normal_scale != 0.0 {
        let tangent = w * a.tangent + hit.barycentric.x * b.tangent + hit.barycentric.y * c.tangent;
        n = bent_normal(n, to_world_vector(i, tangent.xyz), tangent.w, sample_texture(material.normal_texture, uv, vec4f(0.5, 0.5, 1.0, 1.0)).xyz, material.normal_scale);
    }
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
