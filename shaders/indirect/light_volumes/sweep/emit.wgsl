// Sources: what each cell sends out, from the texels of reflective shadow maps, from emissive surfaces, and from what
// the surfaces reflect of the bounce before, or of all bounces before.
//   COUNTED     the flux of this cascade is the scene's, and is summed up
//   EXPOSED     the brightest source is found, for the exposure of light that is kept in half precision
//   NO_OUTER    no coarser cascade lies around this one
//   HAZE        media absorb light
//   SCATTERED   and what they scatter straight from the lights is a source

#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::lights::{Light, is_distant}
#ifdef MEDIA
#import lightwell::media::{FARTHEST, transmittance}
#endif
#import lightwell::rsm::{RsmLayer, texel_received}
#import lightwell::sweep::{Surfel, BEFORE, LINKED, link_way, openness, to_fixed, from_fixed, nearest_axis}
#import lightwell::coverage::{linked_cell, source_cell}
#import lightwell::volume::{Volume, cell_index}

struct Emit {
    scale: f32,            // power of two that turns flux [W] into fixed point
    bounce: u32,           // 0: light that comes straight from the lights
    padding: vec2u,
    sky: vec3f,            // what enters from the sky, in fixed point
    inner_low: vec3f,      // box of the next finer cascade [cells]; without one it is empty
    inner_high: vec3f,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> emit: Emit;
@group(0) @binding(2) var<uniform> light: Light;
@group(0) @binding(3) var<uniform> rsm: RsmLayer;
@group(0) @binding(4) var base_color: texture_2d_array<u32>;
@group(0) @binding(5) var normal: texture_2d_array<u32>;
@group(0) @binding(6) var depth: texture_depth_2d_array;
@group(0) @binding(7) var<storage, read> surfels: array<Surfel>;
@group(0) @binding(8) var<storage, read> opacity: array<vec4f>;
// Irradiance of the surfels, as much of it as they reflect a share of [W/m²].
@group(0) @binding(9) var<storage, read> received: array<vec4f>;
// Thirty-six a cell, for each axis that a normal may lie nearest to high and low words of: F (RGB), Σ F·n. Behind them the
// bits of the brightest source, which are in the order of the numbers.
@group(0) @binding(10) var<storage, read_write> sums: array<atomic<i32>>;
// Six vectors a cell, for each of those axes: F/h² [W/m²] and whether it leaves in all directions alike (below 0); mean normal.
// Media have the rest: in the first one's fourth number, by axis a channel of F/h² of what they scatter, in the second's that of
// the optical depth of what they absorb, over the edge of a cell.
// One mean for all would send the light of two walls that meet into neither. Behind them, with EXPOSED, the brightest source
// of this cascade and the coarser ones, and of those alone [W/(m² sr)].
@group(0) @binding(11) var<storage, read_write> emission: array<vec4f>;
// Six a bounce: emitted flux (RGB), high and low words each.
@group(0) @binding(12) var<storage, read_write> totals: array<atomic<i32>>;
#ifndef NO_OUTER
// That of the next coarser cascade.
@group(0) @binding(13) var<storage, read> outer_emission: array<vec4f>;
#endif
// Where each surfel's light goes, see `indirect/light_volumes/sweep/links.wgsl`.
@group(0) @binding(16) var<storage, read> links: array<u32>;
#ifdef HAZE
// See `indirect/light_volumes/sweep/lamp_light.wgsl`.
@group(0) @binding(17) var<storage, read> lamp_light: array<vec4f>;
#endif
// Unit direction and weight [sr] of the sweep that follows.
@group(0) @binding(15) var<storage, read> directions: array<vec4f>;

fn inside(cell: vec3f) -> bool {
    return all(cell >= vec3f(0.0)) && all(cell < vec3f(volume.cells));
}

fn in_inner(cell: vec3f) -> bool {
    return all(cell >= emit.inner_low) && all(cell < emit.inner_high);
}

// Adds to the cell, or to that of the surface itself where the border of this cascade or of the next finer one lies
// between them: else the light of a surface would enter the finer cascade twice, or not at all.
fn add_to_cell(wanted: vec3f, own: vec3f, n: vec3f, flux: vec3f) {
    var cell = wanted;
    if !inside(wanted) || in_inner(wanted) != in_inner(own) {
        cell = own;
    }
    if !inside(cell) {
        return;
    }
    let first = 36u * cell_index(volume, vec3u(cell)) + 12u * nearest_axis(n);
    let lobe = (flux.r + flux.g + flux.b) * n;
    for (var i = 0u; i < 3u; i++) {
        let f = to_fixed(flux[i] * emit.scale);
        atomicAdd(&sums[first + 2u * i], f.x);
        atomicAdd(&sums[first + 2u * i + 1u], f.y);
        let m = to_fixed(lobe[i] * emit.scale * 0.25);
        atomicAdd(&sums[first + 6u + 2u * i], m.x);
        atomicAdd(&sums[first + 7u + 2u * i], m.y);
    }
}

@compute @workgroup_size(8, 8)
fn from_rsm(@builtin(global_invocation_id) thread: vec3u) {
    let texel = thread.xy;
    if any(texel >= vec2u(rsm.size)) {
        return;
    }
    let z = textureLoad(depth, texel, rsm.layer, 0);
    if z <= 0.0 {
        return;
    }
    let albedo = decode_albedo(textureLoad(base_color, texel, rsm.layer, 0));
    if all(albedo <= vec3f(0.0)) {
        return;
    }
    let n = decode_normal(textureLoad(normal, texel, rsm.layer, 0));
    let position = world_position(texel, vec2u(rsm.size), z, rsm.world_from_clip);
    let received = texel_received(rsm, light, texel, position);
    var flux = albedo * received.flux;
#ifdef MEDIA
    let distance = select(distance(light.position, position), FARTHEST, is_distant(light));
    flux *= transmittance(position, received.to_light, distance);
#endif
    let p = (position - volume.origin) / volume.cell;
    let cell = floor(p + BEFORE * n);
    if !inside(cell) || all(flux <= vec3f(0.0)) {
        return;
    }
    let is_thin = opacity[11u * cell_index(volume, vec3u(cell)) + 1u].z > 0.0;
    let linked = linked_cell(volume, p, n, source_cell(p, n, is_thin));
    if linked.is_any {
        add_to_cell(linked.cell, cell, n, flux);
    }
}

fn from_surfel(index: u32, flux: vec3f) {
    let link = links[index];
    let n = surfels[index].normal;
    let own = floor((surfels[index].position - volume.origin) / volume.cell + BEFORE * n);
    if (link & LINKED) != 0u && inside(own) && any(flux > vec3f(0.0)) {
        add_to_cell(own + link_way(link), own, n, flux);
    }
}

// Emissive surfaces: F = π·L·A.
@compute @workgroup_size(64)
fn from_emissive(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    from_surfel(index, surfel.emissive * (3.14159265 * surfel.area));
}

// White light, of radiance 1 from all surfaces: F = π·A.
@compute @workgroup_size(64)
fn from_white(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index < arrayLength(&surfels) {
        from_surfel(index, vec3f(3.14159265 * surfels[index].area * openness(surfels[index])));
    }
}

// Reflected light: F = ρ·A·E.
@compute @workgroup_size(64)
fn from_bounce(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    from_surfel(index, surfel.albedo * received[index].rgb * surfel.area);
}

fn add_to_totals(channel: u32, flux: f32) {
    if flux > 0.0 {
        let f = to_fixed(flux);
        atomicAdd(&totals[6u * emit.bounce + 2u * channel], f.x);
        atomicAdd(&totals[6u * emit.bounce + 2u * channel + 1u], f.y);
    }
}

// What the directions make of a cosine lobe, Σ w·max(0, n·d)/π: up to 2 % more or less than one. A source divided by it
// sends out its flux and no more; a room of albedo 0.9 would gain a fifth by the excess of all bounces.
fn lobe_integral(n: vec3f) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < arrayLength(&directions); i++) {
        sum += directions[i].w * max(0.0, dot(n, directions[i].xyz));
    }
    return sum * 0.318309886;
}

