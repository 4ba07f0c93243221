#define_import_path lightwell::shadow_lookup

// Where a point lies in a light's shadow map, and how much of it is lit.

struct ShadowFace {
    clip_from_world: mat4x4f,
}

// What all faces of a map share.
struct ShadowView {
    eye: vec3f,
    far: f32,
    axis: vec3f,           // of a spot's view
    texel: f32,            // width of a texel: metres (directional) or per metre of distance along the axis
    size: f32,             // edge of the map [texels]
    kind: u32,             // 0 none, 1 directional, 2 spot, 3 point
    pad_a: u32,
    pad_b: u32,
}

// Not to be handed to a function: drivers copy a value before they index into it, and compile two seconds for that of six
// matrices.
struct Shadow {
    faces: array<ShadowFace, 6>,
    view: ShadowView,
}

const NO_SHADOW: u32 = 0u;
const DIRECTIONAL_SHADOW: u32 = 1u;
const SPOT_SHADOW: u32 = 2u;
const POINT_SHADOW: u32 = 3u;

struct ShadowCoordinate {
    uv: vec2f,
    depth: f32,            // reversed
    face: i32,
    inside: bool,
}

// Cube face whose axis lies nearest to a direction: +X −X +Y −Y +Z −Z.
fn cube_face(d: vec3f) -> i32 {
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(1, 0, d.x > 0.0);
    }
    if a.y >= a.z {
        return select(3, 2, d.y > 0.0);
    }
    return select(5, 4, d.z > 0.0);
}

// Distance along the axis of the view that sees a point, as widths of texels grow with it; 1 for directional lights.
fn distance_along_view(shadow: ShadowView, position: vec3f) -> f32 {
    let offset = position - shadow.eye;
    if shadow.kind == SPOT_SHADOW {
        return max(dot(offset, shadow.axis), 0.0);
    }
    let largest = max(abs(offset.x), max(abs(offset.y), abs(offset.z)));
    return select(1.0, largest, shadow.kind == POINT_SHADOW);
}

// Where a point is compared with a map.
struct Receiver {
    position: vec3f,       // [m]
    from_eye: vec3f,       // [m]
    face: i32,
}

// The receiver is moved off its surface before it is compared: along the normal by as much as the plane's depth
// changes over the filter's radius of √2 texels (slope bias, grows with sin θ) and by a fraction of a texel (static bias).
fn shadow_receiver(shadow: ShadowView, position: vec3f, n: vec3f, to_light: vec3f) -> Receiver {
    let along_axis = distance_along_view(shadow, position);
    let cosine = saturate(dot(n, to_light));
    let sine = sqrt(1.0 - cosine * cosine);
    let moved = position + n * (shadow.texel * along_axis * (1.45 * sine + 0.2));
    let from_eye = moved - shadow.eye;
    return Receiver(moved, from_eye, select(0, cube_face(from_eye), shadow.kind == POINT_SHADOW));
}

// Its place in the map, by the matrix of its face.
fn shadow_coordinate(shadow: ShadowView, clip_from_world: mat4x4f, receiver: Receiver) -> ShadowCoordinate {
    var out: ShadowCoordinate;
    out.face = receiver.face;
    let clip = clip_from_world * vec4f(receiver.position, 1.0);
    let ndc = clip.xyz / clip.w;
    out.uv = vec2f(0.5, -0.5) * ndc.xy + 0.5;
    out.inside = clip.w > 0.0 && all(abs(ndc.xy) <= vec2f(1.0));
    // Static bias against rounding: a few units of the stored value.
    let far_share = length(receiver.from_eye) / shadow.far;
    out.depth = select(1.0 - far_share, ndc.z, shadow.kind == DIRECTIONAL_SHADOW) + 1e-6;
    return out;
}
