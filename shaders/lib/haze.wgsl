#define_import_path lightwell::haze

// The grid of what media scatter towards the eye: columns of TILE by TILE pixels, cut into slices by the distance from the near
// plane (Wronski 2014, "Volumetric fog").

#import lightwell::view::View

struct Haze {
    columns: vec2u,
    tile: f32,             // edge of a column [pixels]
    begin: f32,            // distance of the first slice from the near plane [m]
    length: f32,           // of all slices [m]
    power: f32,            // of how slices grow with distance
    shift: vec2f,          // of the columns' middles [columns]
    depth_shift: f32,      // of the points in slices where light is looked up, within −.5..1/2
    padding: f32,
}

const SLICES: u32 = 40u;

// A line of sight: where it leaves the near plane, and its unit direction.
struct Sight {
    origin: vec3f,
    direction: vec3f,
}

// That through a point of the image [pixels].
fn sight_through(view: View, at: vec2f) -> Sight {
    let uv = at / vec2f(view.size);
    let near = view.world_from_clip * vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 1.0, 1.0);
    let origin = near.xyz / near.w;
    let ahead = select(-view.eye.xyz, origin - view.eye.xyz, view.eye.w > 0.0);
    return Sight(origin, normalize(ahead));
}

// Distance of the beginning of a slice [m].
fn slice_distance(haze: Haze, slice: f32) -> f32 {
    return haze.begin + haze.length * pow(slice / f32(SLICES), haze.power);
}

fn slice_of(haze: Haze, distance: f32) -> f32 {
    let t = saturate((distance - haze.begin) / haze.length);
    return f32(SLICES) * pow(t, 1.0 / haze.power);
}

// Slices lie SLICES + 2 to a column: what is scattered up to the beginning of each, up to the end of the last, and up to the
// end of the world.
fn haze_index(haze: Haze, column: vec2u, slice: u32) -> u32 {
    return (column.y * haze.columns.x + column.x) * (SLICES + 2u) + slice;
}
