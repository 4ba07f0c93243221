// Depth of field: the light of each pixel is spread over its circle of confusion. What a pixel receives is gathered from
// around it in two layers, what is nearer than the plane of focus over all else (Jimenez 2014). Points lie on a spiral of
// equal areas (Vogel 1979), dealt out to the pixels of each block of 3 by 3; a filter over those blocks sums them up
// (interleaved sampling: Keller and Heidrich 2001).
//   TILES    tiles on each side that a circle may reach from

struct Focus {
    base: f32,             // signed radius of the circle at infinity, or on the far plane [pixels]
    slope: f32,            // how much less it is at depth 1 [pixels]
    limit: f32,            // largest radius [pixels]
}

@group(0) @binding(0) var<uniform> focus: Focus;
@group(0) @binding(1) var sharp: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_depth_2d;
// Radiance [W/(m² sr)] with the signed radius of the circle, negative where it is near [pixels].
@group(0) @binding(3) var circles: texture_2d<f32>;
// Largest radius of a near circle in each tile, and of those that reach each tile [pixels].
@group(0) @binding(4) var nearest: texture_2d<f32>;
@group(0) @binding(5) var reach: texture_2d<f32>;
@group(0) @binding(6) var result: texture_storage_2d<rgba32float, write>;
@group(0) @binding(7) var largest: texture_storage_2d<r32float, write>;
// What is gathered: radiance of what is behind with the radius of its circles, and that of what is near times its coverage
// with both its radius and its coverage, 2·⌊radius⌋ + coverage.
@group(0) @binding(8) var behind: texture_2d<f32>;
@group(0) @binding(9) var near: texture_2d<f32>;
@group(0) @binding(10) var near_result: texture_storage_2d<rgba32float, write>;

#ifdef TILES
const TILES: i32 = #{TILES};
#else
const TILES: i32 = 1;
#endif
const TILE: i32 = 16;
const POINTS: i32 = 32;
// Pixels that share one spiral.
const BLOCK: i32 = 3;
const PI: f32 = 3.14159265358979;
const GOLDEN_ANGLE: f32 = 2.39996322972865;
// What is brighter would not stay finite in sums.
const MAX_RADIANCE: f32 = 1e30;

// ---- Circles ----

// Bits of the largest near radius: those of positive floats are in the order of the floats.
var<workgroup> largest_bits: atomic<u32>;

@compute @workgroup_size(16, 16)
fn circles_main(
    @builtin(global_invocation_id) thread: vec3u,
    @builtin(workgroup_id) tile: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    if all(thread.xy < textureDimensions(result)) {
        let radius = clamp(focus.base - focus.slope * textureLoad(depth, thread.xy, 0), -focus.limit, focus.limit);
        let light = min(textureLoad(sharp, thread.xy, 0).rgb, vec3f(MAX_RADIANCE));
        textureStore(result, thread.xy, vec4f(light, radius));
        atomicMax(&largest_bits, bitcast<u32>(max(-radius, 0.0)));
    }
    workgroupBarrier();
    if index == 0u {
        textureStore(largest, tile.xy, vec4f(bitcast<f32>(atomicLoad(&largest_bits))));
    }
}

@compute @workgroup_size(8, 8)
fn reach_main(@builtin(global_invocation_id) thread: vec3u) {
    let size = vec2i(textureDimensions(nearest));
    let tile = vec2i(thread.xy);
    if any(tile >= size) {
        return;
    }
    var found = 0.0;
    for (var y = -TILES; y <= TILES; y++) {
        for (var x = -TILES; x <= TILES; x++) {
            let radius = textureLoad(nearest, clamp(tile + vec2i(x, y), vec2i(0), size - 1), 0).r;
            let gap = f32(TILE * max(max(abs(x), abs(y)) - 1, 0));
            found = select(found, max(found, radius), radius > gap);
        }
    }
    textureStore(largest, tile, vec4f(found));
}

// ---- Gather ----

// Area of a circle, a pixel at least [pixels²].
fn area(radius: f32) -> f32 {
    return max(PI * radius * radius, 1.0);
}

// Share of a pixel at some distance from its centre that a circle covers.
fn cover(radius: f32, distance: f32) -> f32 {
    return saturate(radius - distance + 0.5);
}

struct Layers {
    near: vec4f,           // radiance times coverage, and coverage
    near_radius: f32,      // times coverage [pixels]
    behind: vec4f,         // radiance times weight, and weight
}

// Adds what a pixel at some distance gives, chosen with that density [1/pixel²].
fn add_near(layers: ptr<function, Layers>, there: vec4f, distance: f32, density: f32) {
    if there.a < 0.0 {
        let radius = max(-there.a, 0.5);
        let weight = cover(radius, distance) / (area(radius) * density);
        (*layers).near += weight * vec4f(there.rgb, 1.0);
        (*layers).near_radius += weight * radius;
    }
}

