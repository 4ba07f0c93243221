// Light straight from the lights in each cell, as media would scatter it to all sides alike: J = Σ E/(4π), past shadows and
// through the media; what is scattered of it, and what is absorbed, there. Cells have the mean of eight points.
//   LIT   there are lights
//   MORE  light of other lights is there already

#ifdef LIT
#import lightwell::haze_lamps::{arriving, lamp_count}
#endif
#import lightwell::media::{MEDIA, extinction_at, media}
#import lightwell::volume::{Volume, cell_index}

@group(0) @binding(0) var<uniform> volume: Volume;
// Three vectors a cell: J [W/(m² sr)]; Σ σ·ρ·J [W/(m³ sr)]; Σ σ·(1 − ρ) [1/m]. Their fourth numbers are the net flux of all
// channels together [W/m²].
@group(0) @binding(1) var<storage, read_write> lamp_light: array<vec4f>;

const POINTS: u32 = 8u;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    let cells = volume.cells;
    if index >= cells.x * cells.y * cells.z {
        return;
    }
    let cell = vec3u(index % cells.x, (index / cells.x) % cells.y, index / (cells.x * cells.y));
    var light = vec3f(0.0);
    var scattered = vec3f(0.0);
    var absorption = vec3f(0.0);
    var flux = vec3f(0.0);
    // Nearer to a light than that, a cell has the mean of 1/r² over a ball of its volume: 3/R².
    let least = 0.3578 * volume.cell;
    for (var i = 0u; i < POINTS; i++) {
        let place = vec3f(vec3u(i & 1u, (i >> 1u) & 1u, i >> 2u)) * 0.5 + 0.25;
        let position = volume.origin + (vec3f(cell) + place) * volume.cell;
        var sum = vec3f(0.0);
#ifdef LIT
        for (var k = 0u; k < lamp_count(index); k++) {
            let lamp = arriving(k, position);
            let near = min(lamp.distance / least, 1.0);
            let irradiance = lamp.irradiance * select(1.0, near * near, lamp.distance > 0.0);
            sum += irradiance;
            flux -= lamp.to_light * (irradiance.r + irradiance.g + irradiance.b);
        }
#endif
        sum *= 0.0795774715;
        light += sum;
        for (var k = 0u; k < MEDIA; k++) {
            let extinction = extinction_at(media[k], position);
            scattered += extinction * media[k].albedo * sum;
            absorption += extinction * (1.0 - media[k].albedo);
        }
    }
    let scale = 1.0 / f32(POINTS);
#ifdef MORE
    light += lamp_light[3u * index].rgb / scale;
    scattered += lamp_light[3u * index + 1u].rgb / scale;
    flux += vec3f(lamp_light[3u * index].w, lamp_light[3u * index + 1u].w, lamp_light[3u * index + 2u].w) / scale;
#endif
    lamp_light[3u * index] = vec4f(light, flux.x) * scale;
    lamp_light[3u * index + 1u] = vec4f(scattered, flux.y) * scale;
    lamp_light[3u * index + 2u] = vec4f(absorption, flux.z) * scale;
}
