#define_import_path lightwell::mesh

// Vertices, instances and materials of the raster passes. Each pass declares the bindings under these names.

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
}

// What only some meshes have: passes take it unless PLAIN is defined.
struct VertexExtra {
    @location(4) second_uv: vec2f,
    @location(5) color: vec4f, // linear, multiplies the base colour
}

struct Instance {
    rows: array<vec4f, 3>, // world_from_object, row by row
    id: u32,
    handedness: f32,       // -1 if the transform mirrors, else 1
    pad_a: u32,
    pad_b: u32,
}

struct Material {
    base_color: vec4f,
    emissive: vec3f,       // radiance [W/(m² sr)]
    metallic: f32,
    specular_color: vec3f,
    roughness: f32,
    specular: f32,
    alpha_cutoff: f32,     // below 0: alpha is ignored; BLENDED: the surface is blended over what lies behind
    normal_scale: f32,
    double_sided: u32,
    transmission: f32,     // of light that is neither reflected nor a metal's
    clearcoat: f32,        // share of the surface that a clear coat covers; the layers: lib/layers.wgsl
    clearcoat_roughness: f32,
    clearcoat_normal_scale: f32,
    sheen_color: vec3f,
    sheen_roughness: f32,
    anisotropy: vec3f,     // strength; cosine and sine of its turn from the tangent
    iridescence: f32,      // share of the surface that a film covers
    film: vec3f,           // its index of refraction; its least and most thickness [nm]
    even_layers: vec4f,    // what sheen reflects of even light, and what the layers leave of the base's diffuse reflection
    // Two rows for each texture: base colour, metallic-roughness, normal, emissive, specular, specular colour, transmission,
    // clear coat, its roughness and its normal, sheen colour and roughness, anisotropy, iridescence and thickness.
    uv_rows: array<vec4f, 30>,
}

// `alpha_cutoff` of blended surfaces, above any cutoff of masked ones.
const BLENDED: f32 = 2.0;
// From here on a blended surface hides all that lies behind, and is drawn with the opaque ones: the last half step of
// eight bits.
const OPAQUE_ALPHA: f32 = 0.998;

// Whether the passes that hold one surface a pixel leave the point out.
fn is_cut_out(material: Material, alpha: f32) -> bool {
    return alpha < select(material.alpha_cutoff, OPAQUE_ALPHA, material.alpha_cutoff >= BLENDED);
}

// Whether light passes the point in a light's own view. There a blended surface is there where it is more than half
// opaque: a map holds one distance a texel.
fn is_cut_out_for_lights(material: Material, alpha: f32) -> bool {
    return alpha < select(material.alpha_cutoff, 0.5, material.alpha_cutoff >= BLENDED);
}

fn world_from_object_point(instance: Instance, p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(dot(instance.rows[0], q), dot(instance.rows[1], q), dot(instance.rows[2], q));
}

fn world_from_object_vector(instance: Instance, v: vec3f) -> vec3f {
    return vec3f(dot(instance.rows[0].xyz, v), dot(instance.rows[1].xyz, v), dot(instance.rows[2].xyz, v));
}

// Normals transform by the cofactor matrix, which exists for singular transforms too; the sign of the determinant is
// taken out, so that mirrored objects keep their outside.
fn world_from_object_normal(instance: Instance, n: vec3f) -> vec3f {
    let a = instance.rows[0].xyz;
    let b = instance.rows[1].xyz;
    let c = instance.rows[2].xyz;
    return instance.handedness * vec3f(dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n));
}

// A tangent with the sign of its bitangent, which a transform that mirrors turns around.
fn world_from_object_tangent(instance: Instance, tangent: vec4f) -> vec4f {
    return vec4f(world_from_object_vector(instance, tangent.xyz), instance.handedness * tangent.w);
}

// Where a texture is sampled, and how far the next pixels lie from there.
struct TexturePoint {
    uv: vec2f,
    dx: vec2f,
    dy: vec2f,
}

// Close to the plane of the eye, where clip w is zero, texture coordinates may come out huge or as NaN, which costs
// some samplers a hundred times the usual time. Beyond 10⁴ repeats a float cannot tell the texels apart anyway.
fn texture_point(uv: vec2f) -> TexturePoint {
    let dx = dpdx(uv);
    let dy = dpdy(uv);
    return TexturePoint(
        select(vec2f(0.0), clamp(uv, vec2f(-1e4), vec2f(1e4)), abs(uv) < vec2f(1e30)),
        select(vec2f(0.0), dx, abs(dx) < vec2f(1e3)),
        select(vec2f(0.0), dy, abs(dy) < vec2f(1e3)),
    );
}

// Where a texture is sampled: by the first or second set of coordinates (w of the first row), moved by the two rows
// of an affine map.
fn mapped(row_u: vec4f, row_v: vec4f, first: TexturePoint, second: TexturePoint) -> TexturePoint {
    let takes_second = row_u.w != 0.0;
    let uv = select(first.uv, second.uv, takes_second);
    let dx = select(first.dx, second.dx, takes_second);
    let dy = select(first.dy, second.dy, takes_second);
    return TexturePoint(
        vec2f(dot(row_u.xy, uv) + row_u.z, dot(row_v.xy, uv) + row_v.z),
        vec2f(dot(row_u.xy, dx), dot(row_v.xy, dx)),
        vec2f(dot(row_u.xy, dy), dot(row_v.xy, dy)),
    );
}

// What vertex colours do to emission: they are for surfaces, but for those that show themselves without light.
fn emission_color(row: vec4f, color: vec4f) -> vec3f {
    return select(vec3f(1.0), color.rgb, row.w != 0.0);
}

fn normalize_or_zero(v: vec3f) -> vec3f {
    // Scaled by the largest component first, so that neither tiny nor huge vectors leave the range of floats.
    let largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    if !(largest > 0.0) {
        return vec3f(0.0);
    }
    return normalize(v / largest);
}

// The shading normal: interpolated, bent by the normal map, turned to the viewer on double-sided surfaces. Where
// the mesh has no normal, the triangle's own takes its place.
fn shading_normal(
    interpolated: vec3f, tangent: vec4f, position: vec3f, sampled: vec3f, scale: f32, flip: bool, to_eye: vec3f,
) -> vec3f {
    let face = normalize_or_zero(cross(dpdx(position), dpdy(position)));
    var n = normalize_or_zero(interpolated);
    if all(n == vec3f(0.0)) {
        n = select(face, -face, dot(face, to_eye) < 0.0);
        return select(n, vec3f(0.0, 1.0, 0.0), all(n == vec3f(0.0)));
    }
    n = select(n, -n, flip);
    let t = normalize_or_zero(tangent.xyz - n * dot(n, tangent.xyz));
    let bend = vec3f((sampled.xy * 2.0 - 1.0) * scale, sampled.z * 2.0 - 1.0);
    let b = cross(n, t) * tangent.w;
    let bent = normalize_or_zero(t * bend.x + b * bend.y + n * bend.z);
    return select(bent, n, all(bent == vec3f(0.0)) || all(t == vec3f(0.0)));
}
