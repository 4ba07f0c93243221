// The cells of a light volume: light and blockers by direction as spheres, and voxels in the colour of their surfaces.

#import lightwell::sh::{sh_basis, COSINE_ZERO, COSINE_ONE}
#import lightwell::sweep::Surfel
#import lightwell::view::{View, eye_distance, toward_eye}
#import lightwell::volume::Volume

struct Cells {
    volume: Volume,
    content: u32,
    scale: f32,            // 2^exposure
    pad_a: u32,
    pad_b: u32,
}

// What `data` holds.
const LIGHT_HARMONICS: u32 = 0u;    // twelve numbers a cell: red, green, blue of I/h² in four coefficients
const LIGHT_AXES: u32 = 1u;         // eighteen: irradiance for +x −x +y −y +z −z
const BLOCKERS: u32 = 2u;           // eight a corner: B_lm, Σρ·A, ΣA
const OPACITY: u32 = 3u;            // forty-four: see `indirect/light_volumes/sweep/opacity.wgsl`
const VOXELS_OF_BLOCKERS: u32 = 4u; // as BLOCKERS
const VOXELS_OF_SURFELS: u32 = 5u;  // four whole numbers: Σρ·A, ΣA in fixed point

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> cells: Cells;
@group(0) @binding(2) var<storage, read> data: array<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
@group(0) @binding(4) var<storage, read> surfels: array<Surfel>;
@group(0) @binding(5) var<storage, read_write> sums: array<atomic<i32>>;

const INVERSE_PI: f32 = 0.31830988618379;
// Radius of a sphere and half the edge of a voxel [cells].
const RADIUS: f32 = 0.18;
// Spheres nearer to the eye are left out: they would hide all others [cells].
const NEAREST: f32 = 2.0;
const HALF_EDGE: f32 = 0.48;
// Blockers that stop less are none to speak of.
const LEAST: f32 = 0.02;
// Cells' faces of area that a sum may hold.
const AREA_SCALE: f32 = 65536.0;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,                         // on a sphere: of the square around it; on a voxel: its normal
    @location(1) @interpolate(flat) cell: u32,
    @location(2) @interpolate(flat) center: vec3f,  // [m]
    @location(3) position: vec3f,                   // [m]
}

struct Shown {
    @location(0) color: vec4f,
    @builtin(frag_depth) depth: f32,
}

// Sums the reflectance of the surfels in each cell.
@compute @workgroup_size(64)
fn scatter(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    let at = floor((surfel.position - cells.volume.origin) / cells.volume.cell - 1e-3 * surfel.normal);
    if any(at < vec3f(0.0)) || any(at >= vec3f(cells.volume.cells)) {
        return;
    }
    let area = min(surfel.area / cells.volume.cell / cells.volume.cell, 4.0);
    let sum = vec4i(round(vec4f(surfel.albedo, 1.0) * (area * AREA_SCALE)));
    let cell = vec3u(at);
    let first = 4u * ((cell.z * cells.volume.cells.y + cell.y) * cells.volume.cells.x + cell.x);
    for (var i = 0u; i < 4u; i++) {
        atomicAdd(&sums[first + i], sum[i]);
    }
}

fn number(index: u32) -> f32 {
    return bitcast<f32>(data[index]);
}

fn numbers(index: u32) -> vec4f {
    return vec4f(number(index), number(index + 1u), number(index + 2u), number(index + 3u));
}

fn is_on_corners() -> bool {
    return cells.content == BLOCKERS || cells.content == VOXELS_OF_BLOCKERS;
}

// Reflectance of a voxel; negative where there is no surface.
fn reflectance(cell: u32) -> vec3f {
    var sum: vec4f;
    if cells.content == VOXELS_OF_BLOCKERS {
        sum = numbers(8u * cell + 4u);
    } else {
        sum = vec4f(vec4i(
            bitcast<i32>(data[4u * cell]), bitcast<i32>(data[4u * cell + 1u]),
            bitcast<i32>(data[4u * cell + 2u]), bitcast<i32>(data[4u * cell + 3u]),
        )) / AREA_SCALE;
    }
    return select(vec3f(-1.0), sum.rgb / max(sum.w, 1e-12), sum.w > 1e-3);
}

fn is_empty(cell: u32) -> bool {
    switch cells.content {
        case LIGHT_HARMONICS: {
            return number(12u * cell) == 0.0 && number(12u * cell + 4u) == 0.0 && number(12u * cell + 8u) == 0.0;
        }
        case LIGHT_AXES: {
            var sum = 0.0;
            for (var i = 0u; i < 18u; i++) {
                sum += abs(number(18u * cell + i));
            }
            return sum == 0.0;
        }
        case BLOCKERS: { return number(8u * cell) < LEAST; }
        case OPACITY: {
            var sum = number(44u * cell) + number(44u * cell + 1u) + number(44u * cell + 2u);
            for (var i = 2u; i < 8u; i++) {
                sum += number(44u * cell + 4u * i + 3u);
            }
            return sum < LEAST;
        }
        default: { return reflectance(cell).r < 0.0; }
    }
}

