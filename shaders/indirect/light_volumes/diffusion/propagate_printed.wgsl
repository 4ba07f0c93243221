// One step of propagation by the formulas as Šefčík 2016 prints them in section 3.10.3, a gather of all elementary steps
// into a cell (section 5.5). Beside `propagate.wgsl`:
//   (3.5)  Φ_f = Δω_f/4π·I(ω_f): a step passes on 1/4π of the flux
//   β = B(−ω_f) for each face's own direction, at the face that source and destination share
//   (3.7)  ρ·B(ω)·B(−ω_f)·Φ_f at the face of the destination that is farthest from the source, added to the destination
//          beside the flux that passes. As printed it lacks Φ_f, without which unlit scenes would glow.
// β is held between 0 and 1: beyond that flux would be negative.

#import lightwell::sh::{sh_basis, sh_cosine_lobe}
#import lightwell::volume::{Volume, cell_index, corner_index}

struct Propagation {
    occlusion: u32,
    bounce: u32,
    blocker_scale: f32,    // b
    padding: u32,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> propagation: Propagation;
@group(0) @binding(2) var<storage, read> source: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> gathered: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> accumulated: array<vec4f>;
@group(0) @binding(5) var<storage, read> blockers: array<vec4f>;

// Solid angles of a neighbour's far face and of its side faces, over 4π.
const SHARE_FAR: f32 = 0.0318842;
const SHARE_SIDE: f32 = 0.0336956;
const INVERSE_PI: f32 = 0.318309886;

// Axis 0 to 2 and a sign for each of six directions.
fn direction(i: u32) -> vec3i {
    var d = vec3i(0);
    d[i >> 1u] = select(-1, 1, (i & 1u) == 0u);
    return d;
}

struct Face {
    blocked: vec4f,
    reflectance: vec3f,
}

// The blockers at the face of a cell in a direction: the mean of its four corners.
fn face(cell: vec3u, i: u32) -> Face {
    let axis = i >> 1u;
    let side = select(0u, 1u, (i & 1u) == 0u);
    var blocked = vec4f(0.0);
    var area = vec4f(0.0);
    for (var corner = 0u; corner < 4u; corner++) {
        var at = cell;
        at[axis] += side;
        at[(axis + 1u) % 3u] += corner & 1u;
        at[(axis + 2u) % 3u] += corner >> 1u;
        let index = 2u * corner_index(volume, at);
        blocked += 0.25 * blockers[index];
        area += blockers[index + 1u];
    }
    return Face(blocked, area.rgb / max(area.w, 1e-12));
}

// b·B in a direction, between 0 and 1.
fn blocking(f: Face, d: vec3f) -> f32 {
    return saturate(propagation.blocker_scale * dot(f.blocked, sh_basis(d)));
}

@compute @workgroup_size(8, 8, 1)
fn step(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= volume.cells) {
        return;
    }
    let blocks = propagation.occlusion != 0u;
    let bounces = blocks && propagation.bounce != 0u;
    var red = vec4f(0.0);
    var green = vec4f(0.0);
    var blue = vec4f(0.0);
    for (var i = 0u; i < 6u; i++) {
        // Light that travels along i comes from the neighbour on the other side.
        let travel = direction(i);
        let neighbour = vec3i(cell) - travel;
        if any(neighbour < vec3i(0)) || any(neighbour >= vec3i(volume.cells)) {
            continue;
        }
        let first = 3u * cell_index(volume, vec3u(neighbour));
        let between = face(cell, i ^ 1u);
        let farthest = face(cell, i);
        for (var j = 0u; j < 6u; j++) {
            if j == (i ^ 1u) {
                continue;
            }
            let normal = vec3f(direction(j));
            let toward = normalize(vec3f(travel) + 0.5 * normal);
            let basis = sh_basis(toward);
            let intensity = vec3f(dot(source[first], basis), dot(source[first + 1u], basis), dot(source[first + 2u], basis));
            var flux = max(intensity, vec3f(0.0)) * select(SHARE_SIDE, SHARE_FAR, i == j);
            if blocks {
                flux *= 1.0 - blocking(between, -toward);
            }
            let lobe = sh_cosine_lobe(normal) * INVERSE_PI;
            red += flux.r * lobe;
            green += flux.g * lobe;
            blue += flux.b * lobe;
            if bounces {
                let reflected = farthest.reflectance * flux * blocking(farthest, -toward);
                red += reflected.r * farthest.blocked;
                green += reflected.g * farthest.blocked;
                blue += reflected.b * farthest.blocked;
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
