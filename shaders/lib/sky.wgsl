#define_import_path lightwell::sky

// A sky by direction, as `SkyMap::table` of assets/sky_map.rs lays it out: radiance, and in alpha the running chance
// of the texels of a row; the last column holds the running chance of the rows.

const SKY_PI: f32 = 3.14159265358979;

fn sky_size(sky: texture_2d<f32>) -> vec2u {
    return textureDimensions(sky) - vec2u(1u, 0u);
}

// Where a direction lies on the map, in texels; `turn` in radians.
fn sky_place(sky: texture_2d<f32>, d: vec3f, turn: f32) -> vec2f {
    let u = fract(0.5 + (atan2(d.x, -d.z) + turn) / (2.0 * SKY_PI));
    let v = acos(clamp(d.y, -1.0, 1.0)) / SKY_PI;
    return vec2f(u, v) * vec2f(sky_size(sky));
}

// Radiance from a unit direction [W/(m² sr)], bilinear.
fn sky_radiance(sky: texture_2d<f32>, d: vec3f, turn: f32) -> vec3f {
    let size = vec2i(sky_size(sky));
    let at = sky_place(sky, d, turn) - 0.5;
    let low = vec2i(floor(at));
    let f = at - floor(at);
    let x = (vec2i(low.x, low.x + 1) + size.x) % size.x;
    let y = clamp(vec2i(low.y, low.y + 1), vec2i(0), vec2i(size.y - 1));
    let top = mix(textureLoad(sky, vec2i(x.x, y.x), 0).rgb, textureLoad(sky, vec2i(x.y, y.x), 0).rgb, f.x);
    let bottom = mix(textureLoad(sky, vec2i(x.x, y.y), 0).rgb, textureLoad(sky, vec2i(x.y, y.y), 0).rgb, f.x);
    return mix(top, bottom, f.y);
}

// The chance of entry `index` among running chances of a row (along columns) or of the rows (the last column).
fn sky_chance(sky: texture_2d<f32>, row: u32, index: u32, of_rows: bool) -> vec2f {
    let last = sky_size(sky).x;
    let here = select(vec2u(index, row), vec2u(last, index), of_rows);
    let above = textureLoad(sky, here, 0).a;
    if index == 0u {
        return vec2f(0.0, above);
    }
    let before = select(vec2u(index - 1u, row), vec2u(last, index - 1u), of_rows);
    return vec2f(textureLoad(sky, before, 0).a, above);
}

// The first entry whose running chance lies above a random number.
fn choose_entry(sky: texture_2d<f32>, row: u32, count: u32, of_rows: bool, random: f32) -> u32 {
    var low = 0u;
    var high = count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if sky_chance(sky, row, middle, of_rows).y > random {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

// Density with which `sample_sky` gives directions of a texel [1/sr].
fn texel_density(sky: texture_2d<f32>, texel: vec2u) -> f32 {
    let size = sky_size(sky);
    let row = sky_chance(sky, 0u, texel.y, true);
    let column = sky_chance(sky, texel.y, texel.x, false);
    let edges = cos(SKY_PI * vec2f(f32(texel.y), f32(texel.y + 1u)) / f32(size.y));
    let angle = 2.0 * SKY_PI / f32(size.x) * (edges.x - edges.y);
    return (row.y - row.x) * (column.y - column.x) / angle;
}

fn sky_density(sky: texture_2d<f32>, d: vec3f, turn: f32) -> f32 {
    let at = min(vec2u(sky_place(sky, d, turn)), sky_size(sky) - 1u);
    return texel_density(sky, at);
}

struct SkySample {
    direction: vec3f,      // unit
    density: f32,          // [1/sr]
}

// A direction, by the flux of the sky's texels; even in solid angle within a texel.
fn sample_sky(sky: texture_2d<f32>, turn: f32, choice: vec2f, place: vec2f) -> SkySample {
    let size = sky_size(sky);
    let row = choose_entry(sky, 0u, size.y, true, choice.x);
    let column = choose_entry(sky, row, size.x, false, choice.y);
    let edges = cos(SKY_PI * vec2f(f32(row), f32(row + 1u)) / f32(size.y));
    let y = mix(edges.x, edges.y, place.y);
    let azimuth = 2.0 * SKY_PI * ((f32(column) + place.x) / f32(size.x) - 0.5) - turn;
    let horizontal = sqrt(max(0.0, 1.0 - y * y));
    let direction = vec3f(horizontal * sin(azimuth), y, -horizontal * cos(azimuth));
    return SkySample(direction, texel_density(sky, vec2u(column, row)));
}
