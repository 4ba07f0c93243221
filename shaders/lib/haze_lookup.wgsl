#define_import_path lightwell::haze_lookup

// What media do to light on its way to the eye.
//   FORWARD  the bindings are those of a raster pass, whose first groups are taken

#import lightwell::haze::{Haze, SLICES, haze_index, sight_through, slice_of}
#import lightwell::media::{FARTHEST, transmittance}
#import lightwell::view::View

#ifdef FORWARD
@group(3) @binding(17) var<uniform> haze: Haze;
@group(3) @binding(18) var<storage, read> in_scattered: array<vec4f>;
#else
@group(0) @binding(39) var<uniform> haze: Haze;
@group(0) @binding(40) var<storage, read> in_scattered: array<vec4f>;
#endif

struct Veil {
    passing: f32,          // share of light from behind that passes
    added: vec3f,          // what is scattered on the way [W/(m² sr)]
}

fn of_column(column: vec2u, slice: f32, is_beyond: bool) -> vec3f {
    let low = min(u32(slice), SLICES - 1u);
    let near = in_scattered[haze_index(haze, column, low)].rgb;
    let far = in_scattered[haze_index(haze, column, low + 1u)].rgb;
    let beyond = in_scattered[haze_index(haze, column, SLICES + 1u)].rgb;
    return select(mix(near, far, slice - f32(low)), beyond, is_beyond);
}

// Between the eye and a point of the image [pixels] at a distance [m] from the near plane: the share that passes is exact, what
// is scattered is interpolated in the grid.
fn veil(view: View, at: vec2f, position: vec3f, is_sky: bool) -> Veil {
    let sight = sight_through(view, at);
    let distance = select(distance(sight.origin, position), FARTHEST, is_sky);
    let slice = slice_of(haze, distance);
    let column = clamp(at / haze.tile - 0.5 - haze.shift, vec2f(0.0), vec2f(haze.columns - 1u));
    let low = min(vec2u(column), max(haze.columns, vec2u(2u)) - 2u);
    let high = min(low + 1u, haze.columns - 1u);
    let part = column - vec2f(low);
    let a = mix(of_column(low, slice, is_sky), of_column(vec2u(high.x, low.y), slice, is_sky), part.x);
    let b = mix(of_column(vec2u(low.x, high.y), slice, is_sky), of_column(high, slice, is_sky), part.x);
    return Veil(transmittance(sight.origin, sight.direction, distance), mix(a, b, part.y));
}