// Radiance of a white surface in the cell that faces n, as a screen shows it.
fn light_toward(cell: u32, n: vec3f) -> vec3f {
    var e = vec3f(0.0);
    if cells.content == LIGHT_HARMONICS {
        let lobe = sh_basis(-n) * vec4f(COSINE_ZERO, COSINE_ONE, COSINE_ONE, COSINE_ONE);
        for (var channel = 0u; channel < 3u; channel++) {
            e[channel] = dot(numbers(12u * cell + 4u * channel), lobe);
        }
    } else {
        // By the squares of the normal's components (McTaggart 2004, the ambient cube).
        for (var axis = 0u; axis < 3u; axis++) {
            let first = 18u * cell + 6u * axis + select(3u, 0u, n[axis] >= 0.0);
            e += n[axis] * n[axis] * vec3f(number(first), number(first + 1u), number(first + 2u));
        }
    }
    let shown = max(e, vec3f(0.0)) * (INVERSE_PI * cells.scale);
    return pow(shown / (1.0 + shown), vec3f(1.0 / 2.2));
}

// How much of the light that arrives from the side of n the cell stops.
fn blocked_from(cell: u32, n: vec3f) -> f32 {
    if cells.content == BLOCKERS {
        return saturate(dot(numbers(8u * cell), sh_basis(n)));
    }
    let first = 44u * cell;
    let straight = vec3f(number(first), number(first + 1u), number(first + 2u));
    let mixed = vec3f(number(first + 3u), number(first + 4u), number(first + 5u));
    let along = dot(straight, n * n) + 2.0 * dot(mixed, n * n.yzx);
    let solid = sqrt(max(along * (straight.x + straight.y + straight.z), 0.0));
    var faces = 0.0;
    for (var axis = 0u; axis < 3u; axis++) {
        // Light from the side of +axis moves along −axis.
        let side = select(0u, 1u, n[axis] > 0.0);
        faces += n[axis] * n[axis] * number(first + 4u * (2u + 2u * axis + side) + 3u);
    }
    return saturate(max(solid, faces));
}

fn sphere(index: u32, out: ptr<function, Varying>) {
    let radius = RADIUS * cells.volume.cell;
    let corner = select(index, 6u - index, index >= 3u) % 4u;
    let square = vec2f(select(-1.0, 1.0, (corner & 1u) != 0u), select(-1.0, 1.0, corner >= 2u));
    let frame = facing((*out).center);
    (*out).at = vec3f(square, 0.0);
    (*out).position = (*out).center + frame * vec3f(square * radius, 0.0);
}

// Right, up and towards the eye.
fn facing(center: vec3f) -> mat3x3f {
    let back = normalize(toward_eye(view, center));
    let helper = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(back.y) > 0.99);
    let right = normalize(cross(helper, back));
    return mat3x3f(right, cross(back, right), back);
}

fn voxel(index: u32, out: ptr<function, Varying>) {
    let face = index / 6u;
    let axis = face / 2u;
    let sign = select(-1.0, 1.0, (face & 1u) != 0u);
    let within = index % 6u;
    let corner = select(within, 6u - within, within >= 3u) % 4u;
    var offset = vec3f(sign);
    offset[(axis + 1u) % 3u] = select(-1.0, 1.0, (corner & 1u) != 0u);
    offset[(axis + 2u) % 3u] = select(-1.0, 1.0, corner >= 2u);
    var n = vec3f(0.0);
    n[axis] = sign;
    (*out).at = n;
    (*out).position = (*out).center + offset * (HALF_EDGE * cells.volume.cell);
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varying {
    var count = cells.volume.cells;
    if is_on_corners() {
        count += 1u;
    }
    var out: Varying;
    out.cell = instance;
    let place = vec3u(instance % count.x, (instance / count.x) % count.y, instance / count.x / count.y);
    let within = select(0.5, 0.0, is_on_corners());
    out.center = cells.volume.origin + (vec3f(place) + within) * cells.volume.cell;
    let is_near = cells.content < VOXELS_OF_BLOCKERS && eye_distance(view, out.center) < NEAREST * cells.volume.cell;
    if is_near || is_empty(instance) {
        out.clip = vec4f(0.0, 0.0, 2.0, 1.0);
        return out;
    }
    if cells.content >= VOXELS_OF_BLOCKERS {
        voxel(index, &out);
    } else {
        sphere(index, &out);
    }
    out.clip = view.clip_from_world * vec4f(out.position, 1.0);
    return out;
}

fn depth_of(position: vec3f) -> f32 {
    let clip = view.clip_from_world * vec4f(position, 1.0);
    return clip.z / clip.w;
}

@fragment
fn fragment(in: Varying) -> Shown {
    var out: Shown;
    let surface = textureLoad(depth, vec2i(in.clip.xy), 0);
    let frame = facing(in.center);
    if cells.content >= VOXELS_OF_BLOCKERS {
        out.depth = in.clip.z;
        // What lies far before the visible surface is a wall that the camera looks through from behind.
        let toward = -normalize(toward_eye(view, in.position));
        if surface > 0.0 && depth_of(in.position + toward * (3.0 * cells.volume.cell)) > surface {
            discard;
        }
        let shade = dot(abs(in.at), vec3f(0.85, 1.0, 0.7));
        out.color = vec4f(pow(saturate(reflectance(in.cell)), vec3f(1.0 / 2.2)) * shade, 1.0);
        return out;
    }
    let square = dot(in.at.xy, in.at.xy);
    if square > 1.0 {
        discard;
    }
    let n = frame * vec3f(in.at.xy, sqrt(1.0 - square));
    out.depth = depth_of(in.center + n * (RADIUS * cells.volume.cell));
    if out.depth < surface {
        discard;
    }
    if cells.content <= LIGHT_AXES {
        out.color = vec4f(light_toward(in.cell, n), 1.0);
    } else {
        out.color = vec4f(mix(vec3f(0.08, 0.1, 0.16), vec3f(1.0, 0.6, 0.2), blocked_from(in.cell, n)), 1.0);
    }
    return out;
}