fn cell_count() -> u32 {
    return volume.cells.x * volume.cells.y * volume.cells.z;
}

// What `transport.wgsl` chooses its exposure by.
@compute @workgroup_size(1)
fn keep_brightest() {
    let here = bitcast<f32>(atomicLoad(&sums[36u * cell_count()]));
#ifdef NO_OUTER
    let around = 0.0;
#else
    let around = outer_emission[arrayLength(&outer_emission) - 1u].x;
#endif
    emission[6u * cell_count()] = vec4f(max(here, around), around, 0.0, 0.0);
}

@compute @workgroup_size(64)
fn finish(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= cell_count() {
        return;
    }
    var bright = 0.0;
    for (var axis = 0u; axis < 3u; axis++) {
        let first = 36u * index + 12u * axis;
        var flux: vec3f;
        var lobe: vec3f;
        for (var i = 0u; i < 3u; i++) {
            let at = first + 2u * i;
            flux[i] = from_fixed(atomicLoad(&sums[at]), atomicLoad(&sums[at + 1u]));
            lobe[i] = 4.0 * from_fixed(atomicLoad(&sums[at + 6u]), atomicLoad(&sums[at + 7u]));
#ifdef COUNTED
            add_to_totals(i, flux[i]);
#endif
        }
        let sum = flux.r + flux.g + flux.b;
        let size = length(lobe);
        // Where surfaces face each other in one cell there is no mean direction.
        let isotropic = size < 0.1 * sum;
        let to = 6u * index + 2u * axis;
        let n = lobe / max(size, 1e-30);
        var whole = 1.0;
        if sum > 0.0 && !isotropic {
            whole = lobe_integral(n);
        }
        var sent = flux / emit.scale / volume.cell / volume.cell / whole;
        var scattered = 0.0;
        var absorbed = 0.0;
#ifdef HAZE
        absorbed = lamp_light[3u * index + 2u][axis] * volume.cell;
#endif
#ifdef SCATTERED
        // Radiant intensity over area is that of the cell's depth, to all sides.
        scattered = 12.5663706 * volume.cell * lamp_light[3u * index + 1u][axis];
        if isotropic {
            sent[axis] += scattered;
        }
#endif
        emission[to] = vec4f(sent, select(scattered, -1.0, isotropic));
        emission[to + 1u] = vec4f(n, absorbed);
        bright += max(scattered, max(sent.r, max(sent.g, sent.b)));
    }
#ifdef EXPOSED
    if bright > 0.0 {
        // No direction lies farther than √3 from its axis.
        atomicMax(&sums[36u * cell_count()], bitcast<i32>(bright * (1.7320508 * 0.318309886)));
    }
#endif
#ifdef COUNTED
    if index == 0u {
        for (var i = 0u; i < 3u; i++) {
            add_to_totals(i, emit.sky[i]);
        }
    }
#endif
}
