#define_import_path lightwell::relight

// Irradiance at a point from the propagated volumes. FORWARD: the bindings of a raster pass, whose first groups are
// taken.

#import lightwell::sh::sh_cosine_lobe
#import lightwell::volume::{Volume, cell_index}

struct Cascade {
    volume: Volume,
    fade_center: vec3f,    // centre of the box before it was snapped [m]
    fade_cells: f32,       // width of the fade into the next coarser cascade, or into the outside [cells]; 0: none
    fade_half: vec3f,      // half extent of that box [m]
    padding: f32,
}

struct Relight {
    cascades: array<Cascade, 4>,
    count: u32,
    gain: f32,             // k
    offset: f32,           // of lookups before the surface [cells]
    damping: f32,          // strength of the gradient damping
}

#ifdef FORWARD
@group(3) @binding(0) var<uniform> relight: Relight;
@group(3) @binding(1) var<storage, read> light_finest: array<vec4f>;
@group(3) @binding(2) var<storage, read> light_second: array<vec4f>;
@group(3) @binding(3) var<storage, read> light_third: array<vec4f>;
@group(3) @binding(4) var<storage, read> light_coarsest: array<vec4f>;
#else
@group(0) @binding(1) var<uniform> relight: Relight;
@group(0) @binding(5) var<storage, read> light_finest: array<vec4f>;
@group(0) @binding(6) var<storage, read> light_second: array<vec4f>;
@group(0) @binding(7) var<storage, read> light_third: array<vec4f>;
@group(0) @binding(8) var<storage, read> light_coarsest: array<vec4f>;
#endif

struct Cell {
    red: vec4f,
    green: vec4f,
    blue: vec4f,
}

fn load(level: u32, index: u32) -> Cell {
    let first = 3u * index;
    switch level {
        case 0u: { return Cell(light_finest[first], light_finest[first + 1u], light_finest[first + 2u]); }
        case 1u: { return Cell(light_second[first], light_second[first + 1u], light_second[first + 2u]); }
        case 2u: { return Cell(light_third[first], light_third[first + 1u], light_third[first + 2u]); }
        default: { return Cell(light_coarsest[first], light_coarsest[first + 1u], light_coarsest[first + 2u]); }
    }
}

// Trilinear between cell centres; outside them the border cells go on.
fn sample(level: u32, volume: Volume, point: vec3f) -> Cell {
    let at = clamp((point - volume.origin) / volume.cell - 0.5, vec3f(0.0), vec3f(volume.cells - 1u));
    let low = vec3u(at);
    let high = min(low + 1u, volume.cells - 1u);
    let t = at - vec3f(low);
    var sum = Cell(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    for (var i = 0u; i < 8u; i++) {
        let upper = vec3<bool>((i & 1u) != 0u, (i & 2u) != 0u, (i & 4u) != 0u);
        let w = select(1.0 - t, t, upper);
        let weight = w.x * w.y * w.z;
        let cell = load(level, cell_index(volume, select(low, high, upper)));
        sum.red += weight * cell.red;
        sum.green += weight * cell.green;
        sum.blue += weight * cell.blue;
    }
    return sum;
}

fn irradiance(level: u32, point: vec3f, n: vec3f) -> vec3f {
    let volume = relight.cascades[level].volume;
    let at = point + n * (relight.offset * volume.cell);
    let cell = sample(level, volume, at);
    let lobe = sh_cosine_lobe(-n);
    let looked_up = max(vec3f(dot(cell.red, lobe), dot(cell.green, lobe), dot(cell.blue, lobe)), vec3f(0.0));
    if relight.damping > 0.0 {
        return looked_up / (1.0 + relight.damping * gradient(level, volume, at, n, cell));
    }
    return looked_up;
}

// The largest square, over the colour channels, of the central difference of the coefficients over one cell along the
// normal (Šefčík 2016, section 5.6), relative to the coefficients, so that light of any brightness is damped alike.
fn gradient(level: u32, volume: Volume, at: vec3f, n: vec3f, here: Cell) -> f32 {
    let ahead = sample(level, volume, at + n * (0.5 * volume.cell));
    let behind = sample(level, volume, at - n * (0.5 * volume.cell));
    let red = relative_square(ahead.red - behind.red, here.red);
    let green = relative_square(ahead.green - behind.green, here.green);
    let blue = relative_square(ahead.blue - behind.blue, here.blue);
    return max(red, max(green, blue));
}

// |difference|²/|coefficients|², of numbers whose squares may be too small or too large for floats.
fn relative_square(difference: vec4f, coefficients: vec4f) -> f32 {
    let either = max(abs(difference), abs(coefficients));
    let largest = max(max(either.x, either.y), max(either.z, either.w));
    if largest <= 0.0 {
        return 0.0;
    }
    let d = difference / largest;
    let c = coefficients / largest;
    return dot(d, d) / max(dot(c, c), 1e-6);
}

// Share of a cascade at a point: 1 inside, falling to 0 over the fade.
// The fade follows the box before it was snapped, so that a moving camera sees no jump.
fn share(level: u32, point: vec3f) -> f32 {
    let cascade = relight.cascades[level];
    let extent = vec3f(cascade.volume.cells) * cascade.volume.cell;
    let inside = min(point - cascade.volume.origin, cascade.volume.origin + extent - point);
    if any(inside < vec3f(-1e-3 * cascade.volume.cell)) {
        return 0.0;
    }
    if cascade.fade_cells <= 0.0 {
        return 1.0;
    }
    let margin = cascade.fade_half - abs(point - cascade.fade_center);
    let least = min(margin.x, min(margin.y, margin.z));
    return saturate(least / (cascade.fade_cells * cascade.volume.cell));
}

// E = k·Σ A_l·Y_lm(−n)·Î_lm of all cascades that cover the point [W/m²].
fn propagated_irradiance(point: vec3f, n: vec3f) -> vec3f {
    // Each cascade holds the light of its own box alone, carried as far as its steps go: the finer know the
    // near light better, the coarser more of the far light. Their average by share (Šefčík 2016, section 5.6).
    var e = vec3f(0.0);
    var shares = 0.0;
    for (var level = 0u; level < relight.count; level++) {
        let w = share(level, point);
        if w > 0.0 {
            e += w * irradiance(level, point, n);
            shares += w;
        }
    }
    // Shares of less than 1 in all fade into the unlit outside.
    return e * (relight.gain / max(shares, 1.0));
}