fn add_behind(layers: ptr<function, Layers>, here: f32, there: vec4f, distance: f32, density: f32) {
    if there.a < 0.0 {
        return;
    }
    // What is farther away than the surface here shows as far as that is blurred itself.
    let radius = max(min(there.a, here), 0.5);
    // What lies behind a near surface is guessed from the nearest that shows.
    let guess = 1.0 / (1.0 + distance * distance);
    let weight = select(cover(radius, distance) / area(radius), guess, here < 0.0) / density;
    (*layers).behind += weight * vec4f(there.rgb, 1.0);
}

@compute @workgroup_size(8, 8)
fn gather_main(@builtin(global_invocation_id) thread: vec3u) {
    let size = vec2i(textureDimensions(circles));
    let pixel = vec2i(thread.xy);
    if any(pixel >= size) {
        return;
    }
    let center = textureLoad(circles, pixel, 0);
    let here = center.a;
    // All that may reach this pixel: of what is near from as far as that spreads, of what is behind from its own circle.
    let wide = textureLoad(reach, pixel / TILE, 0).r;
    let narrow = abs(here);
    let radii = vec2f(select(0.0, narrow + 0.5, narrow > 0.5), select(0.0, wide + 0.5, wide > 0.5));
    let areas = PI * radii * radii / f32(POINTS);
    let densities = select(vec2f(0.0), 1.0 / max(areas, vec2f(1e-6)), radii > vec2f(0.0));
    var layers = Layers(vec4f(0.0), 0.0, vec4f(0.0));
    // The pixel itself is looked at once more.
    add_near(&layers, center, 0.0, 1.0 + densities.x + densities.y);
    add_behind(&layers, here, center, 0.0, 1.0 + densities.x);
    let share = (f32(pixel.x % BLOCK + BLOCK * (pixel.y % BLOCK)) + 0.5) / f32(BLOCK * BLOCK);
    for (var i = 0; i < 2 * POINTS; i++) {
        let is_wide = i >= POINTS;
        let radius = select(radii.x, radii.y, is_wide);
        if radius > 0.0 {
            let index = f32(i % POINTS) + share;
            let distance = radius * sqrt(index / f32(POINTS));
            let angle = GOLDEN_ANGLE * f32(BLOCK * BLOCK) * index;
            let offset = round(distance * vec2f(cos(angle), sin(angle)));
            let there = textureLoad(circles, clamp(pixel + vec2i(offset), vec2i(0), size - 1), 0);
            // Either spiral may have chosen it (balance heuristic, Veach and Guibas 1995).
            let away = length(offset);
            let again = select(0.0, 1.0, away < 0.5);
            let density = again + dot(densities, select(vec2f(0.0), vec2f(1.0), vec2f(distance) < radii));
            add_near(&layers, there, away, density);
            if !is_wide {
                add_behind(&layers, here, there, away, again + densities.x);
            }
        }
    }
    let coverage = select(saturate(layers.near.a), 1.0, layers.behind.a <= 0.0);
    let color = layers.near.rgb / max(layers.near.a, 1e-6);
    let near_radius = floor(layers.near_radius / max(layers.near.a, 1e-6));
    textureStore(near_result, pixel, vec4f(coverage * color, 2.0 * near_radius + coverage));
    textureStore(result, pixel, vec4f(layers.behind.rgb / max(layers.behind.a, 1e-6), abs(here)));
}

// ---- Filter ----

// How much a pixel of a block counts: as far as both circles are wider than the block.
fn share_of(radii: vec2f, is_center: bool) -> f32 {
    return select(saturate(min(radii.x, radii.y) - 1.0), 1.0, is_center);
}

struct Near {
    over: vec4f,           // radiance times coverage, and coverage
    radius: f32,           // without a bound where nothing is near: there a pixel takes part in the borders of what is
}

fn near_at(pixel: vec2i) -> Near {
    let found = textureLoad(near, pixel, 0);
    let radius = floor(0.5 * found.a);
    let coverage = found.a - 2.0 * radius;
    return Near(vec4f(found.rgb, coverage), select(radius, 1e6, coverage <= 0.0));
}

@compute @workgroup_size(8, 8)
fn filter_main(@builtin(global_invocation_id) thread: vec3u) {
    let size = vec2i(textureDimensions(behind));
    let pixel = vec2i(thread.xy);
    if any(pixel >= size) {
        return;
    }
    let radius = textureLoad(behind, pixel, 0).a;
    let near_radius = near_at(pixel).radius;
    var far = vec4f(0.0);
    var over = vec4f(0.0);
    var total = 0.0;
    for (var i = 0; i < BLOCK * BLOCK; i++) {
        let offset = vec2i(i % BLOCK, i / BLOCK) - BLOCK / 2;
        let there = clamp(pixel + offset, vec2i(0), size - 1);
        let is_center = all(offset == vec2i(0));
        let far_there = textureLoad(behind, there, 0);
        far += share_of(vec2f(radius, far_there.a), is_center) * vec4f(far_there.rgb, 1.0);
        let near_there = near_at(there);
        let share = share_of(vec2f(near_radius, near_there.radius), is_center);
        over += share * near_there.over;
        total += share;
    }
    over /= total;
    textureStore(result, pixel, vec4f(far.rgb / far.a * (1.0 - over.a) + over.rgb, 1.0));
}
