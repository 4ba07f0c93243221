// One step of propagation: each cell gathers what its six neighbours send through its faces, and what of its own
// light comes back from blockers.
//
// From the centre of a neighbour a cell's far face fills Ω_FAR and each of its four side faces Ω_SIDE; the thirty
// solid angles around a source are the whole sphere. The flux through a face, Φ_f = Ω_f·I(ω_f), leaves the cell
// again as a cosine lobe along the face's normal with the same flux (Kaplanyan and Dachsbacher 2010, section 4.3;
// Šefčík 2016, section 3.10.3).

#import lightwell::sh::{BAND_ZERO, BAND_ONE}
#import lightwell::volume::{Volume, cell_index, corner_index}

struct Propagation {
    occlusion: u32,
    bounce: u32,
    blocker_scale: f32,    // b: 4/3 makes a full wall opaque
    padding: u32,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> propagation: Propagation;
@group(0) @binding(2) var<storage, read> source: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> gathered: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> accumulated: array<vec4f>;
@group(0) @binding(5) var<storage, read> blockers: array<vec4f>;

const OMEGA_FAR: f32 = 0.4006696846;
const OMEGA_SIDE: f32 = 0.4234313544;
// Direction to the centre of a side face: (2, 1)/√5 along and across.
const ALONG: f32 = 0.894427191;
const ACROSS: f32 = 0.447213595;
// (1/π)·A_1·(BAND_ONE): first-order coefficient of a cosine lobe with unit flux.
const LOBE_ONE: f32 = 0.325735008;
const INVERSE_SQRT_FOUR_PI: f32 = 0.28209479;

// Flux through the five faces from one channel's coefficients, split as they are needed again: x all faces;
// y through the far face; z, w differences across the two side axes.
// `along` is the coefficient in the direction of travel, `side` those across.
fn sent(constant: f32, along: f32, side: vec2f) -> vec4f {
    let far = OMEGA_FAR * max(0.0, BAND_ZERO * constant + BAND_ONE * along);
    let base = BAND_ZERO * constant + (BAND_ONE * ALONG) * along;
    let tilt = (BAND_ONE * ACROSS) * vec4f(side.x, -side.x, side.y, -side.y);
    let sides = OMEGA_SIDE * max(vec4f(0.0), base + tilt);
    return vec4f(far + sides.x + sides.y + sides.z + sides.w, far, sides.x - sides.y, sides.z - sides.w);
}

// Coefficients are (1, y, z, x). These pick (along, sides) for travel along +x, +y, +z; a negative sign mirrors.
fn along_x(c: vec4f, s: f32) -> vec4f {
    let f = sent(c.x, s * c.w, c.yz);
    return vec4f(BAND_ZERO * f.x, LOBE_ONE * f.z, LOBE_ONE * f.w, s * LOBE_ONE * f.y);
}

fn along_y(c: vec4f, s: f32) -> vec4f {
    let f = sent(c.x, s * c.y, c.zw);
    return vec4f(BAND_ZERO * f.x, s * LOBE_ONE * f.y, LOBE_ONE * f.z, LOBE_ONE * f.w);
}

fn along_z(c: vec4f, s: f32) -> vec4f {
    let f = sent(c.x, s * c.z, c.yw);
    return vec4f(BAND_ZERO * f.x, LOBE_ONE * f.z, s * LOBE_ONE * f.y, LOBE_ONE * f.w);
}

// What stops light at a face: its vector, and the mean reflectance.
struct Face {
    blocked: vec4f,
    reflectance: vec3f,
}

fn face(a: vec3u, b: vec3u, c: vec3u, d: vec3u) -> Face {
    let i = 2u * vec4u(corner_index(volume, a), corner_index(volume, b), corner_index(volume, c), corner_index(volume, d));
    var out: Face;
    out.blocked = 0.25 * (blockers[i.x] + blockers[i.y] + blockers[i.z] + blockers[i.w]);
    let area = blockers[i.x + 1u] + blockers[i.y + 1u] + blockers[i.z + 1u] + blockers[i.w + 1u];
    out.reflectance = area.rgb / max(area.w, 1e-12);
    return out;
}

// The share that a face stops of light whose direction has the coefficient `against` towards the light's origin.
fn stopped(f: Face, against: f32) -> f32 {
    return saturate(propagation.blocker_scale * (BAND_ZERO * f.blocked.x + BAND_ONE * against));
}

struct Cell {
    red: vec4f,
    green: vec4f,
    blue: vec4f,
}

fn load(cell: vec3u) -> Cell {
    let first = 3u * cell_index(volume, cell);
    return Cell(source[first], source[first + 1u], source[first + 2u]);
}

// The lobe that blocked flux leaves as: B(ω)/∫B, with ∫B = √(4π)·B_00; scaled by what the face stops and reflects.
fn returned(f: Face, share: f32, flux: vec3f) -> array<vec4f, 3> {
    let lobe = f.blocked * (share * INVERSE_SQRT_FOUR_PI / max(f.blocked.x, 1e-12));
    let light = f.reflectance * flux;
    return array<vec4f, 3>(lobe * light.r, lobe * light.g, lobe * light.b);
}

@compute @workgroup_size(8, 8, 1)
fn step(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= volume.cells) {
        return;
    }
    let own = load(cell);
    let last = volume.cells - 1u;
    let one = vec3u(1u, 0u, 0u);
    let blocks = propagation.occlusion != 0u;
    let bounces = blocks && propagation.bounce != 0u;
    var faces: array<Face, 6>;
    if blocks {
        let c = cell;
        let x = one.xyy;
        let y = one.yxy;
        let z = one.yyx;
        let opposite = c + vec3u(1u);
        faces[0] = face(c, c + y, c + z, c + y + z);
        faces[1] = face(c + x, c + x + y, c + x + z, opposite);
        faces[2] = face(c, c + x, c + z, c + x + z);
        faces[3] = face(c + y, c + x + y, c + y + z, opposite);
        faces[4] = face(c, c + x, c + y, c + x + y);
        faces[5] = face(c + z, c + x + z, c + y + z, opposite);
    }
    var red = vec4f(0.0);
    var green = vec4f(0.0);
    var blue = vec4f(0.0);
    // Incoming: the neighbour at −x sends along +x, against which the blocker's −x coefficient stands; and so on.
    if cell.x > 0u {
        let n = load(cell - one.xyy);
        let t = select(1.0, 1.0 - stopped(faces[0], -faces[0].blocked.w), blocks);
        red += t * along_x(n.red, 1.0); green += t * along_x(n.green, 1.0); blue += t * along_x(n.blue, 1.0);
    }
    if cell.x < last.x {
        let n = load(cell + one.xyy);
        let t = select(1.0, 1.0 - stopped(faces[1], faces[1].blocked.w), blocks);
        red += t * along_x(n.red, -1.0); green += t * along_x(n.green, -1.0); blue += t * along_x(n.blue, -1.0);
    }
    if cell.y > 0u {
        let n = load(cell - one.yxy);
        let t = select(1.0, 1.0 - stopped(faces[2], -faces[2].blocked.y), blocks);
        red += t * along_y(n.red, 1.0); green += t * along_y(n.green, 1.0); blue += t * along_y(n.blue, 1.0);
    }
    if cell.y < last.y {
        let n = load(cell + one.yxy);
        let t = select(1.0, 1.0 - stopped(faces[3], faces[3].blocked.y), blocks);
        red += t * along_y(n.red, -1.0); green += t * along_y(n.green, -1.0); blue += t * along_y(n.blue, -1.0);
    }
    if cell.z > 0u {
        let n = load(cell - one.yyx);
        let t = select(1.0, 1.0 - stopped(faces[4], -faces[4].blocked.z), blocks);
        red += t * along_z(n.red, 1.0); green += t * along_z(n.green, 1.0); blue += t * along_z(n.blue, 1.0);
    }
    if cell.z < last.z {
        let n = load(cell + one.yyx);
        let t = select(1.0, 1.0 - stopped(faces[5], faces[5].blocked.z), blocks);
        red += t * along_z(n.red, -1.0); green += t * along_z(n.green, -1.0); blue += t * along_z(n.blue, -1.0);
    }
    if bounces {
        // Outgoing: own light towards each face, the part that is stopped there, back into this cell.
        for (var i = 0u; i < 6u; i++) {
            let f = faces[i];
            let s = select(-1.0, 1.0, (i & 1u) != 0u);
            var against = -s * f.blocked.w;
            if i >= 4u {
                against = -s * f.blocked.z;
            } else if i >= 2u {
                against = -s * f.blocked.y;
            }
            let share = stopped(f, against);
            if share > 0.0 && f.blocked.x > 0.0 {
                var flux: vec3f;
                if i < 2u {
                    flux = vec3f(along_x(own.red, s).x, along_x(own.green, s).x, along_x(own.blue, s).x);
                } else if i < 4u {
                    flux = vec3f(along_y(own.red, s).x, along_y(own.green, s).x, along_y(own.blue, s).x);
                } else {
                    flux = vec3f(along_z(own.red, s).x, along_z(own.green, s).x, along_z(own.blue, s).x);
                }
                let back = returned(f, share, flux / BAND_ZERO);
                red += back[0]; green += back[1]; blue += back[2];
            }
        }
    }
    let first = 3u * cell_index(volume, cell);
    gathered[first] = red;
    gathered[first + 1u] = green;
    gathered[first + 2u] = blue;
    accumulated[first] += red;
    accumulated[first + 1u] += green;
    accumulated[first + 2u] += blue;
}
